/* The Jiles-Atherton model, form "bulk" without clamp, by its exact step in the effective field.
 *
 * p: Ms, a, alpha, c, k, longest step, form, clamp, 1 / a, 1 / k, tolerance of the field
 * s: angle, torque, (not used), field x, lag u = M - Man, Man, and its two derivatives
 */
#include "langevin.c"

/* A point of a motion: the last five numbers of s. */
typedef struct {
    as_real x, u, man, slope, curvature;
} as_jiles_atherton_point;

/* Fills the anhysteretic torque and its derivatives at the field of a point. */
static inline void as_jiles_atherton_anhysteretic(const as_real *p, as_jiles_atherton_point *at)
{
    as_real value, slope, curvature;
    as_langevin(at->x * p[8], &value, &slope, &curvature);
    at->man = p[0] * value;
    at->slope = p[0] * p[8] * slope;
    at->curvature = p[0] * p[8] * p[8] * curvature;
}

/* Returns the point after a step dx of the field: Man by a cubic, its decay exactly. */
static inline as_jiles_atherton_point as_jiles_atherton_step(const as_real *p,
                                                             const as_jiles_atherton_point *at,
                                                             as_real dx)
{
    as_jiles_atherton_point end = {at->x + dx, 0, 0, 0, 0};
    as_jiles_atherton_anhysteretic(p, &end);
    const as_real z = AS_(fabs)(dx * p[9]);
    as_real decay, phi1, phi2, phi3; /* phi_j(-z) is the sum of (-z)^i / (i + j)! */
    if (z < AS_EITHER(0.25, 1.0)) {
        phi3 = 0;
        for (int i = 10; i > 2; i--)
            phi3 = (1 - z * phi3) / (as_real)i;
        phi3 /= 2;
        phi2 = AS_(0.5) - z * phi3;
        phi1 = 1 - z * phi2;
        decay = 1 - z * phi1;
    } else {
        decay = AS_(exp)(-z);
        phi1 = (1 - decay) / z;
        phi2 = (1 - phi1) / z;
        phi3 = (AS_(0.5) - phi2) / z;
    }
    const as_real first = phi1 - 4 * phi2 + 6 * phi3, last = 6 * phi3 - 2 * phi2;
    const as_real rise = 6 * phi2 - 12 * phi3;
    const as_real integral =
        dx * (at->slope * first + end.slope * last) + (end.man - at->man) * rise;
    end.u = at->u * decay + (p[3] - 1) * integral;
    return end;
}

/* Ends a motion at an angle by Newton's method on the last step; u is NaN past the pole. */
static inline as_jiles_atherton_point as_jiles_atherton_land(const as_real *p,
                                                             const as_jiles_atherton_point *at,
                                                             as_real dx, as_real angle,
                                                             as_real delta)
{
    const as_real per_k = delta * p[9];
    const as_real tolerance =
        p[10] + AS_EITHER(1e-14, 2e-5) * (AS_(fabs)(angle) + AS_(fabs)(at->x));
    as_real low = 0, high = (as_real)INFINITY;
    as_jiles_atherton_point end = *at;
    for (int i = 0; i < 60; i++) {
        end = as_jiles_atherton_step(p, at, dx);
        const as_real tangent = p[3] * end.slope - end.u * per_k, g = 1 - p[2] * tangent;
        const as_real residual = end.x - angle - p[2] * (end.man + end.u);
        const as_real newton = -residual / g;
        if (g > 0 && AS_(fabs)(newton) <= tolerance) { /* the rest is of second order */
            end.x += newton;
            end.u += (tangent - end.slope) * newton;
            end.man += end.slope * newton;
            end.slope += end.curvature * newton;
            return end;
        }
        if (delta * residual > 0)
            high = AS_(fabs)(dx);
        else if (g > 0)
            low = AS_(fabs)(dx);
        else
            break;
        as_real reach = g > 0 ? AS_(fabs)(dx) + delta * newton : low;
        if (!(low < reach && reach < high))
            reach = high < (as_real)INFINITY ? AS_(0.5) * (low + high) : 2 * AS_(fabs)(dx);
        dx = delta * reach;
    }
    end.u = (as_real)NAN;
    return end;
}

static inline as_real as_jiles_atherton_commit(const as_real *p, int size, as_real *s,
                                               as_real angle)
{
    (void)size;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    as_jiles_atherton_point at = {s[3], s[4], s[5], s[6], s[7]};
    const as_real delta = angle > s[0] ? 1 : -1, per_k = delta * p[9];
    as_real left = angle - s[0], dx = 0;
    for (;;) { /* each step but the last has the longest length that keeps the error bound */
        const as_real tangent = p[3] * at.slope - at.u * per_k;
        const as_real per_g = 1 / (1 - p[2] * tangent), first = left * per_g;
        if (!(per_g > 0))
            return (as_real)NAN; /* past the pole */
        const as_real limit = p[5] * as_max(1, AS_(0.25) * AS_(fabs)(at.x) * p[8]);
        if (AS_(fabs)(first) <= limit) {
            const as_real bend =
                p[2] * ((tangent - at.slope) * per_k - p[3] * at.curvature);
            dx = first - AS_(0.5) * bend * per_g * first * first;
            if (!(0 < delta * dx && delta * dx <= 2 * limit))
                dx = delta * limit;
            break;
        }
        dx = delta * limit;
        const as_jiles_atherton_point next = as_jiles_atherton_step(p, &at, dx);
        const as_real rest = angle - (next.x - p[2] * (next.man + next.u));
        if (delta * rest <= 0)
            break;
        if (!(next.x != at.x))
            return (as_real)NAN; /* too far for the digits of a number */
        at = next;
        left = rest;
    }
    const as_jiles_atherton_point end = as_jiles_atherton_land(p, &at, dx, angle, delta);
    if (isnan(end.u))
        return (as_real)NAN;
    s[0] = angle;
    s[1] = end.man + end.u;
    s[3] = end.x;
    s[4] = end.u;
    s[5] = end.man;
    s[6] = end.slope;
    s[7] = end.curvature;
    return s[1];
}

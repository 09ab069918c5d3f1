/* The Jiles-Atherton model of the other forms and with clamps, by an adaptive step in the field.
 *
 * p: Ms, a, alpha, c, k, (not used), form, clamp, then three numbers that are not used
 * s: angle, torque, then numbers that are not used
 */
#include "langevin.c"

enum { AS_FORM_BULK, AS_FORM_ORIGINAL, AS_FORM_DERIVATIVE, AS_FORM_JILES_1992 };
enum { AS_CLAMP_NONE, AS_CLAMP_JILES, AS_CLAMP_IRREVERSIBLE };

/* Returns the anhysteretic torque at a field, and its slope. */
static inline as_real as_other_forms_anhysteretic(const as_real *p, as_real x, as_real *slope)
{
    as_real value, curvature;
    as_langevin(x / p[1], &value, slope, &curvature);
    *slope *= p[0] / p[1];
    return p[0] * value;
}

/* Returns dM/dHe at a field. */
static inline as_real as_other_forms_rate(const as_real *p, as_real x, as_real M, as_real delta)
{
    const as_real alpha = p[2], c = p[3], k = p[4];
    const int form = (int)p[6], clamp = (int)p[7];
    as_real slope;
    const as_real D = as_other_forms_anhysteretic(p, x, &slope) - M, reversible = c * slope;
    const as_real rest = delta * k - alpha * D;
    int blocked = 0;
    if (clamp == AS_CLAMP_JILES || form == AS_FORM_ORIGINAL || form == AS_FORM_DERIVATIVE)
        blocked = clamp != AS_CLAMP_NONE && delta * D < 0;
    else if (clamp == AS_CLAMP_IRREVERSIBLE)
        blocked = delta * D * (1 - c) < 0;
    if (form == AS_FORM_BULK)
        return blocked ? reversible : D / (delta * k) + reversible;
    if (form == AS_FORM_ORIGINAL)
        return blocked ? reversible / (1 + c)
                       : (D + reversible * rest) / ((1 + c) * delta * k - c * alpha * D);
    if (form == AS_FORM_DERIVATIVE)
        return blocked ? reversible / (1 + c + alpha * reversible)
                       : (D + reversible * rest) / (delta * k + (c + alpha * reversible) * rest);
    const as_real pin = (1 - c) * delta * k;
    return blocked
               ? reversible
               : ((1 - c) * D + reversible * (pin - alpha * D)) / (pin - alpha * c * D);
}

/* Returns M after a step of dx, its error, and the rate there (Bogacki and Shampine, order 3). */
static inline as_real as_other_forms_step(const as_real *p, as_real dx, as_real x, as_real M,
                                          as_real first, as_real delta, as_real *error,
                                          as_real *last)
{
    const as_real second = as_other_forms_rate(p, x + dx / 2, M + dx / 2 * first, delta);
    const as_real third =
        as_other_forms_rate(p, x + AS_(0.75) * dx, M + AS_(0.75) * dx * second, delta);
    const as_real end = M + dx * (2 * first + 3 * second + 4 * third) / 9;
    *last = as_other_forms_rate(p, x + dx, end, delta);
    *error = AS_(fabs)(dx * (-5 * first / 72 + second / 12 + third / 9 - *last / 8));
    return end;
}

/* Ends a motion at an angle by Newton's method on the last step; NaN if that step is too long. */
static inline as_real as_other_forms_land(const as_real *p, as_real dx, as_real x, as_real M,
                                          as_real slope, as_real angle, as_real delta)
{
    const as_real alpha = p[2];
    const as_real tolerance = AS_EITHER(1e-11, 1e-5) * as_min(p[1], p[4]) +
                              AS_EITHER(0.0, 2e-6) * (AS_(fabs)(x) + AS_(fabs)(angle));
    for (int i = 0; i < 80; i++) {
        as_real error, last;
        const as_real end = as_other_forms_step(p, dx, x, M, slope, delta, &error, &last);
        if (!(error <= AS_EITHER(1e-9, 1e-6) * p[0] && alpha * last < 1))
            break;
        const as_real newton = -(x + dx - alpha * end - angle) / (1 - alpha * last);
        if (AS_(fabs)(newton) <= tolerance)
            return end + last * newton;
        dx += newton;
        if (!(delta * dx > 0))
            break;
    }
    return (as_real)NAN;
}

static inline as_real as_other_forms_commit(const as_real *p, int size, as_real *s, as_real angle)
{
    (void)size;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    const as_real alpha = p[2], delta = angle > s[0] ? 1 : -1;
    as_real x = s[0] + alpha * s[1], M = s[1], dx = delta * AS_(0.1) * as_min(p[1], p[4]);
    as_real slope = as_other_forms_rate(p, x, M, delta);
    for (long i = 0; i < 1000000 && alpha * slope < 1; i++) {
        const as_real whole = (angle - (x - alpha * M)) / (1 - alpha * slope);
        if (AS_(fabs)(whole) <= AS_(fabs)(dx)) {
            const as_real end = as_other_forms_land(p, whole, x, M, slope, angle, delta);
            if (isfinite(end)) {
                s[0] = angle;
                s[1] = end;
                return end;
            }
            dx = AS_(0.5) * whole;
        }
        as_real error, last;
        const as_real end = as_other_forms_step(p, dx, x, M, slope, delta, &error, &last);
        const int passed = delta * (x + dx - alpha * end - angle) > 0;
        const as_real allowed = AS_EITHER(1e-9, 1e-6) * p[0];
        const as_real growth = as_min(
            4, AS_(0.9) * AS_(pow)(allowed / as_max(error, AS_EITHER(1e-300, 1e-30)), AS_(1.0) / 3));
        if (error <= allowed && !passed) {
            x += dx;
            M = end;
            slope = last;
        } else if (AS_(fabs)(dx) <= AS_EITHER(1e-14, 1e-6) * (AS_(fabs)(x) + p[1])) {
            break;
        }
        dx *= passed ? AS_(0.5) : as_max(growth, AS_(0.1));
    }
    return (as_real)NAN; /* past the pole */
}

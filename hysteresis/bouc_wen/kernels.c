/* The Bouc-Wen model.
 *
 * p: elastic, hysteretic, rest angle, A, n, then scale and sign of loading, of unloading
 * s: angle, torque, (not used), z
 *
 * In units of the scale a branch obeys dw/dx = direction (1 - sigma w^n). The functions below move
 * w by *x, but not below 0, and leave in *x what remains of the motion there. Each returns w, NaN
 * beyond a pole.
 */

/* Returns the gain of w over n dx = h by a Taylor series, and its error relative to w. */
static inline as_real as_bouc_wen_taylor(as_real w, as_real u, as_real sigma, as_real h,
                                         as_real per_n, as_real *error)
{
    /* v and p are the terms of n w and w^n; p = w^n gives w p' = p (n w)'. */
    as_real v[9], p[8], sum = 0;
    p[0] = u;
    v[1] = (1 - sigma * u) * h;
    for (int k = 1; k < 8; k++) {
        as_real next = 0;
        for (int j = 1; j <= k; j++)
            next += ((as_real)j - (as_real)(k - j) * per_n) * v[j] * p[k - j];
        p[k] = next / (w * (as_real)k);
        v[k + 1] = -sigma * p[k] * h / (as_real)(k + 1);
    }
    for (int k = 8; k > 0; k--)
        sum += v[k];
    *error = as_max(AS_(fabs)(v[8]), AS_(0.05) * AS_(fabs)(v[7])) * per_n / w;
    return sum * per_n;
}

/* Returns the x in which w rises from 0, where u = w^n < 1. */
static inline as_real as_bouc_wen_time(as_real w, as_real u, as_real sigma, as_real n)
{
    const as_real t = sigma * u;
    as_real time = 1, power = t, divisor = n + 1;
    for (int k = 0; k < 64 && AS_(fabs)(power) > AS_EITHER(1e-17, 1e-9) * divisor; k++) {
        time += power / divisor;
        power *= t;
        divisor += n;
    }
    return w * time;
}

/* Solves the equation near w = 0, where w^n is not smooth, up to w^n = 0.25. */
static inline as_real as_bouc_wen_near_zero(as_real w, as_real u, as_real *x, as_real sigma,
                                            as_real direction, as_real n)
{
    const as_real target = as_bouc_wen_time(w, u, sigma, n) + direction * *x;
    if (target <= 0) {
        *x = -target;
        return 0;
    }
    const as_real end = AS_(pow)(AS_(0.25), 1 / n);
    if (direction > 0) {
        const as_real time_end = as_bouc_wen_time(end, AS_(0.25), sigma, n);
        if (target >= time_end) {
            *x = target - time_end;
            return end;
        }
    }
    as_real w1 = as_min(target, end);
    for (int k = 0; k < 20; k++) { /* Newton's method, from one side */
        const as_real u1 = AS_(pow)(w1, n);
        const as_real correction = (target - as_bouc_wen_time(w1, u1, sigma, n)) * (1 - sigma * u1);
        w1 += correction;
        if (AS_(fabs)(correction) <= AS_EITHER(1e-9, 1e-6) * w1)
            break;
    }
    *x = 0;
    return w1;
}

/* Solves dw/dx = -decay w^n, which remains for very large w. */
static inline as_real as_bouc_wen_far_out(as_real w, as_real *x, as_real decay, as_real n)
{
    if (decay > 0) {
        w = as_min(w, AS_(pow)(AS_EITHER(1e300, 1e30), 1 / n));
        const as_real end = AS_(pow)(AS_EITHER(5e15, 5e6), 1 / n);
        const as_real x_end =
            -AS_(expm1)((n - 1) * AS_(log)(end / w)) * AS_(pow)(end, 1 - n) / (n - 1);
        if (*x >= x_end) {
            *x -= x_end;
            return end;
        }
    }
    w *= AS_(exp)(-AS_(log1p)(decay * (n - 1) * *x * AS_(pow)(w, n - 1)) / (n - 1));
    *x = 0;
    return w;
}

/* Solves the equation for sigma = 1 or -1 and n > 1. */
static inline as_real as_bouc_wen_march(as_real w, as_real *x, as_real sigma, as_real direction,
                                        as_real n)
{
    const int attracted = sigma > 0 && direction > 0;
    as_real longest = (as_real)INFINITY;
    for (long i = 0; i < 100000; i++) {
        const as_real u = AS_(pow)(w, n);
        if (!(u < AS_EITHER(1e16, 1e7))) {
            w = as_bouc_wen_far_out(w, x, direction * sigma, n);
            if (!(*x > 0))
                return w;
            continue;
        }
        if (attracted && AS_(fabs)(w - 1) <= AS_EITHER(2e-15, 1e-6)) {
            *x = 0;
            return 1;
        }
        const as_real whole = n * *x;
        const int is_short = direction < 0 || u < AS_(0.125);
        as_real h = is_short ? AS_(0.25) * n * w / (1 + u) : w / u;
        h = as_min(as_min(whole, h), longest);
        if (u < AS_(0.125) && h < whole) {
            w = as_bouc_wen_near_zero(w, u, x, sigma, direction, n);
            if (*x == 0 || w == 0)
                return w;
            continue;
        }
        as_real error, gain = as_bouc_wen_taylor(w, u, sigma, direction * h, 1 / n, &error);
        for (int k = 0; k < 100 && error > AS_EITHER(1e-12, 1e-7); k++) {
            h *= as_max(AS_(0.1),
                        AS_(0.95) * AS_(pow)(AS_EITHER(1e-12, 1e-7) / error, AS_(0.125)));
            gain = as_bouc_wen_taylor(w, u, sigma, direction * h, 1 / n, &error);
        }
        w = attracted && w <= 1 ? as_min(w + gain, 1) : w + gain;
        if (h == whole) {
            *x = 0;
            return w;
        }
        *x -= h / n;
        longest = AS_(1.5) * h;
    }
    return (as_real)NAN;
}

static inline as_real as_bouc_wen_flow(as_real w, as_real *x, as_real sigma, as_real direction,
                                       as_real n)
{
    if (sigma == 0) {
        const as_real end = w + direction * *x;
        *x = as_max(-end, 0);
        return as_max(end, 0);
    }
    if (n != 1)
        return as_bouc_wen_march(w, x, sigma, direction, n);
    as_real rest = 0;
    if (direction < 0) {
        const as_real to_zero = -sigma * AS_(log1p)(-sigma * w);
        if (*x >= to_zero) {
            rest = *x - to_zero;
            *x = to_zero;
        }
    }
    const as_real phi = -sigma * AS_(expm1)(-sigma * direction * *x);
    *x = rest;
    return rest > 0 ? 0 : as_max(w + (1 - sigma * w) * phi, 0);
}

static inline as_real as_bouc_wen_commit(const as_real *p, int size, as_real *s, as_real angle)
{
    (void)size;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    const as_real delta = angle > s[0] ? 1 : -1, A = p[3], n = p[4];
    as_real y = delta * s[3], moved = AS_(fabs)(angle - s[0]);
    if (y < 0) { /* a motion against z unloads first */
        const as_real scale = p[7];
        as_real x = moved * A / scale;
        y = -scale * as_bouc_wen_flow(-y / scale, &x, p[8], -1, n);
        moved = x * scale / A;
    }
    if (moved > 0) {
        const as_real scale = p[5];
        as_real x = moved * A / scale;
        y = scale * as_bouc_wen_flow(y / scale, &x, p[6], 1, n);
    }
    const as_real torque = p[0] * (angle - p[2]) + p[1] * delta * y;
    if (!isfinite(torque))
        return (as_real)NAN;
    s[0] = angle;
    s[1] = torque;
    s[3] = delta * y;
    return torque;
}

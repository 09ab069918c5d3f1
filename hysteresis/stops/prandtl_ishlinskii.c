/* The Prandtl-Ishlinskii model in its stop form.
 *
 * p: stiffness, rest angle, n thresholds, n weights
 * s: angle, torque, (not used), n plays
 */
#include "stop.c"

static inline as_real as_prandtl_ishlinskii_commit(const as_real *p, int size, as_real *s,
                                                   as_real angle)
{
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    s[0] = angle;
    s[1] = as_stops(p, (size - 2) / 2, s + 3, angle);
    return s[1];
}

/* The Prandtl-Ishlinskii model in its stop form.
 *
 * p: stiffness, rest angle, n thresholds, n weights
 * s: angle, torque, (not used), n plays
 */
#include "stop.c"

static inline as_real as_prandtl_ishlinskii_commit(const as_real *p, int size, as_real *s,
                                                   as_real angle)
{
    const int n = (size - 2) / 2;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    as_real torque = p[0] * (angle - p[1]);
    for (int i = 0; i < n; i++)
        torque += p[2 + n + i] * as_stop(angle, &s[3 + i], p[2 + i]);
    s[0] = angle;
    s[1] = torque;
    return torque;
}

/* Dahl's friction and the semilinear Duhem model, beside a polynomial spring.
 *
 * p: stiffness, friction up, friction down, coefficients of the spring
 * s: angle, torque, (not used), friction z
 */
#include "../polynomial.c"

static inline as_real as_dahl_commit(const as_real *p, int size, as_real *s, as_real angle)
{
    if (angle == s[0])
        return s[1];
    const as_real limit = angle > s[0] ? p[1] : -p[2];
    const as_real x = p[0] * AS_(fabs)(angle - s[0]) / AS_(fabs)(limit);
    const as_real z = s[3] - (limit - s[3]) * AS_(expm1)(-x);
    const as_real torque = as_polynomial(p + 3, size - 3, angle) + z;
    if (!isfinite(angle) || !isfinite(torque))
        return (as_real)NAN;
    s[0] = angle;
    s[1] = torque;
    s[3] = z;
    return torque;
}

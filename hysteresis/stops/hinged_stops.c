/* Springs with sliders in parallel, behind a hinge function h of their sum.
 *
 * p: stiffness, rest angle, n thresholds, n weights, offset, number of knots, then with room for 16
 *    knots: the knots, the values of h there, the slopes of h
 * s: angle, torque, (not used), n plays
 */
#include "stop.c"

enum { AS_HINGED_STOPS_KNOTS = 16, AS_HINGED_STOPS_HINGE = 2 + 3 * AS_HINGED_STOPS_KNOTS + 1 };

static inline as_real as_hinged_stops_commit(const as_real *p, int size, as_real *s, as_real angle)
{
    const int n = (size - 2 - AS_HINGED_STOPS_HINGE) / 2;
    const as_real *hinge = p + 2 + 2 * n;
    const as_real *knots = hinge + 2, *values = knots + AS_HINGED_STOPS_KNOTS;
    const as_real *slopes = values + AS_HINGED_STOPS_KNOTS;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    const as_real sum = as_stops(p, n, s + 3, angle);
    int piece = 0; /* number of knots below */
    while (piece < (int)hinge[1] && sum >= knots[piece])
        piece++;
    const int knot = piece > 0 ? piece - 1 : 0;
    s[0] = angle;
    s[1] = hinge[0] + (values[knot] + slopes[piece] * (sum - knots[knot]));
    return s[1];
}

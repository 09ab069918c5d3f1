/* Returns the torque of a spring and n springs with sliders after a motion, and moves their plays.
 *
 * p: stiffness, rest angle, n thresholds, n weights
 */
static inline as_real as_stops(const as_real *p, int n, as_real *play, as_real angle)
{
    as_real torque = p[0] * (angle - p[1]);
    for (int i = 0; i < n; i++) {
        const as_real threshold = p[2 + i], low = angle - threshold, high = angle + threshold;
        as_real strain = angle - play[i];
        if (play[i] <= low) {
            play[i] = low;
            strain = threshold;
        } else if (play[i] >= high) {
            play[i] = high;
            strain = -threshold;
        }
        torque += p[2 + n + i] * strain;
    }
    return torque;
}

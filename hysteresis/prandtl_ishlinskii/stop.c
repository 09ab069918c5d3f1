/* Returns the strain of a spring with a slider after a motion, and moves its play. */
static inline as_real as_stop(as_real angle, as_real *play, as_real threshold)
{
    const as_real low = angle - threshold, high = angle + threshold;
    if (*play <= low) {
        *play = low;
        return threshold;
    }
    if (*play >= high) {
        *play = high;
        return -threshold;
    }
    return angle - *play;
}

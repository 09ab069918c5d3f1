/* A controller: reads angles and rates of the four joints, writes the torques of two motors. */
#include <stdio.h>
#include <time.h>

#include "compensation.h"

enum { REPEATS = 100000 };

int main(void)
{
    compensation_state state;
    compensation_real seen[8], torque[2];
    int begun = 0;
    while (fread(seen, sizeof seen, 1, stdin) == 1) { /* once in each control period */
        if (!begun)
            compensation_init(&state, seen);
        begun = 1;
        compensation_step(&state, seen, seen + 4, torque);
        fwrite(torque, sizeof torque, 1, stdout);
        fflush(stdout);
    }
    if (!begun)
        return 1; /* there was no input */
    const clock_t start = clock();
    for (long i = 0; i < REPEATS; i++) { /* a motion of the elbow, to and fro */
        seen[2] += (i / 100) % 2 ? -(compensation_real)0.01 : (compensation_real)0.01;
        compensation_step(&state, seen, seen + 4, torque);
    }
    const double nanoseconds = 1e9 * (double)(clock() - start) / CLOCKS_PER_SEC / REPEATS;
    fprintf(stderr, "state %d bytes, %.0f ns per step\n", (int)sizeof state, nanoseconds);
    return 0;
}

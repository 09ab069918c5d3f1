/* The type of all numbers, and functions that the code below shares. */
#include <float.h>
#include <math.h>

#ifdef ACTIVESUIT_FLOAT
typedef float as_real;
#define AS_(x) x##f /* 0.5 becomes 0.5f, exp becomes expf */
#define AS_EITHER(wide, narrow) narrow##f
#else
typedef double as_real;
#define AS_(x) x
#define AS_EITHER(wide, narrow) wide
#endif

static inline as_real as_min(as_real a, as_real b)
{
    return b < a ? b : a;
}

static inline as_real as_max(as_real a, as_real b)
{
    return b > a ? b : a;
}

/* Returns x within two limits; NaN stays NaN. */
static inline as_real as_clip(as_real x, as_real low, as_real high)
{
    return as_min(as_max(x, low), high);
}

/* The model inside, plus a polynomial of the angle: LAYER_p. */
#include "../polynomial.c"

typedef INNER_state LAYER_state;

static inline void LAYER_init(LAYER_state *s)
{
    INNER_init(s);
}

static inline as_real LAYER_step(LAYER_state *s, as_real angle)
{
    const int count = (int)(sizeof LAYER_p / sizeof LAYER_p[0]);
    return INNER_step(s, angle) + as_polynomial(LAYER_p, count, angle);
}

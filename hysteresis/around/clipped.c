/* The model inside, whose torque is constant outside a range of angles: LAYER_p. */
typedef INNER_state LAYER_state;

static inline void LAYER_init(LAYER_state *s)
{
    INNER_init(s);
}

static inline as_real LAYER_step(LAYER_state *s, as_real angle)
{
    return INNER_step(s, as_clip(angle, LAYER_p[0], LAYER_p[1]));
}

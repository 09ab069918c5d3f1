/* The model inside, a dashpot and a Maxwell element: LAYER_p is damping, stiffness and time. */
typedef struct {
    INNER_state inner;
    as_real angle, torque; /* angle of the last step, NaN before the first; torque of the element */
} LAYER_state;

static inline void LAYER_init(LAYER_state *s)
{
    INNER_init(&s->inner);
    s->angle = (as_real)NAN;
    s->torque = 0;
}

/* Moves both elements on to an angle in the time dt [s], at a constant rate; returns the rate. */
static inline as_real LAYER_relax(LAYER_state *s, as_real angle, as_real dt)
{
    const as_real rate = isnan(s->angle) ? 0 : (angle - s->angle) / dt;
    s->angle = angle;
    if (LAYER_p[1] > 0) {
        const as_real steady = LAYER_p[1] * LAYER_p[2] * rate;
        s->torque -= (steady - s->torque) * AS_(expm1)(-dt / LAYER_p[2]);
    }
    return rate;
}

/* Returns the torque of both elements at an angle that the joint has just reached, at a rate. */
static inline as_real LAYER_beside(const LAYER_state *s, as_real angle, as_real rate)
{
    const as_real strain = isnan(s->angle) ? 0 : angle - s->angle;
    return LAYER_p[0] * rate + s->torque + LAYER_p[1] * strain;
}

/* Moves on to an angle in the time dt [s], at a constant rate. */
static inline as_real LAYER_step(LAYER_state *s, as_real angle, as_real dt)
{
    if (!isfinite(angle) || !(dt > 0))
        return (as_real)NAN;
    const as_real torque = INNER_step(&s->inner, angle);
    if (isnan(torque))
        return torque;
    const as_real rate = LAYER_relax(s, angle, dt);
    return torque + LAYER_beside(s, angle, rate);
}

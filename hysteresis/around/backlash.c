/* The model inside behind play: LAYER_p is the gap. */
typedef struct {
    INNER_state inner;
    as_real end, angle; /* angles of the suit's side and of the joint, the latter NaN at first */
} LAYER_state;

static inline void LAYER_init(LAYER_state *s)
{
    INNER_init(&s->inner);
    s->end = LAYER_start[0];
    s->angle = (as_real)NAN;
}

/* Returns the torque where the suit's side moves to `end`; the memory stays as it is. */
static inline as_real LAYER_torque(const LAYER_state *s, as_real end)
{
    INNER_state trial = s->inner;
    return INNER_step(&trial, end);
}

/* Returns where the torque vanishes on the way to `far`, or `far` (Illinois rule). */
static inline as_real LAYER_opening(const LAYER_state *s, as_real torque, as_real far)
{
    as_real near = s->end, last = LAYER_torque(s, far);
    if (!(last * torque < 0))
        return far;
    for (int i = 0; i < 100; i++) {
        as_real middle = far - last * (far - near) / (last - torque);
        if (!(as_min(near, far) < middle && middle < as_max(near, far)))
            middle = (near + far) / 2;
        if (middle == near || middle == far)
            break;
        const as_real now = LAYER_torque(s, middle);
        if (now * last < 0) {
            near = far;
            torque = last;
        } else {
            torque /= 2;
        }
        far = middle;
        last = now;
        if (AS_(fabs)(last) <= AS_EITHER(1e-10, 1e-6))
            break;
    }
    return far;
}

/* Returns the angle of the suit's side after a motion of the joint: contact can only push. */
static inline as_real LAYER_end(const LAYER_state *s, as_real angle)
{
    const as_real torque = LAYER_torque(s, s->end);
    as_real half = LAYER_p[0] / 2;
    if (AS_(fabs)(torque) <= AS_EITHER(1e-9, 1e-5))
        return as_clip(s->end, angle - half, angle + half);
    half = AS_(copysign)(half, torque);
    const as_real face = angle - half, other = angle + half;
    if (half * (s->end - face) <= 0)
        return face;
    const as_real rest = LAYER_opening(s, torque, face);
    return half > 0 ? as_min(rest, other) : as_max(rest, other);
}

static inline as_real LAYER_step(LAYER_state *s, as_real angle)
{
    if (!isfinite(angle))
        return (as_real)NAN;
    const as_real end = angle == s->angle ? s->end : LAYER_end(s, angle);
    const as_real torque = INNER_step(&s->inner, end);
    if (!isnan(torque)) {
        s->end = end;
        s->angle = angle;
    }
    return torque;
}

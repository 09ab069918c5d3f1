/* Begins where the arm is; angles of the four joints. */
static inline void as_init(as_state *s, const as_real angle[4])
{
    for (int i = 0; i < 2; i++)
        s->followed[i] = angle[as_assisted[i]];
    as_begin_suit(s, angle);
}

/* Computes the torques of the motors of shoulder and elbow, once in each control period.
 *
 * angle, rate: measured angles and rates of the four joints
 * torque: at most the motors' peak torques; 0 where an angle or a rate is not finite, which
 *     the memory ignores
 */
static inline void as_step(as_state *s, const as_real angle[4], const as_real rate[4],
                           as_real torque[2])
{
    as_real soon[4];
    for (int j = 0; j < 4; j++)
        soon[j] = angle[j] + as_lead * rate[j];
    as_carry(soon, torque);
    as_add_suit(s, angle, rate, torque);
    for (int i = 0; i < 2; i++) {
        const as_real r = rate[as_assisted[i]];
        torque[i] += as_friction_share * (as_coulomb[i] * AS_(tanh)(r / as_turning_rate)
                                          + as_viscous[i] * r);
        torque[i] = isfinite(torque[i]) ? as_clip(torque[i], -as_peak[i], as_peak[i]) : 0;
    }
}

/* Returns the torques that carry what shall be carried: a sum of products of sines and cosines. */
static inline void as_carry(const as_real angle[4], as_real torque[2])
{
    as_real products[81];
    int count = 1;
    products[0] = 1;
    for (int j = 0; j < 4; j++) {
        const as_real s = AS_(sin)(angle[j]), c = AS_(cos)(angle[j]);
        for (int i = 0; i < count; i++) {
            products[count + i] = s * products[i];
            products[2 * count + i] = c * products[i];
        }
        count *= 3;
    }
    torque[0] = torque[1] = 0;
    for (int i = 0; i < 81; i++) {
        torque[0] += products[i] * as_weight[2 * i];
        torque[1] += products[i] * as_weight[2 * i + 1];
    }
}

/* Computes the Langevin function L(x) = coth x - 1 / x and its first two derivatives. */
static inline void as_langevin(as_real x, as_real *value, as_real *slope, as_real *curvature)
{
    static const as_real c[9] = {
        AS_(1.0) / 3,
        -AS_(1.0) / 45,
        AS_(2.0) / 945,
        -AS_(1.0) / 4725,
        AS_(2.0) / 93555,
        -AS_(1382.0) / AS_(638512875.0),
        AS_(4.0) / AS_(18243225.0),
        -AS_(7234.0) / AS_(325641566250.0),
        AS_(87734.0) / AS_(38979295480125.0),
    };
    if (AS_(fabs)(x) < AS_EITHER(0.42, 1.0)) { /* below, the closed form would cancel */
        const as_real s = x * x;
        as_real v = c[8], d = 17 * c[8], e = 0;
        for (int k = 7; k >= 0; k--) {
            v = v * s + c[k];
            d = d * s + (as_real)(2 * k + 1) * c[k];
        }
        for (int k = 4; k > 0; k--)
            e = e * s + (as_real)(2 * k * (2 * k + 1)) * c[k];
        *value = x * v;
        *slope = d;
        *curvature = x * e;
        return;
    }
    const as_real e = AS_(exp)(-2 * AS_(fabs)(x)), inverse = 1 / AS_(fabs)(x), scale = 1 / (1 - e);
    const as_real coth = (1 + e) * scale, csch2 = 4 * e * scale * scale;
    *value = AS_(copysign)(coth - inverse, x);
    *slope = inverse * inverse - csch2;
    *curvature = AS_(copysign)(2, x) * (coth * csch2 - inverse * inverse * inverse);
}

/* Returns a polynomial of the angle; its coefficients begin with the constant. */
static inline as_real as_polynomial(const as_real *coefficients, int count, as_real angle)
{
    as_real value = 0;
    for (int power = count - 1; power >= 0; power--)
        value = value * angle + coefficients[power];
    return value;
}

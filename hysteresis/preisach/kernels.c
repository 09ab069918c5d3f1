/* The Preisach model: a piecewise uniform density of relays, and a stack of turning points.
 *
 * p: number n of segments, lowest and highest level; n rows of (level, width, 1 / width, weight on
 *    the diagonal, elastic torque, elastic slope, (not used)); then rows of eight for each cell
 *    (i, j), j < i: weight, sum of row, of column, of triangle, (not used) four times
 * s: angle, torque, (not used), torque of the relays, number of turning points, (not used), then
 *    records (angle, torque of the relays); branch k leaves record k, and rises for even k
 */
enum { AS_PREISACH_CAPACITY = 64, AS_PREISACH_RECORDS = 6 };

static inline const as_real *as_preisach_row(const as_real *p, int i)
{
    return p + 3 + 7 * i;
}

/* Returns the last segment that does not begin above x. */
static inline int as_preisach_segment(const as_real *p, as_real x)
{
    int low = 0, high = (int)p[0];
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (x >= as_preisach_row(p, middle)[0])
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Returns the weight of all relays that a motion between two angles switches. */
static inline as_real as_preisach_swept(const as_real *p, as_real x, as_real y)
{
    if (x < y) {
        const as_real larger = y;
        y = x;
        x = larger;
    }
    const int i = as_preisach_segment(p, x), j = as_preisach_segment(p, y);
    const as_real *a = as_preisach_row(p, i), *c = as_preisach_row(p, j);
    if (i <= j) {
        const as_real u = (x - y) * a[2];
        return a[3] * u * u;
    }
    const as_real *r = as_preisach_row(p, (int)p[0]) + 8 * (i * (i - 1) / 2 + j);
    const as_real u = (x - a[0]) * a[2], b = (c[1] - (y - c[0])) * c[2];
    return r[3] + u * r[1] + b * r[2] + u * b * r[0] + u * u * a[3] + b * b * c[3];
}

static inline as_real as_preisach_commit(const as_real *p, int size, as_real *s, as_real angle)
{
    (void)size;
    if (angle == s[0])
        return s[1];
    if (!isfinite(angle))
        return (as_real)NAN;
    as_real *records = s + AS_PREISACH_RECORDS;
    const as_real x = as_clip(angle, p[1], p[2]), before = as_clip(s[0], p[1], p[2]);
    const int rises = angle > s[0], count = (int)s[4];
    int k = count, inside = 0;
    as_real base = records[2 * k], relays = records[2 * k + 1];
    if (rises != (k % 2 == 0)) { /* the motion turns, and opens a branch */
        if (k < AS_PREISACH_CAPACITY) {
            k++;
            base = before;
            relays = s[3];
        } else if (x > base) { /* the stack is full: back along the innermost branch */
            inside = 1;
        } else {
            k--;
            base = records[2 * k];
            relays = records[2 * k + 1];
        }
    }
    while (!inside && k > 0) { /* loops that close are forgotten */
        const as_real bound = records[2 * (k - 1)];
        if (rises ? x < bound : x > bound)
            break;
        k = k > 2 ? k - 2 : 0;
        base = records[2 * k];
        relays = records[2 * k + 1];
    }
    const as_real weight = as_preisach_swept(p, x, base);
    relays += k % 2 ? weight : -weight;
    const as_real *a = as_preisach_row(p, as_preisach_segment(p, angle));
    const as_real torque = relays + (a[4] + a[5] * (angle - a[0]));
    if (!isfinite(torque))
        return (as_real)NAN;
    if (k == count + 1) {
        records[2 * k] = before;
        records[2 * k + 1] = s[3];
    }
    s[0] = angle;
    s[1] = torque;
    s[3] = relays;
    s[4] = (as_real)k;
    return torque;
}

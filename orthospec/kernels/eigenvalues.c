/* Eigenvalues of symmetric 3 x 3 matrices in closed form, to rounding, repeated ones included.
 *
 * With q = tr A / 3 and p = ||A - q I||_F / sqrt 6, the matrix N = (A - q I) / p has the characteristic
 * polynomial b^3 - 3 b - 2 r, r = det N / 2 in [-1, 1] (Smith 1961). The textbook takes all three roots from
 * the angle acos(r) / 3: that divides 0 by 0 at multiples of I, and loses half of the digits where two roots
 * meet (r = +-1). One root never suffers: for r >= 0 the largest, which lies in [sqrt 3, 2], at least sqrt 3
 * from the others. It is found by Newton's method, its eigenvector from the rows of N - b I, and the other two
 * from the 2 x 2 matrix that N is across that eigenvector. For r < 0 the same is done with -N.
 *
 * No step needs more than + - * / and sqrt: the same bits on every processor.
 */
#include "kernels.h"

#include <float.h>
#include <math.h>

typedef struct {
    double x, y, z;
} Vector;

/* A symmetric matrix, by its lower triangle. */
typedef struct {
    double xx, yx, yy, zx, zy, zz;
} Symmetric;

/* Of two numbers; unlike fmin and fmax, which mind NaN, one instruction each. */
static double lesser(double a, double b)
{
    return a < b ? a : b;
}

static double greater(double a, double b)
{
    return a > b ? a : b;
}

static double dot(Vector a, Vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static Vector cross(Vector a, Vector b)
{
    return (Vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static Vector times(Symmetric m, Vector v)
{
    return (Vector){m.xx * v.x + m.yx * v.y + m.zx * v.z, m.yx * v.x + m.yy * v.y + m.zy * v.z,
                    m.zx * v.x + m.zy * v.y + m.zz * v.z};
}

static Symmetric scaled(Symmetric m, double by)
{
    return (Symmetric){m.xx * by, m.yx * by, m.yy * by, m.zx * by, m.zy * by, m.zz * by};
}

static Symmetric shifted(Symmetric m, double by)
{
    m.xx -= by;
    m.yy -= by;
    m.zz -= by;
    return m;
}

static int finite(Symmetric m)
{
    return isfinite(m.xx) && isfinite(m.yy) && isfinite(m.zz) && isfinite(m.yx) && isfinite(m.zx) && isfinite(m.zy);
}

static double greatest_entry(Symmetric m)
{
    const double diagonal = greater(greater(fabs(m.xx), fabs(m.yy)), fabs(m.zz));
    const double off_diagonal = greater(greater(fabs(m.yx), fabs(m.zx)), fabs(m.zy));
    return greater(diagonal, off_diagonal);
}

static int diagonal(Symmetric m)
{
    return m.yx == 0.0 && m.zx == 0.0 && m.zy == 0.0;
}

/* The sum of the squares of all nine entries. */
static double squares(Symmetric m)
{
    return m.xx * m.xx + m.yy * m.yy + m.zz * m.zz + 2.0 * (m.yx * m.yx + m.zx * m.zx + m.zy * m.zy);
}

static double half_determinant(Symmetric m)
{
    return 0.5 * (m.xx * (m.yy * m.zz - m.zy * m.zy) - m.yx * (m.yx * m.zz - m.zy * m.zx) +
                  m.zx * (m.yx * m.zy - m.yy * m.zx));
}

/* The root of b^3 - 3 b = 2 r in [sqrt 3, 2], for r in [0, 1]. The first guess is right to 1.1e-3, and a Newton
 * step squares the error: 1e-6, 1e-12, and then rounding. */
static double largest_root(double r)
{
    double b = 1.7331 + r * (0.3192 - r * 0.0531);
    for (int step = 0; step < 3; step++)
        b = (2.0 / 3.0) * (b * b * b + r) / (b * b - 1.0);
    return b;
}

/* The unit vector that a matrix of rank two, given by its rows, takes to 0: the longest product of rows. */
static Vector null_vector(Symmetric m)
{
    const Vector rows[3] = {{m.xx, m.yx, m.zx}, {m.yx, m.yy, m.zy}, {m.zx, m.zy, m.zz}};
    Vector longest = cross(rows[0], rows[1]);
    for (int i = 1; i < 3; i++) {
        const Vector other = cross(rows[i], rows[(i + 1) % 3]);
        if (dot(other, other) > dot(longest, longest))
            longest = other;
    }
    const double length = sqrt(dot(longest, longest));
    return (Vector){longest.x / length, longest.y / length, longest.z / length};
}

/* Two unit vectors across the unit vector n and each other (Duff et al. 2017). */
static void vectors_across(Vector n, Vector *u, Vector *v)
{
    const double sign = copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    *u = (Vector){1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    *v = (Vector){b, sign + n.y * n.y * a, -n.y};
}

/* Roots of a matrix N as above with r >= 0, ascending. */
static void normalised_roots(Symmetric n, double r, double roots[3])
{
    roots[2] = largest_root(lesser(r, 1.0));
    Vector u, v;
    vectors_across(null_vector(shifted(n, roots[2])), &u, &v);
    const Vector nu = times(n, u), nv = times(n, v);
    const double uu = dot(u, nu), vv = dot(v, nv), uv = dot(u, nv);
    const double middle = 0.5 * (uu + vv), half = 0.5 * (uu - vv), radius = sqrt(half * half + uv * uv);
    roots[0] = middle - radius;
    roots[1] = middle + radius;
}

static void sort_three(double out[3], double a, double b, double c)
{
    const double low = lesser(a, b), high = greater(a, b);
    out[0] = lesser(low, c);
    out[1] = greater(low, lesser(high, c));
    out[2] = greater(high, c);
}

/* Eigenvalues of a matrix whose squares neither overflow nor vanish beside each other. */
static void eigenvalues_in_range(Symmetric a, double out[3])
{
    const double q = (a.xx + a.yy + a.zz) / 3.0;
    const Symmetric b = shifted(a, q);
    const double p = sqrt(squares(b) / 6.0);
    if (p * p < DBL_MIN) {
        sort_three(out, a.xx, a.yy, a.zz);
        return;
    }
    const Symmetric n = scaled(b, 1.0 / p);
    const double r = half_determinant(n);
    double roots[3];
    if (r >= 0.0) {
        normalised_roots(n, r, roots);
        for (int i = 0; i < 3; i++)
            out[i] = q + p * roots[i];
    } else {
        normalised_roots(scaled(n, -1.0), -r, roots);
        for (int i = 0; i < 3; i++)
            out[i] = q - p * roots[2 - i];
    }
}

static void eigenvalues_of(Symmetric a, double out[3])
{
    if (!finite(a)) {
        out[0] = out[1] = out[2] = NAN;
        return;
    }
    if (diagonal(a)) {
        sort_three(out, a.xx, a.yy, a.zz);
        return;
    }
    const double most = greatest_entry(a);
    const double scale = most > 0x1p300 ? 0x1p600 : most < 0x1p-300 ? 0x1p-600 : 1.0;
    eigenvalues_in_range(scaled(a, 1.0 / scale), out);
    for (int i = 0; i < 3; i++)
        out[i] *= scale;
}

void symmetric_eigenvalues_3(const double *matrices, double *eigenvalues, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double *m = matrices + 9 * i;
        eigenvalues_of((Symmetric){m[0], m[3], m[4], m[6], m[7], m[8]}, eigenvalues + 3 * i);
    }
}

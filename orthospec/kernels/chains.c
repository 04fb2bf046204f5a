/* The compliance of a platform on chains side by side, where no chain is rigid and the platform is held.
 *
 * Chain i transmits the wrenches in the rows of W_i, which find the compliance D_i:
 *
 *     C = K^-1,      K = sum of W_i^T D_i^-1 W_i.
 *
 * With D_i = L P L^T (L unit lower triangular, P the pivots) and Y = L^-1 W_i, a chain adds Y^T P^-1 Y; K is
 * inverted by the same factors. These need no pivoting and no scale: the error is rounding times the condition
 * number that D_i and K have once their diagonals are 1, whatever the units. A small pivot beside its diagonal
 * entry tells where that is large: all have to be above SAFE.
 *
 * GROUP nodes go side by side through each step, in vector registers, and none looks at another: a node has the
 * same bits in any company and, of + - * / alone, on every processor.
 */
#include "kernels.h"

#include <math.h>

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

enum { GROUP = 8, AXES = 6 };

static const double SAFE = 1e-6;

/* One number of each node of a group. */
typedef struct {
    double of[GROUP];
} Lanes;

#define EACH_LANE for (int lane = 0; lane < GROUP; lane++)

/* A symmetric matrix by its lower triangle, row after row; once factorised, L below the diagonal and 1 / P on it. */
enum { TRIANGLE = AXES * (AXES + 1) / 2 };

static inline int entry(int row, int column)
{
    return row * (row + 1) / 2 + column;
}

static inline void subtract_product(Lanes *RESTRICT to, const Lanes *RESTRICT a, const Lanes *RESTRICT b)
{
    EACH_LANE to->of[lane] -= a->of[lane] * b->of[lane];
}

static inline void add_product(Lanes *RESTRICT to, const Lanes *RESTRICT a, const Lanes *RESTRICT b)
{
    EACH_LANE to->of[lane] += a->of[lane] * b->of[lane];
}

static inline Lanes product(const Lanes *a, const Lanes *b)
{
    Lanes c;
    EACH_LANE c.of[lane] = a->of[lane] * b->of[lane];
    return c;
}

/* A pivot becomes its inverse; where it is not well above 0, beside its diagonal entry, the node is not safe. */
static inline void invert_pivot(Lanes *pivot, const Lanes *diagonal, Lanes *safe)
{
    EACH_LANE {
        safe->of[lane] = pivot->of[lane] > SAFE * diagonal->of[lane] ? safe->of[lane] : 0.0;
        pivot->of[lane] = 1.0 / pivot->of[lane];
    }
}

static inline void factorise(Lanes m[], int size, Lanes *safe)
{
    for (int row = 0; row < size; row++) {
        Lanes *const pivot = &m[entry(row, row)];
        const Lanes diagonal = *pivot;
        for (int column = 0; column < row; column++) {
            Lanes *const here = &m[entry(row, column)];
            for (int k = 0; k < column; k++)
                subtract_product(here, &m[entry(row, k)], &m[entry(column, k)]);
        }
        for (int column = 0; column < row; column++) {
            Lanes *const here = &m[entry(row, column)];
            const Lanes whole = *here;
            *here = product(&whole, &m[entry(column, column)]);
            subtract_product(pivot, here, &whole);
        }
        invert_pivot(pivot, &diagonal, safe);
    }
}

/* stiffness += Y^T P^-1 Y, with the rows of W in `wrenches` turned into those of Y. */
static inline void add_chain(Lanes stiffness[TRIANGLE], Lanes d[TRIANGLE], Lanes wrenches[AXES][AXES], int size,
                             Lanes *safe)
{
    factorise(d, size, safe);
    for (int row = 1; row < size; row++)
        for (int k = 0; k < row; k++)
            for (int axis = 0; axis < AXES; axis++)
                subtract_product(&wrenches[row][axis], &d[entry(row, k)], &wrenches[k][axis]);
    for (int row = 0; row < size; row++)
        for (int i = 0; i < AXES; i++) {
            const Lanes flow = product(&d[entry(row, row)], &wrenches[row][i]);
            for (int j = 0; j <= i; j++)
                add_product(&stiffness[entry(i, j)], &flow, &wrenches[row][j]);
        }
}

/* The inverse of a unit lower triangular matrix, below the diagonal in place. */
static inline void invert_triangle(Lanes m[TRIANGLE])
{
    for (int column = 0; column < AXES; column++)
        for (int row = column + 1; row < AXES; row++) {
            Lanes *const here = &m[entry(row, column)];
            EACH_LANE here->of[lane] = -here->of[lane];
            for (int k = column + 1; k < row; k++)
                subtract_product(here, &m[entry(row, k)], &m[entry(k, column)]);
        }
}

/* The matrix becomes its inverse, M^T P^-1 M with M = L^-1. */
static inline void invert(Lanes m[TRIANGLE], Lanes *safe)
{
    factorise(m, AXES, safe);
    invert_triangle(m);
    for (int i = 0; i < AXES; i++)
        for (int j = 0; j <= i; j++) {
            Lanes sum = i == j ? m[entry(i, i)] : product(&m[entry(i, i)], &m[entry(i, j)]);
            for (int k = i + 1; k < AXES; k++) {
                const Lanes flow = product(&m[entry(k, k)], &m[entry(k, i)]);
                add_product(&sum, &flow, &m[entry(k, j)]);
            }
            m[entry(i, j)] = sum;
        }
}

/* Where the nodes of a group stand; those beyond the last are the last again. */
typedef struct {
    size_t node[GROUP];
} Places;

static void gather(Lanes *to, const double *from, size_t stride, const Places *places)
{
    EACH_LANE to->of[lane] = from[places->node[lane] * stride];
}

static void gather_chain(Lanes d[TRIANGLE], Lanes wrenches[AXES][AXES], const Chains *chains, size_t chain,
                         const Places *places)
{
    const size_t size = chains->size, squares = size * size, rows = size * AXES;
    const double *const from_d = chains->compliances + chain * squares;
    const double *const from_w = chains->wrenches + chain * rows;
    for (size_t row = 0; row < size; row++) {
        for (size_t column = 0; column <= row; column++)
            gather(&d[entry((int)row, (int)column)], from_d + row * size + column, chains->chains * squares, places);
        for (size_t axis = 0; axis < AXES; axis++)
            gather(&wrenches[row][axis], from_w + row * AXES + axis, chains->chains * rows, places);
    }
}

/* The usual sizes as constants, for which the loops unroll. */
static void add_chain_of_size(Lanes stiffness[TRIANGLE], Lanes d[TRIANGLE], Lanes wrenches[AXES][AXES], size_t size,
                              Lanes *safe)
{
    if (size == 1)
        add_chain(stiffness, d, wrenches, 1, safe);
    else if (size == 2)
        add_chain(stiffness, d, wrenches, 2, safe);
    else if (size == 3)
        add_chain(stiffness, d, wrenches, 3, safe);
    else
        add_chain(stiffness, d, wrenches, (int)size, safe);
}

static void write_node(double out[AXES * AXES], const Lanes compliance[TRIANGLE], int lane, int safe)
{
    for (int i = 0; i < AXES; i++)
        for (int j = 0; j <= i; j++)
            out[AXES * i + j] = out[AXES * j + i] = safe ? compliance[entry(i, j)].of[lane] : NAN;
}

void chain_compliance(const Chains *chains, double *out, uint8_t *safe)
{
    const size_t count = chains->count;
    for (size_t first = 0; first < count; first += GROUP) {
        Places places;
        Lanes stiffness[TRIANGLE] = {{{0.0}}}, d[TRIANGLE], wrenches[AXES][AXES], fine;
        EACH_LANE {
            places.node[lane] = first + (size_t)lane < count ? first + (size_t)lane : count - 1;
            fine.of[lane] = 1.0;
        }
        for (size_t chain = 0; chain < chains->chains; chain++) {
            gather_chain(d, wrenches, chains, chain, &places);
            add_chain_of_size(stiffness, d, wrenches, chains->size, &fine);
        }
        invert(stiffness, &fine);
        for (int lane = 0; lane < GROUP && first + (size_t)lane < count; lane++) {
            safe[first + (size_t)lane] = fine.of[lane] != 0.0;
            write_node(out + (first + (size_t)lane) * AXES * AXES, stiffness, lane, fine.of[lane] != 0.0);
        }
    }
}

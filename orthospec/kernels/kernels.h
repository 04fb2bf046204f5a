/* The kernels in plain C, without Python: contiguous arrays in, contiguous arrays out, where nothing else is said.
 *
 * Each stands once, in a file *.inc, and is compiled for several instruction sets (variant.h). All give the same
 * bits: no contraction to fused operations, and sums in one order.
 */
#ifndef ORTHOSPEC_KERNELS_H
#define ORTHOSPEC_KERNELS_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define LEAST(a, b) ((a) < (b) ? (a) : (b))

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

/* `count` matrices, rows x columns; the entry (i, j) of node n stands at data + n * node + i * row + j * column, in
 * doubles. */
typedef struct {
    const double *data;
    ptrdiff_t node, row, column;
    size_t count;
    ptrdiff_t rows, columns;
} Matrices;

/* `count` nodes, each of `chains` chains that transmit `size` <= 6 wrenches. */
typedef struct {
    const double *compliances; /* count x chains x size x size, symmetric, of which the lower triangles are read */
    const double *wrenches;    /* count x chains x size x 6 */
    size_t count, chains, size;
} Chains;

/* Three legs on slides, and `count` poses (count x 3). */
typedef struct {
    const double *geometry; /* 3 x 8: a slide's unit axis, the way from its base point to the leg's end with the tool at
                             * the origin, the leg's length, and its branch, 1 or -1 */
    const double *poses;
    size_t count;
} Slides;

/* Where the legs over `count` poses go; the poses are the last axis but for rho. */
typedef struct {
    double *rho;     /* count x 3 */
    double *s;       /* 3 x 3 x count */
    double *along;   /* 3 x count */
    double *closing; /* 3 x count */
} ClosedLegs;

/* What the margins of three legs are told by. */
typedef struct {
    const double *scales;  /* 3 x 7: a leg's length squared, its branch over its length, a row of the home directions'
                            * inverse transposed, the sign of their determinant, and the least (s.e / L)^2 */
    const double *s;       /* 3 x 3 x count */
    const double *closing; /* 3 x count */
    size_t count;
} LegRoom;

/* Three elastic legs on slides over `count` poses. */
enum { ELASTIC_NUMBERS = 21 };
typedef struct {
    const double *numbers; /* 3 x ELASTIC_NUMBERS: as elastic_legs.inc names them */
    const double *feet;    /* 3 x 6 x 6: a foot's compliance along the axes of space, 0 where it is rigid */
    const double *s;       /* 3 x 3 x count */
    size_t count;
} ElasticLegs;

/* Nodes are set where at_least <= low and high <= at_most. */
typedef struct {
    const double *low, *high; /* in the layout of `strides`, in doubles */
    ptrdiff_t strides[3];
    double at_least, at_most;
} Bounds;

/* Nodes of a grid, set or not. */
typedef struct {
    const uint8_t *mask; /* set where nonzero; NULL where bounds tell it */
    Bounds bounds;
    size_t shape[3];
    int flat; /* squares are looked for along the first and last axis; the other has one node */
} Nodes;

/* The longest edge, in nodes, that a cube among these may have. */
static inline size_t longest_edge(const Nodes *nodes)
{
    const size_t square = LEAST(nodes->shape[0], nodes->shape[2]);
    return nodes->flat ? square : LEAST(square, nodes->shape[1]);
}

/* 64-bit words of a row of nodes as bits, of which the last is unset; and words to work in, with `planes` of rows. */
static inline size_t words_of_row(const Nodes *nodes)
{
    return nodes->shape[2] / 64 + 1;
}

static inline size_t room_for_cubes(const Nodes *nodes, size_t planes)
{
    return (planes + 3) * nodes->shape[1] * words_of_row(nodes);
}

/* Kernels that go through numbers side by side take so many at a time, and so many quantities known by bounds. */
enum { GROUP = 32, INTERVAL_BLOCK = 256 };

/* One number of each node of a group. */
typedef struct {
    double of[GROUP];
} Lanes;

/* Quantities of which only bounds are known: their ends and, over boxes of d > 0 coordinates, their mean-value forms
 * c + sum_k g_k u_k with a rest of at most r. The slopes g_k stand `next` numbers apart. */
typedef struct {
    const double *lo, *hi, *c, *r, *g;
    ptrdiff_t next;
    int exact; /* numbers: both ends are one, and the forms have neither slopes nor a rest */
} Known;

typedef struct {
    double *lo, *hi, *c, *r, *g;
    ptrdiff_t next;
} Found;

/* What is added for rounding: see orthospec/intervals/rounding.py. */
#define INTERVAL_ULP 0x1p-52
#define INTERVAL_TINIEST 0x1p-1074
#define INTERVAL_TINY 1e-300
#define INTERVAL_SPARE (1.0 + 0x1p-45)
#define INTERVAL_FEW 0x1p-48

/* The greater of two numbers; NaN where one is. */
static inline double greater_of(double a, double b)
{
    return a > b || a != a ? a : b;
}

/* How far lo and hi are from m at most. */
static inline double interval_radius(double lo, double hi, double m)
{
    return greater_of(hi - m, m - lo) * INTERVAL_SPARE + INTERVAL_TINY;
}

typedef enum { NUMBERS, WITHOUT_FORMS, WITH_FORMS } Knowledge;

/* One factor of sums of products, for a group of lanes: `interval_width` numbers of each of its `count` entries, of
 * which ends and forms stand there when it is `fresh`. The entry of output p and term t is of_out[p] + of_term[t]. */
typedef struct {
    Lanes *entries;
    size_t count;
    Knowledge kind;
    int fresh;
    const size_t *of_out, *of_term;
} Factor;

typedef struct {
    Factor x, y;
    size_t outs, terms, d;
} Contraction;

/* Numbers that a factor has of each entry: middle, radius, c, r, spread and slopes. */
static inline size_t interval_width(size_t d)
{
    return d > 0 ? 5 + d : 2;
}

/* Numbers of a result: lo, hi and, with forms, c, r and slopes. */
static inline size_t interval_rows(size_t d)
{
    return d > 0 ? 4 + d : 2;
}

/* One instruction set's kernels. */
typedef struct {
    const char *name;
    /* Edge, in nodes, of the largest cube of nonzero nodes that ends at each node.
     * The smallest of `shape` must be in the range of the cells of `sizes`. */
    void (*cube_sizes_u8)(const uint8_t *mask, uint8_t *sizes, const size_t shape[3]);
    void (*cube_sizes_u16)(const uint8_t *mask, uint16_t *sizes, const size_t shape[3]);
    /* Edge, in nodes, of the largest cube of set nodes; in room for as many planes as the longest edge has nodes. */
    size_t (*largest_cube)(const Nodes *nodes, uint64_t *room);
    /* Where cubes of an edge > 0 end: rows of words, the least bit first; in room for `edge` planes. */
    void (*cube_ends)(const Nodes *nodes, size_t edge, uint64_t *room, uint64_t *ends);
    /* Eigenvalues, ascending, of symmetric matrices of up to 6 rows, of which the lower triangles are read. */
    void (*symmetric_eigenvalues)(const Matrices *matrices, double *eigenvalues);
    /* Those and unit vectors to them, in the columns of count matrices. */
    void (*symmetric_eigenvectors)(const Matrices *matrices, double *eigenvalues, double *vectors);
    /* The eigenvalues of A^T A. */
    void (*gram_eigenvalues)(const Matrices *matrices, double *eigenvalues);
    /* Inverses of symmetric positive definite matrices of up to 6 rows, of which the lower triangles are read; a
     * node that is not safe to compute so is NaN. */
    void (*positive_inverse)(const Matrices *matrices, double *inverses, uint8_t *safe);
    /* What such matrices take to `right` (count x rows x any), in its shape. */
    void (*positive_solve)(const Matrices *matrices, const Matrices *right, double *solutions, uint8_t *safe);
    /* The length of each row (count x rows). */
    void (*row_norms)(const Matrices *matrices, double *norms);
    /* Compliance of each node's platform (count x 6 x 6); a node that is not safe to compute so is NaN. */
    void (*chain_compliance)(const Chains *chains, double *out, uint8_t *safe);
    /* That of a platform on three legs on slides. */
    void (*legs_compliance)(const ElasticLegs *legs, double *out, uint8_t *safe);
    /* The loops of the legs closed. */
    void (*close_legs)(const Slides *slides, const ClosedLegs *legs);
    /* The margins of the three legs, of the volume and of the pairs (5 x count). */
    void (*leg_margins)(const LegRoom *room, double *margins);
    /* Of up to INTERVAL_BLOCK quantities, x + y (y may be exact), x y, and the narrower of the ends and the form of x. */
    void (*add_intervals)(const Known *x, const Known *y, size_t count, size_t d, const Found *out);
    void (*multiply_intervals)(const Known *x, const Known *y, size_t count, size_t d, const Found *out);
    void (*narrow_intervals)(const Known *x, size_t count, size_t d, const Found *out);
    /* Sums of products: `interval_rows` numbers of each output. */
    void (*contract_intervals)(const Contraction *by, Lanes *out);
} Kernels;

/* Those that this processor can run, the best first; ends with NULL. */
const Kernels *const *kernels_at_hand(void);

#endif

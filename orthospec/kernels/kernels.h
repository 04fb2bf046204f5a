/* The kernels in plain C, without Python: contiguous arrays in, contiguous arrays out. */
#ifndef ORTHOSPEC_KERNELS_H
#define ORTHOSPEC_KERNELS_H

#include <stddef.h>
#include <stdint.h>

/* Edge, in nodes, of the largest cube of nonzero nodes that ends at each node.
 * The smallest of `shape` must be in the range of the cells of `sizes`. */
void cube_sizes_u8(const uint8_t *mask, uint8_t *sizes, const size_t shape[3]);
void cube_sizes_u16(const uint8_t *mask, uint16_t *sizes, const size_t shape[3]);

/* Eigenvalues, ascending, of `count` symmetric 3 x 3 matrices, of which the lower triangles are read. */
void symmetric_eigenvalues_3(const double *matrices, double *eigenvalues, size_t count);

/* `count` nodes, each of `chains` chains that transmit `size` <= 6 wrenches. */
typedef struct {
    const double *compliances; /* count x chains x size x size, symmetric, of which the lower triangles are read */
    const double *wrenches;    /* count x chains x size x 6 */
    size_t count, chains, size;
} Chains;

/* Compliance of each node's platform (count x 6 x 6); a node that is not safe to compute so is NaN. */
void chain_compliance(const Chains *chains, double *out, uint8_t *safe);

#endif

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

#endif

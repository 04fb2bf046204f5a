/* All kernels, compiled for the instruction set of the file that includes this and defines VARIANT and NAME. */
#include "cube_sizes.inc"
#include "lanes.inc"
#include "factors.inc"
#include "chains.inc"
#include "elastic_legs.inc"
#include "positive.inc"
#include "eigenvalues.inc"
#include "tridiagonal.inc"
#include "jacobi.inc"
#include "rows.inc"
#include "legs.inc"
#include "pack.inc"
#include "largest_cubes.inc"
#include "intervals.inc"

const Kernels VARIANT = {
    .name = NAME,
    .cube_sizes_u8 = cube_sizes_u8,
    .cube_sizes_u16 = cube_sizes_u16,
    .largest_cube = largest_cube,
    .cube_ends = cube_ends,
    .symmetric_eigenvalues = symmetric_eigenvalues,
    .symmetric_eigenvectors = symmetric_eigenvectors,
    .gram_eigenvalues = gram_eigenvalues,
    .positive_inverse = positive_inverse,
    .positive_solve = positive_solve,
    .row_norms = row_norms,
    .chain_compliance = chain_compliance,
    .legs_compliance = legs_compliance,
    .close_legs = close_legs,
    .leg_margins = leg_margins,
    .add_intervals = add_intervals,
    .multiply_intervals = multiply_intervals,
    .narrow_intervals = narrow_intervals,
    .contract_intervals = contract_intervals,
};

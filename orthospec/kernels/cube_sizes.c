/* The largest cube of ones that ends at each node of a mask.
 *
 * Pashkevich, Chablat and Wenger (2009), section 4: where the mask is 1,
 *
 *     size[i,j,k] = 1 + min of the seven predecessors                                          (paper)
 *                 = min(run[i,j,k], 1 + min of the six predecessors outside the own row)        (here)
 *
 * with run[i,j,k] the number of ones in a row that end at k. They are equal: let d be the least of the six.
 * Of the (d+1)-cube that ends here, the four cubes of plane i-1 cover all below plane i, the two of row j-1
 * cover plane i below row j, and a run of d+1 covers the rest. The paper's form is a serial chain along k;
 * here only the run is one, a cheap one, and all else goes element by element, in vector registers.
 */
#include "kernels.h"

#include <string.h>

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

#define LEAST(a, b) ((a) < (b) ? (a) : (b))

/* Nodes looked at together when runs are counted: most stretches of a workspace are all ones or all zeros. */
enum { STRETCH = 16 };

static const uint8_t ONES[STRETCH] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
static const uint8_t ZEROS[STRETCH] = {0};

#define CELL uint8_t
#define NAME(stem) stem##_u8
#include "cube_sizes_of_cell.h"
#undef CELL
#undef NAME

#define CELL uint16_t
#define NAME(stem) stem##_u16
#include "cube_sizes_of_cell.h"

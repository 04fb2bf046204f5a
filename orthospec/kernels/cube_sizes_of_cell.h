/* The body of cube_sizes.c for one type of cell, CELL; NAME(stem) names its functions. */

/* Ones in a row that end at each node, cut off at `limit`: no cube is larger. */
static void NAME(count_runs)(const uint8_t *RESTRICT mask, CELL *RESTRICT runs, size_t n, size_t limit)
{
    size_t run = 0, k = 0;
    while (k < n) {
        if (k + STRETCH <= n && memcmp(mask + k, ONES, STRETCH) == 0) {
            const unsigned before = (unsigned)LEAST(run, limit), most = (unsigned)limit;
            for (unsigned t = 0; t < STRETCH; t++) {
                const unsigned here = before + t + 1;
                runs[k + t] = (CELL)LEAST(here, most);
            }
            run += STRETCH;
            k += STRETCH;
        } else if (k + STRETCH <= n && memcmp(mask + k, ZEROS, STRETCH) == 0) {
            memset(runs + k, 0, STRETCH * sizeof *runs);
            run = 0;
            k += STRETCH;
        } else {
            const size_t end = LEAST(k + STRETCH, n);
            for (; k < end; k++) {
                run = (run + 1) & (0 - (size_t)(mask[k] != 0)); /* no branch: noise would mislead it */
                runs[k] = (CELL)LEAST(run, limit);
            }
        }
    }
}

/* Runs become sizes. Nodes at the start of a row have no predecessors: their size is the mask.
 * The sum fits a cell: the least predecessor's cube stands clear of the far sides of the mask. */
static void NAME(join_rows)(CELL *RESTRICT row, const CELL *RESTRICT below, const CELL *RESTRICT beside,
                            const CELL *RESTRICT diagonal, size_t n)
{
    row[0] = LEAST(row[0], 1);
    for (size_t k = 1; k < n; k++) {
        const CELL here = LEAST(LEAST(below[k], beside[k]), diagonal[k]);
        const CELL before = LEAST(LEAST(below[k - 1], beside[k - 1]), diagonal[k - 1]);
        const CELL joined = (CELL)(LEAST(here, before) + 1);
        row[k] = LEAST(row[k], joined);
    }
}

void NAME(cube_sizes)(const uint8_t *mask, CELL *sizes, const size_t shape[3])
{
    const size_t nj = shape[1], nk = shape[2], plane = nj * nk;
    const size_t limit = LEAST(LEAST(shape[0], nj), nk);
    if (limit == 0)
        return;
    for (size_t i = 0; i < shape[0]; i++) {
        for (size_t j = 0; j < nj; j++) {
            const size_t at = i * plane + j * nk;
            const int at_the_side = i == 0 || j == 0;
            NAME(count_runs)(mask + at, sizes + at, nk, at_the_side ? 1 : limit);
            if (!at_the_side)
                NAME(join_rows)(sizes + at, sizes + at - plane, sizes + at - nk, sizes + at - plane - nk, nk);
        }
    }
}

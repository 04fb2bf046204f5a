"""One thread for linear algebra: the matrices are small, and processes are what shares out the work."""

from __future__ import annotations

import os

_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_blas_thread() -> None:
    """Let BLAS libraries loaded from now on, here or in processes begun here, use one thread.

    Several could also add in another order, and a result would depend on the machine's cores.
    """
    for name in _VARIABLES:
        os.environ[name] = "1"

"""Arrays as the kernels read them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from orthospec.arrays import Array


def numbers(array: Array) -> Array:
    """As float64, in whatever order they lie, but each at an address of a float64."""
    found = np.asarray(array, dtype=np.float64)
    return found if found.flags.aligned else found.copy()

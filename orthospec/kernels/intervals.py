"""Intervals with mean-value forms: `orthospec.intervals.fused` is what they are for.

Quantities are tuples of arrays, with any strides: (numbers,), (lo, hi) or, over boxes of d coordinates,
(lo, hi, c, g, r), of which g has one axis of d more at the end. Results are rows: lo, hi and, where d > 0, c,
r and d rows of g.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.kernels import _kernels

if TYPE_CHECKING:
    from orthospec.arrays import Array

    Quantities: TypeAlias = tuple[Array, ...]


def add_intervals(x: Quantities, y: Quantities, shape: tuple[int, ...], d: int) -> Array:
    """The rows of x + y, broadcast to a shape; of both only y may be numbers where d > 0."""
    rows = _rows(shape, d)
    _kernels.add_intervals(x, y, rows)
    return rows


def multiply_intervals(x: Quantities, y: Quantities, shape: tuple[int, ...], d: int) -> Array:
    """The rows of x y, broadcast to a shape."""
    rows = _rows(shape, d)
    _kernels.multiply_intervals(x, y, rows)
    return rows


def narrow_intervals(x: Quantities, shape: tuple[int, ...], d: int) -> Array:
    """The rows of x, its ends no wider than its form, which knows nothing else where it was not finite."""
    rows = _rows(shape, d)
    _kernels.narrow_intervals(x, rows)
    return rows


def contract_intervals(
    x: Quantities, x_axes: bytes, y: Quantities, y_axes: bytes, shape: tuple[int, ...], d: int
) -> Array:
    """The rows of sums of products of x and y.

    The axes of the result have the numbers 0, 1, ..., what is summed over those that follow; the bytes tell
    which of them each axis of x and of y runs over.
    """
    rows = _rows(shape, d)
    _kernels.contract_intervals(x, x_axes, y, y_axes, rows)
    return rows


def _rows(shape: tuple[int, ...], d: int) -> Array:
    return np.empty((4 + d if d else 2, *shape))

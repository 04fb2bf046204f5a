"""The largest cube of set nodes: its size, and where all of that size end.

A cube of nodes is one of indices; over two axes it is a square. It *ends* at its node of greatest indices.

>>> import numpy as np
>>> mask = np.zeros((9, 9, 9), dtype=bool)
>>> mask[1:5, 2:6, 3:7] = True
>>> largest_cube(mask), cube_ends(mask, 4).tolist()
(4, [[4, 5, 6]])
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.kernels import _kernels

if TYPE_CHECKING:
    from typing import Any, TypeAlias

    from numpy.typing import NDArray

    from orthospec.arrays import Array

    Mask: TypeAlias = NDArray[np.uint8 | np.bool_]

__all__ = ["Within", "cube_ends", "largest_cube"]


@dataclass(frozen=True)
class Within:
    """The nodes at which a field is within bounds: a mask that is never written down. NaN is not within.

    ``field`` has a value for each node of a grid of this shape, (n,), or the least and the greatest, (n, 2),
    in the order of the nodes. Of two, the least is held to ``at_least`` and the greatest to ``at_most``.
    """

    field: Array
    shape: tuple[int, ...]
    at_least: float = -np.inf
    at_most: float = np.inf


def largest_cube(nodes: Mask | Within) -> int:
    """Edge, in nodes, of the largest cube of nodes that are set; 0 where none is.

    ``nodes`` is a mask of two or three axes, nonzero where a node is set, or `Within`. A bit a node is held.
    """
    source, axes = _source(nodes)
    return _kernels.largest_cube(source, axes)


def cube_ends(nodes: Mask | Within, edge: int) -> NDArray[np.int64]:
    """The indices (n, axes) at which cubes of set nodes of this edge end, also those within larger ones.

    In the order of the nodes. Raises ValueError where the grid has no room for such a cube, or ``edge`` < 1.
    """
    source, axes = _source(nodes)
    shape = source[0].shape
    words = np.empty((shape[0], shape[1], shape[2] // 64 + 1), dtype=np.uint64)
    _kernels.cube_ends(source, axes, edge, words)
    places = np.flatnonzero(words)
    bits = words.ravel()[places].astype("<u8").view(np.uint8).reshape(-1, 8)
    which, bit = np.nonzero(np.unpackbits(bits, axis=1, bitorder="little"))
    i, j, word = np.unravel_index(places[which], words.shape)
    k = word * 64 + bit
    return np.column_stack([i, j, k] if axes == 3 else [i, k])


def _source(nodes: Mask | Within) -> tuple[tuple[Any, ...], int]:
    """The nodes as the kernel takes them, along three axes, and how many axes they have."""
    if not isinstance(nodes, Within):
        mask = np.ascontiguousarray(nodes)
        return (_solid(mask, mask.shape),), mask.ndim
    field = np.asarray(nodes.field, dtype=np.float64)
    low, high = (field, field) if field.ndim == 1 else (field[:, 0], field[:, 1])
    parts = (_solid(low, nodes.shape), _solid(high, nodes.shape), nodes.at_least, nodes.at_most)
    return parts, len(nodes.shape)


def _solid(values: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """With a second axis of one node between the two of a plane."""
    return values.reshape((shape[0], 1, shape[1]) if len(shape) == 2 else shape)

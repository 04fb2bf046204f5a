"""Cuboids in the pose space, and the largest one on a mask of grid nodes.

On a grid whose steps are the prescribed size over N_0, a cuboid of the prescribed proportions is a cube of
indices; the dynamic program of Pashkevich, Chablat and Wenger (2009), section 4, finds the largest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec import kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Poses


@dataclass(frozen=True)
class Cuboid:
    """The poses between two corners, in the first ``len(low)`` pose axes [m, rad]."""

    low: tuple[float, ...]
    high: tuple[float, ...]

    @classmethod
    def around(cls, centre: Array, size: Array) -> Cuboid:
        """The cuboid of this size with this centre."""
        return cls(tuple(map(float, centre - size / 2)), tuple(map(float, centre + size / 2)))

    @property
    def centre(self) -> Array:
        """Its centre (d,)."""
        return np.asarray(np.mean([self.low, self.high], axis=0))

    @property
    def size(self) -> Array:
        """Its edges (d,)."""
        return np.subtract(self.high, self.low)

    def poses(self, u: Array, coordinates: int) -> Poses:
        """Poses (n, coordinates) at u (n, d) in [−1/2, 1/2]; further pose coordinates are 0."""
        poses = np.zeros((len(u), coordinates))
        poses[:, : u.shape[1]] = self.centre + u * self.size
        poses.flags.writeable = False
        return poses


@dataclass(frozen=True)
class Placement:
    """A cube of indices: ``steps`` long, from the node ``corner``; ``ties`` places have the same length."""

    steps: int
    corner: tuple[int, ...]
    ties: int


def edge_lengths(mask: NDArray[np.bool_]) -> NDArray[Any]:
    """Φ: edge, in nodes, of the largest cube (square, for two axes) of ones ending at each node."""
    return kernels.cube_sizes(mask) if mask.ndim == 3 else _square_sizes(mask)


def largest(edges: NDArray[Any]) -> Placement | None:
    """The largest cube; of equal ones that whose centre is nearest the mean of their centres, then the first.

    Distances are compared in integers. None where no node is set; a single node is a cube of 0 steps.
    """
    edge = int(edges.max(initial=0))
    return None if edge == 0 else _nearest_mean(np.argwhere(edges == edge), edge)


def clusters(edges: NDArray[Any]) -> list[Placement]:
    """One placement for each cluster of cubes within one step of the largest, the largest clusters first.

    A grid can prefer the wrong component of the feasible set: it under-reports each by up to two steps.
    """
    from scipy import ndimage

    edge = int(edges.max(initial=0))
    if edge == 0:
        return []
    near = edges >= max(edge - 1, 1)
    labels, count = ndimage.label(near, structure=np.ones((3,) * near.ndim))
    nodes, label = np.argwhere(near), labels[near]
    sizes = edges[near]
    found = []
    for k in range(1, count + 1):
        best = int(sizes[label == k].max())
        found.append(_nearest_mean(nodes[(label == k) & (sizes == best)], best))
    return sorted(found, key=lambda placement: (-placement.steps, -placement.ties, placement.corner))


def _nearest_mean(ends: NDArray[np.int64], edge: int) -> Placement:
    count = len(ends)
    # count·(end − mean) in whole numbers; Python's own where 64 bits could overflow.
    offsets = ends * count - ends.sum(axis=0)
    if int(np.abs(offsets).max()) > 1_000_000_000:
        offsets = offsets.astype(object)
    nearest = ends[int(np.argmin((offsets**2).sum(axis=1)))]
    return Placement(edge - 1, tuple(int(i) - edge + 1 for i in nearest), count)


def _square_sizes(mask: NDArray[np.bool_]) -> NDArray[Any]:
    """Φ of a plane, row by row: min(run of ones in the row, 1 + the lesser of the two predecessors above)."""
    index = np.arange(1, mask.shape[1] + 1)
    runs = index - np.maximum.accumulate(np.where(mask, 0, index), axis=1)
    edges = np.zeros(mask.shape, dtype=np.int64)
    above = np.zeros(mask.shape[1] + 1, dtype=np.int64)
    for i, run in enumerate(runs):
        edges[i] = np.minimum(run, 1 + np.minimum(above[1:], above[:-1]))
        above[1:] = edges[i]
    return edges

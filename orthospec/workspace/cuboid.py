"""Cuboids in the pose space, and the largest one on a mask of grid nodes.

On a grid whose steps are the prescribed size over N_0, a cuboid of the prescribed proportions is a cube of
indices (Pashkevich, Chablat and Wenger, 2009, section 4); the kernels find the largest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

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


def largest(mask: NDArray[np.bool_]) -> Placement | None:
    """The largest cube (square, for two axes) of nodes that are set.

    Of equal ones that whose centre is nearest the mean of their centres, then the first; distances are
    compared in integers. None where no node is set; a single node is a cube of 0 steps.
    """
    edge = kernels.largest_cube(mask)
    return None if edge == 0 else _nearest_mean(kernels.cube_ends(mask, edge), edge)


def clusters(mask: NDArray[np.bool_]) -> list[Placement]:
    """One placement for each cluster of cubes within one step of the largest, the largest clusters first.

    A grid can prefer the wrong component of the feasible set: it under-reports each by up to two steps.
    """
    from scipy import ndimage

    edge = kernels.largest_cube(mask)
    if edge == 0:
        return []
    ends = kernels.cube_ends(mask, max(edge - 1, 1))
    first = ends.min(axis=0)
    # 1 where a cube one step smaller ends, 2 where one of the largest does; about these nodes alone.
    marks = np.zeros(ends.max(axis=0) - first + 1, dtype=np.uint8)
    places = tuple((ends - first).T)
    marks[places] = 1
    marks[tuple((kernels.cube_ends(mask, edge) - first).T)] = 2
    labels, count = ndimage.label(marks, structure=np.ones((3,) * marks.ndim))
    label, size = labels[places], edge - 2 + marks[places].astype(int)
    found = []
    for k in range(1, count + 1):
        best = int(size[label == k].max())
        found.append(_nearest_mean(ends[(label == k) & (size == best)], best))
    return sorted(found, key=lambda placement: (-placement.steps, -placement.ties, placement.corner))


def _nearest_mean(ends: NDArray[np.int64], edge: int) -> Placement:
    count = len(ends)
    # count·(end − mean) in whole numbers; Python's own where 64 bits could overflow.
    offsets = ends * count - ends.sum(axis=0)
    if int(np.abs(offsets).max()) > 1_000_000_000:
        offsets = offsets.astype(object)
    nearest = ends[int(np.argmin((offsets**2).sum(axis=1)))]
    return Placement(edge - 1, tuple(int(i) - edge + 1 for i in nearest), count)

"""The workspace grid: nodes at whole multiples of its step from the origin of the pose axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import GridTooLarge, UsageError
from orthospec.manipulators import Manipulator
from orthospec.workspace.cuboid import Cuboid, Placement

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Poses

LATTICE = 33
"""Nodes along each axis of the lattice that looks for the reach."""
MOST_NODES = 1_000_000_000
"""More nodes than this are refused: a byte and more of each is held."""
COARSENED = 100_000_000
"""Nodes, roughly, of the coarser grid that is taken where one would be too large."""
DOUBLINGS = 24
"""How often the search box may double before the reach is said to have no end."""
REFINEMENTS = 24
"""How often the box about the reach is found anew at most."""


@dataclass(frozen=True)
class Grid:
    """Nodes ``first`` ... ``first + shape − 1`` (whole multiples of ``step`` along each axis)."""

    step: tuple[float, ...]
    first: tuple[int, ...]
    shape: tuple[int, ...]
    coordinates: int
    """Length of a pose; coordinates beyond the grid's axes are 0."""

    @property
    def nodes(self) -> int:
        """How many nodes there are."""
        return int(np.prod(self.shape, dtype=np.int64))

    def poses(self, start: int, stop: int) -> Poses:
        """Poses of the nodes start ... stop − 1 in C order, read-only."""
        stop = min(stop, self.nodes)
        poses = np.zeros((stop - start, self.coordinates))
        row = self.shape[-1]
        first, last = start // row, -(-stop // row)
        # A row's coordinates are the axis itself, and all others stand still along it.
        places = np.unravel_index(np.arange(first, last), self.shape[:-1])
        skipped = start - first * row
        for k, place in enumerate(places):
            poses[:, k] = np.repeat(self.axis(k)[place], row)[skipped : skipped + len(poses)]
        poses[:, len(places)] = np.tile(self.axis(len(places)), last - first)[skipped : skipped + len(poses)]
        poses.flags.writeable = False
        return poses

    def axis(self, k: int) -> Array:
        """Coordinates of the nodes along axis k [m, rad]."""
        return np.asarray((self.first[k] + np.arange(self.shape[k])) * self.step[k], dtype=float)

    def cuboid(self, placement: Placement) -> Cuboid:
        """The cuboid that a cube of indices spans."""
        low = [(self.first[k] + i) * self.step[k] for k, i in enumerate(placement.corner)]
        high = [(self.first[k] + i + placement.steps) * self.step[k] for k, i in enumerate(placement.corner)]
        return Cuboid(tuple(map(float, low)), tuple(map(float, high)))


def make_grid(manipulator: Manipulator, size: Array, divisions: float, region: Cuboid | None) -> Grid:
    """The grid of steps size / divisions over the region, or over the reach where none is given.

    Raises UsageError where the reach cannot be found, or not one node lies in the region, GridTooLarge for
    too many nodes.
    """
    step = size / divisions
    box = region if region is not None else reach_box(manipulator, size)
    first = np.ceil(np.array(box.low) / step - 1e-9).astype(int)
    last = np.floor(np.array(box.high) / step + 1e-9).astype(int)
    if (last < first).any():
        raise UsageError("the region holds no node of the grid: enlarge workspace.region or raise divisions")
    shape = tuple(int(n) for n in last - first + 1)
    if math.prod(shape) > MOST_NODES:
        raise GridTooLarge(shape, MOST_NODES)
    return Grid(tuple(map(float, step)), tuple(map(int, first)), shape, len(manipulator.axes))


def fitting_divisions(manipulator: Manipulator, size: Array, divisions: int, region: Cuboid | None) -> float:
    """The divisions, or fewer where their grid would be too large; less than 1 is a step beyond the size."""
    try:
        make_grid(manipulator, size, divisions, region)
    except GridTooLarge as large:
        fewer: float = divisions * (COARSENED / large.nodes) ** (1 / len(size))
        return math.floor(fewer) if fewer >= 1 else fewer
    return divisions


def reach_box(manipulator: Manipulator, size: Array) -> Cuboid:
    """A box around all reachable poses, by a lattice that is refined along each axis; larger by a step of it.

    It is sought in a box as long along all lengths (or angles) as the longest of the cuboid's edges, doubled
    until nothing touches its faces: a reach has proportions of its own.

    Raises UsageError where nothing is reachable, or the reach has no end: the spec's region says it then.
    """
    half = _evened(size, manipulator.axes)
    lattice = _lattice(len(size))
    on_faces = (np.abs(lattice) == 0.5).any(axis=1)
    for _ in range(DOUBLINGS):
        box = Cuboid.around(np.zeros(len(size)), 2 * half)
        # The faces first: they are few, and decide it for all but the last box.
        if not _reachable(manipulator, box, lattice[on_faces]).any():
            inside = _reachable(manipulator, box, lattice)
            if inside.any():
                return _fitted(manipulator, _around(box, inside), lattice)
        half *= 2
    raise UsageError("the machine's reach was not found, or has no end: give workspace.region in the spec")


def _evened(size: Array, axes: Sequence[str]) -> Array:
    """The longest edge of the same kind for each one (d,): of the lengths, or of the angles."""
    turns = np.array([axis.startswith("r") for axis in axes[: len(size)]])
    return np.asarray(np.where(turns, size[turns].max(initial=0.0), size[~turns].max(initial=0.0)))


def _fitted(manipulator: Manipulator, box: Cuboid, lattice: Array) -> Cuboid:
    """The box about the reach found anew on its own lattice, until that halves no edge nor goes beyond it."""
    for _ in range(REFINEMENTS):
        closer = _around(box, _reachable(manipulator, box, lattice))
        outside = np.less(closer.low, box.low) | np.greater(closer.high, box.high)
        if not (outside | (closer.size < box.size / 2)).any():
            return closer
        box = closer
    return box


def _lattice(d: int) -> Array:
    """Places u of the nodes in a box, C order (LATTICE^d, d)."""
    axis = np.linspace(-0.5, 0.5, LATTICE)
    return np.stack(np.meshgrid(*[axis] * d, indexing="ij"), axis=-1).reshape(-1, d)


def _reachable(manipulator: Manipulator, box: Cuboid, u: Array) -> NDArray[np.bool_]:
    return np.asarray(manipulator.inverse_kinematics(box.poses(u, len(manipulator.axes)))[1])


def _around(box: Cuboid, inside: NDArray[np.bool_]) -> Cuboid:
    """The part of the box that holds the lattice's nodes found inside, and one lattice step more."""
    where = np.argwhere(inside.reshape((LATTICE,) * len(box.low)))
    if len(where) == 0:
        return box
    pitch = box.size / (LATTICE - 1)
    low = np.array(box.low) + (where.min(axis=0) - 1) * pitch
    high = np.array(box.low) + (where.max(axis=0) + 1) * pitch
    return Cuboid(tuple(map(float, low)), tuple(map(float, high)))

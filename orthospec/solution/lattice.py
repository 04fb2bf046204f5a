"""`Lattice`: the reach and the measures of a design at the nodes of a coarse grid, for looking at.

Its nodes stand closer together along no axis than along another, whatever the proportions of the prescribed
cuboid, so that surfaces come out smooth from all sides. What is decided is decided on the grid of a run, not
here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.field import BLOCK, measured
from orthospec.workspace.grid import reach_box

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.spec import Design, Region

NODES = 49
"""Nodes along the longest edge unless said otherwise: some 0.1 million in all."""
FEWEST = 3
"""Nodes along the shortest edge, however flat a region is."""


@dataclass(frozen=True)
class Lattice:
    """Values at the nodes of a grid over d axes of the pose, arrays shaped (n1, ..., nd)."""

    axes: tuple[Array, ...]
    """Coordinates of the nodes along each axis [m, rad]."""
    margin: Array
    """The least margin of the reach, >= 0 inside; NaN where it cannot be computed."""
    reachable: Array
    """Whether the machine reaches the node (bool)."""
    values: Mapping[str, Array]
    """Each measure by its name, (...) or (..., 2) for least and greatest; NaN out of reach."""

    @property
    def box(self) -> Cuboid:
        """The box that the nodes fill."""
        return Cuboid(
            tuple(float(axis[0]) for axis in self.axes), tuple(float(axis[-1]) for axis in self.axes)
        )


def sampled(design: Design, region: Cuboid | Region | None, size: Array, nodes: int = NODES) -> Lattice:
    """The design at so many nodes along the longest edge of a region, or of a box around its reach.

    ``size`` (d,) is the prescribed cuboid's, from which the reach is looked for. Raises `UsageError` where
    the reach has no end or is not found, `PluginFault` where a measure fails.
    """
    box = _box(region) or reach_box(design.manipulator, np.asarray(size, dtype=float))
    axes = _axes(box, nodes)
    return _measured(design, axes, np.zeros(len(design.manipulator.axes)), tuple(range(len(axes))))


def sliced(design: Design, box: Cuboid, through: Array, across: tuple[int, int], nodes: int) -> Lattice:
    """The design in a plane: at so many nodes along each of two pose axes of the box (n1, n2).

    The other coordinates are those of the pose ``through`` (d,). Raises `PluginFault` where a measure fails.
    """
    axes = tuple(np.linspace(box.low[k], box.high[k], nodes) for k in across)
    pose = np.pad(through, (0, len(design.manipulator.axes) - len(through)))
    return _measured(design, axes, pose, across)


def _measured(design: Design, axes: tuple[Array, ...], pose: Array, along: tuple[int, ...]) -> Lattice:
    """All there is to tell at the nodes of these axes of the pose, the other coordinates as in ``pose``."""
    machine, shape = design.manipulator, tuple(map(len, axes))
    poses = np.tile(pose, (int(np.prod(shape)), 1))
    for k, values in zip(along, np.meshgrid(*axes, indexing="ij"), strict=True):
        poses[:, k] = values.ravel()
    margin = np.empty(len(poses))
    reachable = np.empty(len(poses), dtype=bool)
    found: dict[str, Array] = {}
    for start in range(0, len(poses), BLOCK):
        part = slice(start, start + BLOCK)
        block = poses[part]
        margin[part] = _least(np.stack(list(machine.reach(block).values())))
        reachable[part] = machine.inverse_kinematics(block)[1]
        inside = block[reachable[part]]
        inside.flags.writeable = False
        for demand in design.demands if len(inside) else ():
            values = measured(demand, machine, inside)
            whole = found.setdefault(demand.name, np.full((len(poses), *values.shape[1:]), np.nan))
            whole[part][reachable[part]] = values
    return Lattice(
        axes,
        margin.reshape(shape),
        reachable.reshape(shape),
        {name: values.reshape(*shape, *values.shape[1:]) for name, values in found.items()},
    )


def _box(region: Cuboid | Region | None) -> Cuboid | None:
    if region is None or isinstance(region, Cuboid):
        return region
    return Cuboid(region.min, region.max)


def _least(margins: Array) -> Array:
    """The least of the margins (k, n) that can be computed; NaN where a missing one might be less than 0."""
    least = np.fmin.reduce(margins)
    return np.where(np.isnan(margins).any(axis=0) & ~(least < 0), np.nan, least)


def _axes(box: Cuboid, nodes: int) -> tuple[Array, ...]:
    pitch = float(box.size.max()) / (nodes - 1)
    counts = [max(round(float(edge) / pitch) + 1, FEWEST) for edge in box.size]
    ends = zip(box.low, box.high, counts, strict=True)
    return tuple(np.linspace(low, high, count) for low, high, count in ends)

"""Measures over blocks of poses, and the states of the grid's nodes.

A measure is handed reachable poses only, in whole blocks. A node *meets* or *violates* the bounds, is
*unreachable*, or *failed*: the measure gave NaN though the pose is reachable. Only the first counts for a
cuboid, and a failed node is never silent: one at the isotropic pose shrinks the cuboid by a tenth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import RAISED, OrthospecError, PluginFault
from orthospec.manipulators import Manipulator
from orthospec.measures import Demand
from orthospec.measures.demand import ROUNDING
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Poses

BLOCK = 1 << 14
"""Poses to a block: bounded memory whatever the grid."""

Progress = Callable[[str, int, int], None]
"""Told what is being done, how much is done, and of how much."""


class State(IntEnum):
    """State of a node."""

    UNREACHABLE = 0
    MEETS = 1
    VIOLATES = 2
    FAILED = 3


@dataclass(frozen=True)
class Block:
    """Some measures at consecutive nodes of a grid, in C order from the node ``start``."""

    start: int
    reachable: NDArray[np.bool_]
    """Of each of its nodes."""
    values: Mapping[str, Array]
    """At the reachable nodes alone, by the measure's name: (r,) or (r, 2)."""

    @property
    def nodes(self) -> slice:
        """Where its nodes stand in a flat array of all of them."""
        return slice(self.start, self.start + len(self.reachable))


@dataclass(frozen=True)
class Failure:
    """A measure's first failed pose."""

    measure: str
    pose: tuple[float, ...]
    place: str | None


def measured(demand: Demand, manipulator: Manipulator, poses: Poses) -> Array:
    """The demand's measure at the poses: (n,) or (n, 2).

    Raises PluginFault where the measure raises, gives another shape or type, or least and greatest swapped.
    """
    try:
        values = demand.measure.values(manipulator, poses)
    except OrthospecError:
        raise
    except RAISED as error:
        raise PluginFault(_title(demand), f"raised {type(error).__name__}: {error}", demand.place) from error
    is_array = isinstance(values, np.ndarray) and not isinstance(values, np.ma.MaskedArray)
    if not is_array or values.dtype.kind != "f":
        raise PluginFault(
            _title(demand), f"gave {type(values).__name__}, not an array of floats", demand.place
        )
    n = len(poses)
    if values.shape not in {(n,), (n, 2)}:
        raise PluginFault(
            _title(demand), f"gave shape {values.shape} for {n} poses, not (n,) or (n, 2)", demand.place
        )
    if values.ndim == 2 and (swapped := _swapped(values)).any():
        least, greatest = values[int(np.argmax(swapped))]
        said = f"gave {least:.6g} as the least value and {greatest:.6g} as the greatest of one pose"
        raise PluginFault(_title(demand), said, demand.place)
    return values


def _swapped(values: Array) -> NDArray[np.bool_]:
    """Where the least value lies above the greatest one by more than rounding (n,)."""
    least, greatest = values[:, 0], values[:, 1]
    with np.errstate(invalid="ignore"):
        return np.asarray(least > greatest + ROUNDING * np.abs(greatest))


def _title(demand: Demand) -> str:
    return f"{type(demand.measure).__name__} (measure {demand.name})"


def measured_blocks(
    manipulator: Manipulator,
    demands: Sequence[Demand],
    grid: Grid,
    progress: Progress | None = None,
    start: int = 0,
    stop: int | None = None,
) -> Iterator[Block]:
    """The measures at the nodes start ... stop − 1, computed here block after block."""
    stop = grid.nodes if stop is None else stop
    for first in range(start, stop, BLOCK):
        poses = grid.poses(first, min(first + BLOCK, stop))
        reachable = np.asarray(manipulator.inverse_kinematics(poses)[1])
        if progress is not None:
            progress("grid", first + len(poses), grid.nodes)
        inside = poses if reachable.all() else poses[reachable]
        inside.flags.writeable = False
        values = {d.name: measured(d, manipulator, inside) if len(inside) else np.empty(0) for d in demands}
        yield Block(first, reachable, values)


Blocks = Callable[[Manipulator, Sequence[Demand], Grid, Progress | None], Iterator[Block]]
"""Who gives a field: each measure at each node once, in blocks of any size and order.

Without demands the blocks tell the reach.
"""


def node_states(
    manipulator: Manipulator,
    demands: Sequence[Demand],
    grid: Grid,
    progress: Progress | None = None,
    blocks: Blocks = measured_blocks,
) -> tuple[list[NDArray[np.uint8]], list[Failure]]:
    """The state of each node under each demand alone, shaped as the grid; and the first failure of each.

    Without demands the one array tells the reach alone (eq. 3 of the paper). Demands on equal measures share
    their values: levels, and bounds apart from each other.
    """
    states = [np.zeros(grid.nodes, dtype=np.uint8) for _ in demands or (None,)]
    owners = [next(other for other in demands if other.measure == d.measure) for d in demands]
    distinct = {owner.name: owner for owner in owners}
    failed_at: dict[str, int] = {}
    for block in blocks(manipulator, list(distinct.values()), grid, progress):
        for state, owner, demand in zip(states, owners, demands, strict=False):
            if owner.name not in block.values:
                continue
            values = block.values[owner.name]
            state[block.nodes][block.reachable] = judged(demand, values)
            fails = failed(values)
            if fails.any():
                node = block.start + int(np.flatnonzero(block.reachable)[np.argmax(fails)])
                failed_at[demand.name] = min(node, failed_at.get(demand.name, node))
        if not demands:
            states[0][block.nodes][block.reachable] = State.MEETS
    return [state.reshape(grid.shape) for state in states], failures_at(failed_at, demands, grid)


def judged(demand: Demand, values: Array) -> NDArray[np.uint8]:
    """The states of reachable nodes at which a measure has these values."""
    met = np.where(demand.meets(values), np.uint8(State.MEETS), np.uint8(State.VIOLATES))
    return np.where(failed(values), np.uint8(State.FAILED), met)


def failures_at(nodes: Mapping[str, int], demands: Sequence[Demand], grid: Grid) -> list[Failure]:
    """The failures of measures at these nodes, by the demand's name."""
    places = {demand.name: demand.place for demand in demands}
    return [
        Failure(name, tuple(map(float, grid.poses(nodes[name], nodes[name] + 1)[0])), place)
        for name, place in places.items()
        if name in nodes
    ]


def failed(values: Array) -> NDArray[np.bool_]:
    """Where a measure gave no value at a reachable pose, or not both, (n,)."""
    missing = np.isnan(values)
    # By columns: a reduction along rows of two takes thirty times as long.
    return missing if missing.ndim == 1 else missing[:, 0] | missing[:, 1]


def fields(
    manipulator: Manipulator,
    demands: Sequence[Demand],
    grid: Grid,
    progress: Progress | None = None,
    blocks: Blocks = measured_blocks,
) -> dict[str, Array]:
    """Each measure's values on the grid, shaped as the grid (and 2 for least and greatest); NaN out of reach.

    The coordinates of the nodes along axis x stand under ``axis_x``. A measure in reach nowhere is left out.
    """
    found: dict[str, Array] = {}
    for block in blocks(manipulator, demands, grid, progress):
        for name, values in block.values.items():
            if name not in found and len(values):
                found[name] = np.full((grid.nodes, *values.shape[1:]), np.nan)
            if len(values):
                found[name][block.nodes][block.reachable] = values
    axes = {f"axis_{manipulator.axes[k]}": grid.axis(k) for k in range(len(grid.shape))}
    shaped = {d.name: found[d.name] for d in demands if d.name in found}
    return axes | {name: all_.reshape(*grid.shape, *all_.shape[1:]) for name, all_ in shaped.items()}


def reach_alone(states: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The state under no demand at all: what is in reach meets it (eq. 3)."""
    unreachable, meets = np.uint8(State.UNREACHABLE), np.uint8(State.MEETS)  # a byte a node, not eight
    return np.where(states == unreachable, unreachable, meets)


def together(states: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """The state under all demands: unreachable, failed where one failed, violates where one violates."""
    return np.asarray(np.maximum.reduce(list(states)))

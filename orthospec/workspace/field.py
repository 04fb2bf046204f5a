"""Measures over blocks of poses, and the states of the grid's nodes.

A measure is handed reachable poses only, in whole blocks. A node *meets* or *violates* the bounds, is
*unreachable*, or *failed*: the measure gave NaN though the pose is reachable. Only the first counts for a
cuboid, and a failed node is never silent: one at the isotropic pose shrinks the cuboid by a tenth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Protocol

import numpy as np

from orthospec.errors import OrthospecError, PluginFault
from orthospec.manipulators import Manipulator
from orthospec.measures import Demand
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Poses

BLOCK = 1 << 15
"""Poses to a block: bounded memory whatever the grid."""

MOST_KEPT = 1 << 22
"""Values on grids of more nodes are not kept: they would fill memory and disk."""

Progress = Callable[[str, int, int], None]
"""Told what is being done, how much is done, and of how much."""


class State(IntEnum):
    """State of a node."""

    UNREACHABLE = 0
    MEETS = 1
    VIOLATES = 2
    FAILED = 3


class KeptValues(Protocol):
    """Values of measures on grids, kept from an earlier time: they do not depend on the bounds."""

    def read(self, measure: str, grid: Grid) -> Array | None:
        """The measure's values at the reachable nodes, in their order; None where they are not kept."""

    def write(self, measure: str, grid: Grid, values: Array) -> None:
        """Keep them."""


@dataclass(frozen=True)
class Failure:
    """A measure's first failed pose."""

    measure: str
    pose: tuple[float, ...]
    place: str | None


def measured(demand: Demand, manipulator: Manipulator, poses: Poses) -> Array:
    """The demand's measure at the poses: (n,) or (n, 2).

    Raises PluginFault where the measure raises, or gives another shape or type.
    """
    try:
        values = demand.measure.values(manipulator, poses)
    except OrthospecError:
        raise
    except Exception as error:
        raise PluginFault(_title(demand), f"raised {type(error).__name__}: {error}", demand.place) from error
    if not isinstance(values, np.ndarray) or values.dtype.kind != "f":
        raise PluginFault(
            _title(demand), f"gave {type(values).__name__}, not an array of floats", demand.place
        )
    n = len(poses)
    if values.shape not in {(n,), (n, 2)}:
        raise PluginFault(
            _title(demand), f"gave shape {values.shape} for {n} poses, not (n,) or (n, 2)", demand.place
        )
    return values


def _title(demand: Demand) -> str:
    return f"{type(demand.measure).__name__} (measure {demand.name})"


def _reachable_blocks(
    manipulator: Manipulator, grid: Grid, progress: Progress | None
) -> Iterator[tuple[NDArray[np.intp], Poses]]:
    """Block by block, the numbers of the reachable nodes and their poses, read-only; no empty block."""
    for start in range(0, grid.nodes, BLOCK):
        poses = grid.poses(start, start + BLOCK)
        reachable = manipulator.inverse_kinematics(poses)[1]
        if progress is not None:
            progress("grid", start + len(poses), grid.nodes)
        inside = poses[reachable]
        inside.flags.writeable = False
        if len(inside):
            yield start + np.flatnonzero(reachable), inside


class _Values:
    """A measure's values block by block: those that are kept, or measured now and then kept."""

    def __init__(self, demand: Demand, grid: Grid, kept: KeptValues | None) -> None:
        self._demand, self._grid = demand, grid
        self._kept = kept if grid.nodes <= MOST_KEPT else None
        self._known = self._kept.read(demand.name, grid) if self._kept else None
        self._new: list[Array] = []
        self._done = 0

    def at(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The values at the next reachable poses."""
        if self._known is not None:
            self._done += len(poses)
            return self._known[self._done - len(poses) : self._done]
        values = measured(self._demand, manipulator, poses)
        if self._kept:
            self._new.append(values)
        return values

    def keep(self) -> None:
        """All blocks have been asked for."""
        if self._kept and self._new:
            self._kept.write(self._demand.name, self._grid, np.concatenate(self._new))


def node_states(
    manipulator: Manipulator,
    demands: Sequence[Demand],
    grid: Grid,
    progress: Progress | None = None,
    kept: KeptValues | None = None,
) -> tuple[list[NDArray[np.uint8]], list[Failure]]:
    """The state of each node under each demand alone, shaped as the grid; and the first failure of each.

    Without demands the one array tells the reach alone (eq. 3 of the paper). Demands on equal measures share
    their values: levels, and bounds apart from each other.
    """
    states = [np.zeros(grid.nodes, dtype=np.uint8) for _ in demands or (None,)]
    owners = [next(i for i, other in enumerate(demands) if other.measure == d.measure) for d in demands]
    sources = {owner: _Values(demands[owner], grid, kept) for owner in owners}
    failures: dict[str, Failure] = {}
    for nodes, inside in _reachable_blocks(manipulator, grid, progress):
        values = {owner: source.at(manipulator, inside) for owner, source in sources.items()}
        for state, owner, demand in zip(states, owners, demands, strict=False):
            found = values[owner]
            failed = np.isnan(found).any(axis=tuple(range(1, found.ndim)))
            met = np.where(demand.meets(found), State.MEETS, State.VIOLATES)
            state[nodes] = np.where(failed, State.FAILED, met)
            if failed.any() and demand.name not in failures:
                pose = tuple(map(float, inside[int(np.argmax(failed))]))
                failures[demand.name] = Failure(demand.name, pose, demand.place)
        if not demands:
            states[0][nodes] = State.MEETS
    for source in sources.values():
        source.keep()
    return [state.reshape(grid.shape) for state in states], list(failures.values())


def fields(manipulator: Manipulator, demands: Sequence[Demand], grid: Grid) -> dict[str, Array]:
    """Each measure's values on the grid, shaped as the grid (and 2 for least and greatest); NaN out of reach.

    The coordinates of the nodes along axis x stand under ``axis_x``.
    """
    found: dict[str, Array] = {f"axis_{manipulator.axes[k]}": grid.axis(k) for k in range(len(grid.shape))}
    for nodes, inside in _reachable_blocks(manipulator, grid, None):
        for demand in demands:
            values = measured(demand, manipulator, inside)
            if demand.name not in found:
                found[demand.name] = np.full((grid.nodes, *values.shape[1:]), np.nan)
            found[demand.name][nodes] = values
    for demand in demands:
        if demand.name in found:
            found[demand.name] = found[demand.name].reshape(*grid.shape, *found[demand.name].shape[1:])
    return found


def reach_alone(states: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The state under no demand at all: what is in reach meets it (eq. 3)."""
    return np.where(states == State.UNREACHABLE, State.UNREACHABLE, State.MEETS).astype(np.uint8)


def together(states: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """The state under all demands: unreachable, failed where one failed, violates where one violates."""
    return np.asarray(np.maximum.reduce(list(states)))

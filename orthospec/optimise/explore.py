"""Where to start: low-discrepancy designs, each measured by the grid metric on a coarse grid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.errors import UnbuildableDesign, UsageError
from orthospec.optimise.objective import scale_is_asked
from orthospec.optimise.place import Place, fit_at
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.optimise.tasks import Task, problem_of
from orthospec.optimise.workers import Workers, in_order
from orthospec.workspace.cuboid import Cuboid, largest
from orthospec.workspace.evaluate import Setting
from orthospec.workspace.field import Progress, State, node_states, reach_alone, together
from orthospec.workspace.fit import Group
from orthospec.workspace.grid import Grid, make_grid, reach_box
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array

COARSE = 10
"""Divisions of the prescribed size on the coarse grid."""
MOST_COARSE = 500_000
"""Most nodes, roughly, of a coarse grid."""
SMALLEST = 1e-4
"""The least scale that a start may have."""
SCALES = (1e-3, 1e3)
"""Range of μ where a goal is about it."""


@dataclass(frozen=True)
class Start:
    """A place to solve from, and its merit there: the less the better."""

    place: Place
    merit: float


def candidates(space: DesignSpace) -> Iterator[Array]:
    """The spec's own start, then a Kronecker sequence of the golden ratio's kin, shifted by the seed."""
    yield space.scaled(space.spec.default_values())
    k = len(space.names)
    if k == 0:
        return
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (k + 1))
    pace = ratio ** -np.arange(1.0, k + 1)
    shift = np.random.default_rng(space.spec.optimise.seed).random(k)
    for i in range(1, space.spec.optimise.starts):
        yield np.asarray((shift + i * pace) % 1.0)


def start_at(space: DesignSpace, z: tuple[float, ...], _: Progress | None = None) -> Start | None:
    """Where to solve from with a design, its cuboids placed by a coarse grid; None where there is no start.

    Where the prescribed cuboid leaves the reach, the grid's own is taken, with its scale as a variable and
    the prescribed one to be reached elastically, so that the current point can always be evaluated.
    """
    try:
        design = space.design(np.array(z))
        placed = _place(space, machine_of(design))
    except (UnbuildableDesign, UsageError):
        return None
    if placed is None:
        return None
    groups, scale = placed
    place = Place(z, groups)
    if scale_is_asked(design.goals):
        return _judged(space, replace(place, scale=max(scale, 0.05), scales=SCALES))
    start = _judged(space, place)
    if np.isfinite(start.merit):
        return start
    part = 0.95 * min(1.0, max(scale, 0.05))
    while part > SMALLEST:
        start = _judged(space, replace(place, scale=part, scales=(SMALLEST, 1.0), least_scale=1.0))
        if np.isfinite(start.merit):
            return start
        part /= 3
    return None


def problem_on_grid(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a design's first measuring depends on: the problem, and how coarse the grid is."""
    return {**problem_of(content), "divisions": min(content["workspace"]["divisions"], COARSE)}


MEASURE = Task("designs on the coarse grid", start_at, problem_on_grid, (Start, Place, Group))


def _judged(space: DesignSpace, place: Place) -> Start:
    problem = fit_at(space, place).problem
    judged = problem.assess(problem.start)
    merit = judged.factor + 10 * judged.violation if np.isfinite(judged.violation) else np.inf
    return Start(place, float(merit))


def _place(space: DesignSpace, machine: Machine) -> tuple[tuple[Group, ...], float] | None:
    """The groups of demands, their cuboids' centres on a coarse grid, and the least scale of these."""
    setting = space.setting
    bounded = [demand for demand in machine.demands.values() if demand.bounds]
    free = [name for name, demand in machine.demands.items() if not demand.bounds]
    grid = coarse_grid(machine, setting)
    states, _ = node_states(machine.manipulator, bounded, grid)
    reach = reach_alone(states[0])
    if setting.together or not bounded:
        parts = [(tuple(machine.demands), together(states))]
    else:
        parts = [((demand.name,), state) for demand, state in zip(bounded, states, strict=True)]
        parts += [((name,), reach) for name in free]
    groups, scales = [], []
    for names, state in parts:
        found = _cuboid(grid, state) or _cuboid(grid, reach)
        if found is None:
            return None
        groups.append(Group(names, tuple(map(float, found.centre))))
        scales.append(float(np.max(found.size / setting.size)))
    return tuple(groups), min(scales)


def coarse_grid(machine: Machine, setting: Setting) -> Grid:
    """A grid of few nodes over the region or the reach, however large that is beside the cuboid."""
    region = setting.region or reach_box(machine.manipulator, setting.size)
    cuboids = float(np.prod(region.size / setting.size))
    divisions = (MOST_COARSE / cuboids) ** (1 / len(setting.size))
    return make_grid(machine.manipulator, setting.size, min(setting.divisions, COARSE, divisions), region)


def _cuboid(grid: Grid, states: NDArray[np.uint8]) -> Cuboid | None:
    placement = largest(states == State.MEETS)
    return None if placement is None else grid.cuboid(placement)


def explore(
    space: DesignSpace, workers: Workers, progress: Progress | None = None
) -> tuple[list[Start], int]:
    """The starts that were found, best first, and how many designs were measured."""
    designs = [tuple(map(float, z)) for z in candidates(space)]
    found = in_order(workers, MEASURE, space, designs, progress)
    starts = [start for start in found if start is not None]
    return sorted(starts, key=lambda start: start.merit), len(designs)

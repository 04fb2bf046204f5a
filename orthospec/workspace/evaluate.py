"""One design, measured: its cuboids on the grid and polished, and its extremes over the prescribed cuboid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.composite.trust_region import FEASIBLE
from orthospec.manipulators import Manipulator
from orthospec.measures import Demand, Level
from orthospec.workspace.cells import FindStates, grid_states
from orthospec.workspace.conditions import Condition, Extreme, Sample, conditions_of
from orthospec.workspace.critical import find_peaks, highest_peaks
from orthospec.workspace.cuboid import Cuboid, clusters, largest
from orthospec.workspace.field import (
    Failure,
    Progress,
    State,
    measured,
    reach_alone,
    together,
)
from orthospec.workspace.forms import Forms
from orthospec.workspace.grid import Grid, make_grid
from orthospec.workspace.guarantee import Bracket, Proof
from orthospec.workspace.machine import Machine
from orthospec.workspace.polish import polish

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array

FINE = 17
"""Lattice nodes along each axis when a final answer is given."""
STARTS = 6
"""Most clusters of grid cuboids that are polished."""


@dataclass(frozen=True)
class Setting:
    """The spec's workspace: the prescribed size, the grid, where to look."""

    size: Array
    divisions: float
    region: Cuboid | None = None
    together: bool = True
    poses: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    grows: bool = False
    """Whether the prescribed cuboid is to be as large as may be, and stands where the largest one does."""


@dataclass(frozen=True)
class Largest:
    """The largest cuboid of the prescribed proportions under some demands."""

    scale: float
    """Polished μ; 0 where there is none."""
    grid_scale: float
    """The paper's metric, on the grid alone."""
    ties: int
    cuboid: Cuboid | None
    nodes: Mapping[str, int]
    """How many nodes meet, violate, are unreachable, failed."""
    proof: Proof | None = None
    """Over the polished cuboid; None where none was asked for."""
    proved: Bracket | None = None
    """Proved ends of the scale."""


@dataclass(frozen=True)
class Value:
    """A measure's value at a pose."""

    value: float
    at: tuple[float, ...]


@dataclass(frozen=True)
class Prescribed:
    """The prescribed cuboid where it stands, and whether everything holds in it."""

    cuboid: Cuboid
    holds: bool
    violation: float
    reached: bool
    scale: float = 1.0
    """Of the prescribed size: less where the search found no place for all of it, more where a goal asks."""
    proof: Proof | None = None


@dataclass(frozen=True)
class Measured:
    """One measure: its own largest cuboid, its extremes over the prescribed one, its levels and poses."""

    largest: Largest | None
    """None for a measure without bounds."""
    lowest: Value | None
    highest: Value | None
    levels: tuple[tuple[Level, Largest], ...]
    poses: Mapping[str, tuple[float, ...] | None]
    prescribed: Prescribed | None
    """Its own prescribed cuboid, where each measure has one."""


@dataclass(frozen=True)
class Evaluation:
    """What is known of one design."""

    prescribed: Prescribed | None
    joint: Largest | None
    measures: Mapping[str, Measured]
    joints: Array | None
    """Range of each joint over the prescribed cuboid (m, 2); None where it leaves the reach."""
    indices: Mapping[str, float]
    failures: tuple[Failure, ...]

    @property
    def holds(self) -> bool:
        """Whether every bound and the reach hold in the prescribed cuboid, or in each measure's own."""
        places = [self.prescribed, *(m.prescribed for m in self.measures.values() if m.largest is not None)]
        known = [place for place in places if place is not None]
        wanted = 1 if self.joint is not None else sum(m.largest is not None for m in self.measures.values())
        return len(known) >= wanted and all(place.holds for place in known)


def evaluate(
    machine: Machine,
    setting: Setting,
    prescribed: Mapping[str, Cuboid] | None = None,
    progress: Progress | None = None,
    states_of: FindStates = grid_states,
    forms: Forms | None = None,
) -> Evaluation:
    """Measure one design.

    ``prescribed`` gives the places of the prescribed cuboids, by measure, and "" for the joint one; where it
    is left out each stands centred on its largest cuboid. ``states_of`` finds the states on the grid;
    ``forms`` have been compiled for other designs.
    """
    demands = list(machine.demands.values())
    bounded = [demand for demand in demands if demand.bounds]
    levels = [(demand, level) for demand in demands for level in demand.levels]
    grid = make_grid(machine.manipulator, setting.size, setting.divisions, setting.region)
    asked = [*bounded, *(demand.at(level) for demand, level in levels)]
    states, failures = states_of(machine.manipulator, asked, grid, progress)
    look = _Search(machine, setting, grid, forms or Forms())
    known = prescribed or {}
    own = {
        d.name: look.largest([d], state, known.get(d.name, known.get("")))
        for d, state in zip(bounded, states, strict=False)
    }
    nested = [
        (demand.name, level, look.largest([demand.at(level)], state))
        for (demand, level), state in zip(levels, states[len(bounded) :], strict=False)
    ]
    joint = None
    if setting.together or not bounded:
        everything = together(states[: len(bounded)]) if bounded else reach_alone(states[0])
        joint = (
            next(iter(own.values()))
            if len(bounded) == 1
            else look.largest(bounded, everything, known.get(""))
        )
    levels_of = {
        demand.name: tuple((level, found) for name, level, found in nested if name == demand.name)
        for demand in demands
    }
    places = _places(setting, joint, own) if prescribed is None else prescribed
    standing = {name: _stand(machine, setting, place, name) for name, place in places.items()}
    return _evaluation(machine, setting, _Cuboids(joint, own, levels_of), standing, tuple(failures))


def enlarged(
    machine: Machine,
    setting: Setting,
    evaluation: Evaluation,
    larger: Mapping[str, Cuboid],
    forms: Forms | None = None,
) -> Evaluation:
    """The evaluation with cuboids larger than those told, polished from these, by measure ("": joint).

    What is new is without a proof. A prescribed cuboid that does not hold, or is the one that was largest, is
    placed by the new one; any other stays where it stands. The same evaluation where none of these leads to a
    larger one.
    """
    measures = evaluation.measures
    joint, own = evaluation.joint, {n: r.largest for n, r in measures.items() if r.largest is not None}
    standing = {n: r.prescribed for n, r in measures.items() if r.prescribed is not None}
    if evaluation.prescribed is not None:
        standing[""] = evaluation.prescribed
    grown = False
    for name, start in larger.items():
        names = [name] if name else list(own)
        before = own[name] if name else joint
        found = polish(machine, names, setting.size, [start], setting.region, forms)
        if found is None or before is None or found.scale <= before.scale * (1 + FEASIBLE):
            continue
        grown = True
        after = replace(before, scale=found.scale, cuboid=found.cuboid, proof=None, proved=None)
        joint = joint if name else after
        own.update(dict.fromkeys(names if len(names) == 1 else (), after))
        if name in standing and (not standing[name].holds or standing[name].cuboid == before.cuboid):
            standing[name] = _stand(machine, setting, _place(setting, found.cuboid), name)
    if not grown:
        return evaluation
    cuboids = _Cuboids(joint, own, {name: record.levels for name, record in measures.items()})
    return _evaluation(machine, setting, cuboids, standing, evaluation.failures)


class _Cuboids(NamedTuple):
    """The largest cuboids of a design."""

    joint: Largest | None
    own: Mapping[str, Largest]
    """Of each measure with bounds."""
    levels: Mapping[str, tuple[tuple[Level, Largest], ...]]
    """Of each measure."""


def _evaluation(
    machine: Machine,
    setting: Setting,
    cuboids: _Cuboids,
    standing: Mapping[str, Prescribed],
    failures: tuple[Failure, ...],
) -> Evaluation:
    """What there is to tell of a design with the prescribed cuboids that stand there."""
    demands = list(machine.demands.values())
    records = {
        demand.name: Measured(
            cuboids.own.get(demand.name),
            *_extremes(machine, demand, standing.get("" if "" in standing else demand.name)),
            cuboids.levels[demand.name],
            _at_poses(machine, demand, setting.poses),
            standing.get(demand.name),
        )
        for demand in demands
    }
    joints = _joint_ranges(machine.manipulator, list(standing.values()))
    ranges = joints if joints is not None else np.full((len(machine.manipulator.joint_units), 2), np.nan)
    indices = dict(machine.manipulator.indices(ranges))
    return Evaluation(standing.get(""), cuboids.joint, records, joints, indices, failures)


@dataclass(frozen=True)
class _Search:
    machine: Machine
    setting: Setting
    grid: Grid
    forms: Forms

    def largest(
        self, demands: Sequence[Demand], states: NDArray[np.uint8], also: Cuboid | None = None
    ) -> Largest:
        """The largest cuboid of one mask, polished from each of its first `STARTS` clusters on the grid.

        ``also`` is polished too: a cuboid that a search has placed may stand where the grid shows less.
        """
        met = states == State.MEETS
        best = largest(met)
        order = (State.MEETS, State.VIOLATES, State.UNREACHABLE, State.FAILED)
        nodes = {state.name.lower(): int(np.count_nonzero(states == state)) for state in order}
        if best is None:
            return Largest(0.0, 0.0, 0, None, nodes)
        starts = [self.grid.cuboid(placement) for placement in clusters(met)[:STARTS]]
        starts += [also] if also is not None else []
        machine = Machine(self.machine.manipulator, {demand.name: demand for demand in demands})
        found = polish(
            machine, list(machine.demands), self.setting.size, starts, self.setting.region, self.forms
        )
        grid_scale = best.steps / self.setting.divisions
        if found is None:
            return Largest(0.0, grid_scale, best.ties, None, nodes)
        return Largest(found.scale, grid_scale, best.ties, found.cuboid, nodes)


def _places(setting: Setting, joint: Largest | None, own: Mapping[str, Largest]) -> Mapping[str, Cuboid]:
    """The prescribed cuboids, each centred on its largest one."""
    found = {"": joint} if joint is not None else own
    return {
        name: _place(setting, record.cuboid) for name, record in found.items() if record.cuboid is not None
    }


def _place(setting: Setting, largest: Cuboid) -> Cuboid:
    """Where the prescribed cuboid stands that nothing else has placed."""
    return largest if setting.grows else Cuboid.around(largest.centre, setting.size)


def _stand(machine: Machine, setting: Setting, place: Cuboid, name: str) -> Prescribed:
    """Judge a prescribed cuboid: for the joint one ("") by all demands, for a measure's own by its bounds."""
    demands = [one for one in machine.demands.values() if one.bounds and name in ("", one.name)]
    greatest = _greatest(
        machine, place, conditions_of(machine.manipulator, demands, _probe(machine, place)), []
    )
    reach = sum(isinstance(c, Condition) and c.kind == "joint" for c in greatest)
    values = np.array([value for value, _ in greatest.values()])
    violation = float(values.max(initial=0.0))
    reached = bool(values[:reach].max(initial=0.0) <= FEASIBLE)
    scale = float(np.max(place.size / setting.size))
    whole = abs(scale - 1) <= FEASIBLE
    return Prescribed(place, violation <= FEASIBLE, violation, reached, 1.0 if whole else scale)


def _probe(machine: Machine, place: Cuboid) -> Array:
    return place.poses(np.zeros((1, len(place.low))), len(machine.manipulator.axes))


def _greatest(
    machine: Machine, place: Cuboid, conditions: Sequence[Condition], extremes: Sequence[Extreme]
) -> dict[Condition | Extreme, tuple[float, tuple[float, ...]]]:
    """Each condition's worst excess and each extreme's signed value over a cuboid, with its pose."""
    axes = len(machine.manipulator.axes)

    def functions(u: Array) -> Array:
        sample = Sample(machine, place.poses(u, axes))
        return sample.rows(conditions, extremes, {})

    terms: list[Condition | Extreme] = [*conditions, *extremes]
    if not terms:
        return {}
    peaks = highest_peaks(functions, find_peaks(functions, len(place.low), nodes=FINE), len(terms))
    poses = place.poses(peaks.u, axes)
    return {
        term: (float(value), tuple(map(float, pose)))
        for term, value, pose in zip(terms, peaks.value, poses, strict=True)
    }


def _extremes(
    machine: Machine, demand: Demand, place: Prescribed | None
) -> tuple[Value | None, Value | None]:
    if place is None or not place.reached:
        return None, None
    asked = [Extreme("lowest", demand.name), Extreme("highest", demand.name)]
    found = _greatest(machine, place.cuboid, [], asked)
    lowest, highest = (Value(extreme.sign * found[extreme][0], found[extreme][1]) for extreme in asked)
    return lowest, highest


def _joint_ranges(manipulator: Manipulator, places: Sequence[Prescribed]) -> Array | None:
    """Least and greatest value of each joint over the prescribed cuboids (m, 2)."""
    if not places or not all(place.reached for place in places):
        return None
    count = len(manipulator.joint_units)
    asked = [Extreme(kind, joint) for joint in range(count) for kind in ("lowest", "highest")]
    every = [_greatest(Machine(manipulator, {}), place.cuboid, [], asked) for place in places]
    ends = [extreme.sign * max(found[extreme][0] for found in every) for extreme in asked]
    return np.array(ends).reshape(count, 2)


def _at_poses(
    machine: Machine, demand: Demand, poses: Mapping[str, tuple[float, ...]]
) -> Mapping[str, tuple[float, ...] | None]:
    """The measure at each named pose; None where the pose is not reachable or the measure failed."""
    if not poses:
        return {}
    block = np.array(list(poses.values()), dtype=float)
    reachable = machine.manipulator.inverse_kinematics(block)[1]
    found: dict[str, tuple[float, ...] | None] = dict.fromkeys(poses)
    if not reachable.any():
        return found
    values = measured(demand, machine.manipulator, block[reachable])
    for name, value in zip(np.array(list(poses))[reachable], values, strict=True):
        found[str(name)] = tuple(map(float, np.atleast_1d(value))) if not np.isnan(value).any() else None
    return found

"""Looking again for a design with some conditions loosened, left out, or loosened as little as does it.

Each look is a local solve from the place where a search ended.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, minimise
from orthospec.optimise.objective import GoalObjective
from orthospec.optimise.place import Place
from orthospec.optimise.space import DesignSpace
from orthospec.result import FURTHEST, Limit
from orthospec.workspace.conditions import Condition, Extreme, conditions_of
from orthospec.workspace.fit import FitProblem
from orthospec.workspace.layout import Limits, Point
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

SMALLEST = 1e-3
"""The least scale of a cuboid that a look starts from or ends at."""
AWAY = (10.0, 100.0, 1000.0, FURTHEST)
"""An end of a variable's range is left out by moving it this many ranges away, the fewest that do."""
SUBPROBLEMS = 60
"""Most subproblems spent on one look."""

Loosening: TypeAlias = Mapping[Limit, float]
"""How far each condition is loosened, relative; infinite where it is left out."""
Box: TypeAlias = "tuple[Array, Array]"
"""The least and the greatest of each scaled variable, (k,) each."""


@dataclass(frozen=True)
class Aims:
    """The `Objective` of what is held of the goals, and of what is to be loosened as little as possible.

    One row each for what is loosened: by which part it is exceeded. Without any, the greatest scale.
    """

    goals: GoalObjective
    held: Flags
    ranges: Box
    """The ends of the spec's ranges, as the space of the solve has them."""
    loose: tuple[Limit, ...] = ()
    largest: bool = False

    @property
    def extremes(self) -> tuple[Extreme, ...]:
        """Those that the goals need, then those that the loosened bounds bound."""
        return tuple(dict.fromkeys([*self._theirs, *map(_extreme, self._bounds)]))

    @property
    def on_factor(self) -> Array:
        """1 for what is loosened."""
        rows = len(self._bounds) + len(self._ends) + int(self._moved.sum()) + self.largest
        return np.array([*np.zeros(self.held.sum()), *np.ones(rows)])

    @property
    def on_slack(self) -> Array:
        """As the goals have it, for those that are held."""
        return np.array([*self.goals.on_slack[self.held], *np.zeros(int(self.on_factor.sum()))])

    def rows(self, machine: Machine, point: Point) -> Array:
        """Held goals, bounds, ends of ranges, goals that are loosened, the scale."""
        named = dict(zip(self.extremes, point.extremes, strict=True))
        bounds = [_exceeded(machine, one, named[_extreme(one)]) for one in self._bounds]
        ends = [self._beyond(one, point) for one in self._ends]
        theirs = point._replace(extremes=point.extremes[: len(self._theirs)])
        every = self.goals.rows(machine, theirs) if self._any_goal else np.zeros(len(self.held))
        moved = every[self._moved] / self.goals.on_slack[self._moved]
        return np.array([*every[self.held], *bounds, *ends, *moved, *([-point.scale] * self.largest)])

    @property
    def _any_goal(self) -> bool:
        return bool((self.held | self._moved).any())

    @property
    def _theirs(self) -> tuple[Extreme, ...]:
        return self.goals.extremes if self._any_goal else ()

    @property
    def _bounds(self) -> list[Limit]:
        return [one for one in self.loose if one.kind == "bound"]

    @property
    def _ends(self) -> list[Limit]:
        return [one for one in self.loose if one.kind == "variable"]

    @property
    def _moved(self) -> Flags:
        names = {one.name for one in self.loose if one.kind == "goal"}
        return np.array([owner in names for owner in self.goals.owners], dtype=bool)

    def _beyond(self, one: Limit, point: Point) -> float:
        k = self.goals.names.index(one.name)
        z, low, high = float(point.design[k]), float(self.ranges[0][k]), float(self.ranges[1][k])
        return (z - high if one.side == "at_most" else low - z) / (high - low)


@dataclass(frozen=True)
class Look:
    """What one local solve came to: by how much the conditions are still missed, and where."""

    missed: float
    factor: float
    at: Place

    @property
    def found(self) -> bool:
        """Whether everything holds there."""
        return self.missed <= FEASIBLE


def joint_limits(space: DesignSpace, place: Place) -> dict[tuple[str, str], list[Condition]]:
    """The reach's conditions with a side, those of one name for all joints together: as the spec has them."""
    manipulator = space.machine(place.design).manipulator
    found: dict[tuple[str, str], list[Condition]] = {}
    for one in conditions_of(manipulator, [], np.zeros((1, len(manipulator.axes)))):
        if one.side is not None:
            found.setdefault((stem(one.name), one.side), []).append(one)
    return found


def stem(name: str) -> str:
    """``joint_limits`` of ``joint_limits.0``."""
    stem, _, number = name.rpartition(".")
    return stem if number.isdigit() else name


def look(space: DesignSpace, place: Place, loosening: Loosening, least: tuple[Limit, ...] = ()) -> Look:
    """Seek a design with some conditions loosened or left out, or with ``least`` loosened least."""
    moved = {one.name: by for one, by in loosening.items() if one.kind == "goal"}
    shifts, joints = _goal_shifts(space, place, moved), joint_limits(space, place)
    relaxed = {
        condition: _excess(condition, by)
        for one, by in loosening.items()
        for condition in _conditions(one, joints)
    }
    for box in _boxes(space, place, loosening):
        wide = space.within(*box)
        here = place.carried(space, wide)
        goals = GoalObjective(wide, here.design, shifts)
        held = [
            size > 0 and moved.get(name) != inf
            for name, size in zip(goals.owners, goals.on_slack, strict=True)
        ]
        aims = Aims(goals, np.array(held, dtype=bool), _ranges(space, wide), least)
        seen = _solve(wide, here, aims, here.limits(wide), relaxed)
        if seen.found:
            break
    return replace(seen, at=seen.at.carried(wide, space))


def _boxes(space: DesignSpace, place: Place, loosening: Loosening) -> list[Box]:
    """The variables' ranges with some ends moved: where one is left out, further and further from the place.

    A solve takes steps of the size of its ranges: wide ones lead far, narrow ones are resolved well.
    """
    left_out = any(one.kind == "variable" and by == inf for one, by in loosening.items())
    boxes = [_box(space, loosening, away) for away in (AWAY if left_out else AWAY[-1:])]
    z = place.design
    return [(low, high) for low, high in boxes[:-1] if ((low <= z) & (z <= high)).all()] + boxes[-1:]


def _box(space: DesignSpace, loosening: Loosening, away: float) -> Box:
    box = np.zeros(len(space.names)), np.ones(len(space.names))
    for one, by in loosening.items():
        if one.kind == "variable":
            side = ("at_least", "at_most").index(str(one.side))
            box[side][space.names.index(one.name)] += (-1.0, 1.0)[side] * min(by, away)
    return box


def _ranges(space: DesignSpace, wide: DesignSpace) -> Box:
    ends = (np.zeros(len(space.names)), np.ones(len(space.names)))
    low, high = (wide.scaled(space.values(end)) for end in ends)
    return low, high


def _solve(
    space: DesignSpace, place: Place, aims: Aims, limits: Limits, relaxed: dict[Condition, float]
) -> Look:
    start = np.clip(place.design, *limits.design), place.scale
    problem = FitProblem(
        space.machine, space.setting.size, place.groups, aims, limits, start, relaxed, forms=space.forms
    )
    solved = minimise(problem, problem.start, most=SUBPROBLEMS)
    return Look(float(solved.violation), float(solved.factor), place.at(problem.layout.unpack(solved.x)))


def _extreme(bound: Limit) -> Extreme:
    """What a bound bounds."""
    return Extreme("highest" if bound.side == "at_most" else "lowest", bound.name)


def _exceeded(machine: Machine, one: Limit, value: float) -> float:
    bound = machine.demands[one.name].bounds[str(one.side)]
    return (value - bound) / (abs(bound) or 1.0) * (1.0 if one.side == "at_most" else -1.0)


def _conditions(one: Limit, joints: Mapping[tuple[str, str], Sequence[Condition]]) -> Sequence[Condition]:
    if one.kind == "joint":
        return joints[one.name, str(one.side)]
    return [Condition("bound", one.name, one.side)] if one.kind == "bound" else []


def _excess(one: Condition, by: float) -> float:
    """A relative loosening as `Condition` rows measure it: a bound's in logarithms, a joint's as it is."""
    if one.kind == "joint" or by == inf:
        return by
    return float(np.log1p(by)) if one.side == "at_most" else -float(np.log1p(-min(by, 1 - 1e-12)))


def _goal_shifts(space: DesignSpace, place: Place, moved: dict[str, float]) -> dict[str, float]:
    sizes = {goal.name: abs(goal.goal) or 1.0 for goal in space.design(place.design).goals}
    return {name: by * sizes[name] for name, by in moved.items() if by != inf}


def largest_scale(space: DesignSpace, place: Place) -> float | None:
    """The scale of the largest cuboid in which everything holds; None where none was found."""
    goals = GoalObjective(space, place.design)
    aims = Aims(goals, goals.on_slack > 0, _ranges(space, space), largest=True)
    limits = replace(place, scales=(SMALLEST, 1.0), least_scale=None).limits(space)
    seen = _solve(space, place, aims, limits, {})
    return seen.at.scale if seen.found and SMALLEST < seen.at.scale < 1.0 else None

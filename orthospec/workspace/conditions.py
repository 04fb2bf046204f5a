"""Everything that must hold at a pose, as one number each: how far it is exceeded.

A bound's excess is the logarithm of value over bound, so that one slack and one trust radius serve bounds of
any unit; a reach condition's is its margin, negated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from orthospec.manipulators import Manipulator
from orthospec.measures import Demand
from orthospec.measures.demand import bounded_side, excess
from orthospec.workspace.field import measured
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Poses


JUST = 0.01
"""Margins of reach down to minus this are just out of it."""


@dataclass(frozen=True)
class Condition:
    """A bound of a measure (``side`` at_least or at_most) or a reach condition (``side`` may be None)."""

    kind: Literal["bound", "joint"]
    name: str
    side: str | None

    @property
    def of(self) -> str:
        """The measure or reach condition."""
        return self.name

    @property
    def reach_key(self) -> str:
        """The key of a reach condition in `Manipulator.reach`."""
        return f"{self.name}.{self.side}" if self.side else self.name


@dataclass(frozen=True)
class Extreme:
    """The greatest or least value, over the cuboid, of a measure (by name) or of a joint (by number)."""

    kind: Literal["highest", "lowest"]
    of: str | int

    @property
    def side(self) -> str:
        """The side of a bound that this extreme would be: highest <= bound, lowest >= bound."""
        return "at_most" if self.kind == "highest" else "at_least"

    @property
    def sign(self) -> float:
        """1 where greater is worse, −1 where less is."""
        return 1.0 if self.kind == "highest" else -1.0


def conditions_of(manipulator: Manipulator, demands: Sequence[Demand], pose: Poses) -> tuple[Condition, ...]:
    """The reach conditions of the machine, then each demand's bounds; pose (1, d) is any."""
    found = []
    for key in manipulator.reach(pose):
        name, dot, side = key.rpartition(".")
        sided = bool(dot) and side in {"at_least", "at_most"}
        found.append(Condition("joint", name if sided else key, side if sided else None))
    found += [Condition("bound", demand.name, side) for demand in demands for side in demand.bounds]
    return tuple(found)


@dataclass(frozen=True)
class Sample:
    """A block of poses under one machine."""

    machine: Machine
    poses: Poses

    def rows(
        self, conditions: Sequence[Condition], extremes: Sequence[Extreme], relaxed: Mapping[Condition, float]
    ) -> Array:
        """Excess of each condition, then signed value of each extreme (k, n); inf where not computable.

        Just out of reach there is nothing to measure, but the reach conditions tell how far out that is: all
        others are −inf there. ``relaxed`` loosens a condition by so much.
        """
        manipulator, demands = self.machine.manipulator, self.machine.demands
        joints, _ = manipulator.inverse_kinematics(self.poses)
        known: Flags = np.asarray(np.isfinite(joints).all(axis=1))
        margins = manipulator.reach(self.poses)
        values = {name: self._values(name, known) for name in self._needed(conditions, extremes)}
        rows = []
        for condition in conditions:
            if condition.kind == "joint":
                row = -margins[condition.reach_key]
            else:
                bound = demands[condition.name].bounds[str(condition.side)]
                row = excess(values[condition.name], bound, str(condition.side))
            rows.append(row - relaxed.get(condition, 0.0))
        for extreme in extremes:
            of = extreme.of
            value = joints[:, of] if isinstance(of, int) else bounded_side(values[of], extreme.side)
            rows.append(extreme.sign * value)
        found = np.array(rows).reshape(len(rows), len(self.poses))
        if margins and not known.all():
            outside = -np.fmin.reduce([*margins.values()])
            found[np.isnan(found) & ~known & (outside > 0) & (outside < JUST)] = -np.inf
        return np.where(np.isnan(found), np.inf, found)

    def _needed(self, conditions: Sequence[Condition], extremes: Sequence[Extreme]) -> list[str]:
        names = [condition.name for condition in conditions if condition.kind == "bound"]
        names += [extreme.of for extreme in extremes if isinstance(extreme.of, str)]
        return list(dict.fromkeys(names))

    def _values(self, name: str, known: Flags) -> Array:
        manipulator, demand = self.machine.manipulator, self.machine.demands[name]
        if known.all():
            return measured(demand, manipulator, self.poses)
        poses = self.poses[known]
        poses.flags.writeable = False
        part = measured(demand, manipulator, poses)
        values = np.full((len(self.poses), *part.shape[1:]), np.nan)
        values[known] = part
        return values

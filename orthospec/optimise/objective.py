"""A spec's goals as rows of the subproblem (Pashkevich, Chablat and Wenger 2009, eqs. 12-13).

    minimise  f − wλ <= goal,      maximise  f + wλ >= goal,      match  |f − goal| <= wλ

A weight of 0 makes a row hard. f may name extremes of measures over the cuboid and indices that depend on
the range of the joints over it; each such extreme is a variable, held by the measure's own bound rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.space import DesignSpace
from orthospec.quantities import Expression, ExpressionError
from orthospec.quantities.pieces import pieces
from orthospec.spec import Design, Goal
from orthospec.workspace.conditions import Extreme
from orthospec.workspace.evaluate import Evaluation
from orthospec.workspace.layout import Point
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array

LEAST = 1e-12
"""A weight that varies is told from 0 down to this part of what it was where a solve began."""
LEAD = 0.01
"""How much shorter the other joints' ranges are made in the row in which one joint leads."""


@dataclass(frozen=True)
class _Row:
    """One row of a goal: sign·(piece − goal). ``leader`` is a joint that leads by a hair, or None."""

    goal: int
    sign: float
    piece: Expression
    leader: int | None = None


@dataclass(frozen=True)
class Learnt:
    """What an objective learns where a solve begins: see `GoalObjective.settle`."""

    sizes: tuple[float, ...]


class GoalObjective:
    """The `Objective` of a spec's goals; the factor is λ over ``unit``, so that it is of order 1.

    Kinks are taken apart: a goal has a row for each piece of its ``max`` and ``min``, and where an index may
    be the greatest over the joints (``stroke``), a row for each joint in which that one leads.
    ``shifts`` moves goals by name, towards easier where positive: what a price is found with.
    """

    def __init__(self, space: DesignSpace, z: Array, shifts: Mapping[str, float] | None = None) -> None:
        self._space, self._shifts = space, dict(shifts or {})
        design = space.design(z)
        moving = _moving_indices(design)
        self._joints = len(design.manipulator.joint_units) if moving else 0
        self.extremes = _extremes(design, self._joints)
        self._rows = [row for k, goal in enumerate(design.goals) for row in _rows_of(k, goal)]
        self._rows += [
            replace(row, leader=joint)
            for row in self._rows
            if row.sign > 0 and row.piece.names & moving
            for joint in range(self._joints)
        ]
        self._weights = np.array([design.goals[row.goal].weight for row in self._rows])
        self._sizes = np.array([abs(design.goals[row.goal].goal) or 1.0 for row in self._rows])
        self.owners = tuple(design.goals[row.goal].name for row in self._rows)

    @property
    def names(self) -> tuple[str, ...]:
        """The design variables, in the order of z."""
        return self._space.names

    @property
    def unit(self) -> float:
        """What one unit of the factor is in λ: the least size of a soft goal over its weight."""
        soft = self._weights > 0
        return float((self._sizes[soft] / self._weights[soft]).min(initial=np.inf)) if soft.any() else 1.0

    @property
    def on_factor(self) -> Array:
        """Weights in units of the factor (r,); 0 for a hard row."""
        return self._weights * self.unit

    @property
    def on_slack(self) -> Array:
        """Sizes of the hard rows (r,); 0 for a soft one."""
        return np.where(self._weights > 0, 0.0, self._sizes)

    def settle(self, machine: Machine, point: Point) -> None:
        """Learn from the start the sizes of goals at 0, which have none but that of their values."""
        goals = self._space.design(point.design).goals
        values = np.abs(self.rows(machine, point))
        at_zero = np.array([goals[row.goal].goal == 0 for row in self._rows], dtype=bool)
        usable = at_zero & np.isfinite(values) & (values > 0)
        self._sizes = np.where(usable, values, self._sizes)

    @property
    def learnt(self) -> Learnt:
        """What was learnt at the start, to be handed on."""
        return Learnt(tuple(map(float, self._sizes)))

    def recall(self, learnt: Learnt) -> None:
        """Take over what another objective of the same goals has learnt at its start."""
        self._sizes = np.array(learnt.sizes)

    def rows(self, machine: Machine, point: Point) -> Array:
        """The rows g (r,); NaN where a goal has no value."""
        design = self._space.design(point.design)
        known: dict[tuple[str, str], float] = {
            (e.kind, str(e.of)): float(v) for e, v in zip(self.extremes, point.extremes, strict=True)
        }
        indices: dict[int | None, Mapping[str, float]] = {None: self._indices(machine, point, None)}
        indices |= {joint: self._indices(machine, point, joint) for joint in range(self._joints)}

        def value(row: _Row, leader: int | None) -> float:
            """A piece's; where it has none, as ``sqrt(x)`` of ``sqrt(max(0, x))``, that of the whole goal."""
            f = _value(design, row.piece, indices[leader], point.scale, known)
            whole = design.goals[row.goal].expression
            return f if np.isfinite(f) else _value(design, whole, indices[leader], point.scale, known)

        found = []
        for row, weight in zip(self._rows, self._weights, strict=True):
            goal = design.goals[row.goal]
            f = value(row, row.leader)
            if row.leader is not None:
                # A goal that falls as ranges grow has no kink of this kind: its row may not be tightened.
                f = min(f, value(row, None))
            excess = row.sign * (f - goal.goal) - self._shifts.get(goal.name, 0.0)
            # A weight that varies with the design: its row is told as with the weight of where this began.
            found.append(excess * (weight / max(goal.weight, LEAST * weight)) if weight > 0 else excess)
        return np.array(found)

    def _indices(self, machine: Machine, point: Point, leader: int | None) -> Mapping[str, float]:
        """The indices, the ranges of all joints but the leader made shorter."""
        ranges = np.full((len(machine.manipulator.joint_units), 2), np.nan)
        if self._joints:
            ranges = point.extremes[len(self.extremes) - 2 * self._joints :].reshape(-1, 2).copy()
        if leader is not None:
            others = np.arange(self._joints) != leader
            cut = LEAD / 2 * (ranges[others, 1] - ranges[others, 0])
            ranges[others] += np.stack([cut, -cut], axis=1)
        return machine.manipulator.indices(ranges)


def goal_values(design: Design, evaluation: Evaluation) -> dict[str, float]:
    """Each goal's f at an evaluated design; NaN where it has no value."""
    values = {}
    for name, record in evaluation.measures.items():
        for kind, extreme in (("lowest", record.lowest), ("highest", record.highest)):
            values[kind, name] = extreme.value if extreme is not None else np.nan
    # That of the cuboid over which all else is told: with other goals beside it, the largest one is larger.
    scale = evaluation.prescribed.scale if evaluation.prescribed is not None else np.nan
    return {
        goal.name: _value(design, goal.expression, evaluation.indices, scale, values) for goal in design.goals
    }


def _value(
    design: Design,
    expression: Expression,
    indices: Mapping[str, float],
    scale: float,
    extremes: Mapping[tuple[str, str], float],
) -> float:
    known = dict(extremes)
    for kind, name in expression.extremes:
        if kind == "worst":
            known[kind, name] = extremes[_worst_kind(design, name), name]
    try:
        return expression.value({**design.values, **indices, "scale": scale}, known)
    except ExpressionError:
        return np.nan


def _rows_of(k: int, goal: Goal) -> list[_Row]:
    """One row for each piece and side of goal k."""
    signs = {"minimise": (1.0,), "maximise": (-1.0,), "match": (1.0, -1.0)}[goal.sense]
    return [
        _Row(k, sign, piece)
        for sign in signs
        for piece in pieces(goal.expression, "max" if sign > 0 else "min")
    ]


def _worst_kind(design: Design, name: str) -> str:
    """Which extreme is a measure's worst: the one on its bounded side."""
    demand = next(demand for demand in design.demands if demand.name == name)
    return "highest" if "at_most" in demand.bounds else "lowest"


def _extremes(design: Design, joints: int) -> tuple[Extreme, ...]:
    """The extremes that the goals name, then those of all joints where an index depends on them."""
    found: dict[Extreme, None] = {}
    for goal in design.goals:
        for kind, name in sorted(goal.expression.extremes):
            known = _worst_kind(design, name) if kind == "worst" else kind
            found[Extreme("highest" if known == "highest" else "lowest", name)] = None
    ends = [Extreme(kind, joint) for joint in range(joints) for kind in ("lowest", "highest")]
    return (*found, *ends)


def _moving_indices(design: Design) -> frozenset[str]:
    """The indices that goals name and that change with the range of the joints."""
    wide = np.tile([0.0, 1.0], (len(design.manipulator.joint_units), 1))
    first, second = (dict(design.manipulator.indices(ranges)) for ranges in (wide, 2 * wide + 0.5))
    named = frozenset().union(*(goal.expression.names for goal in design.goals))
    return frozenset(name for name in named & first.keys() if first[name] != second[name])


def scale_is_asked(goals: Sequence[Goal]) -> bool:
    """Whether a goal is about the scale of the cuboid."""
    return any("scale" in goal.expression.names for goal in goals)

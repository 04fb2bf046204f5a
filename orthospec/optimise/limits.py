"""What holds a design back, and at what price.

At an optimum each bound, joint limit, variable's range and goal that binds is moved by one per cent, to
either side, and the problem solved again from there: ``gain`` is what λ falls by when it is loosened,
``cost`` what it rises by when tightened. The two differ where several bounds bind at one pose, and the
solver's multipliers, which are not unique there, are neither.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, minimise
from orthospec.optimise.attain import Attained
from orthospec.optimise.objective import GoalObjective
from orthospec.result import Limit
from orthospec.workspace.conditions import Condition
from orthospec.workspace.fit import FitProblem

if TYPE_CHECKING:
    from orthospec.arrays import Array

ACTIVE = 1e-6
"""A condition this near its bound binds."""
PERCENT = 0.01
PART = 1e-3
"""A condition conflicts when it has more than this part in the least violation."""
ROUNDING = 1e-8
"""A price below this, relative to the unit of λ, is none."""
SUBPROBLEMS = 40
"""Most subproblems spent on one price."""


@dataclass(frozen=True)
class _Shift:
    """One thing moved: a condition by so much, one end of a variable, or a goal."""

    condition: tuple[Condition, float] | None = None
    variable: tuple[int, int, float] | None = None
    goal: tuple[str, float] | None = None


@dataclass(frozen=True)
class _Binding:
    limit: Limit
    loosened: _Shift | None
    tightened: _Shift | None


def find_limits(found: Attained) -> tuple[Limit, ...]:
    """Each thing that binds at an optimum, with its prices, the largest gain first."""
    return tuple(sorted((_priced(found, binding) for binding in _bindings(found)), key=_order))


def _order(limit: Limit) -> tuple[float, float, str, str]:
    """By gain, then cost, then name; to six digits, so that rounding does not decide between equals."""
    gain, cost = (float(f"{price or 0.0:.6g}") for price in (limit.gain, limit.cost))
    return (-gain, -cost, limit.kind, limit.name)


def find_conflicts(found: Attained) -> tuple[Limit, ...]:
    """What conflicts where no feasible point was found: all that has a part in the least violation."""
    solution, problem = found.solution, found.start.problem
    if solution is None or solution.rows is None or solution.step is None:
        return ()
    shares = problem.shares(solution.rows, solution.step)
    owners, stop = found.start.objective.owners, solution.rows.half_lines.stop
    hard = solution.step.shares[stop - len(owners) : stop]
    whole = float(sum(shares.values()) + hard.sum()) or 1.0
    at = problem.critical(found.x, ACTIVE - found.violation)
    limits = [
        Limit(c.kind, c.name, c.side, tuple(at[c]), None, None)
        for c, share in sorted(shares.items(), key=lambda item: (-round(item[1] / whole, 6), item[0].name))
        if share > PART * whole
    ]
    goals = {owner for owner, share in zip(owners, hard, strict=True) if share > PART * whole}
    limits += [Limit("goal", owner, None, (), None, None) for owner in sorted(goals)]
    ends = [binding for binding in _variable_bindings(found) if _pushes(found, binding)]
    return (*limits, *(binding.limit for binding in ends))


def _pushes(found: Attained, binding: _Binding) -> bool:
    """Whether the end of a variable's range holds the least violation back."""
    assert found.solution is not None
    assert found.solution.step is not None
    assert binding.loosened is not None
    assert binding.loosened.variable is not None
    variable, side, _ = binding.loosened.variable
    return bool(found.solution.step.on_bounds[variable, side] > 1e-6)


def _bindings(found: Attained) -> Iterator[_Binding]:
    for condition, poses in found.start.problem.critical(found.x, ACTIVE).items():
        if poses:
            yield _condition_binding(condition, tuple(poses))
    yield from _variable_bindings(found)
    yield from _goal_bindings(found)


def _variable_bindings(found: Attained) -> Iterator[_Binding]:
    for k, name in enumerate(found.start.space.names):
        for side, (z, label) in enumerate(((found.z[k], "at_least"), (1 - found.z[k], "at_most"))):
            if z <= ACTIVE:
                limit = Limit("variable", name, label, (), None, None)
                sign = (-1.0, 1.0)[side]
                yield _Binding(
                    limit,
                    _Shift(variable=(k, side, sign * PERCENT)),
                    _Shift(variable=(k, side, -sign * PERCENT)),
                )


def _condition_binding(condition: Condition, at: tuple[tuple[float, ...], ...]) -> _Binding:
    limit = Limit(condition.kind, condition.name, condition.side, at, None, None)
    if condition.kind == "joint":
        if condition.side is None:
            return _Binding(limit, None, None)
        looser, tighter = PERCENT, -PERCENT
    else:
        sign = 1.0 if condition.side == "at_most" else -1.0
        looser, tighter = (sign * math.log(1 + sign * step) for step in (PERCENT, -PERCENT))
    return _Binding(limit, _Shift(condition=(condition, looser)), _Shift(condition=(condition, tighter)))


def _goal_bindings(found: Attained) -> Iterator[_Binding]:
    """Goals whose row binds: a soft one at λ, a hard one at its bound. A goal at 0 has no price."""
    objective, problem = found.start.objective, found.start.problem
    point = problem.layout.unpack(found.x)
    rows = objective.rows(problem.machine(point.design), point)
    gaps = rows - objective.on_factor * (found.factor if problem.has_factor else 0.0)
    goals = {goal.name: abs(goal.goal) for goal in found.start.space.design(found.z).goals}
    binding: dict[str, None] = {}
    for owner, gap in zip(objective.owners, gaps, strict=True):
        if abs(gap) <= ACTIVE * (goals[owner] or 1.0):
            binding[owner] = None
    for name in binding:
        step = PERCENT * goals[name]
        limit = Limit("goal", name, None, (), None, None)
        moved = (_Shift(goal=(name, step)), _Shift(goal=(name, -step))) if step else (None, None)
        yield _Binding(limit, *moved)


def _priced(found: Attained, binding: _Binding) -> Limit:
    best = found.factor * found.start.objective.unit
    looser, tighter = (_factor(found, shift) for shift in (binding.loosened, binding.tightened))
    noise = ROUNDING * found.start.objective.unit
    gain = None if looser is None else _price(best - looser, noise)
    cost = None if tighter is None else _price(tighter - best, noise)
    return replace(binding.limit, gain=gain, cost=cost)


def _price(price: float, noise: float) -> float:
    """A price, 0 where it is no more than the solver's rounding."""
    return price if price > noise else 0.0


def _factor(found: Attained, shift: _Shift | None) -> float | None:
    """λ with one thing moved; None where it cannot be moved or nothing feasible is near."""
    start = found.start
    if shift is None or not start.problem.has_factor:
        return None
    moved = dict([shift.goal]) if shift.goal else None
    objective = GoalObjective(start.space, found.z, moved).like(start.objective)
    limits = start.problem.layout.limits
    if shift.variable is not None:
        limits = replace(limits, design=_moved(limits.design, *shift.variable))
    point = start.problem.layout.unpack(found.x)
    groups = [
        replace(group, centre=tuple(map(float, centre)))
        for group, centre in zip(start.problem.groups, point.centres, strict=True)
    ]
    z = np.clip(point.design, *limits.design)
    relaxed = dict([shift.condition]) if shift.condition else None
    problem = FitProblem(
        start.space.machine, start.problem.size, groups, objective, limits, (z, point.scale), relaxed
    )
    solved = minimise(problem, problem.start, most=SUBPROBLEMS, radius=0.05)
    return solved.factor * objective.unit if solved.violation <= FEASIBLE else None


def _moved(box: tuple[Array, Array], variable: int, side: int, step: float) -> tuple[Array, Array]:
    moved = (box[0].copy(), box[1].copy())
    moved[side][variable] += step
    return moved

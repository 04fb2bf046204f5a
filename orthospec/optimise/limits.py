"""What holds a design back, and at what price.

At an optimum each bound, joint limit, variable's range and goal that binds is moved by one per cent, to
either side, and the problem solved again from there: ``gain`` is what λ falls by when it is loosened,
``cost`` what it rises by when tightened. The two differ where several bounds bind at one pose, and the
solver's multipliers, which are not unique there, are neither.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from orthospec.composite.trust_region import FEASIBLE, Ending, minimise
from orthospec.optimise.attain import Attained, Pressure
from orthospec.optimise.objective import Learnt
from orthospec.optimise.place import Fit, Place, fit_at, fit_finely
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, problem_of
from orthospec.optimise.workers import Workers, in_order
from orthospec.result import Limit
from orthospec.workspace.conditions import Condition
from orthospec.workspace.field import Progress

if TYPE_CHECKING:
    from orthospec.arrays import Array

ACTIVE = 1e-6
"""A condition this near its bound binds."""
PERCENT = 0.01
PART = 1e-3
"""A condition conflicts when it has more than this part in the least violation."""
ROUNDING = 1e-8
"""A price below this, relative to the unit of λ, is none."""
SUBPROBLEMS = 100
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


@dataclass(frozen=True)
class _Move:
    """One thing moved at the end of a solve."""

    end: Place
    learnt: Learnt
    shift: _Shift


def find_limits(
    space: DesignSpace, found: Attained, workers: Workers, progress: Progress | None = None
) -> tuple[Limit, ...]:
    """Each thing that binds at an optimum, with its prices, the largest gain first.

    A solve that ran out of subproblems has no prices: what moving a bound gains, going on would gain too.
    """
    fit = fit_finely(space, found.end, found.learnt)
    bindings = list(_bindings(fit, found))
    shifts = [shift for binding in bindings for shift in (binding.loosened, binding.tightened)]
    priced = fit.problem.has_factor and not found.exhausted
    movable = list(dict.fromkeys(shift for shift in shifts if shift is not None and priced))
    moves = [_Move(found.end, found.learnt, shift) for shift in movable]
    factors: dict[_Shift | None, float | None] = dict(
        zip(movable, in_order(workers, PRICE, space, moves, progress), strict=True)
    )
    return tuple(sorted((_priced(found, binding, factors) for binding in bindings), key=_order))


def _order(limit: Limit) -> tuple[float, float, str, str]:
    """By gain, then cost, then name; to six digits, so that rounding does not decide between equals."""
    gain, cost = (float(f"{price or 0.0:.6g}") for price in (limit.gain, limit.cost))
    return (-gain, -cost, limit.kind, limit.name)


def find_conflicts(space: DesignSpace, found: Attained) -> tuple[Limit, ...]:
    """What conflicts where no feasible point was found: all that has a part in the least violation."""
    pressure = found.pressure
    if pressure is None:
        return ()
    whole = sum(share for _, share in (*pressure.conditions, *pressure.goals)) or 1.0
    problem = fit_finely(space, found.end, found.learnt).problem
    at = problem.critical(problem.start, ACTIVE - found.violation)
    by_share = sorted(pressure.conditions, key=lambda item: (-round(item[1] / whole, 6), item[0].name))
    limits = [
        Limit(c.kind, c.name, c.side, tuple(at[c]), None, None)
        for c, share in by_share
        if share > PART * whole
    ]
    goals = {owner for owner, share in pressure.goals if share > PART * whole}
    limits += [Limit("goal", owner, None, (), None, None) for owner in sorted(goals)]
    ends = [binding for binding in _variable_bindings(space, found) if _pushes(pressure, binding)]
    return (*limits, *(binding.limit for binding in ends))


def _pushes(pressure: Pressure, binding: _Binding) -> bool:
    """Whether the end of a variable's range holds the least violation back."""
    assert binding.loosened is not None
    assert binding.loosened.variable is not None
    variable, side, _ = binding.loosened.variable
    return pressure.ends[variable][side] > 1e-6


def _bindings(fit: Fit, found: Attained) -> Iterator[_Binding]:
    demands = fit.problem.machine(fit.problem.layout.unpack(fit.problem.start).design).demands
    for condition, poses in fit.problem.critical(fit.problem.start, ACTIVE).items():
        if poses:
            bound = demands[condition.name].bounds[str(condition.side)] if condition.kind == "bound" else None
            yield _condition_binding(condition, tuple(poses), bound)
    yield from _variable_bindings(fit.space, found)
    yield from _goal_bindings(fit, found)


def _variable_bindings(space: DesignSpace, found: Attained) -> Iterator[_Binding]:
    for k, (name, z) in enumerate(zip(space.names, found.end.z, strict=True)):
        for side, (room, label) in enumerate(((z, "at_least"), (1 - z, "at_most"))):
            if room <= ACTIVE:
                limit = Limit("variable", name, label, (), None, None)
                sign = (-1.0, 1.0)[side]
                yield _Binding(
                    limit,
                    _Shift(variable=(k, side, sign * PERCENT)),
                    _Shift(variable=(k, side, -sign * PERCENT)),
                )


def _condition_binding(
    condition: Condition, at: tuple[tuple[float, ...], ...], bound: float | None
) -> _Binding:
    """A bound is moved by a part of itself, so that one of 0 has no price; a joint limit as its margin is."""
    limit = Limit(condition.kind, condition.name, condition.side, at, None, None)
    if condition.side is None or bound == 0:
        return _Binding(limit, None, None)
    looser, tighter = PERCENT, -PERCENT
    if bound is not None and bound > 0:  # What it is exceeded by is a logarithm: `orthospec.measures.demand`.
        sign = 1.0 if condition.side == "at_most" else -1.0
        looser, tighter = (sign * math.log(1 + sign * step) for step in (PERCENT, -PERCENT))
    return _Binding(limit, _Shift(condition=(condition, looser)), _Shift(condition=(condition, tighter)))


def _goal_bindings(fit: Fit, found: Attained) -> Iterator[_Binding]:
    """Goals whose row binds: a soft one at λ, a hard one at its bound. A goal at 0 has no price."""
    objective, problem = fit.objective, fit.problem
    point = problem.layout.unpack(problem.start)
    rows = objective.rows(problem.machine(point.design), point)
    factor = found.factor * found.unit / objective.unit if problem.has_factor else 0.0
    gaps = rows - objective.on_factor * factor
    goals = {goal.name: abs(goal.goal) for goal in fit.space.design(point.design).goals}
    binding: dict[str, None] = {}
    for owner, gap in zip(objective.owners, gaps, strict=True):
        if abs(gap) <= ACTIVE * (goals[owner] or 1.0):
            binding[owner] = None
    for name in binding:
        step = PERCENT * goals[name]
        limit = Limit("goal", name, None, (), None, None)
        moved = (_Shift(goal=(name, step)), _Shift(goal=(name, -step))) if step else (None, None)
        yield _Binding(limit, *moved)


def _priced(found: Attained, binding: _Binding, factors: Mapping[_Shift | None, float | None]) -> Limit:
    best = found.factor * found.unit
    looser, tighter = (factors.get(shift) for shift in (binding.loosened, binding.tightened))
    if any(factor is not None and math.isnan(factor) for factor in (looser, tighter)):
        return binding.limit
    noise = ROUNDING * found.unit
    gain = None if looser is None else _price(best - looser, noise)
    cost = None if tighter is None else _price(tighter - best, noise)
    return replace(binding.limit, gain=gain, cost=cost)


def _price(price: float, noise: float) -> float:
    """A price, 0 where it is no more than the solver's rounding."""
    return price if price > noise else 0.0


def factor_moved(space: DesignSpace, move: _Move, _: Progress | None = None) -> float | None:
    """λ with one thing moved; None where nothing feasible is near, NaN where that is left open."""
    shift, limits = move.shift, move.end.limits(space)
    if shift.variable is not None:
        limits = replace(limits, design=_moved(limits.design, *shift.variable))
    fit = fit_at(
        space,
        move.end,
        move.learnt,
        limits=limits,
        shifts=dict([shift.goal]) if shift.goal else None,
        relaxed=dict([shift.condition]) if shift.condition else None,
    )
    solved = minimise(fit.problem, fit.problem.start, most=SUBPROBLEMS, radius=0.05)
    if solved.ending is Ending.EXHAUSTED:
        return math.nan
    return float(solved.factor) * fit.objective.unit if solved.violation <= FEASIBLE else None


PRICE = Task("what limits it", factor_moved, problem_of)


def _moved(box: tuple[Array, Array], variable: int, side: int, step: float) -> tuple[Array, Array]:
    moved = (box[0].copy(), box[1].copy())
    moved[side][variable] += step
    return moved

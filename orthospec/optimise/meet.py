"""Meeting a Pareto set from one place: goal attainment along a normal, then on with the goals left over.

Where a goal is flat, as one on the choices of a catalogue alone is within its branch, it may decide λ by
itself. The design is then any of many, and most of them are worse than need be in the other goals. These are
lowered with the deciding ones held, as far as that is worth telling.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orthospec.optimise.attain import FINISH, Attained, attain
from orthospec.optimise.place import Place, fit_at, fit_finely
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, problem_of
from orthospec.spec import Spec
from orthospec.workspace.evaluate import FINE
from orthospec.workspace.field import Progress

SLACK = 1e-6
"""A goal further than this from deciding λ, in parts of its range, is free."""
FLAT = 1e-3
"""What free goals can be lowered by, as a part of their range, where the ones that are held count as flat.

With less to win they are left alone: where a set only runs out evenly, they would be lowered at the price of
the last digits of those that decide.
"""

Aims = tuple[tuple[str, float, float], ...]
"""Of each soft goal: its name, by how much easier it is, and its weight."""
Chosen = tuple[tuple[str, float], ...]
"""The variables with a catalogue, and what is chosen of each."""


@dataclass(frozen=True)
class Met:
    """What was met."""

    attained: Attained
    gaps: tuple[float, ...]
    """Of the spec's soft goals, in their order."""
    aims: Aims
    """Of the problem that it solves."""


@dataclass(frozen=True)
class Sought:
    """A point to look for in a branch, and where from."""

    choice: Chosen
    aims: Aims
    ranges: tuple[float, ...]
    """Of all soft goals over the set."""
    place: Place


@dataclass(frozen=True)
class Lowering:
    """A point that was met in a branch."""

    choice: Chosen
    ranges: tuple[float, ...]
    met: Met


def space_of(spec: Spec, choice: Chosen, aims: Aims) -> DesignSpace:
    """The problem of a point: one branch, its soft goals those of the aims."""
    aimed = spec.aimed({name: (easier, weight) for name, easier, weight in aims})
    return DesignSpace(aimed.chosen(dict(choice)))


def soft_goals(spec: Spec) -> tuple[str, ...]:
    """The goals that a Pareto set is of."""
    return tuple(plan.name for plan in spec.goals if plan.is_soft)


def seek(space: DesignSpace, sought: Sought, _: Progress | None = None) -> Met:
    """Meet the set from one place."""
    found = attain(space_of(space.spec, sought.choice, sought.aims), sought.place)
    met = Met(found, gaps_at(space.spec, sought.choice, found.end), sought.aims)
    return lower(space, Lowering(sought.choice, sought.ranges, met))


def lower(space: DesignSpace, one: Lowering, _: Progress | None = None) -> Met:
    """Lower the goals that do not decide λ as far as they go, with those that do held.

    A goal on choices alone has but one value in the branch: it is neither held nor lowered. Where only such
    goals decide, what is met is the answer to the others' problem.
    """
    spec, met = space.spec, one.met
    names, chosen = soft_goals(spec), {name for name, _ in one.choice}
    gaps, ranges = dict(zip(names, met.gaps, strict=True)), dict(zip(names, one.ranges, strict=True))
    rows = {name: (gaps[name] - by) / weight for name, by, weight in met.aims}
    moving = [plan.name for plan in spec.goals if plan.name in names and not plan.depends_on_only(chosen)]
    free = [name for name in moving if rows.get(name, -np.inf) < max(rows.values()) - SLACK]
    held = [name for name in moving if name not in free]
    if not free or not met.attained.feasible or not _can_be_held(spec, one, held):
        return met
    aims = (
        *((name, gaps[name], 0.0) for name in held),
        *((name, gaps[name], ranges[name]) for name in free),
    )
    better = attain(space_of(spec, one.choice, aims), met.attained.end)
    now = dict(zip(names, gaps_at(spec, one.choice, better.end), strict=True))
    won = min((gaps[name] - now[name]) / ranges[name] for name in free)
    if not better.feasible or won < (FLAT if held else -SLACK):
        return met
    if not held:
        return Met(better, tuple(now.values()), aims)
    spent = met.attained.subproblems + better.subproblems
    attained = replace(met.attained, end=better.end, subproblems=spent)
    return replace(met, attained=attained, gaps=tuple(now.values()))


def _can_be_held(spec: Spec, one: Lowering, held: Sequence[str]) -> bool:
    """Whether goals have a value to be held at: a bound at 0 has no size by which to be judged."""
    values = space_of(spec, one.choice, one.met.aims).values(one.met.attained.end.design)
    plans = [plan for plan in spec.goals if plan.is_soft]
    return all(
        abs(plan.aimed(gap, 0.0).at(values).goal) > FLAT * wide
        for plan, gap, wide in zip(plans, one.met.gaps, one.ranges, strict=True)
        if plan.name in held
    )


def as_aimed(space: DesignSpace, found: Attained) -> Attained:
    """What was found for the same goals by other weights, as the solve of this problem would have told it."""
    fit = fit_finely(space, found.end, found.learnt)
    here = fit.problem.assess(fit.problem.start)
    return replace(found, factor=float(here.factor), unit=fit.objective.unit)


def gaps_at(spec: Spec, choice: Chosen, place: Place) -> tuple[float, ...]:
    """How far each soft goal is missed with the design at a place; negative where it is met."""
    fit = fit_at(DesignSpace(spec.chosen(dict(choice))), place)
    fit.problem.lattice = FINE
    point = fit.problem.layout.unpack(fit.problem.assess(fit.problem.start).x)
    rows = fit.objective.rows(fit.problem.machine(point.design), point)
    owners = fit.objective.owners
    return tuple(
        max(float(row) for row, owner in zip(rows, owners, strict=True) if owner == name)
        for name in soft_goals(spec)
    )


def _problem_of_branch(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a point depends on: of a catalogue no other entry than the chosen one, which is given with it."""
    problem = problem_of(content)
    ranges = {name: None if "choices" in one else one for name, one in problem["variables"].items()}
    return {**problem, "variables": ranges}


_PARTS = (Met, *FINISH.makes)
SEEK = Task("points of the Pareto set", seek, _problem_of_branch, _PARTS)
LOWER = Task("ends of the Pareto set", lower, _problem_of_branch, _PARTS)

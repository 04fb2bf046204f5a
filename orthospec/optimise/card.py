"""Why no design was found: a smallest set of conflicting conditions, and the cheapest way out of it.

A deletion filter (Chinneck, *Feasibility and Infeasibility in Optimization*, 2008, ch. 6) leaves out one
condition after the other and looks again for a design: what is not missed does not belong to the conflict.
Then each condition of the conflict is loosened by as little as does it, everything else held, and all of them
by one and the same part. Each look is a local solve from the point found, so that the card tells what was
*found*, as the search does.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf
from typing import Literal

from orthospec.optimise.loosen import SMALLEST, joint_limits, largest_scale, look, loosened, stem
from orthospec.optimise.place import Place
from orthospec.optimise.space import DesignSpace
from orthospec.result import Card, Culprit, Limit

SAME = 1e-6
"""Loosening all by so little less than one alone is no other way out."""


def find_card(space: DesignSpace, place: Place, suspects: Sequence[Limit]) -> Card:
    """The card of a search that ended at ``place``; ``suspects`` share the least violation there.

    Where a goal is about the scale, a smaller cuboid is no way out, and is not looked for.
    """
    scaled = place.scales is not None and place.least_scale is None
    every = _all_conditions(space, place)
    here = replace(place, scales=(SMALLEST, 1.0), least_scale=1.0) if not scaled else place
    suspected = set(map(_bare, suspects))
    conflict, small = _smallest(space, here, every, [one for one in every if one in suspected])
    found = {one: loosened(space, here, [one]) for one in conflict}
    culprits = sorted((_culprit(space, one, by) for one, by in found.items()), key=_order)
    together = loosened(space, here, conflict) if len(conflict) > 1 else None
    if together is not None and any(by is not None and by <= together * (1 + SAME) for by in found.values()):
        together = None
    return Card(tuple(culprits), small, together, None if scaled else largest_scale(space, place))


def _order(culprit: Culprit) -> tuple[float, str, str, str]:
    """The cheapest first; to six digits, so that rounding does not decide between equals."""
    by = inf if culprit.by is None else float(f"{culprit.by:.6g}")
    return by, culprit.kind, culprit.name, culprit.side or ""


def _bare(limit: Limit) -> Limit:
    """What a limit is of, without its poses and prices; a joint's for all joints."""
    name = stem(limit.name) if limit.kind == "joint" else limit.name
    return Limit(limit.kind, name, limit.side, (), None, None)


def _all_conditions(space: DesignSpace, place: Place) -> tuple[Limit, ...]:
    """All that the spec asks for and may be loosened: bounds, joint limits, hard goals, ends of ranges.

    The reach itself is no wish: a machine cannot do without it.
    """
    design = space.design(place.design)
    found = [_plain("bound", demand.name, side) for demand in design.demands for side in demand.bounds]
    found += [_plain("joint", name, side) for name, side in joint_limits(space, place)]
    found += [_plain("goal", goal.name, None) for goal in design.goals if goal.weight == 0]
    ends = ("at_least", "at_most")
    found += [_plain("variable", name, side) for name in space.names for side in ends]
    return tuple(found)


def _plain(kind: Literal["bound", "joint", "variable", "goal"], name: str, side: str | None) -> Limit:
    return Limit(kind, name, side, (), None, None)


def _smallest(
    space: DesignSpace, place: Place, every: Sequence[Limit], suspects: Sequence[Limit]
) -> tuple[tuple[Limit, ...], bool]:
    """A set that conflicts, and whether a design was found without each one of it."""

    def conflicts(kept: Iterable[Limit]) -> bool:
        held = set(kept)
        return not look(space, place, {one: inf for one in every if one not in held}).found

    left = list(suspects if conflicts(suspects) else every)
    if len(left) == len(every) and not conflicts(left):
        return (), False
    for one in list(left):
        rest = [other for other in left if other != one]
        if rest and conflicts(rest):
            left = rest
    return tuple(left), len(left) > 1 or not conflicts(())


def _culprit(space: DesignSpace, one: Limit, by: float | None) -> Culprit:
    """A condition of the conflict with its place, its value and the one that would do."""
    value, unit = _value(space, one)
    needed = value + by * unit if value is not None and by is not None else None
    return Culprit(one.kind, one.name, one.side, space.spec.place(_path(one)), value, needed, by)


def _value(space: DesignSpace, one: Limit) -> tuple[float | None, float]:
    """The value of a condition, and what a loosening of 1 adds to it; None where the reach alone knows it."""
    spec = space.spec
    design = spec.design(spec.default_values())
    sense = 1.0 if one.side == "at_most" else -1.0
    if one.kind == "bound":
        demand = next(demand for demand in design.demands if demand.name == one.name)
        bound = demand.bounds[str(one.side)]
        return bound, sense * (abs(bound) or 1.0)
    if one.kind == "variable":
        variable = spec.variables[one.name]
        end = variable.min if one.side == "at_least" else variable.max
        return end, sense * (variable.max - variable.min)
    if one.kind == "goal":
        goal = next(goal for goal in design.goals if goal.name == one.name)
        return goal.goal, (-1.0 if goal.sense == "maximise" else 1.0) * (abs(goal.goal) or 1.0)
    return None, 1.0


def _path(one: Limit) -> tuple[str | int, ...]:
    """Where the spec has a condition; a joint limit goes by its name."""
    ends = {"at_least": "min", "at_most": "max"}
    if one.kind == "bound":
        return ("measures", one.name, str(one.side))
    if one.kind == "variable":
        return ("variables", one.name, ends[str(one.side)])
    if one.kind == "goal":
        return ("goals", one.name, "goal")
    return ("manipulator", one.name, ends[str(one.side)])

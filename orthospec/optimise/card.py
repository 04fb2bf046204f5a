"""Why no design was found: a smallest set of conflicting conditions, and the cheapest way out of it.

A deletion filter (Chinneck, *Feasibility and Infeasibility in Optimization*, 2008, ch. 6) leaves out one
condition after the other and looks again for a design: what is not missed does not belong to the conflict.
Then each condition of the conflict is loosened by as little as does it, everything else held, and all of them
by one and the same part. Each look is a local solve from the point found, so that the card tells what was
*found*, as the search does. The looks of the filter follow from one another; the loosenings do not, and are
shared out among the workers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Literal

import numpy as np

from orthospec.optimise.give_way import CONFLICT, GIVE_WAY, Way, WayOut, Without
from orthospec.optimise.loosen import SMALLEST, joint_limits, stem
from orthospec.optimise.place import Place
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Stopped
from orthospec.optimise.workers import Workers, counted, in_order
from orthospec.result import Card, Culprit, Limit
from orthospec.workspace.field import Progress

SAME = 1e-6
"""Loosening all by so little less than one alone is no other way out."""


def find_card(
    space: DesignSpace,
    place: Place,
    suspects: Sequence[Limit],
    workers: Workers,
    progress: Progress | None = None,
) -> Card:
    """The card of a search that ended at ``place``; ``suspects`` share the least violation there.

    Where a goal is about the scale, a smaller cuboid is no way out, and is not looked for. Ctrl-C once the
    conflict is known is `Stopped`, with a card of what is known by then.
    """
    scaled = place.scales is not None and place.least_scale is None
    every = _all_conditions(space, place)
    here = replace(place, scales=(SMALLEST, 1.0), least_scale=1.0) if not scaled else place
    suspected = set(map(_bare, suspects))
    look = _Filter(space, here, workers, every, progress)
    conflict, small = _smallest(look, every, [one for one in every if one in suspected])
    ways = [WayOut(here, (one,)) for one in conflict]
    ways += [WayOut(here, conflict)] if len(conflict) > 1 else []
    ways += [] if scaled else [WayOut(here, ())]
    known: dict[WayOut, Way | None] = {}
    try:
        for number, least in counted(workers, GIVE_WAY, space, ways, progress):
            known[ways[number]] = least
    except KeyboardInterrupt:
        raise Stopped(_card(space, here, conflict, small, known)) from None
    return _card(space, here, conflict, small, known)


def _card(
    space: DesignSpace,
    end: Place,
    conflict: tuple[Limit, ...],
    small: bool,
    known: Mapping[WayOut, Way | None],
) -> Card:
    """The card of what is known; the loosening of a condition that is not was cut off."""
    least = {way.ones: by for way, by in known.items()}
    culprits = [_culprit(space, one, end, least[(one,)]) for one in conflict if (one,) in least]
    unknown = [_culprit(space, one, end, None) for one in conflict if (one,) not in least]
    cut_off = [replace(one, sought=False) for one in unknown]
    all_of_them, smaller = least.get(conflict), least.get(())
    together = all_of_them.by if all_of_them is not None and len(conflict) > 1 else None
    if together is not None and any(
        one.by is not None and one.by <= together * (1 + SAME) for one in culprits
    ):
        together = None
    scale = None if smaller is None else smaller.by
    return Card((*sorted(culprits, key=_order), *cut_off), small, together, scale)


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


@dataclass(frozen=True)
class _Filter:
    """Looks for a design with some of the conditions held."""

    space: DesignSpace
    place: Place
    workers: Workers
    every: Sequence[Limit]
    progress: Progress | None

    def conflicts(self, held: Iterable[Limit]) -> bool:
        """Whether none is found."""
        kept = set(held)
        asked = Without(self.place, tuple(one for one in self.every if one not in kept))
        (found,) = in_order(self.workers, CONFLICT, self.space, [asked], self.progress)
        return found


def _smallest(
    look: _Filter, every: Sequence[Limit], suspects: Sequence[Limit]
) -> tuple[tuple[Limit, ...], bool]:
    """A set that conflicts, and whether a design was found without each one of it."""
    left = list(suspects if look.conflicts(suspects) else every)
    if len(left) == len(every) and not look.conflicts(left):
        return (), False
    for one in list(left):
        rest = [other for other in left if other != one]
        if rest and look.conflicts(rest):
            left = rest
    return tuple(left), len(left) > 1 or not look.conflicts(())


def _culprit(space: DesignSpace, one: Limit, end: Place, way: Way | None) -> Culprit:
    """A condition of the conflict with its place, its value and the one that would do.

    A value that varies is that of the design found with it loosened, or else of the search's end.
    """
    value, unit = _value(space, one, end.z if way is None or way.z is None else way.z)
    by = None if way is None else way.by
    needed = value + by * unit if value is not None and by is not None else None
    return Culprit(one.kind, one.name, one.side, space.spec.place(_path(one)), value, needed, by)


def _value(space: DesignSpace, one: Limit, z: tuple[float, ...]) -> tuple[float | None, float]:
    """The value of a condition, and what a loosening of 1 adds to it; None where the reach alone knows it."""
    spec, design = space.spec, space.design(np.array(z))
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

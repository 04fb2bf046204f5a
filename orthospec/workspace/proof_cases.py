"""What a proof asks of each box: how far the conditions of one measure, or of the reach, may be exceeded.

An excess is relative: to a bound's magnitude, or a margin of the reach as the machine gives it. Slack is for
bounds and joint limits, on which designs end. The other margins of the reach have none: beyond 0 the
machine cannot stand.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.errors import NoEnclosure
from orthospec.intervals import Boxes
from orthospec.measures import Demand
from orthospec.measures.demand import ROUNDING, bounded_side
from orthospec.workspace.conditions import Condition, conditions_of
from orthospec.workspace.tolerances import Family

if TYPE_CHECKING:
    from orthospec.arrays import Array


class Case(NamedTuple):
    """Conditions that are computed together."""

    conditions: tuple[Condition, ...]
    slack: Array
    """What each may be exceeded by (k,)."""
    over: Callable[[Boxes], Array]
    """Verified bounds on the excess of each in each box (k, n); NaN where nothing is known."""
    at: Callable[[Array], Array]
    """The excess of each at points (k, n), in plain arithmetic."""


def cases_of(family: Family, demands: tuple[Demand, ...], start: Boxes, slack: float) -> list[Case]:
    """The reach, then each demand: in all the order of `conditions_of`."""
    conditions = conditions_of(family.nominal, demands, family.at(start.lo)[1])
    reach = tuple(c for c in conditions if c.kind == "joint")
    cases = [_reach_case(family, reach, slack)]
    for demand in demands:
        bounds = tuple(c for c in conditions if c.kind == "bound" and c.name == demand.name)
        cases.append(_bounds_case(family, demand, bounds, start, slack))
    return cases


def _reach_case(family: Family, conditions: tuple[Condition, ...], slack: float) -> Case:
    def over(boxes: Boxes) -> Array:
        manipulator, of_poses = family.over(boxes)
        margins = manipulator.reach_enclosure(of_poses)
        return np.stack([-margins[c.reach_key].lo for c in conditions])

    def at(points: Array) -> Array:
        manipulator, poses = family.at(points)
        margins = manipulator.reach(poses)
        return np.stack([-margins[c.reach_key] for c in conditions])

    return Case(conditions, np.array([slack if c.side else 0.0 for c in conditions]), over, at)


def _bounds_case(
    family: Family, demand: Demand, conditions: tuple[Condition, ...], start: Boxes, slack: float
) -> Case:
    @cache
    def axes() -> int:
        return np.ndim(demand.measure.values(*family.at(start.lo)))

    def excess(ends: Callable[[str], Array]) -> Array:
        rows = []
        for side, bound in demand.bounds.items():
            sign = 1.0 if side == "at_most" else -1.0
            rows.append(sign * (bounded_side(ends(side), side) - bound) / (abs(bound) or 1.0))
        return np.stack(rows)

    def over(boxes: Boxes) -> Array:
        found = demand.enclosure(*family.over(boxes))
        if found.ndim != axes():
            title = type(demand.measure).__name__
            raise NoEnclosure(
                f"{title} gives an enclosure of shape {found.shape} for values of {axes()} axes"
            )
        known = excess(lambda side: found.hi if side == "at_most" else found.lo)
        with np.errstate(invalid="ignore"):
            return np.asarray(known + ROUNDING * np.maximum(np.abs(known), 1.0))

    def at(points: Array) -> Array:
        values = demand.measure.values(*family.at(points))
        return excess(lambda _: values)

    return Case(conditions, np.full(len(conditions), slack), over, at)

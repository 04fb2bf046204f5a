"""Bars of numbers: a value beside its goal, or where it stands in a range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from orthospec.spec import Variable

_ROOM = 0.08
"""Beyond the greater of value and goal, as a part of the bar."""


@dataclass(frozen=True)
class Bar:
    """A bar from ``start`` to ``end`` on a track of 0 ... 100, and ticks on it."""

    start: float
    end: float | None
    ticks: tuple[float, ...]
    manner: str
    told: str


def beside_goal(value: float | None, goal: float, manner: str, told: str) -> Bar | None:
    """From 0 to the value, with a tick at the goal."""
    if value is None:
        return None
    low, high = min(0.0, value, goal), max(0.0, value, goal)
    room = _ROOM * (high - low) or 1.0
    low, high = low - (room if low < 0 else 0.0), high + (room if high > 0 else 0.0)

    def at(one: float) -> float:
        return 100 * (one - low) / (high - low)

    return Bar(at(min(0.0, value)), at(max(0.0, value)), (at(goal),), manner, told)


def in_range(value: float, variable: Variable, told: str) -> Bar | None:
    """The range as the whole track, filled up to the value; choices as ticks."""
    low, high = variable.min, variable.max
    if not high > low:
        return None
    ends = (variable.choices or ()) if len(variable.choices) <= 24 else ()
    ticks = tuple(100 * (one - low) / (high - low) for one in ends)
    end = min(max(100 * (value - low) / (high - low), 0.0), 100.0)
    return Bar(max(end - 1.5, 0.0), min(end + 1.5, 100.0), ticks, "within", told)

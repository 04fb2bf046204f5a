"""`Demand`: a measure with the bounds that a spec puts on it, at one design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from orthospec.arrays import np
from orthospec.errors import NoEnclosure
from orthospec.measures.base import Measure

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags
    from orthospec.intervals import Boxes, Interval
    from orthospec.manipulators import Manipulator

LITTLE = 1e-3
"""The part of a lower bound below which a value's distance from it is no more told by their ratio."""
ROUNDING = 1e-12
"""A bound holds within this, relative: designs end on their bounds, and the last bit must not decide."""


@dataclass(frozen=True)
class Level:
    """Further bounds on a measure: reported with a cuboid of their own, binding nothing."""

    bounds: Mapping[str, float]


@dataclass(frozen=True)
class Demand:
    """``name`` is the user's; ``bounds`` maps the sides in use ("at_least", "at_most") to SI values."""

    name: str
    measure: Measure
    bounds: Mapping[str, float]
    levels: tuple[Level, ...] = ()
    place: str | None = None
    """``FILE:LINE:COLUMN`` of the measure in its spec, for messages."""

    def at(self, level: Level) -> Demand:
        """The same measure with the bounds of one of its levels."""
        return Demand(self.name, self.measure, level.bounds, (), self.place)

    def meets(self, values: Array) -> Flags:
        """Whether each pose meets the bounds (n,); values as `Measure.values` gives them; NaN does not."""
        met = np.ones(len(values), dtype=bool)
        for side, bound in self.bounds.items():
            slack = ROUNDING * abs(bound)
            bounded = bounded_side(values, side)
            met &= bounded >= bound - slack if side == "at_least" else bounded <= bound + slack
        return met

    def enclosure(self, manipulator: Manipulator, boxes: Boxes) -> Interval:
        """Bounds on the values over each box, (n,) or (n, 2).

        Raises NoEnclosure where the measure gives none, or what cannot be one.
        """
        from orthospec.intervals import Interval

        found, n = self.measure.enclosure(manipulator, boxes), len(boxes)
        title = type(self.measure).__name__
        if not isinstance(found, Interval):
            raise NoEnclosure(f"{title} gives no enclosure")
        if found.shape not in {(n,), (n, 2)}:
            raise NoEnclosure(f"{title} gives an enclosure of shape {found.shape} for {n} boxes")
        if (found.lo > found.hi).any():
            raise NoEnclosure(f"{title} gives an enclosure whose lower end lies above the upper one")
        return found


def bounded_side(values: Array, side: str) -> Array:
    """The column of a measure's values that a bound of this side bounds, (n,)."""
    if values.ndim == 1:
        return values
    return values[:, 0] if side == "at_least" else values[:, 1]


def excess(values: Array, bound: float, side: str) -> Array:
    """How far a bound is exceeded (n,), <= 0 where it holds: ln of the ratio where both are positive.

    Elsewhere the difference over the bound's magnitude (over 1 for a bound of 0). NaN stays NaN. Below a
    positive lower bound the logarithm goes on straight from `LITTLE` of it: a value may be negative where an
    actuator cannot hold the machine, and a search has to find its way out. No factor makes 0 meet it: inf.
    """
    sign = 1.0 if side == "at_most" else -1.0
    bounded = bounded_side(values, side)
    difference = sign * (bounded - bound) / (abs(bound) or 1.0)
    if bound <= 0:
        return difference
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = sign * np.log(bounded / bound)
        straight = 1.0 - np.log(LITTLE) - bounded / (LITTLE * bound)
    if side == "at_most":
        return np.where(bounded <= 0, difference, ratio)
    return np.where(bounded == 0, np.inf, np.where(bounded < LITTLE * bound, straight, ratio))

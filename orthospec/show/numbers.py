"""Numbers as an engineer reads them: six significant digits, and one unit of length in a whole text.

Where no other unit is asked for, lengths are in millimetres where the prescribed cuboid is smaller than a
metre, else in metres; stiffness is in N/um, a modulus in GPa or MPa, and all else in SI units.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from orthospec.quantities.units import UnitError, parse_unit

Scaled = TypeVar("Scaled")

UNKNOWN = "?"
NOTHING = "-"


@dataclass(frozen=True)
class Numbers:
    """How numbers are written in one text; a unit may be any that specs know."""

    millimetres: bool

    def value(self, number: float | None, unit: str = "1") -> str:
        """An SI number with its unit: ``310.583 mm``; no unit where it is 1 or not known."""
        return self.several([number], unit)

    def several(self, numbers: Sequence[float | None], unit: str = "1") -> str:
        """Numbers with one unit after them; equal ones as ``3 x 310.583 mm``."""
        if all(number is None for number in numbers):
            return NOTHING
        shown = self.shown(unit, numbers)
        if shown and len(numbers) > 1 and len({_digits(number, shown) for number in numbers}) == 1:
            return f"{len(numbers)} x {self.value(numbers[0], unit)}"
        return self._listed(numbers, unit)

    def each(self, numbers: Sequence[float | None], units: Sequence[str]) -> str:
        """Numbers with units of their own, those of one unit together: ``0  0  -100 N  0  0  0 N*m``."""
        groups = itertools.groupby(zip(numbers, units, strict=True), key=lambda pair: pair[1])
        return "  ".join(self._listed([number for number, _ in group], unit) for unit, group in groups)

    def _listed(self, numbers: Sequence[float | None], unit: str) -> str:
        shown = self.shown(unit, numbers)
        return "  ".join(_digits(number, shown) for number in numbers) + _after(shown)

    def interval(self, low: float | None, high: float | None, unit: str = "1") -> str:
        """``126.795 ... 383.788 mm``."""
        shown = self.shown(unit, [low, high])
        return f"{_digits(low, shown)} ... {_digits(high, shown)}{_after(shown)}"

    def edges(self, low: Sequence[float | None], high: Sequence[float | None], units: Sequence[str]) -> str:
        """The size between two corners: ``200 x 200 x 200 mm``."""
        sizes = [None if a is None or b is None else b - a for a, b in zip(low, high, strict=True)]
        return self._with_units([self.value(s, u) for s, u in zip(sizes, units, strict=False)], " x ")

    def pose(self, pose: Sequence[float | None], units: Sequence[str]) -> str:
        """A point with as many decimals as matter to a machine: ``(-126.795, 73.205, 0.000) mm``."""
        every = (*units, *["1"] * len(pose))
        texts = [self._coordinate(one, unit) for one, unit in zip(pose, every, strict=False)]
        return self._with_units(texts, ", ", "()")

    def _coordinate(self, coordinate: float | None, unit: str) -> str:
        if coordinate is None:
            return NOTHING
        shown = self.shown(unit, [coordinate])
        decimals = 3 if shown == "mm" else 5
        return f"{round(in_unit(coordinate, shown), decimals) + 0.0:.{decimals}f}{_after(shown)}"

    def _with_units(self, texts: Sequence[str], between: str, brackets: str = "") -> str:
        """One unit behind all where they share it."""
        units = {text.partition(" ")[2] for text in texts if text != NOTHING}
        unit = units.pop() if len(units) == 1 else ""
        inner = between.join(text.removesuffix(f" {unit}") if unit else text for text in texts)
        return f"{brackets[:1]}{inner}{brackets[1:]}{_after(unit)}"

    def scale(self, unit: str, numbers: Sequence[float | None]) -> tuple[float, str]:
        """By what SI numbers of a unit are multiplied to be told, and the unit that they are told in."""
        name = self.shown(unit, numbers)
        return in_unit(1.0, name), name

    def shown(self, unit: str, numbers: Sequence[float | None]) -> str:
        """The unit in which numbers of this one are told; nothing where it is 1 or not known."""
        if unit == "m":
            return "mm" if self.millimetres else "m"
        if unit == "Pa":
            greatest = max((abs(number) for number in numbers if number is not None), default=0.0)
            return "GPa" if greatest >= 1e9 else "MPa"
        return {"1": "", UNKNOWN: "", "N/m": "N/um"}.get(unit, unit)


def in_unit(number: Scaled, shown: str) -> Scaled:
    """An SI number, or an array of them, in this unit; as it is where a plugin's unit is not in the table."""
    try:
        unit = parse_unit(shown or "1")
    except UnitError:
        return number
    factor: Any = float(unit.denominator / unit.numerator)
    scaled: Scaled = number * factor
    return scaled


def _digits(number: float | None, shown: str) -> str:
    return NOTHING if number is None else f"{in_unit(number, shown):.6g}"


def _after(unit: str) -> str:
    return f" {unit}" if unit else ""


def percent(part: float) -> str:
    """``4.9 %``; two digits that tell something, and no exponent for a large part."""
    told = float(f"{100 * part:.2g}")
    return f"{told:.0f} %" if abs(told) >= 100 else f"{told:g} %"

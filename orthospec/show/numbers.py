"""Numbers as an engineer reads them: six significant digits, and one unit of length in a whole text.

Lengths are in millimetres where the prescribed cuboid is smaller than a metre, else in metres; all else is in
SI units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

UNKNOWN = "?"
NOTHING = "-"


@dataclass(frozen=True)
class Numbers:
    """How numbers are written in one text."""

    millimetres: bool

    def value(self, number: float | None, unit: str = "1") -> str:
        """A number with its unit: ``310.583 mm``; no unit where it is 1 or not known."""
        if number is None:
            return NOTHING
        number, shown = self._scaled(number, unit)
        return f"{number:.6g}{_after(shown)}"

    def several(self, numbers: Sequence[float | None], unit: str = "1") -> str:
        """Numbers with one unit after them; equal ones as ``3 x 310.583 mm``."""
        texts = [self.value(number, unit).split(" ")[0] for number in numbers]
        shown = _after(self._scaled(0.0, unit)[1])
        if shown and len(texts) > 1 and len(set(texts)) == 1:
            return f"{len(texts)} x {texts[0]}{shown}"
        return "  ".join(texts) + shown

    def interval(self, low: float | None, high: float | None, unit: str = "1") -> str:
        """``126.795 ... 383.788 mm``."""
        first = self.value(low, unit).split(" ")[0]
        return f"{first} ... {self.value(high, unit)}"

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
        number, shown = self._scaled(coordinate, unit)
        decimals = 3 if shown == "mm" else 5
        return f"{round(number, decimals) + 0.0:.{decimals}f}{_after(shown)}"

    def _with_units(self, texts: Sequence[str], between: str, brackets: str = "") -> str:
        """One unit behind all where they share it."""
        units = {text.partition(" ")[2] for text in texts if text != NOTHING}
        unit = units.pop() if len(units) == 1 else ""
        inner = between.join(text.removesuffix(f" {unit}") if unit else text for text in texts)
        return f"{brackets[:1]}{inner}{brackets[1:]}{_after(unit)}"

    def _scaled(self, number: float, unit: str) -> tuple[float, str]:
        if unit == "m" and self.millimetres:
            return number * 1000, "mm"
        return number, "" if unit in ("1", UNKNOWN) else unit


def _after(unit: str) -> str:
    return f" {unit}" if unit else ""


def percent(part: float) -> str:
    """``4.9 %``."""
    return f"{100 * part:.2g} %"

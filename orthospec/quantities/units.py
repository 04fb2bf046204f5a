"""The units that designers write, converted to SI in decimals: ``310.58 mm`` is 0.31058 exactly.

A unit is a product of named ones, read from left to right: ``N/um``, ``kg*m^2``, ``m/s^2``, ``kg·m²``. Each
stands for a number and the exponents of m, kg, s and rad. The radian is kept apart, so that an angle is not
taken for a number, nor a torque for a rotational stiffness.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from decimal import Context, Decimal
from functools import lru_cache
from typing import NamedTuple, TypeAlias

Dimension: TypeAlias = tuple[int, int, int, int]
"""Exponents of m, kg, s, rad."""

NONE: Dimension = (0, 0, 0, 0)
_PI = Decimal("3.14159265358979323846264338327950288419716939937511")
_EXACT = Context(prec=60)


class UnitError(ValueError):
    """A unit that does not exist, or of another kind than the one expected."""


class Unit(NamedTuple):
    """``numerator / denominator`` SI units, kept apart so that a conversion rounds once."""

    numerator: Decimal
    denominator: Decimal
    dimension: Dimension

    def to_si(self, number: str) -> float:
        """The SI value of a decimal number in this unit."""
        return float(_EXACT.divide(_EXACT.multiply(Decimal(number), self.numerator), self.denominator))


_PREFIXES = {
    "G": "1e9",
    "M": "1e6",
    "k": "1e3",
    "d": "0.1",
    "c": "0.01",
    "m": "1e-3",
    "µ": "1e-6",
    "n": "1e-9",
}

_NAMED: dict[str, tuple[Decimal | int | str, Decimal | int | str, Dimension, str]] = {
    # name: numerator, denominator, exponents of (m, kg, s, rad), prefixes
    "1": (1, 1, NONE, ""),
    "%": (1, 100, NONE, ""),
    "m": (1, 1, (1, 0, 0, 0), "kdcmµn"),
    "in": ("0.0254", 1, (1, 0, 0, 0), ""),
    "g": (1, 1000, (0, 1, 0, 0), "km"),
    "t": (1000, 1, (0, 1, 0, 0), ""),
    "s": (1, 1, (0, 0, 1, 0), "mµ"),
    "min": (60, 1, (0, 0, 1, 0), ""),
    "h": (3600, 1, (0, 0, 1, 0), ""),
    "Hz": (1, 1, (0, 0, -1, 0), "k"),
    "rad": (1, 1, (0, 0, 0, 1), "mµ"),
    "deg": (_PI, 180, (0, 0, 0, 1), ""),
    "°": (_PI, 180, (0, 0, 0, 1), ""),
    "rpm": (_PI, 30, (0, 0, -1, 1), ""),
    "N": (1, 1, (1, 1, -2, 0), "Mkmµ"),
    "Nm": (1, 1, (2, 1, -2, 0), "km"),
    "Pa": (1, 1, (-1, 1, -2, 0), "GMk"),
}

_KINDS: dict[Dimension, str] = {
    NONE: "a plain number",
    (1, 0, 0, 0): "a length",
    (2, 0, 0, 0): "an area",
    (3, 0, 0, 0): "a volume",
    (4, 0, 0, 0): "a second moment of area",
    (0, 1, 0, 0): "a mass",
    (0, 0, 1, 0): "a time",
    (0, 0, 0, 1): "an angle",
    (0, 0, -1, 0): "a frequency",
    (0, 0, -1, 1): "an angular speed",
    (0, 0, -2, 1): "an angular acceleration",
    (1, 0, -1, 0): "a speed",
    (1, 0, -2, 0): "an acceleration",
    (1, 1, -2, 0): "a force",
    (2, 1, -2, 0): "a torque",
    (0, 1, -2, 0): "a stiffness",
    (2, 1, -2, -1): "a rotational stiffness",
    (-1, 1, -2, 0): "a pressure",
    (-3, 1, 0, 0): "a density",
    (2, 1, 0, 0): "a moment of inertia",
}


def _spelled_out() -> Iterator[tuple[str, Unit]]:
    for name, (numerator, denominator, dimension, prefixes) in _NAMED.items():
        yield name, Unit(Decimal(numerator), Decimal(denominator), dimension)
        for prefix in prefixes:
            scale = Decimal(numerator) * Decimal(_PREFIXES[prefix])
            yield prefix + name, Unit(scale, Decimal(denominator), dimension)


UNITS: dict[str, Unit] = dict(_spelled_out())
"""Every unit with a name of its own, prefixes spelled out."""

_SPELLINGS = str.maketrans({"μ": "µ", "·": "*", "²": "^2", "³": "^3", "⁴": "^4"})
_STEP = re.compile(r"([*/])([^*/^]+)(?:\^(-?\d))?")


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """The unit that ``text`` names; `UnitError` for one that is not in the table."""
    spelled = "*" + text.translate(_SPELLINGS).replace("**", "^")
    steps = list(_STEP.finditer(spelled))
    if " " in text or "".join(step[0] for step in steps) != spelled:
        raise UnitError(f"'{text}' is not a unit; one is written like mm, N/um or kg*m^2, without blanks")
    numerator, denominator, dimension = Decimal(1), Decimal(1), NONE
    for sign, name, power in (step.groups() for step in steps):
        unit = _named(name)
        exponent = int(power or 1) * (1 if sign == "*" else -1)
        top, bottom = unit[:2] if exponent > 0 else unit[1::-1]
        numerator = _EXACT.multiply(numerator, _EXACT.power(top, abs(exponent)))
        denominator = _EXACT.multiply(denominator, _EXACT.power(bottom, abs(exponent)))
        m, kg, s, rad = (a + exponent * b for a, b in zip(dimension, unit.dimension, strict=True))
        dimension = (m, kg, s, rad)
    return Unit(numerator, denominator, dimension)


def _named(name: str) -> Unit:
    """The unit of this name; u may stand for µ."""
    known = UNITS.get(name) or (UNITS.get("µ" + name[1:]) if name.startswith("u") else None)
    if known is not None:
        return known
    folded = [other for other in UNITS if other.lower() == name.lower()]
    folded.sort(key=lambda other: sum(a != b for a, b in zip(other, name, strict=True)))
    close = folded or difflib.get_close_matches(name, UNITS, n=1)
    raise UnitError(f"unknown unit '{name}'" + (f"; did you mean '{close[0]}'?" if close else ""))


def kind(unit: str) -> str:
    """What a unit measures, as an engineer says it: "a length"."""
    return _KINDS.get(parse_unit(unit).dimension, "a quantity")


def si_unit(unit: str) -> str:
    """The SI unit of the same kind where it has a name: ``m`` for ``mm``; else the unit itself."""
    dimension = parse_unit(unit).dimension
    named = (name for name, one in UNITS.items() if one.dimension == dimension and one.to_si("1") == 1)
    return next(named, unit)

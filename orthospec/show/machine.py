"""A machine's keys and indices as rows: what a drawing or an order needs, without what is at its default."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from orthospec.show.keys import Path
from orthospec.show.labels import Field
from orthospec.show.numbers import NOTHING, UNKNOWN, Numbers

SMALL = 0.1
"""Lengths of parts below this are in millimetres in every text [m]."""


def fields(
    keys: Mapping[str, Any], known: Mapping[Path, Field], numbers: Numbers
) -> Iterator[tuple[str, str]]:
    """A row for each key of the machine's own, then one for each part with what the part has."""
    yield from _told(keys, known, numbers, ())
    for name, value in keys.items():
        if isinstance(value, Mapping):
            yield from _part(value, known, numbers, (name,))


def tolerances(
    values: Mapping[str, float], known: Mapping[Path, Field], numbers: Numbers
) -> Iterator[tuple[str, str]]:
    """A row of how far the fields may be off, where any may."""
    texts = [f"{name} ± {_value(off, known[name,].units, numbers)}" for name, off in values.items()]
    if texts:
        yield "tolerance", ", ".join(texts)


def in_words(keys: Mapping[str, Any], known: Mapping[Path, Field], numbers: Numbers) -> str:
    """``force 100 N``: the keys that a measure was given."""
    given = {name: value for name, value in keys.items() if value != known.get((name,), Field()).default}
    return ", ".join(f"{name} {text}" for name, text in _told(given, known, numbers, ()))


def indices(
    values: Mapping[str, float | None], units: Mapping[str, str], numbers: Numbers
) -> Iterator[tuple[str, str]]:
    """A row for each index; those of equal legs, say, which differ in a number only, together."""
    together: dict[tuple[str, float | None], list[str]] = {}
    for name, value in values.items():
        together.setdefault((re.sub(r"\d+", "#", name), value), []).append(name)
    for (_, value), names in together.items():
        label = names[0] if len(names) == 1 else f"{names[0]} ... {names[-1]}"
        yield label, numbers.several([value] * len(names), units.get(names[0], UNKNOWN))


def _part(
    keys: Mapping[str, Any], known: Mapping[Path, Field], numbers: Numbers, path: Path
) -> Iterator[tuple[str, str]]:
    word = known.get(path, Field()).word
    text = ", ".join(f"{name} {text}" for name, text in _told(keys, known, numbers, path))
    if word or text:
        yield ".".join(path), ": ".join(filter(None, (word, text)))
    for name, value in keys.items():
        if isinstance(value, Mapping):
            yield from _part(value, known, numbers, (*path, name))


def _told(
    keys: Mapping[str, Any], known: Mapping[Path, Field], numbers: Numbers, path: Path
) -> Iterator[tuple[str, str]]:
    """The keys with a value of their own; numbers at their default say nothing, words do."""
    for name, value in keys.items():
        one = known.get((*path, name), Field())
        if not isinstance(value, Mapping) and (isinstance(value, str) or value != one.default):
            yield name, _value(value, one.units, numbers)


def _value(value: Any, units: tuple[str, ...], numbers: Numbers) -> str:
    several = value if isinstance(value, list) else [value]
    if several and all(isinstance(one, list) for one in several):
        return f"{len(several)} x {len(several[0])} matrix"
    if several and all(isinstance(one, int | float) and not isinstance(one, bool) for one in several):
        if len(units) == len(several) > 1:
            return numbers.each(several, units)
        unit = units[0] if len(units) == 1 else UNKNOWN
        return numbers.several(several, "mm" if unit == "m" and max(map(abs, several)) < SMALL else unit)
    return ", ".join(map(str, several)) or NOTHING

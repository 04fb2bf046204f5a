"""Which unit a value of a spec or result has, by its path."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from orthospec.compare.rows import Path
from orthospec.show.keys import Path as Names
from orthospec.show.labels import Field, Labels
from orthospec.show.numbers import UNKNOWN


def unit_at(path: Path, known: Labels) -> str:
    """The unit, as the spec writes it where it does; `UNKNOWN` for what has none."""
    finder = _SECTIONS.get(str(path[0]))
    return finder(path[1:], known) if finder and len(path) > 1 else UNKNOWN


def _variable(path: Path, known: Labels) -> str:
    return known.variables.get(str(path[0]), UNKNOWN)


def _manipulator(path: Path, known: Labels) -> str:
    return _field(path, known.fields)


def _field(path: Path, fields: Mapping[Names, Field]) -> str:
    names = tuple(key for key in path if isinstance(key, str))
    units, last = fields.get(names, Field()).units, path[-1]
    if len(units) > 1:
        return units[last] if isinstance(last, int) and last < len(units) else UNKNOWN
    return units[0] if units else UNKNOWN


def _index(path: Path, known: Labels) -> str:
    return known.indices.get(str(path[0]), UNKNOWN)


def _workspace(path: Path, known: Labels) -> str:
    if path[0] == "measures":
        return _measure(path[1:], known)
    return _axis(path, known) if path[0] in ("size", "region") else UNKNOWN


def _measure(path: Path, known: Labels) -> str:
    """A key of its own, or else a bound, level or value; scales are numbers."""
    asked = known.measures.get(str(path[0]))
    if asked is None or len(path) < 2 or "scale" in path:
        return UNKNOWN
    is_value = path[1] in ("at_least", "at_most", "levels", "lowest", "highest", "poses")
    return asked.unit if is_value else _field(path[1:], asked.fields)


def _goal(path: Path, known: Labels) -> str:
    """Of its value and of what is aimed at; its weight is told as a number."""
    named = str(path[0]) in known.goals and path[-1] != "weight"
    return known.goals[str(path[0])].unit if named else UNKNOWN


def _attainment(path: Path, known: Labels) -> str:
    return _goal(path[1:], known) if path[0] == "goals" and len(path) > 1 else UNKNOWN


def _axis(path: Path, known: Labels) -> str:
    last = path[-1]
    return known.axes[last] if isinstance(last, int) and last < len(known.axes) else UNKNOWN


def _sweep(path: Path, known: Labels) -> str:
    """The ends of the spec's sweep have the unit of what varies."""
    if isinstance(path[0], int):
        return _point(path, known)
    units = set(known.variables.values())
    return units.pop() if path[0] in ("from", "to") and len(units) == 1 else UNKNOWN


def _point(path: Path, known: Labels) -> str:
    return unit_at(path[1:], known) if len(path) > 2 else UNKNOWN


_SECTIONS: dict[str, Callable[[Path, Labels], str]] = {
    "variables": _variable,
    "manipulator": _manipulator,
    "indices": _index,
    "workspace": _workspace,
    "measures": _measure,
    "goals": _goal,
    "attainment": _attainment,
    "poses": _axis,
    "sweep": _sweep,
    "pareto": _point,
}

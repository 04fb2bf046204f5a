"""A comparison for people and for programs: what differs, side by side, in the units of the specs."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from orthospec.compare import Comparison, Row, Side
from orthospec.compare.rows import Path
from orthospec.show.labels import Labels, labels
from orthospec.show.machine import SMALL
from orthospec.show.numbers import NOTHING, UNKNOWN, Numbers
from orthospec.show.page import Page
from orthospec.show.reading import is_small
from orthospec.show.units import unit_at
from orthospec.show.words import counted

HEADINGS = {
    "status": "Status",
    "attainment": "Goals",
    "variables": "Design variables",
    "manipulator": "Machine",
    "indices": "Indices",
    "workspace": "Workspace",
    "limits": "What limits the design: what λ gains by 1 % looser, and costs by 1 % tighter",
    "pareto": "Pareto set",
    "sweep": "Sweep",
    "provenance": "Versions",
}
_WORDS = {"added": ("only in B", "good"), "removed": ("only in A", "bad")}


def diff_content(found: Comparison, *, changed: bool) -> dict[str, Any]:
    """The comparison as plain content: numbers in SI, a row for each value."""
    return {
        "kind": found.a.kind,
        "a": found.a.name,
        "b": found.b.name,
        "same": not found.changed,
        "rows": [
            {
                "what": row.what,
                "state": row.state,
                "a": row.a,
                "b": row.b,
                "difference": row.difference,
                "relative": row.relative,
            }
            for row in (found.changed if changed else found.rows)
        ],
    }


def show_diff(found: Comparison, *, changed: bool, width: int, colour: bool) -> str:
    """The comparison in words; unless ``changed``, a result's goals and variables that are the same too."""
    page = Page(width=width, colour=colour)
    _Writer(page, found, *_known(found)).write(found.changed if changed else _of_interest(found))
    return str(page)


def lines_of(found: Comparison, rows: Iterable[Row]) -> list[Line]:
    """Rows of a comparison as text, those that say the same in one."""
    writer = _Writer(Page(width=80, colour=False), found, *_known(found))
    return list(_folded(map(writer._line, rows)))


def _known(found: Comparison) -> tuple[tuple[Labels, Labels], Numbers]:
    """What B's names mean, then A's; and numbers in the unit of length that suits both."""
    both = [(side, _labels(side)) for side in (found.b, found.a)]
    small = all(_is_small(side, known) for side, known in both)
    return (both[0][1], both[1][1]), Numbers(small)


def _labels(side: Side) -> Labels:
    if side.result is not None:
        return labels(side.spec, side.result.variables)
    return labels(side.spec, side.spec.default_values() if side.spec else {})


def _is_small(side: Side, known: Labels) -> bool:
    if side.spec is not None:
        return max(side.spec.workspace.size) < 1.0
    return side.result is not None and is_small(side.result, known)


def _of_interest(found: Comparison) -> Iterator[Row]:
    for row in found.rows:
        goal = row.path[0] == "attainment" and row.path[-1] in ("factor", "value")
        of_result = found.a.kind == "result" and (goal or row.path[0] == "variables")
        if of_result or row.state != "same":
            yield row


@dataclass(frozen=True)
class Line:
    """A row as text: the cells of a table, or words with what leads them."""

    label: str
    cells: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    manner: str = ""


@dataclass(frozen=True)
class _Writer:
    page: Page
    found: Comparison
    known: tuple[Labels, Labels]
    numbers: Numbers

    def write(self, rows: Iterable[Row]) -> None:
        for letter, side in (("A", self.found.a), ("B", self.found.b)):
            self.page.rows([(letter, side.name)], indent=0)
        sections = itertools.groupby(rows, key=lambda row: str(row.path[0]))
        texts = {name: list(_folded(map(self._line, part))) for name, part in sections}
        whole = _widths([line for lines in texts.values() for line in lines])
        with_head = next((name for name, lines in texts.items() if any(line.cells for line in lines)), None)
        for name, lines in texts.items():
            self.page.heading(HEADINGS.get(name, name) if self.found.a.kind == "result" else name)
            head = [Line("", ("A", "B", "B - A", ""), manner="dim")] if name == with_head else []
            fitting, widths = (lines, whole) if self._fits(whole) else self._narrow(lines)
            for line in head + fitting:
                self._row(line, widths)
        self._rest()

    def _narrow(self, lines: list[Line]) -> tuple[list[Line], list[int]]:
        """A section by itself and, where that is too wide, with A's unit left to B."""
        widths = _widths(lines)
        if not self._fits(widths):
            lines = [replace(line, cells=_one_unit(line.cells)) for line in lines]
        return lines, _widths(lines)

    def _fits(self, widths: list[int]) -> bool:
        return self.page.fits(sum(widths) + 2 * len(widths))

    def _row(self, line: Line, widths: list[int]) -> None:
        """The text beside its label or, where the terminal is too narrow for that, below."""
        label, led, text = line.label.ljust(widths[0]), line.words[:-1], "".join(line.words[-1:])
        if line.cells:
            cells = [cell.rjust(width) for cell, width in zip(line.cells, widths[1:], strict=True)]
            text = self.page.paint("  ".join(cells).rstrip(), line.manner)
        below = not self._fits(widths)
        if below:
            self.page.rows([(self.page.paint(line.label, line.manner),)] if line.label else [])
            label = ""
        parts = [*(self.page.paint(part, line.manner) for part in (label, *led)), text]
        self.page.rows([parts], indent=4 if below else 2)

    def _rest(self) -> None:
        differ = len(self.found.changed)
        same = len(self.found.rows) - differ
        said = f"{counted(differ, 'value')} {'differs' if differ == 1 else 'differ'}, {same} the same."
        if not differ:
            in_meaning = " in meaning: titles, notes, comments and the choice of units do not count"
            said = f"No difference{in_meaning if self.found.a.kind == 'spec' else ''}."
        self.page.gap()
        self.page.sentence(said, indent=0)

    def _line(self, row: Row) -> tuple[Path, Line]:
        label, unit = _label(row.path), self._unit(row)
        if row.state in _WORDS:
            said, manner = _WORDS[row.state]
            value = self._value(row.a if row.state == "removed" else row.b, unit, row.path)
            return row.path, Line(label, words=(said, value), manner=manner)
        a, b = self._value(row.a, unit, row.path), self._value(row.b, unit, row.path)
        if row.difference is None:
            return row.path, Line(label, words=(a if row.state == "same" else f"{a} -> {b}",))
        if row.state == "same":
            return row.path, Line(label, (a, b, "same", ""), manner="dim")
        part = "" if row.relative is None else _percent(row.relative)
        return row.path, Line(label, (a, b, _signed(self.numbers.value(row.difference, unit)), part))

    def _unit(self, row: Row) -> str:
        units = [unit for unit in (unit_at(row.path, known) for known in self.known) if unit != UNKNOWN]
        unit = units[0] if units else UNKNOWN
        sizes = [abs(value) for value in (row.a, row.b) if isinstance(value, int | float)]
        of_part = unit == "m" and row.path[0] == "manipulator"
        return "mm" if of_part and sizes and max(sizes) < SMALL else unit

    def _value(self, value: Any, unit: str, path: Path) -> str:
        """A value, or a part as in a spec's flow style: ``use: deflection, force: 100 N, at_most: 15 um``."""
        if isinstance(value, Mapping):
            inner = [f"{key}: {self._inner(one, (*path, key))}" for key, one in value.items()]
            return ", ".join(inner) or NOTHING
        if isinstance(value, list | tuple):
            inner = [self._inner(one, (*path, k)) for k, one in enumerate(value)]
            return f"{len(inner)} x {inner[0]}" if len(set(inner)) == 1 < len(inner) else ", ".join(inner)
        if isinstance(value, bool):
            return str(value).lower()
        return self.numbers.value(value, unit) if isinstance(value, int | float) else str(value or NOTHING)

    def _inner(self, value: Any, path: Path) -> str:
        text = self._value(value, self._unit(Row(path, "same", value, value)), path)
        if isinstance(value, Mapping):
            return f"{{{text}}}"
        return f"[{text}]" if isinstance(value, list | tuple) else text


def _folded(lines: Iterable[tuple[Path, Line]]) -> Iterator[Line]:
    """Items of a list, and indices of equal legs, that say the same in one line: ``leg_lengths.0 ... 2``."""
    for _, group in itertools.groupby(lines, key=_alike):
        several = list(group)
        line, last = several[0][1], several[-1][0][-1]
        yield line if len(several) == 1 else replace(line, label=f"{line.label} ... {last}")


def _alike(one: tuple[Path, Line]) -> tuple[Any, ...]:
    path, line = one
    if isinstance(path[-1], int):
        return (path[:-1], line.cells, line.words)
    return (re.sub(r"\d+", "#", str(path[-1])), line.cells, line.words) if path[0] == "indices" else path


def _label(path: Path) -> str:
    """The path under its heading, in a result without the keys that say nothing more."""
    if path[0] == "attainment":
        path = ("", "λ") if path[-1] == "factor" else ("", *path[2:])
    if path[0] == "limits":
        path = ("", str(path[1]).removeprefix("bound."), *path[2:])
    if path[:2] == ("workspace", "measures"):
        path = path[1:]
    if path[0] == "sweep":
        path = (*path[:2], *path[3:])
    of_extreme = path[-1] == "value" and len(path) > 2
    return ".".join(map(str, path[1:-1] if of_extreme else path[1:]))


def _one_unit(cells: tuple[str, ...]) -> tuple[str, ...]:
    """The unit of two numbers behind the second alone."""
    if not cells:
        return cells
    (a, unit), (_, other) = (cell.partition(" ")[::2] for cell in cells[:2])
    return (a, *cells[1:]) if unit == other else cells


def _widths(lines: list[Line]) -> list[int]:
    """Of the label, and of four columns of numbers."""
    rows = [line.cells for line in lines if line.cells]
    return [
        max((len(line.label) for line in lines), default=0),
        *(max((len(row[k]) for row in rows), default=0) for k in range(4)),
    ]


def _signed(text: str) -> str:
    return text if text.startswith("-") else f"+{text}"


def _percent(part: float) -> str:
    return f"{100 * part:+.3g} %"

"""Comparisons as Markdown, for the comment on a pull request."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from orthospec.show.diff import HEADINGS, Line, lines_of
from orthospec.show.words import counted

if TYPE_CHECKING:
    from orthospec.compare import Comparison
    from orthospec.compare.revisions import Changed

FIRST = ("status", "attainment", "variables")
"""Sections of a result that a comment shows unfolded."""


def comment(changed: Sequence[Changed], revision: str) -> str:
    """A comment on all that differs since a revision."""
    if not changed:
        return f"No spec and no result differs from `{revision}`.\n"
    parts = [f"### Specs and results that differ from `{revision}`"]
    for one in changed:
        if one.comparison is None:
            parts.append(f"**{one.path}**: {one.said}")
        elif not one.comparison.changed:
            parts.append(f"**{one.path}**: the same in meaning")
        else:
            parts.append(compared(one.comparison, one.path))
    return "\n\n".join(parts) + "\n"


def compared(found: Comparison, name: str) -> str:
    """What differs between two specs or two results: goals and design first, the rest folded."""
    if not found.changed:
        return f"**{name}**: no difference"
    sections = {
        section: list(rows)
        for section, rows in itertools.groupby(found.changed, key=lambda row: str(row.path[0]))
    }
    shown = FIRST if found.a.kind == "result" else tuple(sections)
    parts = [f"**{name}**: {counted(len(found.changed), 'value')} differ"]
    folded: list[str] = []
    for section, rows in sections.items():
        heading = HEADINGS.get(section, section) if found.a.kind == "result" else section
        text = f"**{heading}**\n\n{_table(lines_of(found, rows))}"
        (parts if section in shown else folded).append(text)
    if folded:
        inner = "\n\n".join(folded)
        parts.append(f"<details><summary>All that differs besides</summary>\n\n{inner}\n\n</details>")
    return "\n\n".join(parts)


def _table(lines: Sequence[Line]) -> str:
    rows = [
        ["", "before", "after", "difference", ""],
        ["---", "--:", "--:", "--:", "--:"],
        *map(_cells, lines),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _cells(line: Line) -> list[str]:
    return [_escaped(cell) for cell in _unescaped(line)]


def _unescaped(line: Line) -> Iterator[str]:
    yield line.label
    if line.cells:
        yield from line.cells
        return
    text = " ".join(line.words)
    before, arrow, after = text.partition(" -> ")
    yield from (before, after, "", "") if arrow else ("", text, "", "")


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")

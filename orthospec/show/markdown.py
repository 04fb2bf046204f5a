"""Comparisons as Markdown, for the comment on a pull request."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from orthospec.show.diff import HEADINGS, Line, lines_of
from orthospec.show.words import counted

if TYPE_CHECKING:
    from orthospec.compare import Comparison
    from orthospec.compare.revisions import Changed

LONGEST = 60_000
"""Characters of a comment: hosts refuse longer ones."""
FIRST = ("status", "attainment", "variables")
"""Sections of a result that a comment shows unfolded."""


def comment(changed: Sequence[Changed], revision: str) -> str:
    """A comment on all that differs since a revision."""
    if not changed:
        return f"No spec and no result differs from `{revision}`.\n"
    parts = [f"### Specs and results that differ from `{revision}`"]
    for one in changed:
        if one.comparison is not None and one.comparison.changed:
            parts.append(compared(one.comparison, one.path))
        else:
            parts.append(_in_words(one))
    return _short(parts)


def _short(parts: list[str]) -> str:
    """As much as a comment may hold, and how much is left out."""
    kept: list[str] = []
    length = 0
    for part in parts:
        if length + len(part) > LONGEST:
            rest = counted(len(parts) - len(kept), "file")
            kept.append(f"And {rest} more: `orthospec diff --since` tells them.")
            break
        kept.append(part)
        length += len(part) + 2
    return "\n\n".join(kept) + "\n"


def _in_words(one: Changed) -> str:
    """A file without a table: new, removed, the same, or what keeps it from being read, a mistake an item."""
    lines = one.said.splitlines() or ["the same in meaning"]
    if len(lines) == 1:
        return f"{_bold(one.path)}: {_escaped(lines[0])}"
    items = "\n".join(f"* {_escaped(line)}" for line in lines)
    return f"{_bold(one.path)} cannot be read:\n\n{items}"


def _bold(name: str) -> str:
    return f"**{_escaped(name)}**"


def compared(found: Comparison, name: str) -> str:
    """What differs between two specs or two results: goals and design first, the rest folded."""
    if not found.changed:
        return f"{_bold(name)}: no difference"
    sections = {
        section: list(rows)
        for section, rows in itertools.groupby(found.changed, key=lambda row: str(row.path[0]))
    }
    shown = FIRST if found.a.kind == "result" else tuple(sections)
    differ = len(found.changed)
    parts = [f"{_bold(name)}: {counted(differ, 'value')} {'differs' if differ == 1 else 'differ'}"]
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
    return re.sub(r"([|*_`])", r"\\\1", text).replace("<", "&lt;").replace("\n", " ")

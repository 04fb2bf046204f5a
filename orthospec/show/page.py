"""A page of text for the terminal: headings, aligned rows, wrapped sentences, and colour where wanted."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

_COLOURS = {"bold": "1", "dim": "2", "good": "32", "warn": "33", "bad": "31"}
_CODE = re.compile(r"\033\[\d+m")


class Page:
    """Lines that are added one after the other."""

    def __init__(self, *, width: int, colour: bool) -> None:
        """Lines fit in ``width`` columns where they can be broken."""
        self._width = max(width, 40)
        self._colour = colour
        self._lines: list[str] = []

    def __str__(self) -> str:
        """The page, without blanks at the ends of lines."""
        return "\n".join(line.rstrip() for line in self._lines) + "\n"

    def paint(self, text: str, manner: str) -> str:
        """Text in a manner: bold, dim, good, warn, bad."""
        return f"\033[{_COLOURS[manner]}m{text}\033[0m" if self._colour and text else text

    def heading(self, text: str) -> None:
        """A heading, with a line left free before it."""
        if self._lines:
            self._lines.append("")
        self._lines.append(self.paint(text, "bold"))

    def gap(self) -> None:
        """A line left free."""
        self._lines.append("")

    def sentence(self, text: str, *, indent: int = 2, manner: str = "") -> None:
        """Words, wrapped."""
        lead = " " * indent
        for line in textwrap.wrap(
            text,
            self._width,
            initial_indent=lead,
            subsequent_indent=lead,
            break_long_words=False,
            break_on_hyphens=False,
        ):
            self._lines.append(self.paint(line, manner) if manner else line)

    def rows(
        self, rows: Sequence[Sequence[str]], *, indent: int = 2, right: frozenset[int] = frozenset()
    ) -> None:
        """Cells in aligned columns; those in ``right`` stand at the right. The last column is wrapped."""
        if not rows:
            return
        widths = [max(_length(row[k]) for row in rows if k < len(row)) for k in range(max(map(len, rows)))]
        for row in rows:
            cells = [
                _padded(cell, width, right=k in right)
                for k, (cell, width) in enumerate(zip(row, widths, strict=False))
            ]
            self._row(
                " " * indent + "  ".join(cells[:-1]), row[-1] if len(row) - 1 not in right else cells[-1]
            )

    def table(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Rows under a dim head, numbers at the right; columns that do not fit are left out."""
        every = [list(head), *(list(row) for row in rows)]
        fitting = len(head)
        while fitting > 1 and self._needs(every, fitting) > self._width:
            fitting -= 1
        first = len(self._lines)
        self.rows([row[:fitting] for row in every], right=frozenset(range(1, fitting)))
        self._lines[first] = self.paint(self._lines[first], "dim")

    def _needs(self, rows: Sequence[Sequence[str]], columns: int) -> int:
        return sum(2 + max(_length(row[k]) for row in rows) for k in range(columns))

    def _row(self, lead: str, last: str) -> None:
        """The last cell behind the others, and on lines of its own below where it is too long for one."""
        gap = f"{lead}  " if lead.strip() else lead
        room = self._width - _length(gap)
        if _length(last) <= room or room < 20 or _CODE.search(last):
            self._lines.append(gap + last)
            return
        wrapped = textwrap.wrap(last, room, break_long_words=False, break_on_hyphens=False)
        self._lines.append(gap + wrapped[0])
        self._lines.extend(" " * _length(gap) + line for line in wrapped[1:])


def _length(text: str) -> int:
    return len(_CODE.sub("", text))


def _padded(text: str, width: int, *, right: bool) -> str:
    blanks = " " * (width - _length(text))
    return blanks + text if right else text + blanks

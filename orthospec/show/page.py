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
        """Text in a manner: bold, dim, good, warn, bad; or as it is."""
        return f"\033[{_COLOURS[manner]}m{text}\033[0m" if self._colour and text and manner else text

    def heading(self, text: str) -> None:
        """A heading, with a line left free before it."""
        if self._lines:
            self._lines.append("")
        self.sentence(text, indent=0, manner="bold")

    def gap(self) -> None:
        """A line left free."""
        self._lines.append("")

    def sentence(self, text: str, *, indent: int = 2, manner: str = "") -> None:
        """Words, wrapped."""
        lead = " " * indent
        for line in _wrapped(text, self._width - indent):
            self._lines.append(self.paint(lead + line, manner) if manner else lead + line)

    def fits(self, columns: int) -> bool:
        """Whether a line of so many columns fits."""
        return columns <= self._width

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
            last = cells[-1] if len(row) - 1 in right else row[-1]
            self._row("  ".join(cells[:-1]), last, indent)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Rows under a dim head, numbers at the right; columns that do not fit follow in further tables.

        The first column stands in each.
        """
        every = [list(head), *(list(row) for row in rows)]
        while every[0]:
            fitting = len(every[0])
            while fitting > 2 and self._needs(every, fitting) > self._width:
                fitting -= 1
            first = len(self._lines)
            self.rows([row[:fitting] for row in every], right=frozenset(range(1, fitting)))
            self._lines[first] = self.paint(self._lines[first], "dim")
            every = [row[:1] + row[fitting:] if row[fitting:] else [] for row in every]
            if every[0]:
                self.gap()

    def _needs(self, rows: Sequence[Sequence[str]], columns: int) -> int:
        return sum(2 + max(_length(row[k]) for row in rows) for k in range(columns))

    def _row(self, lead: str, last: str, indent: int) -> None:
        """The last cell behind the others, wrapped there or, where that is too narrow, below."""
        gap = " " * indent + (f"{lead}  " if lead else "")
        room = self._width - _length(gap)
        wrapped = [last] if _length(last) <= room else _wrapped(last, max(room, 1))
        if max(map(_length, wrapped), default=0) > room:
            self._lines.append(gap)
            self.sentence(last, indent=indent + 2)
            return
        self._lines.append(gap + (wrapped[0] if wrapped else ""))
        self._lines.extend(" " * _length(gap) + line for line in wrapped[1:])


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def _length(text: str) -> int:
    return len(_CODE.sub("", text))


def _padded(text: str, width: int, *, right: bool) -> str:
    blanks = " " * (width - _length(text))
    return blanks + text if right else text + blanks

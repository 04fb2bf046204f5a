"""A file's content as plain Python, with the place of each part."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from orthospec.errors import Mistake

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root: ("manipulator", "leg_lengths", 0)."""


class Place(NamedTuple):
    """Line and column, from 1."""

    line: int
    column: int


@dataclass
class Document:
    """The content of a file as plain Python, the place of each part, and what is wrong with its YAML."""

    file: str
    data: Any = None
    mistakes: list[Mistake] = field(default_factory=list)
    keys: dict[Path, Place] = field(default_factory=dict)
    values: dict[Path, Place] = field(default_factory=dict)
    overridden: dict[Path, str] = field(default_factory=dict)
    """Paths that do not come from the file, with the words that gave them."""

    def mistake(self, path: Path, message: str, *, at_key: bool = False) -> Mistake:
        """A mistake at a value, or at its key; where the path has no place, at what it lies in."""
        for end in range(len(path), -1, -1):
            here = path[:end]
            if here in self.overridden:
                return Mistake(self.overridden[here], 0, 0, message)
            at_key = at_key or end < len(path)
            place = (self.keys.get(here) if at_key else None) or self.values.get(here)
            if place is not None:
                return Mistake(self.file, place.line, place.column, message)
        return Mistake(self.file, 1, 1, message)

    def place(self, path: Path) -> str:
        """``FILE:LINE:COLUMN`` of a key or list item."""
        return self.mistake(path, "", at_key=True).place

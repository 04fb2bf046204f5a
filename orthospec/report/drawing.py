"""`Drawing`: one figure, its words and its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Table(NamedTuple):
    """Numbers as a CSV file has them, SI; units stand in the head."""

    head: Sequence[str]
    rows: Sequence[Sequence[float | str | None]]


@dataclass(frozen=True)
class Drawing:
    """One figure of a report."""

    name: str
    """Of its file, and of its place in the page."""
    caption: str
    words: str
    """What it shows, for who cannot see it."""
    figure: Figure
    table: Table
    hints: Mapping[str, str] = field(default_factory=dict)
    """What appears over its marks, by their ids."""

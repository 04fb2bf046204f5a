"""`Panel`: one figure with its words and the numbers behind it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from orthospec.report.canvas import style
from orthospec.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette


@dataclass(frozen=True)
class Mark:
    """A point of a figure that can be pointed at: where it is, what it says, and the row it leads to."""

    at: tuple[float, float]
    """Parts of the figure's width from the left, of its height from the top."""
    says: str
    leads_to: str


@dataclass(frozen=True)
class Panel:
    """A figure, drawn when it is needed and in the colours of where it is to stand."""

    name: str
    """Of its files; letters, digits and hyphens."""
    title: str
    told: str
    """What it shows, for those who do not see it."""
    draw: Callable[[Palette], Figure]
    data: Mapping[str, Array | Sequence[object]] = field(default_factory=dict)
    """Columns of equal length by head, units in the head."""
    marks: Sequence[Mark] = ()

    @property
    def figure(self) -> Figure:
        """The figure as on light paper, drawn anew."""
        with style():
            return self.draw(LIGHT)


def label(name: str, unit: str) -> str:
    """``x [mm]``; no brackets without a unit."""
    return f"{name} [{unit}]" if unit else name


def file_name(name: str) -> str:
    """A name of the spec as a part of a file's."""
    return "".join(letter if letter.isalnum() else "-" for letter in name)

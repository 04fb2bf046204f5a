"""A Pareto set, two goals at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.canvas import panel
from orthospec.report.panel import Mark, Panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette

_SIZE = (4.8, 3.3)
_MARGINS = (0.75, 0.5, 0.2, 0.2)
_ROOM = 0.09
"""Beside the points, as a part of their range."""


@dataclass(frozen=True)
class Front:
    """Goals' values at each design (n, g), in the units of the page."""

    labels: tuple[str, ...]
    values: Array
    names: Sequence[str]
    """Of the designs: "1, best base_legs", "4, knee"; just a number where it has none."""
    says: Sequence[str]
    """All values of each design, in words."""


def panels(front: Front) -> list[Panel]:
    """One for each pair of goals."""
    goals = range(len(front.labels))
    return [_panel(front, a, b) for a in goals for b in goals if a < b]


def _limits(values: Array) -> tuple[float, float]:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = _ROOM * (high - low) or abs(high) * _ROOM or 1.0
    return low - room, high + room


def _panel(front: Front, a: int, b: int) -> Panel:
    ends = "; ".join(
        f"design {name}: {front.values[k, a]:.4g} and {front.values[k, b]:.4g}"
        for k, name in enumerate(front.names)
        if "," in name
    )
    title = f"{front.labels[b]} against {front.labels[a]}"
    columns = {label: front.values[:, k] for k, label in enumerate(front.labels)}
    return Panel(
        f"pareto-{a + 1}-{b + 1}",
        title,
        f"{len(front.values)} designs, {title}: {ends}. All of them stand in the table that follows.",
        lambda palette: _draw(front, a, b, palette),
        {"design": list(front.names), **columns},
        _marks(front, a, b),
    )


def _marks(front: Front, a: int, b: int) -> list[Mark]:
    """Where the points are on the figure."""
    left, bottom, right, top = _MARGINS
    width, height = _SIZE
    (x0, x1), (y0, y1) = _limits(front.values[:, a]), _limits(front.values[:, b])
    marks = []
    for k, (says, x, y) in enumerate(zip(front.says, front.values[:, a], front.values[:, b], strict=True)):
        across = (left + (x - x0) / (x1 - x0) * (width - left - right)) / width
        down = (top + (y1 - y) / (y1 - y0) * (height - top - bottom)) / height
        if np.isfinite([across, down]).all():
            marks.append(Mark((float(across), float(down)), says, f"pareto-{k + 1}"))
    return marks


def _draw(front: Front, a: int, b: int, palette: Palette) -> Figure:
    figure, axes = panel(palette, *_SIZE, margins=_MARGINS)
    x, y = front.values[:, a], front.values[:, b]
    axes.set(xlim=_limits(x), ylim=_limits(y), xlabel=front.labels[a], ylabel=front.labels[b])
    axes.grid(visible=True, color=palette.rule, linewidth=0.6)
    axes.set_axisbelow(True)
    if len(front.labels) == 2:
        order = np.argsort(x, kind="stable")
        axes.plot(x[order], y[order], color=palette.first, linewidth=1.0)
    axes.plot(x, y, color=palette.first, marker="o", markersize=6, linestyle="none")
    for k, name in enumerate(front.names):
        number, _, word = name.partition(", ")
        is_knee = word.startswith("knee")
        if is_knee:
            axes.plot(x[k], y[k], color=palette.second, marker="D", markersize=8, linestyle="none", zorder=4)
        right = bool(word) and x[k] > np.mean(axes.get_xlim())
        axes.annotate(
            f"{number}{' ' + word if word else ''}",
            (x[k], y[k]),
            xytext=(0, 18) if right else (7, 6),
            textcoords="offset points",
            color=palette.second if is_knee else palette.ink,
            fontsize=8.5 if word else 7.5,
            fontweight="bold" if word else "normal",
            ha="right" if right else "left",
        )
    return figure

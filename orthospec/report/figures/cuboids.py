"""Cuboids in one another: the largest for each list of bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.report.canvas import fit, panel
from orthospec.report.panel import Panel
from orthospec.report.views import AXONOMETRIC, edges, hidden

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette

_DASHES = ("-", (0, (5, 1.5)), (0, (2, 1)), (0, (6, 1.5, 1, 1.5)), (0, (1, 1)), (0, (8, 2, 2, 2)))


@dataclass(frozen=True)
class Nested:
    """A cuboid with its words; corners (3,) [m]."""

    label: str
    low: Array
    high: Array


def panel_of(name: str, title: str, every: Sequence[Nested], factor: float, unit: str) -> Panel:
    """Cuboids in one space, the largest first."""
    ordered = sorted(every, key=lambda one: -float(np.prod(one.high - one.low)))
    sizes = [" by ".join(f"{edge * factor:.4g}" for edge in one.high - one.low) for one in ordered]
    told = "; ".join(f"{one.label}: {size} {unit}" for one, size in zip(ordered, sizes, strict=True))
    columns: dict[str, Sequence[object]] = {
        f"{end} {axis} [{unit}]": [factor * float(getattr(one, end)[k]) for one in ordered]
        for end in ("low", "high")
        for k, axis in enumerate("xyz")
    }
    labels = [one.label for one in ordered]
    return Panel(
        name,
        title,
        f"{title}. {told}.",
        lambda palette: _draw(ordered, palette),
        {"cuboid": labels, **columns},
    )


def _draw(every: Sequence[Nested], palette: Palette) -> Figure:
    legend = 0.17 * len(every)
    figure, axes = panel(palette, 3.2, 2.5 + legend, margins=(0.05, 0.05, 0.05, 0.05 + legend))
    axes.set_axis_off()
    points = []
    for k, one in enumerate(every):
        colour, dash = palette.cycle[k % 6], _DASHES[k % 6]
        draw_box(axes, one.low, one.high, colour, 1.5, dash=dash)
        points.append(AXONOMETRIC(edges(one.low, one.high)).reshape(-1, 3)[:, :2])
        height = 1 - (0.12 + 0.17 * k) / float(figure.get_figheight())
        line = axes.plot([0.03, 0.11], [height, height], color=colour, linestyle=dash, linewidth=1.5)[0]
        line.set_transform(figure.transFigure)
        line.set_clip_on(False)
        figure.text(0.135, height, one.label, color=palette.ink, fontsize=8, va="center")
    low, high = np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)
    span = float((high - low).max())
    fit(axes, low - 0.08 * span, high + 0.04 * span)
    draw_triad(axes, palette, low - 0.02 * span, 0.12 * span)
    return figure


def draw_box(
    axes: Axes,
    low: Array,
    high: Array,
    colour: str,
    width: float,
    *,
    dash: Any = "-",
    halo: str | None = None,
) -> None:
    """A box in the axonometric view; the edges behind are thin."""
    box = edges(low, high)
    behind = hidden(box, AXONOMETRIC)
    seen = AXONOMETRIC(box)
    for is_behind in (True, False):
        lines = seen[behind == is_behind][..., :2]
        joined = np.concatenate([lines, np.full((len(lines), 1, 2), np.nan)], axis=1).reshape(-1, 2)
        thickness = 0.5 * width if is_behind else width
        if halo is not None and not is_behind:
            axes.plot(*joined.T, color=halo, linewidth=width + 1.6, alpha=0.7, zorder=2.5)
        axes.plot(*joined.T, color=colour, linewidth=thickness, linestyle=dash, zorder=2 if is_behind else 3)


def draw_triad(axes: Axes, palette: Palette, at: Array, length: float) -> None:
    """The directions of x, y and z, from a point."""
    for name, tip in zip("xyz", AXONOMETRIC(np.eye(3) * length)[:, :2], strict=True):
        axes.plot(*np.array([at, at + tip]).T, color=palette.muted, linewidth=0.9, zorder=5)
        x, y = at + 1.25 * tip
        axes.text(x, y, name, color=palette.muted, fontsize=8, ha="center", va="center", zorder=5)

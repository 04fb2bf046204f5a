"""A measure on planes through the middle of its cuboid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.report.canvas import panel
from orthospec.report.panel import Panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette

_BEYOND = 0.5
"""How far the colours go on beyond the values in the cuboid and the bound, as a part of their range."""
COLOURS = "cividis"
"""Even in lightness, and alike for the colour-blind."""


@dataclass(frozen=True)
class Slice:
    """Values on a plane, in the units of the page."""

    name: str
    title: str
    across: Array
    """Coordinates of the nodes (a,)."""
    up: Array
    """(b,)."""
    labels: tuple[str, str]
    """Of both axes of the plane, and the values' own."""
    label: str
    values: Array
    """(a, b), NaN out of reach."""
    margin: Array
    """(a, b), >= 0 in reach."""
    box: tuple[tuple[float, float], tuple[float, float]] | None
    """The cuboid's outline: least corner and size."""
    bound: float | None
    side: str
    ends: tuple[float, float]
    """Least and greatest value with a colour of its own, the same in all planes."""
    equal: bool
    """Whether both axes have one unit."""
    bound_in_words: str


def range_of_colours(inside: Sequence[float], bound: float | None, every: Array) -> tuple[float, float]:
    """From the values in the cuboid and the bound a little beyond, no farther than there are values."""
    known = every[np.isfinite(every)]
    if not len(known):
        return 0.0, 1.0
    near = [one for one in (*inside, bound) if one is not None and np.isfinite(one)]
    if not near:
        return float(np.percentile(known, 2)), float(np.percentile(known, 98))
    more = _BEYOND * (max(near) - min(near)) or abs(near[0]) or 1.0
    low, high = max(min(near) - more, float(known.min())), min(max(near) + more, float(known.max()))
    return (low, high) if high > low else (low - 0.5, low + 0.5)


def panel_of(one: Slice) -> Panel:
    """The slice as a panel, with its values as columns."""
    across, up = np.meshgrid(one.across, one.up, indexing="ij")
    return Panel(
        one.name,
        one.title,
        _told(one),
        lambda palette: _draw(one, palette),
        {one.labels[0]: across.ravel(), one.labels[1]: up.ravel(), one.label: one.values.ravel()},
    )


def _told(one: Slice) -> str:
    known = one.values[np.isfinite(one.values)]
    reached = f"{100 * np.isfinite(one.values).mean():.0f} % of the plane is in reach"
    if not len(known):
        return f"{one.title}: {reached}."
    said = f"{one.title}: {reached}; there it is {known.min():.4g} to {known.max():.4g}"
    if one.bound is None:
        return f"{said}."
    meets = known >= one.bound if one.side == "at_least" else known <= one.bound
    return f"{said}, and the bound, {one.bound_in_words}, holds in {100 * meets.mean():.0f} % of that."


def _draw(one: Slice, palette: Palette) -> Figure:
    a, b = np.ptp(one.across), np.ptp(one.up)
    height = min(max(1.83 * b / a, 1.0), 2.6) if one.equal else 1.83
    figure, axes = panel(palette, 3.0, height + 0.57, margins=(0.6, 0.46, 0.57, 0.11))
    _image(axes, one)
    _bar(axes, one, palette)
    if (one.margin < 0).any():
        _out_of_reach(axes, one, palette)
    if one.bound is not None:
        _contour(axes, one, palette)
    if one.box is not None:
        _outline(axes, one, palette)
    axes.set(xlabel=one.labels[0], ylabel=one.labels[1], xlim=one.across[[0, -1]], ylim=one.up[[0, -1]])
    if one.equal:
        axes.set_aspect("equal", adjustable="box", anchor="SW")
    axes.locator_params(nbins=5)
    return figure


def _image(axes: Axes, one: Slice) -> None:
    """Colours at the nodes; fainter where the bound does not hold, none out of reach."""
    from matplotlib import colormaps

    low, high = one.ends
    colours = colormaps[COLOURS](np.clip((one.values - low) / (high - low), 0, 1))
    colours[..., 3] = np.where(np.isfinite(one.values), 1.0, 0.0)
    if one.bound is not None:
        meets = one.values >= one.bound if one.side == "at_least" else one.values <= one.bound
        colours[..., 3] *= np.where(meets, 1.0, 0.45)
    half = (one.across[1] - one.across[0]) / 2, (one.up[1] - one.up[0]) / 2
    extent = (
        one.across[0] - half[0],
        one.across[-1] + half[0],
        one.up[0] - half[1],
        one.up[-1] + half[1],
    )
    pixels = np.swapaxes((colours * 255).round().astype(np.uint8), 0, 1)
    axes.imshow(pixels, origin="lower", extent=extent, interpolation="none", aspect="auto", zorder=1)


def _out_of_reach(axes: Axes, one: Slice, palette: Palette) -> None:
    from matplotlib.colors import to_rgba

    out = axes.contourf(
        one.across, one.up, one.margin.T, levels=[-1e300, 0.0], colors="none", hatches=["////"], zorder=0.5
    )
    out.set_edgecolor(to_rgba(palette.rule))
    out.set_linewidth(0.0)
    axes.contour(
        one.across, one.up, one.margin.T, levels=[0.0], colors=palette.muted, linewidths=0.8, zorder=2
    )


def _contour(axes: Axes, one: Slice, palette: Palette) -> None:
    known = one.values[np.isfinite(one.values)]
    if not len(known) or not known.min() < (one.bound or 0.0) < known.max():
        return
    for colour, width in ((palette.paper, 3.2), (palette.ink, 1.4)):
        axes.contour(
            one.across, one.up, one.values.T, levels=[one.bound], colors=colour, linewidths=width, zorder=3
        )


def _outline(axes: Axes, one: Slice, palette: Palette) -> None:
    from matplotlib.patches import Rectangle

    corner, size = one.box if one.box is not None else ((0.0, 0.0), (0.0, 0.0))
    for colour, width in ((palette.paper, 3.6), (palette.second, 1.8)):
        axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=colour, linewidth=width, zorder=4))


def _bar(axes: Axes, one: Slice, palette: Palette) -> None:
    """The colours and their values beside the axes, with a line at the bound."""
    from matplotlib import colormaps
    from matplotlib.ticker import MaxNLocator

    low, high = one.ends
    ramp = (colormaps[COLOURS](np.linspace(0, 1, 64))[:, None] * 255).round().astype(np.uint8)
    beside: dict[str, Any] = {"transform": axes.transAxes, "clip_on": False}
    axes.imshow(
        ramp, origin="lower", extent=(1.06, 1.12, 0, 1), aspect="auto", interpolation="none", **beside
    )
    ticks = [tick for tick in MaxNLocator(5).tick_values(low, high) if low <= tick <= high]
    for tick in ticks:
        at = (tick - low) / (high - low)
        axes.plot([1.12, 1.14], [at, at], color=palette.muted, linewidth=0.8, **beside)
        axes.text(1.16, at, f"{tick:.6g}", color=palette.ink, fontsize=7.5, va="center", **beside)
    if one.bound is not None and low <= one.bound <= high:
        at = (one.bound - low) / (high - low)
        for colour, width in ((palette.paper, 3.2), (palette.ink, 1.4)):
            axes.plot([1.06, 1.12], [at, at], color=colour, linewidth=width, solid_capstyle="butt", **beside)

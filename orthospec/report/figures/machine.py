"""A drawing of the machine with its cuboid: views along the axes with dimensions, and one axonometric."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.canvas import fit, panel
from orthospec.report.figures.cuboids import draw_triad
from orthospec.report.panel import Panel
from orthospec.report.views import AXONOMETRIC, ORTHOGONAL, View, edges, hidden

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette
    from orthospec.show.numbers import Numbers


ROW = 0.19
"""Height of a line of names [in]."""


def _kind(name: str) -> str:
    """``leg`` of ``leg_1``, ``bar`` of ``bar_left_2``."""
    return name.partition("_")[0]


@dataclass(frozen=True)
class Drawing:
    """What is drawn: the machine at a pose, and a box."""

    segments: Array
    """(s, 2, 3) [m]."""
    radii: Array
    """(s,) [m]."""
    names: tuple[str, ...]
    fixed: Array
    """Whether each segment (s,) is as long at every pose."""
    low: Array
    """(3,) [m], of the prescribed cuboid."""
    high: Array
    box: str
    """The cuboid in words."""
    numbers: Numbers

    @property
    def stems(self) -> list[str]:
        """The kinds of segments."""
        return list(dict.fromkeys(_kind(name) for name in self.names))

    def text(self, length: float) -> str:
        """A length as it is written on a drawing: four digits."""
        factor, unit = self.numbers.scale("m", [length])
        return f"{length * factor:.4g} {unit}"


def panels(drawing: Drawing) -> list[Panel]:
    """The axonometric view first; no view in which a planar machine is a line."""
    flat = [view for view in ORTHOGONAL if _is_flat(np.ptp(_drawn(drawing, view), axis=0))]
    return [_panel(drawing, view) for view in (AXONOMETRIC, *ORTHOGONAL) if view not in flat]


def _is_flat(extent: Array) -> bool:
    """Whether a view shows a line only, as from the side of a planar machine."""
    return bool(extent.min() <= 1e-6 * extent.max())


def _panel(drawing: Drawing, view: View) -> Panel:
    size = drawing.high - drawing.low
    told = f"The machine with the tool at the least corner of the cuboid. {_sentence(drawing)}"
    if view.is_along_an_axis:
        extent = np.ptp(_drawn(drawing, view), axis=0)
        told = (
            f"The machine is {drawing.text(extent[0])} along {view.across} and {drawing.text(extent[1])} "
            f"along {view.up}; the cuboid {drawing.text(size['xyz'.index(view.across)])} by "
            f"{drawing.text(size['xyz'.index(view.up)])}."
        )
    factor, unit = drawing.numbers.scale("m", drawing.segments.ravel().tolist())
    ends = drawing.segments * factor
    columns = {
        f"{end} {axis} [{unit}]": ends[:, k, j]
        for k, end in enumerate(("from", "to"))
        for j, axis in enumerate("xyz")
    }
    return Panel(
        f"machine-{view.name}",
        view.title,
        told,
        lambda palette: _draw(drawing, view, palette),
        {"part": list(drawing.names), **columns},
    )


def _sentence(drawing: Drawing) -> str:
    return f"Parts: {', '.join(filter(None, (_words(drawing, stem) for stem in drawing.stems)))}."


def _words(drawing: Drawing, stem: str) -> str:
    """A kind of part, with its lengths that do not change with the pose."""
    lengths = np.linalg.norm(np.diff(drawing.segments, axis=1)[:, 0], axis=-1)
    texts = [
        drawing.text(float(length))
        for name, length, fixed in zip(drawing.names, lengths, drawing.fixed, strict=True)
        if fixed and length > 0 and _kind(name) == stem
    ]
    return " ".join([stem, ", ".join(dict.fromkeys(texts))]).strip()


def _drawn(drawing: Drawing, view: View) -> Array:
    """All points that are drawn, as seen (k, 2)."""
    every = np.concatenate([drawing.segments.reshape(-1, 3), [drawing.low, drawing.high]])
    if not view.is_along_an_axis:
        every = np.concatenate([every, edges(drawing.low, drawing.high).reshape(-1, 3)])
    return view(every)[:, :2]


def _draw(drawing: Drawing, view: View, palette: Palette) -> Figure:
    names = [] if view.is_along_an_axis else drawing.stems
    above = ROW * (1 + len(names)) if names else 0.0
    figure, axes = panel(
        palette, 3.0, 3.0 + max(0.0, above - 3 * ROW), margins=(0.08, 0.08, 0.08, 0.08 + above)
    )
    points = _drawn(drawing, view)
    low, high = points.min(axis=0), points.max(axis=0)
    span = float((high - low).max())
    axes.set_axis_off()
    room = 0.22 if view.is_along_an_axis else 0.08
    fit(axes, low - room * span, high + 0.04 * span)
    _parts(figure, axes, drawing, view, palette, span)
    _box(axes, edges(drawing.low, drawing.high), view, palette)
    if view.is_along_an_axis:
        _dimensions(axes, drawing, view, palette, (low, high), span)
    else:
        draw_triad(axes, palette, low - 0.03 * span, 0.14 * span)
    return figure


def _parts(figure: Figure, axes: Axes, drawing: Drawing, view: View, palette: Palette, span: float) -> None:
    """Each kind of part in a colour of its own, the nearer ones over the farther ones."""
    seen = view(drawing.segments)
    points_per_length = 72 * 2.3 / span
    colours = dict(zip(drawing.stems, itertools.cycle(_hues(palette)), strict=False))
    for k in np.argsort(seen[..., 2].mean(axis=1), kind="stable"):
        stem = _kind(drawing.names[k])
        width = min(max(2 * drawing.radii[k] * points_per_length, 1.2), 7.0)
        axes.plot(
            seen[k, :, 0],
            seen[k, :, 1],
            color=colours[stem],
            linewidth=width,
            solid_capstyle="round",
            zorder=2,
        )
    if not view.is_along_an_axis:
        _name_parts(figure, drawing, colours, palette)


def _name_parts(figure: Figure, drawing: Drawing, colours: dict[str, str], palette: Palette) -> None:
    """The kinds of parts and the cuboid in their colours, above the machine."""
    height = figure.get_figheight()
    entries = [(_words(drawing, stem), colours[stem]) for stem in drawing.stems]
    for row, (text, colour) in enumerate([*entries, (drawing.box, palette.second)]):
        figure.text(
            0.03,
            1 - (0.08 + ROW * row) / height,
            text,
            color=colour,
            fontsize=8.5,
            fontweight="bold",
            va="top",
        )


def _hues(palette: Palette) -> tuple[str, ...]:
    return palette.muted, palette.first, palette.third, palette.fourth


def _box(axes: Axes, box: Array, view: View, palette: Palette) -> None:
    behind = hidden(box, view) if not view.is_along_an_axis else np.zeros(len(box), dtype=bool)
    seen = view(box)
    for edge, is_behind in zip(seen, behind, strict=True):
        axes.plot(
            edge[:, 0],
            edge[:, 1],
            color=palette.second,
            linewidth=0.9 if is_behind else 1.5,
            linestyle=(0, (3, 2)) if is_behind else "-",
            zorder=1.5 if is_behind else 3,
        )


def _dimensions(
    axes: Axes, drawing: Drawing, view: View, palette: Palette, ends: tuple[Array, Array], span: float
) -> None:
    """The cuboid's edges next to the machine, the whole machine's outside of these."""
    low, high = ends
    box = view(np.array([drawing.low, drawing.high]))[:, :2]
    for k in (0, 1):
        for from_, to, colour, step in (
            (box[:, k].min(), box[:, k].max(), palette.second, 0.06),
            (low[k], high[k], palette.ink, 0.16),
        ):
            beside = low[1 - k] - step * span
            ends_of = (float(from_), float(to))
            _dimension(axes, k, ends_of, float(beside), drawing.text(to - from_), colour, palette)
    x, y = low[0] - 0.21 * span, low[1] - 0.21 * span
    axes.text(x, y, f"{view.across} → {view.up} ↑", color=palette.muted, fontsize=8, va="center")


def _dimension(
    axes: Axes,
    along: int,
    between: tuple[float, float],
    beside: float,
    text: str,
    colour: str,
    palette: Palette,
) -> None:
    """A dimension line with arrows at both ends, its text in a gap of it."""
    low, high = between
    ends = [(low, beside), (high, beside)] if along == 0 else [(beside, low), (beside, high)]
    axes.annotate(
        "",
        ends[0],
        ends[1],
        arrowprops={"arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": colour, "linewidth": 0.8}
        | {"shrinkA": 0, "shrinkB": 0},
    )
    x, y = np.mean(ends, axis=0)
    axes.text(
        x,
        y,
        text,
        color=colour,
        fontsize=8,
        ha="center",
        va="center",
        rotation=0 if along == 0 else 90,
        bbox={"facecolor": palette.paper, "edgecolor": "none", "pad": 1.2},
        zorder=4,
    )

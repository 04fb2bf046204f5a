"""The surface around all poses at which a bound holds, with the cuboid in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.canvas import fit, panel
from orthospec.report.figures.cuboids import draw_box, draw_triad
from orthospec.report.panel import Panel
from orthospec.report.views import AXONOMETRIC

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array, Flags
    from orthospec.report.palette import Palette
    from orthospec.solution import Surface

_LIGHT = np.array([0.35, 0.2, 0.92])
"""Where the light comes from, as seen: from the right, from above, from the eye."""
_DOTS = 115
"""Of the picture, per inch."""
_FEWER_SHADES = 0xFC
"""A mask: neighbours of one shade make a file smaller."""
_DARKEST, _LIGHTEST = np.array([0.13, 0.32, 0.45]), np.array([0.66, 0.86, 0.93])
"""Of shaded triangles; both stand out from light and from dark paper."""


@dataclass(frozen=True)
class Shell:
    """A surface, and the box (3,), (3,) that it is about; lengths in the unit of the page."""

    name: str
    title: str
    surface: Surface
    low: Array
    high: Array
    factor: float
    unit: str


def panel_of(one: Shell) -> Panel:
    """The surface as a panel, with its triangles' corners as columns."""
    corners = one.surface.vertices[one.surface.triangles].reshape(-1, 9) * one.factor
    heads = [f"{axis}{k} [{one.unit}]" for k in (1, 2, 3) for axis in "xyz"]
    ends = " by ".join(f"{length * one.factor:.4g}" for length in np.ptp(one.surface.vertices, axis=0))
    told = f"{one.title}. The surface spans {ends} {one.unit}; the cuboid stands in it."
    columns = dict(zip(heads, corners.T, strict=True))
    return Panel(one.name, one.title, told, lambda palette: _draw(one, palette), columns)


def _draw(one: Shell, palette: Palette) -> Figure:
    figure, axes = panel(palette, 3.0, 2.8, margins=(0.05, 0.05, 0.05, 0.05))
    axes.set_axis_off()
    seen, triangles = AXONOMETRIC(one.surface.vertices), one.surface.triangles
    away, lightness = _shaded(seen, triangles)
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    span = float((high - low).max())
    fit(axes, low - 0.06 * span, high + 0.03 * span)
    _layer(axes, seen, triangles[away], lightness, 1.0, zorder=1)
    draw_box(axes, one.low, one.high, palette.second, 1.8, halo=palette.paper)
    _layer(axes, seen, triangles[~away], lightness, 0.28, zorder=4)
    draw_triad(axes, palette, low + 0.02 * span, 0.13 * span)
    return figure


def _shaded(seen: Array, triangles: Array) -> tuple[Flags, Array]:
    """Which triangles (t,) look away, and how light the surface is at each vertex (v,), from both sides."""
    a, b, c = (seen[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    away = normals[:, 2] < 0
    mean = np.stack(
        [np.bincount(triangles.ravel(), np.repeat(normals[:, k], 3), len(seen)) for k in range(3)], axis=1
    )
    lengths = np.linalg.norm(mean, axis=1)
    unit = mean / np.where(lengths > 0, lengths, 1.0)[:, None]
    towards = np.where(unit[:, 2:] < 0, -unit, unit)
    return away, np.clip(towards @ _LIGHT, 0.0, 1.0)


def _layer(axes: Axes, seen: Array, triangles: Array, lightness: Array, alpha: float, zorder: float) -> None:
    """Triangles as one smooth picture, the nearer ones over the farther; translucent as a whole."""
    from matplotlib.backends.backend_agg import RendererAgg
    from matplotlib.transforms import IdentityTransform

    place = axes.get_position()
    size = axes.figure.get_size_inches() * (place.width, place.height) * _DOTS  # type: ignore[union-attr]
    width, height = (round(float(edge)) for edge in size)
    ends = np.array([axes.get_xlim(), axes.get_ylim()])
    places = (seen[:, :2] - ends[:, 0]) / np.ptp(ends, axis=1) * (width, height)
    order = np.argsort(seen[triangles, 2].mean(axis=1), kind="stable")
    colours = _DARKEST + lightness[:, None] * (_LIGHTEST - _DARKEST)
    opaque = np.concatenate([colours, np.ones((len(colours), 1))], axis=1)
    renderer = RendererAgg(width, height, _DOTS)  # type: ignore[no-untyped-call]
    corners = triangles[order]
    renderer.draw_gouraud_triangles(renderer.new_gc(), places[corners], opaque[corners], IdentityTransform())
    pixels = np.array(renderer.buffer_rgba())  # type: ignore[no-untyped-call]
    pixels[..., :3] &= _FEWER_SHADES
    pixels[..., 3] = (pixels[..., 3] * alpha).astype(np.uint8)
    extent = (*axes.get_xlim(), *axes.get_ylim())
    axes.imshow(pixels, extent=extent, interpolation="none", aspect="auto", zorder=zorder)

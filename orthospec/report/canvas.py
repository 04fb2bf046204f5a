"""Figures of one panel in one style, and their bytes, which are the same each time."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from orthospec.report.palette import with_properties

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette

DOTS = 300
"""Of a PNG for print, per inch."""
_RASTER = 110
"""Of what is too dense for lines in an SVG, per inch."""
_STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "orthospec",
    "pdf.fonttype": 42,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.formatter.use_mathtext": False,
    "hatch.linewidth": 0.6,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "savefig.transparent": True,
    "image.composite_image": False,
}


@contextmanager
def style() -> Iterator[None]:
    """The style in which figures are drawn and written, whatever a user's own settings are."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)  # type: ignore[arg-type]
        yield


def panel(
    palette: Palette, width: float = 3.6, height: float = 2.9, *, margins: tuple[float, ...] = ()
) -> tuple[Figure, Axes]:
    """A figure of so many inches with one pair of axes; ``margins`` left, bottom, right, top [in]."""
    from matplotlib.figure import Figure

    left, bottom, right, top = margins or (0.62, 0.5, 0.12, 0.12)
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes(
        (left / width, bottom / height, (width - left - right) / width, (height - bottom - top) / height)
    )
    axes.set_facecolor("none")
    for spine in axes.spines.values():
        spine.set_color(palette.muted)
    axes.tick_params(colors=palette.muted, labelcolor=palette.ink, labelsize=8)
    axes.xaxis.label.set_color(palette.ink)
    axes.yaxis.label.set_color(palette.ink)
    return figure, axes


def fit(axes: Axes, low: Array, high: Array) -> None:
    """Show all between two points (2,), in the middle, lengths alike to the right and upwards."""
    place = axes.get_position()
    width, height = axes.figure.get_size_inches() * (place.width, place.height)  # type: ignore[union-attr]
    middle, span = (low + high) / 2, high - low
    scale = max(float(span[0]) / width, float(span[1]) / height) or 1.0
    axes.set_xlim(middle[0] - scale * width / 2, middle[0] + scale * width / 2)
    axes.set_ylim(middle[1] - scale * height / 2, middle[1] + scale * height / 2)


def written(figure: Figure, kind: str) -> bytes:
    """The bytes of a figure as ``svg``, ``pdf`` or ``png``: no date, no random names in them."""
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}[kind]
    if kind == "png":  # programs that show the others smooth pictures themselves
        for picture in (one for axes in figure.axes for one in axes.images):
            picture.set_interpolation("bilinear")
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, dpi=DOTS if kind == "png" else _RASTER, metadata=metadata)
    return buffer.getvalue()


def inlined(figure: Figure, name: str) -> str:
    """A figure drawn in `PAGE` as an element of a page, its names kept apart from other figures'."""
    text = written(figure, "svg").decode()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'\s(?:xmlns(?::xlink)?|version)="[^"]*"', "", text).replace("xlink:href", "href")
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r'\1 aria-hidden="true" focusable="false"', text, count=1)
    used = set(re.findall(r"(?:url\(#|href=\"#)([^)\"]+)", text))
    text = re.sub(r'\sid="([^"]*)"', lambda one: one[0] if one[1] in used else "", text)
    text = re.sub(r'(url\(#|href="#|\sid=")', rf"\g<1>{name}-", text)
    text = re.sub(r"<g>\s*</g>\s*", "", text)
    return with_properties(re.sub(r"\s*\n\s*", "\n", text))

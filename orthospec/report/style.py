"""How figures look, and how they become parts of a page that is light, dark or on paper.

A figure is drawn in a few named colours. In a page each of them is a variable of the page's own style, so
that one drawing serves light and dark; in a file of its own it is the colour that stands here.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, MUTED, RULE, SURFACE = "#1b1c1f", "#5d6066", "#d4d6da", "#e9ebee"
BLUE, ORANGE, GREEN, RED, VIOLET = "#1a5fb0", "#bf5208", "#14733f", "#b0271d", "#7a3fa3"
NAMES: Mapping[str, str] = {
    INK: "ink",
    MUTED: "muted",
    RULE: "rule",
    SURFACE: "surface",
    BLUE: "blue",
    ORANGE: "orange",
    GREEN: "green",
    RED: "red",
    VIOLET: "violet",
}
"""Of the page's variables, by colour."""
SERIES = (BLUE, ORANGE, GREEN, VIOLET, RED)
"""For things of one kind, told apart by their marks and labels too."""
MAP = "cividis"
"""Even in lightness, and alike for the colour-blind."""
WIDTH = 7.2
"""Of a figure over the whole width of a page [inches]."""

_SETTINGS: dict[Any, Any] = {
    "font.size": 8.0,
    "font.family": "sans-serif",
    "mathtext.fontset": "dejavusans",
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": False,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "hatch.color": MUTED,
    "hatch.linewidth": 0.4,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "figure.dpi": 100.0,
    "savefig.dpi": 150.0,
    "path.simplify": True,
}


@contextmanager
def styled() -> Iterator[None]:
    """Figures made and written within look alike, whatever the user's own settings are."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def panels(figure: Figure, rows: int, columns: int) -> list[Axes]:
    """The axes of a grid, row by row; those of one column share their x axis."""
    return list(
        figure.subplots(rows, columns, squeeze=False, sharex="col" if columns == 1 else False).ravel()
    )


def inline_svg(figure: Figure, name: str, label: str) -> str:
    """A figure as a part of a page: scalable, its text as text, its colours the page's."""
    text = svg(figure, name, text_as_text=True)
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    # Ids are of this figure alone; a page has several.
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    text = re.sub(r'xlink:href="#', f'xlink:href="#{name}-', text)
    for colour, variable in NAMES.items():
        text = text.replace(colour, f"var(--{variable})")
    width, height = figure.get_size_inches()
    head = (
        f'<svg role="img" aria-label="{escaped(label)}" viewBox="0 0 {72 * width:g} {72 * height:g}"'
        ' xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
    )
    return head + text[text.index(">") + 1 :].strip()


def svg(figure: Figure, name: str, *, text_as_text: bool = False) -> str:
    """The same text for the same figure, on any day."""
    import matplotlib as mpl

    stream = io.StringIO()
    fonts = "none" if text_as_text else "path"
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": fonts}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def escaped(text: str) -> str:
    """Text as it stands in HTML, in attributes too."""
    for sign, entity in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ('"', "&quot;")):
        text = text.replace(sign, entity)
    return text

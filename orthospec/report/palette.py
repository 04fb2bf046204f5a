"""The colours of figures: on paper, and on a page that is light or dark.

On a page each colour stands for a property of its style sheet, so that one drawing suits both schemes. The
hues are near those of Okabe and Ito (2008), which colour-blind people tell apart.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Palette:
    """What colours are for; each ``#rrggbb``."""

    ink: str
    muted: str
    rule: str
    paper: str
    first: str
    second: str
    third: str
    fourth: str

    @property
    def cycle(self) -> tuple[str, ...]:
        """Colours of things alike, told apart by line style or label too."""
        return self.first, self.second, self.third, self.fourth, self.muted, self.ink


LIGHT = Palette(
    ink="#1c1f23",
    muted="#5b626b",
    rule="#d5d9de",
    paper="#ffffff",
    first="#0067a5",
    second="#b84a00",
    third="#00785a",
    fourth="#9b4a7b",
)
DARK = Palette(
    ink="#e9ebee",
    muted="#a7aeb8",
    rule="#3b424b",
    paper="#16191d",
    first="#6cbcf0",
    second="#ff9a55",
    third="#4fd0a8",
    fourth="#e49bc6",
)
PAGE = Palette(
    ink="#0d0a01",
    muted="#0d0a02",
    rule="#0d0a03",
    paper="#0d0a04",
    first="#0d0a05",
    second="#0d0a06",
    third="#0d0a07",
    fourth="#0d0a08",
)
"""Colours that occur nowhere else: `with_properties` puts the style sheet's in their place."""


def with_properties(svg: str) -> str:
    """A drawing in `PAGE`, its colours as ``var(--ink)``."""
    for name, colour in asdict(PAGE).items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg


def properties(palette: Palette) -> str:
    """The declarations of a style sheet: ``--ink:#1c1f23;``."""
    return "".join(f"--{name}:{colour};" for name, colour in asdict(palette).items())

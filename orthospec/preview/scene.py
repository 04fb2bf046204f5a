"""`Scene`: what stands where, in metres; what of it moves; and which parts can be shown or not.

A scene knows nothing of how it is drawn. Its parts have paths, as files have: what stands under a path is
shown or hidden together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from orthospec.arrays import Array

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Mesh:
    """Triangles of one colour, or of a colour at each vertex."""

    path: str
    vertices: Array
    """(v, 3) [m]."""
    triangles: Array
    """(t, 3)."""
    colour: Colour = (255, 255, 255)
    opacity: float = 1.0
    colours: Array | None = None
    """(v, 3), 0 to 1; then light and shade are left out, and a colour means its value."""


@dataclass(frozen=True)
class Lines:
    """Line segments of one colour."""

    path: str
    segments: Array
    """(s, 2, 3) [m]."""
    colour: Colour


@dataclass(frozen=True)
class Ball:
    """A marked point."""

    path: str
    centre: Array
    radius: float
    colour: Colour


@dataclass(frozen=True)
class Bar:
    """A bar whose ends move: those of each frame stand in the scene's `frames`."""

    path: str
    radius: float
    colour: Colour
    square: bool = False
    """As rails are, which do not turn."""


@dataclass(frozen=True)
class Joint:
    """A ball that stays at an end of a bar: which machine's, the bar's number in it, and 0 or 1."""

    ball: Ball
    machine: int
    bar: int
    end: int


@dataclass(frozen=True)
class Tool:
    """A ball that moves: its centre in each frame (k, 3) [m]."""

    ball: Ball
    places: Array


@dataclass(frozen=True)
class Group:
    """What can be shown or hidden together, with words for it."""

    path: str
    words: str
    colour: Colour
    shown: bool = True


@dataclass(frozen=True)
class Scale:
    """A measure that colours mean: the values at both ends of the map, as they are told."""

    path: str
    words: str
    low: str
    high: str


@dataclass
class Scene:
    """All there is to see."""

    things: list[Mesh | Lines | Ball] = field(default_factory=list)
    bars: list[Bar] = field(default_factory=list)
    frames: list[Array] = field(default_factory=list)
    """Of each machine, the ends of its bars at each place of the tool (k, s, 2, 3) [m]."""
    joints: list[Joint] = field(default_factory=list)
    tools: list[Tool] = field(default_factory=list)
    poses: list[str] = field(default_factory=list)
    """The tool's places (k), in words."""
    groups: list[Group] = field(default_factory=list)
    scales: list[Scale] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """What could not be shown, and why."""

    @property
    def points(self) -> Array:
        """What it reaches to, wherever the tool is (p, 3) [m]."""
        points: Sequence[Array] = [
            *(thing.vertices for thing in self.things if isinstance(thing, Mesh)),
            *(thing.segments.reshape(-1, 3) for thing in self.things if isinstance(thing, Lines)),
            *(frames.reshape(-1, 3) for frames in self.frames),
        ]
        every = np.concatenate([one for one in points if len(one)] or [np.zeros((1, 3))])
        return np.asarray(every[np.isfinite(every).all(axis=1)])

    @property
    def ends(self) -> tuple[Array, Array]:
        """The corners of a box around all of it, each (3,)."""
        points = self.points
        return points.min(axis=0), points.max(axis=0)

"""Views of a machine in space: along its axes, and axonometric; cuboids and segments seen in them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from orthospec.arrays import Array

_AXES = ("x", "y", "z")
_AZIMUTH, _ELEVATION = np.radians(35.0), np.radians(24.0)


@dataclass(frozen=True)
class View:
    """A parallel projection: rows to the right, upwards and towards the eye."""

    name: str
    title: str
    across: str
    up: str
    rows: tuple[tuple[float, float, float], ...]

    def __call__(self, points: Array) -> Array:
        """Points (..., 3) as seen: to the right, upwards, and how near (..., 3)."""
        return np.asarray(points @ np.asarray(self.rows).T)

    @property
    def is_along_an_axis(self) -> bool:
        """Whether lengths are seen as they are."""
        return bool(self.across)


FRONT = View("front", "Front: along y", "x", "z", ((1, 0, 0), (0, 0, 1), (0, -1, 0)))
TOP = View("top", "Top: along z", "x", "y", ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
SIDE = View("side", "Side: along x", "y", "z", ((0, 1, 0), (0, 0, 1), (1, 0, 0)))
AXONOMETRIC = View(
    "axonometric",
    "From the corner (1, 1, 1)",
    "",
    "",
    (
        (-float(np.sin(_AZIMUTH)), float(np.cos(_AZIMUTH)), 0.0),
        (
            -float(np.sin(_ELEVATION) * np.cos(_AZIMUTH)),
            -float(np.sin(_ELEVATION) * np.sin(_AZIMUTH)),
            float(np.cos(_ELEVATION)),
        ),
        (
            float(np.cos(_ELEVATION) * np.cos(_AZIMUTH)),
            float(np.cos(_ELEVATION) * np.sin(_AZIMUTH)),
            float(np.sin(_ELEVATION)),
        ),
    ),
)
ORTHOGONAL = (FRONT, SIDE, TOP)


def in_space(pose: Sequence[float] | Array, axes: Sequence[str]) -> Array:
    """The point (3,) of a pose with these axes: angles are left out, and what is missing is 0."""
    found = dict(zip(axes, pose, strict=False))
    return np.array([float(found.get(axis, 0.0)) for axis in _AXES])


def edges(low: Array, high: Array) -> Array:
    """The edges of a box (e, 2, 3) between two points; those without length are left out."""
    corners = np.array([low, high])
    found = []
    for axis in range(3):
        others = [k for k in range(3) if k != axis]
        for ends in itertools.product((0, 1), repeat=2):
            edge = np.empty((2, 3))
            edge[:, axis] = corners[:, axis]
            for k, end in zip(others, ends, strict=True):
                edge[:, k] = corners[end, k]
            found.append(edge)
    every = np.array(found)
    return np.asarray(every[np.abs(every[:, 1] - every[:, 0]).max(axis=1) > 0])


def hidden(every: Array, view: View) -> Array:
    """Which edges (e,) of a box meet at the corner farthest from the eye."""
    seen = view(every)
    farthest = seen[..., 2].min()
    return np.asarray((seen[..., 2] <= farthest + 1e-9 * (1 + abs(farthest))).any(axis=1))

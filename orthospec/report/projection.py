"""Things in space, drawn on paper: views along the axes, and one from the side and above."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.solution import Surface
    from orthospec.workspace.cuboid import Cuboid


class View(NamedTuple):
    """A direction to look in: rows are right, up and towards the eye (3, 3)."""

    name: str
    rows: Array

    def flat(self, points: Array) -> Array:
        """Points (..., 3) on the paper (..., 2)."""
        return np.asarray(points @ self.rows[:2].T)

    def nearness(self, points: Array) -> Array:
        """How near to the eye (...,)."""
        return np.asarray(points @ self.rows[2])


def from_side_and_above(azimuth: float = 35.0, height: float = 25.0) -> View:
    """A view from there [deg], x to the right and z up."""
    a, h = np.radians([azimuth, height])
    eye = np.array([np.sin(a) * np.cos(h), -np.cos(a) * np.cos(h), np.sin(h)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    return View("from the side", np.stack([right, np.cross(eye, right), eye]))


ALONG_AXES = (
    View("from above", np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])),
    View("from the front", np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])),
    View("from the right", np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])),
)


def corners(cuboid: Cuboid) -> Array:
    """Its corners in space (8, 3); of a flat cuboid the third coordinate is 0."""
    low, high = (np.pad(np.array(end), (0, 3 - len(end))) for end in (cuboid.low, cuboid.high))
    return np.array(list(product(*zip(low, high, strict=True))))


EDGES = tuple((a, a | bit) for bit in (4, 2, 1) for a in range(8) if not a & bit)
"""Between the corners."""


def shaded(surface: Surface, view: View) -> tuple[Array, Array]:
    """Triangles (t, 3, 2) on the paper, the far ones first, and how much light each has, 0 to 1 (t,)."""
    space = surface.vertices[surface.triangles]
    normals = np.cross(space[:, 1] - space[:, 0], space[:, 2] - space[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0, lengths, 1.0)
    light = np.array([-0.35, -0.5, 0.8]) / np.linalg.norm([-0.35, -0.5, 0.8])
    order = np.argsort(view.nearness(space.mean(axis=1)), kind="stable")
    return view.flat(space)[order], np.abs(normals @ light)[order]

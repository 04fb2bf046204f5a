"""Surfaces in the space of poses: of the workspace, and of equal values of a measure.

Marching cubes of scikit-image (Lewiner's, without holes), on the nodes of a `Lattice`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array
    from orthospec.solution.lattice import Lattice

_FAR = 1e6
"""How much deeper the outside of a lattice lies than its nodes: surfaces cut off end on its face."""


@dataclass(frozen=True)
class Surface:
    """Triangles in space."""

    vertices: Array
    """(v, 3) [m]."""
    triangles: Array
    """(t, 3): indices of vertices, counter-clockwise as seen from where the values are lower."""


def workspace_surface(lattice: Lattice) -> Surface | None:
    """The closed surface around all that is in reach; None where nothing is, or with other than three axes.

    Where the reach goes on beyond the lattice the surface is closed by the lattice's faces.
    """
    if lattice.margin.ndim != 3 or not lattice.reachable.any():
        return None
    margin = np.where(np.isfinite(lattice.margin), lattice.margin, -np.nanmax(np.abs(lattice.margin)))
    deep = -_FAR * float(np.abs(margin).max())
    axes = [np.concatenate([[2 * a[0] - a[1]], a, [2 * a[-1] - a[-2]]]) for a in lattice.axes]
    return level_surface(axes, np.pad(margin, 1, constant_values=deep), 0.0)


def level_surface(axes: list[Array] | tuple[Array, ...], values: Array, level: float) -> Surface | None:
    """Where values (n1, n2, n3) at evenly spaced nodes cross a level; None where they do not.

    Cells with a node that is NaN are left out.
    """
    from skimage.measure import marching_cubes

    known = np.isfinite(values)
    if not known.any() or not values[known].min() < level < values[known].max():
        return None
    spacing = tuple(float(axis[1] - axis[0]) for axis in axes)
    filled = np.where(known, values, level)
    try:
        vertices, triangles, _, _ = marching_cubes(
            filled, level, spacing=spacing, gradient_direction="ascent", mask=_cells(known)
        )
    except RuntimeError:  # no cell of known nodes alone is crossed
        return None
    origin = np.array([axis[0] for axis in axes])
    return Surface(vertices.astype(float) + origin, triangles.astype(np.int64)) if len(triangles) else None


def _cells(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether all eight nodes of a cell are known, told at its last node, where scikit-image looks."""
    whole = known.copy()
    for axis in range(known.ndim):
        before = np.roll(whole, 1, axis)
        before[(slice(None),) * axis + (0,)] = False
        whole = whole & before
    return whole

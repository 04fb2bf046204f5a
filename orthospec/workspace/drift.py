"""Curvature of a greatest value whose place moves.

A bound over a cuboid is one on g(x) = max_u F(x, u). At a critical point u inside a face or the cuboid, F is
stationary in u's free coordinates, and as the design x moves so does u:

    g_xx = F_xx + F_xu (−F_uu)⁻¹ F_ux        over the free coordinates of u.

The first term is seen at a fixed u; this module gives the second. Without it each step finds the point a
little further on, and the loop crawls after it.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.composite.differences import SECOND

if TYPE_CHECKING:
    from orthospec.arrays import Array

STEP = 1e-3
"""Step of the differences in u, as a part of the cuboid."""
INSIDE = 1e-6
"""A coordinate this far from a face is free."""
FLAT = 1e-6
"""A peak is none in directions in which F falls off less than this, as a part of the steepest."""


class Box(NamedTuple):
    """Where x may be, and over which lengths functions of it change, (n,) each."""

    lower: Array
    upper: Array
    scale: Array


def moving_curvature(
    values: Callable[[Array, Array], Array], weights: Array, u: Array, x: Array, box: Box
) -> Array:
    """Σ weights · F_xu (−F_uu)⁻¹ F_ux (n, n) over the rows k and points s of F.

    values(x, u) gives F (k, s) at points u (s, d) of x; weights (k, s) are its multipliers.
    """
    n, h = len(x), SECOND * box.scale
    centre = np.clip(x, box.lower + h, box.upper - h)
    offsets = _offsets(u.shape[1])
    tries = (u[:, None, :] + offsets).reshape(-1, u.shape[1])

    def around(place: Array) -> Array:
        return values(place, tries).reshape(len(weights), len(u), len(offsets))

    total = np.zeros((n, n))
    with np.errstate(invalid="ignore"):
        bends = _bends(around(centre), u.shape[1])
        steps = np.diag(h)
        slopes = [_slopes(around(centre + s) - around(centre - s), u.shape[1]) for s in steps]
        mixed = np.stack(slopes, axis=2) / (2 * h[:, None])
    for k, s in zip(*np.nonzero(weights), strict=True):
        free = np.abs(u[s]) < 0.5 - INSIDE
        if free.any() and np.isfinite(bends[k, s]).all() and np.isfinite(mixed[k, s]).all():
            total += weights[k, s] * _drift(bends[k, s][np.ix_(free, free)], mixed[k, s][:, free])
    return total


def _drift(bend: Array, mixed: Array) -> Array:
    """F_xu (−F_uu)⁻¹ F_ux in the directions in which F_uu has a peak."""
    fall, directions = np.linalg.eigh(-bend)
    peak = fall > FLAT * np.abs(fall).max(initial=0.0)
    along = mixed @ directions[:, peak]
    return np.asarray((along / fall[peak]) @ along.T)


def _offsets(d: int) -> Array:
    """Points of a difference star in u: itself, ± each axis, ± each pair of axes (o, d)."""
    axes = np.eye(d)
    pairs = [axes[i] + axes[j] for i, j in combinations(range(d), 2)]
    return STEP * np.array([np.zeros(d), *axes, *-axes, *pairs, *(-pair for pair in pairs)])


def _slopes(f: Array, d: int) -> Array:
    """F_u (..., d) of values on a star (..., o)."""
    return np.asarray((f[..., 1 : d + 1] - f[..., d + 1 : 2 * d + 1]) / (2 * STEP))


def _bends(f: Array, d: int) -> Array:
    """F_uu (..., d, d) of values on a star (..., o)."""
    plus, minus, middle = f[..., 1 : d + 1], f[..., d + 1 : 2 * d + 1], f[..., :1]
    pairs = list(combinations(range(d), 2))
    bend = np.zeros((*f.shape[:-1], d, d))
    bend[..., range(d), range(d)] = (plus - 2 * middle + minus) / STEP**2
    for p, (i, j) in enumerate(pairs):
        both = f[..., 2 * d + 1 + p] + f[..., 2 * d + 1 + len(pairs) + p]
        cross = both - plus[..., i] - minus[..., i] - plus[..., j] - minus[..., j] + 2 * middle[..., 0]
        bend[..., i, j] = bend[..., j, i] = cross / (2 * STEP**2)
    return bend

"""Derivatives of a smooth vector function by differences, from one batch of points.

``smooth(X)`` maps points (k, n) to values (k, t); a row of NaN says that a point cannot be evaluated. Nobody
has to write derivatives, so sections, expressions and strangers' plugins are covered alike.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array

FIRST = 6e-6
"""Step of first differences relative to a variable's scale, near ε^(1/3): errors of some 1e-10."""
SECOND = 2e-4
"""Step of second differences, near ε^(1/4): errors of some 1e-8."""
CLOSER = 4.0
"""How many times closer the step is that tells a kink from curvature."""
KINK = 100.0
"""Second differences below this, per scale squared, are not worth the question."""


def jacobian(
    smooth: Callable[[Array], Array], x: Array, scale: Array, lower: Array, upper: Array
) -> tuple[Array, Array]:
    """Values (t,) and Jacobian (t, n) at x, by central differences; three-point one-sided at a bound.

    scale (n,) is the length over which the function changes. Where one neighbour cannot be evaluated, the
    other gives a plain one-sided quotient.
    """
    n, h = len(x), FIRST * scale
    inward = np.where(x + h > upper, -1.0, np.where(x - h < lower, 1.0, 0.0))
    first = np.where(inward == 0, h, inward * h)
    second = np.where(inward == 0, -h, 2 * inward * h)
    values = smooth(np.vstack([x, x + np.diag(first), x + np.diag(second)]))
    f0, fa, fb = values[0], values[1 : n + 1], values[n + 1 :]
    a, b = first[:, None], second[:, None]
    # The parabola through (0, f0), (a, fa), (b, fb): exact slope at 0 for central and one-sided points.
    slopes = ((fa - f0) * b / a - (fb - f0) * a / b) / (b - a)
    slopes = np.where(np.isfinite(slopes), slopes, (fa - f0) / a)
    return f0, np.where(np.isfinite(slopes), slopes, (fb - f0) / b).T


def hessian(
    smooth: Callable[[Array], Array], weights: Array, x: Array, scale: Array, lower: Array, upper: Array
) -> Array:
    """Hessian (n, n) of weights·smooth at x, taken a step inside where x lies on a bound.

    A row with a kink near x is left out: a kink has no curvature, and its second difference, the greater
    the smaller the step, would swamp that of all other rows.
    """
    n, h = len(x), SECOND * scale
    centre = np.clip(x, lower + h, upper - h)
    steps, pairs = np.diag(h), list(combinations(range(n), 2))
    mixed = np.reshape([steps[i] + steps[j] for i, j in pairs], (-1, n))
    offsets = [steps, -steps, steps / CLOSER, -steps / CLOSER, mixed, -mixed]
    points = np.vstack([centre, *(centre + offset for offset in offsets)])
    used = weights != 0
    with np.errstate(invalid="ignore"):
        values = smooth(points)[:, used]
        f0, rest = values[0], values[1:]
        plus, minus, near_plus, near_minus = rest[: 4 * n].reshape(4, n, -1)
        wide = (plus - 2 * f0 + minus) / h[:, None] ** 2
        close = (near_plus - 2 * f0 + near_minus) / (h[:, None] / CLOSER) ** 2
        right, left = (
            2 * (far - f0 - CLOSER * (near - f0)) / (h[:, None] ** 2 * (1 - 1 / CLOSER))
            for far, near in ((plus, near_plus), (minus, near_minus))
        )
        kinked = _differ(wide, close) | _differ(right, left)
        weights = np.where(kinked, 0.0, weights[used])
        f0, plus, minus, rest = (weighed @ weights for weighed in (f0, plus, minus, rest[4 * n :]))
        second = np.diag(wide @ weights)
        both = rest[: len(pairs)] + rest[len(pairs) :]
        for value, (i, j) in zip(both, pairs, strict=True):
            cross = (value - plus[i] - minus[i] - plus[j] - minus[j] + 2 * f0) / (2 * h[i] * h[j])
            second[i, j] = second[j, i] = cross
    return np.nan_to_num(second, nan=0.0, posinf=0.0, neginf=0.0)


def _differ(one: Array, other: Array) -> NDArray[np.bool_]:
    """Of which rows two second differences (n, t), which smoothness makes alike, are large and far apart."""
    greater = np.maximum(np.abs(one), np.abs(other))
    return np.asarray(((np.abs(one - other) > 0.5 * greater) & (greater > KINK)).any(axis=0))


def positive_part(matrix: Array) -> Array:
    """The positive semidefinite part of a symmetric matrix."""
    eigenvalues, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors * np.maximum(eigenvalues, 0)) @ vectors.T)

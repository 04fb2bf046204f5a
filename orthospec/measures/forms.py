"""The convex forms that measures share: insides in logarithms, so that each bound is linear in its own.

    λ_max(X) <= ln b,    λ_min(X) >= ln b,    λ_max(X) − λ_min(X) <= ln b      X = ln M of a positive matrix M
    max x <= ln b,       min x >= ln b                                         x of logarithms

A convex size φ of something that has no logarithm (a vector, entries of both signs) is divided by itself:
with y = Y/φ(Y) and l = ln φ(Y),

    φ(y) − 1 + l <= ln b.

Its left side is ln φ(Y) at every pose, and convex in (y, l). A kink of φ in the divisor does no harm to a
linearisation: to first order the divisor cancels, since φ(y) = 1. In all of them a slack s is worth exactly
the factor e^s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from orthospec.arrays import np
from orthospec.measures.base import ConvexForm, logarithm

if TYPE_CHECKING:
    from orthospec.arrays import Array, Matrices

NEGLIGIBLE = 1e-13
"""What may be added to a matrix, relative to its trace, where only its greatest eigenvalue is bounded."""


def matrix_logarithm(matrices: Matrices) -> Matrices:
    """ln M (n, m, m), symmetric, of symmetric M; NaN where M is not finite or not positive definite."""
    from orthospec import kernels

    eigenvalues, vectors = kernels.symmetric_eigenvectors(matrices)
    known = eigenvalues[:, :1] > 0
    logarithms = np.log(np.where(known, eigenvalues, 1.0))
    found = (vectors * logarithms[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return np.where(known[:, :, None], (found + np.swapaxes(found, 1, 2)) / 2, np.nan)


def semidefinite_logarithm(matrices: Matrices) -> Matrices:
    """ln M where only λ_max(M) matters: M may be semidefinite, and 0 has a very small logarithm."""
    with np.errstate(invalid="ignore"):
        trace = np.einsum("nii->n", matrices)
        added = NEGLIGIBLE * trace + np.finfo(float).tiny
        return matrix_logarithm(matrices + added[:, None, None] * np.eye(matrices.shape[1]))


def greatest_eigenvalue(logarithms: Matrices) -> ConvexForm:
    """λ_max(X) <= ln b."""

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        import cvxpy as cp

        return [cp.lambda_max(x) <= logarithm(bound) + slack]

    return ConvexForm(logarithms, holds)


def least_eigenvalue(logarithms: Matrices) -> ConvexForm:
    """λ_min(X) >= ln b."""

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        import cvxpy as cp

        return [cp.lambda_min(x) >= logarithm(bound) - slack]

    return ConvexForm(logarithms, holds)


def ratio_of_eigenvalues(logarithms: Matrices) -> ConvexForm:
    """λ_max(X) − λ_min(X) <= ln b."""

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        import cvxpy as cp

        return [cp.lambda_max(x) - cp.lambda_min(x) <= logarithm(bound) + slack]

    return ConvexForm(logarithms, holds)


def greatest_entry(logarithms: Array) -> ConvexForm:
    """max x <= ln b, of vectors (n, k)."""

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        return [x <= logarithm(bound) + slack]

    return ConvexForm(logarithms, holds)


def least_entry(logarithms: Array) -> ConvexForm:
    """min x >= ln b, of vectors (n, k)."""

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        return [x >= logarithm(bound) - slack]

    return ConvexForm(logarithms, holds)


def convex_size(
    parts: Array, size: Array, within: Callable[[Any, Any], list[Any]], floor: Array
) -> ConvexForm:
    """φ(Y) <= b for ``parts`` Y (n, k), their ``size`` φ(Y) (n,), convex and homogeneous.

    ``within(y, limit)`` states φ(y) <= limit. A size below its ``floor`` (n,) is divided by the floor: where
    it is nothing but rounding it has no logarithm to follow.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        divisor = np.maximum(np.maximum(size, floor), np.finfo(float).tiny)
        inside = np.concatenate([parts / divisor[:, None], np.log(divisor)[:, None]], axis=1)

    def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
        return within(x[:-1], 1 + logarithm(bound) + slack - x[-1])

    return ConvexForm(inside, holds)

"""Bounds on inverses, determinants and norms of small matrices over boxes.

With R ≈ A⁻¹ at the middle and P = R A − I, of which |P| <= Q entry by entry,

    A⁻¹ = R − P R + P² (I + P)⁻¹ R,      |P² (I + P)⁻¹ R| <= (I − Q)⁻¹ Q² |R|,

where Q w <= q w for some w > 0 and q < 1 (else nothing is known). The rest is of second order, and its bound
follows the units of rows and columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import ends
from orthospec.intervals.eigenvalues import (
    condition_number,
    singular_values,
    symmetric_eigenvalues,
    transposed,
)
from orthospec.intervals.functions import matmul
from orthospec.intervals.interval import PLAIN, Interval, as_interval
from orthospec.intervals.refusal import refuse
from orthospec.intervals.rounding import SPARE, TINY

if TYPE_CHECKING:
    from orthospec.arrays import Array

PERRON = 12
"""Rounds of power iteration for w; any w > 0 gives a bound."""
LITTLE = 1e-30
"""What keeps an entry of w from 0, relative."""


def inverse(x: Any) -> Interval:
    """A⁻¹ of any square matrices (..., m, m); undefined where they may be singular."""
    A = as_interval(x)
    R = _approximate_inverse(A.form_over(A.coordinates).c)
    P = matmul(R, A) - np.eye(A.shape[-1])
    c, g, r = P.form_over(A.coordinates)
    Q = (np.abs(c) + np.abs(g).sum(axis=-1) + r) * SPARE
    second = Q @ (Q @ np.abs(R)) * SPARE
    third = Q @ second * SPARE
    rest = (second + third + _later_terms(Q, third)) * SPARE
    found = R - matmul(P, R)
    return _loosened(found, np.where(np.isfinite(rest), rest, np.nan))


def _pinv(x: Interval, rcond: Any = None, hermitian: bool = False, *, rtol: Any = None) -> Interval:  # noqa: ARG001
    """A⁺ where it is A⁻¹; undefined where A may be singular, since A⁺ jumps there."""
    return inverse(x)


def _later_terms(Q: Array, term: Array) -> Array:
    """A bound on Q T + Q² T + ..., T >= 0 (..., m, k); inf or NaN where the sum may not converge.

    Q w <= q w with w > 0 and q < 1 shows that it does, to within w max_i (Q T)_i / w_i / (1 − q). A column
    T_j with Q T_j <= q_j T_j is followed by q_j / (1 − q_j) T_j at most, whatever the units of its entries.
    """
    w = np.ones(Q.shape[:-1])
    for _ in range(PERRON):
        w = (Q @ w[..., None])[..., 0] + LITTLE * w + TINY
        w /= w.max(axis=-1, keepdims=True)
    q = ((Q @ w[..., None])[..., 0] / w).max(axis=-1)[..., None, None] * SPARE
    after = Q @ term * SPARE
    common = w[..., None] * (after / w[..., None]).max(axis=-2, keepdims=True) / (1 - q)
    ratio = np.where(after > 0, after / term, 0.0).max(axis=-2, keepdims=True) * SPARE
    own = np.where(ratio < 1, term * ratio / (1 - ratio), np.inf)
    return np.where(q < 1, np.minimum(common, own) * SPARE, np.inf)


def _loosened(x: Interval, rest: Array) -> Interval:
    form = x.form and x.form._replace(r=(x.form.r + rest) * SPARE)
    return Interval(*ends.outward(x.lo - rest, x.hi + rest), form).narrowed()


def _approximate_inverse(matrices: Array) -> Array:
    determinant = np.linalg.det(matrices)
    known = (np.isfinite(determinant) & (determinant != 0))[..., None, None]
    found = np.linalg.inv(np.where(known, matrices, np.eye(matrices.shape[-1])))
    return np.where(known, found, np.nan)


def solve(a: Any, b: Any) -> Any:
    """A⁻¹ b, b (m,) or (..., m, k) as in NumPy."""
    return matmul(inverse(a), b)


def determinant(x: Any) -> Any:
    """det A, by expansion along rows."""
    A = as_interval(x)
    m = A.shape[-1]
    minors: dict[tuple[int, ...], Any] = {(): 1.0}
    for row in range(m - 1, -1, -1):
        wider: dict[tuple[int, ...], Any] = {}
        for columns in _subsets(m, m - row):
            terms = [
                A[..., row, j] * minors[columns[:k] + columns[k + 1 :]] * (-1.0) ** k
                for k, j in enumerate(columns)
            ]
            wider[columns] = sum(terms[1:], terms[0])
        minors = wider
    return minors[tuple(range(m))]


def _subsets(m: int, size: int) -> list[tuple[int, ...]]:
    from itertools import combinations

    return list(combinations(range(m), size))


def _norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    """The length of vectors, or the norm of matrices that ``ord`` names."""
    x = as_interval(x)
    axes = (tuple(range(x.ndim)) if axis is None else tuple(np.atleast_1d(axis)))  # fmt: skip
    if ord in (None, "fro") or (ord == 2 and len(axes) == 1):
        return np.sqrt(np.sum(np.square(x), axis=axes, keepdims=keepdims))
    if ord == 2 and len(axes) == 2 and not keepdims:
        return singular_values(np.moveaxis(x, axes, (-2, -1)))[..., 0]
    if ord in (1, np.inf) and len(axes) == 1:
        size = np.abs(x)
        return (size.sum if ord == 1 else size.max)(axis=int(axes[0]), keepdims=keepdims)
    raise refuse(f"np.linalg.norm with ord={ord!r}", PLAIN)


def _svd(x: Any, full_matrices: bool = True, compute_uv: bool = True, **_: Any) -> Interval:  # noqa: ARG001
    if compute_uv:
        raise refuse("np.linalg.svd with vectors", "ask for singular values alone, compute_uv=False")
    return singular_values(x)


def _eigvalsh(x: Any, UPLO: str = "L") -> Interval:
    return symmetric_eigenvalues(x if UPLO == "L" else transposed(x))


def _cond(x: Any, p: Any = None) -> Any:
    if p not in (None, 2):
        raise refuse(f"np.linalg.cond with p={p!r}", PLAIN)
    return condition_number(x)


TABLE: Mapping[Callable[..., Any], Callable[..., Any]] = {
    np.linalg.inv: inverse,
    np.linalg.pinv: _pinv,
    np.linalg.solve: solve,
    np.linalg.det: determinant,
    np.linalg.eigvalsh: _eigvalsh,
    np.linalg.svd: _svd,
    np.linalg.svdvals: singular_values,
    np.linalg.norm: _norm,
    np.linalg.cond: _cond,
}

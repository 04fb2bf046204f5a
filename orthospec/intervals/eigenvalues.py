"""Verified eigenvalues and singular values of small matrices over boxes.

Of a symmetric A(u) = A_c + Σ u_k G_k + E, λ_max is convex and λ_min concave, so that their ends over the box
are those at its 2^d corners, apart from ‖E‖. With V the eigenvectors at the middle, the diagonal of VᵀAV
gives the others, apart from the rest of that matrix (Weyl). Corners are verified by Cholesky factors, whose
rounding is bounded (Demmel 1989; Higham, *Accuracy and Stability of Numerical Algorithms*, theorem 10.3;
Rump 2006).
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import ends, rearranging
from orthospec.intervals.functions import matmul
from orthospec.intervals.interval import Interval, as_interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.rounding import FEW, SPARE, TINIEST, TINY, ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

CORNERS = 256
"""Most corners of a box that eigenvalues are asked at."""
CLOSE = 2.0**-46
"""How far from computed eigenvalues verified bounds are tried, relative to the matrix's norm."""


def symmetric_eigenvalues(x: Any) -> Interval:
    """Eigenvalues (..., m), ascending, of symmetric matrices (..., m, m); their lower triangles are read."""
    A = _mirrored(as_interval(x))
    form = A.form_over(A.coordinates)
    turned, theta = _in_middle_axes(A, form.c)
    diagonal = rearranging.diagonal(turned, 0, -2, -1)
    apart = _frobenius(_off_diagonal(turned))
    lo, hi = np.sort(diagonal.lo, axis=-1), np.sort(diagonal.hi, axis=-1)
    most, least = lo[..., -1], hi[..., 0]
    lo, hi = ends.outward(lo - apart[..., None], hi + apart[..., None])
    lo[..., -1], hi[..., 0] = np.maximum(lo[..., -1], most), np.minimum(hi[..., 0], least)
    lo, hi = ends.multiply((lo, hi), (1 - theta, 1 + theta))
    if A.coordinates and 2**A.coordinates <= CORNERS:
        first, last = _extremes_at_corners(form)
        lo, hi = _raised(lo, first[..., None]), _lowered(hi, last[..., None])
    unknown: Flags = np.any(np.isnan(A.lo), axis=(-2, -1)) | np.any(np.isnan(diagonal.lo), axis=-1)
    unknown = unknown[..., None]
    first_order = _moving_as(diagonal, turned, apart, theta) if A.coordinates else None
    return Interval(np.where(unknown, np.nan, lo), np.where(unknown, np.nan, hi), first_order).narrowed()


def eigenvalue_ratio(x: Any) -> Interval:
    """λ_max / λ_min (...) of symmetric matrices (..., m, m), undefined unless they are positive definite.

    {A : λ_max <= k λ_min} is convex, so that the ratio over a box is greatest at its corners.
    """
    A = _mirrored(as_interval(x))
    return _ratio(A, symmetric_eigenvalues(A))


def condition_number(x: Any) -> Interval:
    """σ_max / σ_min (...) of square matrices (..., m, m): up to inf where they may be singular."""
    M = as_interval(x)
    gram = matmul(transposed(M), M)
    squares = symmetric_eigenvalues(gram)
    found: Any = np.sqrt(_ratio(gram, squares))
    lowest: Any = np.sqrt(_just(np.maximum(squares.lo[..., -1], 0.0)) / _just(squares.hi[..., 0]))
    return _up_to_infinity(found, np.maximum(lowest.lo, 1.0), squares[..., 0])


def inverse_roots(squares: Interval) -> Interval:
    """1/√λ of what is never negative: up to inf where λ may be 0."""
    found: Any = 1.0 / np.sqrt(squares)
    lowest: Any = 1.0 / np.sqrt(_just(squares.hi))
    return _up_to_infinity(found, lowest.lo, squares)


def _just(numbers: Array) -> Any:
    return Interval(numbers, numbers.copy())


def _up_to_infinity(found: Interval, lowest: Array, divisor: Interval) -> Interval:
    """``found``, or what is at least ``lowest`` where a divisor that is never negative may be 0."""
    vanishes = (divisor.lo <= 0) & (divisor.hi > 0)
    lo, hi = np.where(vanishes, lowest, found.lo), np.where(vanishes, np.inf, found.hi)
    return Interval(lo, hi, found.form).narrowed()


def singular_values(x: Any) -> Interval:
    """Singular values (..., k), descending, of any matrices."""
    M = as_interval(x)
    if M.shape[-2] < M.shape[-1]:
        M = transposed(M)
    squares = symmetric_eigenvalues(matmul(transposed(M), M))
    found: Any = np.sqrt(np.maximum(squares, 0.0))
    form = M.form_over(M.coordinates)
    near = Interval(form.c, form.c)
    middle: Any = symmetric_eigenvalues(matmul(transposed(near), near))
    middle = np.sqrt(np.maximum(middle, 0.0))
    moved = _frobenius(form.spread)[..., None]
    lo, hi = ends.outward(middle.lo - moved, middle.hi + moved)
    lo, hi = _raised(found.lo, lo), _lowered(found.hi, hi)
    ascending = Interval(lo, hi, found.form).narrowed()
    return ascending[..., ::-1]


def extreme_eigenvalues(matrices: Array) -> tuple[Array, Array]:
    """Verified bounds below the least and above the greatest eigenvalue of symmetric matrices (..., m, m)."""
    from orthospec import kernels

    m = matrices.shape[-1]
    norm = _frobenius(matrices)
    found = kernels.symmetric_eigenvalues(matrices.reshape(-1, m, m)).reshape(*matrices.shape[:-1])
    margin = norm * CLOSE + TINY
    least, greatest = found[..., 0] - margin, found[..., -1] + margin
    eye = np.eye(m)
    upper = _least_eigenvalue_is_above(greatest[..., None, None] * eye - matrices)
    lower = _least_eigenvalue_is_above(matrices - least[..., None, None] * eye)
    # The differences were rounded: on the diagonal only.
    spare = (np.abs(greatest) + np.abs(least) + norm) * FEW
    lo = np.where(np.isnan(lower), -norm, least + lower - spare)
    hi = np.where(np.isnan(upper), norm, greatest - upper + spare)
    return lo, hi


def _least_eigenvalue_is_above(matrices: Array) -> Array:
    """A number (...) just below 0 that no eigenvalue lies below; NaN where no Cholesky factor was found.

    The computed factor belongs to a matrix that differs by at most 2 (m + 1) u sqrt(a_ii a_jj) in each entry.
    """
    m = matrices.shape[-1]
    columns = np.ascontiguousarray(np.moveaxis(matrices, (-2, -1), (0, 1)))
    L: list[list[Array]] = []
    positive = np.ones(matrices.shape[:-2], dtype=bool)
    for i in range(m):
        row: list[Array] = []
        for j in range(i):
            left = columns[i, j] - sum(row[k] * L[j][k] for k in range(j))
            row.append(left / L[j][j])
        pivot = columns[i, i] - sum(entry * entry for entry in row)
        positive &= pivot > 0
        row.append(np.sqrt(np.where(pivot > 0, pivot, 1.0)))
        L.append(row)
    trace = np.abs(np.einsum("...ii->...", matrices))
    return np.where(positive, -(2 * (m + 2) * ULP * trace + TINY), np.nan)


def _extremes_at_corners(form: Linear) -> tuple[Array, Array]:
    """Below λ_min and above λ_max over each box."""
    corners, rest = _corners(form)
    least, greatest = extreme_eigenvalues(corners)
    return ends.outward(least.min(axis=0) - rest, greatest.max(axis=0) + rest)


def _corners(form: Linear) -> tuple[Array, Array]:
    """A_c + Σ ± G_k (2^d, ..., m, m), and how far (...) from their hull a matrix of the box may lie."""
    signs = np.array(list(product((-1.0, 1.0), repeat=form.g.shape[-1])))
    slopes = np.moveaxis(form.g, -1, 0)
    corners = form.c + np.tensordot(signs, slopes, axes=1)
    rounding = FEW * (np.abs(form.c) + np.abs(form.g).sum(axis=-1))
    rest = (form.r + rounding) * SPARE
    return corners, np.minimum(_frobenius(rest), rest.sum(axis=-1).max(axis=-1) * SPARE)


def _in_middle_axes(A: Interval, middle: Array) -> tuple[Interval, Array]:
    """VᵀAV and θ: each eigenvalue of A is one of VᵀAV times 1 ± θ (Ostrowski), V nearly orthogonal."""
    from orthospec import kernels

    known = np.asarray(np.isfinite(middle).all(axis=(-2, -1)))[..., None, None]
    m = middle.shape[-1]
    safe = np.where(known, middle, 0.0).reshape(-1, m, m)
    V = kernels.symmetric_eigenvectors(safe)[1].reshape(middle.shape)
    Vt = np.swapaxes(V, -1, -2)
    defect = _frobenius(Vt @ V - np.eye(m)) + m * m * FEW
    turned = matmul(matmul(Vt, A), V)
    return turned, 2 * defect[..., None]


def _moving_as(diagonal: Interval, turned: Interval, apart: Array, theta: Array) -> Linear:
    """Forms of ascending eigenvalues: d_i, and the rest of row i squared over its gap (Kato and Temple).

    The gap is what lies between d_i and all other eigenvalues; without one nothing is known of first order.
    """
    lo, hi = ends.outward(diagonal.lo - apart[..., None], diagonal.hi + apart[..., None])
    gap = np.full(lo.shape, np.inf)
    gap[..., :-1] = np.minimum.accumulate(lo[..., :0:-1], axis=-1)[..., ::-1] - diagonal.hi[..., :-1]
    below = diagonal.lo[..., 1:] - np.maximum.accumulate(hi[..., :-1], axis=-1)
    gap[..., 1:] = np.minimum(gap[..., 1:], below)
    magnitude = _off_diagonal(turned)
    squares = np.sum(magnitude * magnitude, axis=-1) + TINIEST * magnitude.shape[-1]
    size = np.maximum(np.abs(lo), np.abs(hi))
    form = diagonal.form_over(turned.coordinates)
    rest = np.where(gap > 0, squares / gap + theta * size, np.nan)
    return form._replace(r=(form.r + rest) * SPARE)


def _off_diagonal(x: Interval) -> Array:
    """The greatest magnitudes of the entries, 0 on the diagonal."""
    return np.asarray(np.maximum(np.abs(x.lo), np.abs(x.hi)) * (1 - np.eye(x.shape[-1])))


def _frobenius(matrices: Array) -> Array:
    """A bound on the norm; squares that underflow are allowed for."""
    squares = (
        np.einsum("...ij,...ij->...", matrices, matrices) + TINIEST * matrices.shape[-2] * matrices.shape[-1]
    )
    return np.asarray(np.sqrt(squares) * SPARE)


def _ratio(A: Interval, spectrum: Interval) -> Interval:
    """λ_max / λ_min of symmetric matrices of which the eigenvalues are known."""
    found: Any = spectrum[..., -1] / spectrum[..., 0]
    lo, hi = np.maximum(found.lo, 1.0), found.hi
    if A.coordinates and 2**A.coordinates <= CORNERS:
        corners, rest = _corners(A.form_over(A.coordinates))
        least, greatest = extreme_eigenvalues(corners)
        least, greatest = ends.outward(least - rest, greatest + rest)
        ratio = ends.outward(greatest / least, greatest / least)[1]
        hi = _lowered(hi, np.where((least > 0).all(axis=0), ratio.max(axis=0), np.nan))
    unknown = ~(spectrum.lo[..., 0] > 0)
    lo, hi = np.where(unknown, np.nan, lo), np.where(unknown, np.nan, hi)
    return Interval(lo, hi, found.form).narrowed()


def _mirrored(A: Interval) -> Interval:
    lower = np.tril(np.ones(A.shape[-2:], dtype=bool))
    found: Any = np.where(lower, A, transposed(A))
    return as_interval(found)


def transposed(x: Any) -> Interval:
    """With the last two axes exchanged."""
    return rearranging.swapaxes(x, -1, -2)


def _raised(lo: Array, other: Array) -> Array:
    return np.where(other > lo, other, lo)


def _lowered(hi: Array, other: Array) -> Array:
    return np.where(other < hi, other, hi)

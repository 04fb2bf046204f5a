"""The virtual joint method: the compliance of a machine from its chains, batched over poses.

Each chain i has passive joints with the unit twists q (k, 6), and springs: its actuator and its links, each a
compliance (6, 6) at the tool point. Springs in series add. With C_i their sum, the passive joints locked, and
the rows of W_i (6 − k, 6) the wrenches that do no work on the passive joints, W_i qᵀ = 0,

    D_i = W_i C_i W_iᵀ,      K_i = W_iᵀ D_i⁻¹ W_i,      K = Σ K_i,      C = K⁻¹.

K_i is the upper left block of the inverse of the bordered matrix in eq. 6 of Pashkevich, Chablat and Wenger
(2009). Twists are (translation, rotation) and wrenches (force, moment), in that order, about the tool point.

>>> leg = spring_at(1e-8 * np.eye(6), frames=np.eye(3)[None], arms=np.zeros((1, 3)))
>>> chain = leg + actuator(np.array([[1.0, 0, 0, 0, 0, 0]]), 3e-8)
>>> universal_joint = np.array([[[0, 0, 0, 0, 1.0, 0], [0, 0, 0, 0, 0, 1.0]]])
>>> stiffness = chain_stiffness(chain, transmitted_wrenches(universal_joint))
>>> round(stiffness[0, 0, 0] / 1e6)
25
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from orthospec.arrays import np

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Matrices

LOOSE = 1e-12
"""Least singular value of the wrenches, beside the greatest, that counts as held."""

DEPENDENT = 1e-10
"""Least singular value of passive twists, beside the greatest, that counts as another joint."""

RIGID = 1e-14
"""Compliances up to here, beside the chain's greatest, are none."""

STILL = 1e-12
"""Deformations up to here, beside the greatest that a load of the same size could cause, are rounding."""

NEGLIGIBLE = 1e-6
"""Arms up to here are rounding, and no unit of length [m]."""


def transported_wrenches(wrenches: Array, arms: Array) -> Array:
    """Wrenches (..., 6) at points, re-expressed at the tool point.

    ``arms`` (..., 3) [m] lead from the tool point to the points.
    """
    forces, moments = wrenches[..., :3], wrenches[..., 3:]
    moved = moments + np.cross(arms, forces)
    return np.concatenate([np.broadcast_to(forces, moved.shape), moved], axis=-1)


def transported_twists(twists: Array, arms: Array) -> Array:
    """Twists (..., 6) at points of one body, re-expressed at the tool point.

    ``arms`` (..., 3) [m] lead from the tool point to the points.
    """
    translations, rotations = twists[..., :3], twists[..., 3:]
    moved = translations + np.cross(arms, rotations)
    return np.concatenate([moved, np.broadcast_to(rotations, moved.shape)], axis=-1)


def spring_at(compliance: Array, frames: Array, arms: Array) -> Matrices:
    """The compliance of a link at the tool point (n, 6, 6).

    ``compliance`` (6, 6) is that of the link's end in the link's frame. The rows of ``frames`` (n, 3, 3) are
    that frame's axes, and ``arms`` (n, 3) [m] lead from the tool point to the link's end.
    """
    axes = np.zeros_like(frames, shape=(len(frames), 6, 6))
    axes[:, :3, :3] = axes[:, 3:, 3:] = frames
    turned = transported_twists(axes, arms[:, None, :])
    found: Matrices = np.swapaxes(turned, 1, 2) @ compliance @ turned
    return found


def actuator(twists: Array, compliance: float) -> Matrices:
    """The compliance of rank one (n, 6, 6) of an actuator that moves the tool by ``twists`` (n, 6) a unit."""
    found: Matrices = compliance * twists[:, :, None] * twists[:, None, :]
    return found


def transmitted_wrenches(passive: Array) -> Array:
    """Basis W (n, m, 6) of the wrenches that do no work on the passive twists (n, k, 6).

    m is 6 less the least rank of a pose; a pose of higher rank fills up with zero rows. So that metres and
    radians compare, lengths count in units of the twists' mean translation; in these units W is orthonormal.
    """
    if not isinstance(passive, np.ndarray):
        return _transmitted_over_boxes(passive)
    length = _length(passive[..., 3:], passive[..., :3])
    units = np.concatenate([np.repeat(1 / length, 3, axis=1), np.ones((len(passive), 3))], axis=1)[:, None, :]
    _, sizes, axes = np.linalg.svd(passive * units)
    ranks = np.sum(sizes > DEPENDENT * sizes[:, :1], axis=1)
    least = int(ranks.min(initial=6))
    transmitted = np.arange(least, 6) >= ranks[:, None]
    return np.asarray(axes[:, least:] * units * transmitted[:, :, None])


def _transmitted_over_boxes(passive: Any) -> Array:
    """W (n, m, 6) of interval twists: those at the middle, less what of them works on the twists elsewhere.

    W = W_c − W_c Qᵀ (Q Qᵀ)⁻¹ Q, Q the twists that are not 0. Nothing is known where these are dependent: over
    a box two twists are never seen to be the same.
    """
    middle = passive.form_over(passive.coordinates).c
    first = transmitted_wrenches(middle)
    free = ~np.all((passive.lo == 0) & (passive.hi == 0), axis=2)
    Q = np.where(free[:, :, None], passive, 0.0)
    gram = Q @ np.swapaxes(Q, 1, 2) + np.eye(middle.shape[1]) * ~free[:, :, None]
    works = np.linalg.inv(gram) @ Q
    nonzero = (first != 0).any(axis=2, keepdims=True)
    known = nonzero[:, :, 0].sum(axis=1) == 6 - free.sum(axis=1)
    found = np.where(nonzero, first - (first @ np.swapaxes(Q, 1, 2)) @ works, 0.0)
    return np.where(known[:, None, None], found, np.nan)


def reduced_compliance(compliance: Matrices, wrenches: Array) -> Matrices:
    """D = W C Wᵀ (n, m, m) of one chain, of unit compliance where W (n, m, 6) has a zero row."""
    reduced: Matrices = wrenches @ compliance @ np.swapaxes(wrenches, 1, 2)
    return reduced + _unit_where_zero(wrenches)


def chain_stiffness(compliance: Matrices, wrenches: Array) -> Matrices:
    """K_i = Wᵀ (W C Wᵀ)⁻¹ W (n, 6, 6) of a chain that no transmitted wrench (n, m, 6) finds rigid."""
    reduced = reduced_compliance(compliance, wrenches)
    stiffness: Matrices = np.swapaxes(wrenches, 1, 2) @ np.linalg.solve(reduced, wrenches)
    return stiffness


def parallel_compliance(reduced: Array, wrenches: Array) -> Matrices:
    """Compliance C (n, 6, 6) of a platform on chains side by side.

    ``wrenches`` (n, chains, m, 6), m up to 6, are those that each chain transmits, in any basis, and
    ``reduced`` (n, chains, m, m) is D = W C Wᵀ of each; a chain of fewer wrenches fills up with zero rows of
    unit compliance. A chain may be rigid (D singular). Where the platform is loose all entries are +inf, and
    where an argument is not finite, NaN. The error is rounding times the condition number of K.

    Poses at which D or K is not safely inverted go another way, a hundred times as long.
    """
    from orthospec import kernels

    if not isinstance(reduced, np.ndarray):
        return _over_boxes(reduced, wrenches)
    compliance, safe = kernels.chain_compliance(reduced, wrenches)
    if not safe.all():
        rest = np.flatnonzero(~safe)
        finite = np.isfinite(reduced[rest]).all(axis=(1, 2, 3)) & np.isfinite(wrenches[rest]).all(
            axis=(1, 2, 3)
        )
        rest = rest[finite]
        compliance[rest] = _by_forces(reduced[rest], wrenches[rest])
    return compliance


def _over_boxes(reduced: Array, wrenches: Array) -> Matrices:
    """C of intervals: minus the lower right block of the inverse of [[D, W], [Wᵀ, 0]].

    It is (Wᵀ D⁻¹ W)⁻¹, but no stiffness is added up: neither a great ratio of stiffnesses nor a rigid chain
    does harm.
    """
    n, chains, m, _ = wrenches.shape
    count = chains * m
    bordered = np.zeros_like(wrenches, shape=(n, count + 6, count + 6))
    for i in range(chains):
        chain = slice(i * m, (i + 1) * m)
        bordered[:, chain, chain] = reduced[:, i]
        bordered[:, chain, count:] = wrenches[:, i]
        bordered[:, count:, chain] = np.swapaxes(wrenches[:, i], 1, 2)
    inverse: Any = np.linalg.inv(bordered)
    found: Matrices = -inverse[:, count:, count:]
    return found


def _by_forces(reduced: Array, wrenches: Array) -> Matrices:
    """C by the principle of least work, which asks for no inverse of a chain's compliance.

    The chains' forces λ balance the load F, B λ = F, B = [W₁ᵀ W₂ᵀ ...]. Of all λ = B⁺F + N z, N the null
    space of B, those at work minimise λᵀ D λ = |Rᵀλ|², D = R Rᵀ. With E F what is left of Rᵀ B⁺F once its
    part along Rᵀ N is taken out, C = Eᵀ E: semidefinite, however rigid a chain. Lengths count in units of the
    forces' mean arm, and each wrench in units of its norm.
    """
    n, chains, m, _ = wrenches.shape
    count = chains * m
    if count < 6:
        return np.full((n, 6, 6), np.inf)
    rows, units = _normalised(wrenches.reshape(n, count, 6))
    norms = np.linalg.norm(rows, axis=2)
    norms[norms == 0] = np.inf  # Nothing acts there, whatever the compliance.
    left, sizes, right = np.linalg.svd(np.swapaxes(rows / norms[:, :, None], 1, 2))
    held = sizes[:, 5] > LOOSE * sizes[:, 0]
    spread = (left[held] / sizes[held, None, :]) @ right[held, :6]
    norms = norms[held].reshape(-1, chains, m)
    root = _blocks(_root(reduced[held] / (norms[..., :, None] * norms[..., None, :])))
    moved = _least_work(root, spread, right[held, 6:]) * units[held, None, :]
    compliance = np.full((n, 6, 6), np.inf)
    compliance[held] = np.einsum("nki,nkj->nij", moved, moved)
    return compliance


def _least_work(root: Matrices, spread: Array, free: Array) -> Array:
    """E (n, k, 6); the rows of ``root``, ``spread`` and ``free`` are those of Rᵀ, B⁺ᵀ and Nᵀ."""
    size = np.linalg.norm(root, axis=(1, 2))[:, None]
    along, sizes, _ = np.linalg.svd(root @ np.swapaxes(free, 1, 2), full_matrices=False)
    along = along * (sizes > STILL * size)[:, None, :]
    left = root @ np.swapaxes(spread, 1, 2)
    for _ in range(2):  # Once leaves rounding of the part that is taken out.
        left -= along @ (np.swapaxes(along, 1, 2) @ left)
    most = size * np.linalg.norm(spread, axis=(1, 2))[:, None]
    moves = np.linalg.norm(left, axis=1) > STILL * most
    return np.asarray(left * moves[:, None, :])


def _root(compliance: Array) -> Array:
    """Rᵀ (..., m, m) with R Rᵀ = C, semidefinite."""
    values, vectors = np.linalg.eigh(compliance)
    values = np.where(values > RIGID * values[..., -1:], values, 0.0)
    return np.asarray(np.sqrt(values)[..., :, None] * np.swapaxes(vectors, -1, -2))


def _normalised(wrenches: Array) -> tuple[Array, Array]:
    """Wrenches (n, m, 6) with moments in units of the mean arm, and the units (n, 6) of these columns."""
    length = _length(wrenches[..., :3], wrenches[..., 3:])
    units = np.concatenate([np.ones((len(wrenches), 3)), np.repeat(1 / length, 3, axis=1)], axis=1)
    return wrenches * units[:, None, :], units


def _length(unit: Array, arm: Array) -> Array:
    """Mean length (n, 1) of ``arm`` (n, m, 3) in the rows that have a ``unit``; 1 where it is negligible."""
    size = np.sum(unit**2, axis=2)
    squares = np.sum(np.where(size > 0, np.sum(arm**2, axis=2), 0.0), axis=1)
    total = np.sum(size, axis=1)
    length = np.sqrt(squares / np.where(total > 0, total, 1.0))
    return np.asarray(np.where(length > NEGLIGIBLE, length, 1.0)[:, None])


def _blocks(reduced: Array) -> Matrices:
    """The chains' matrices (n, chains, m, m) as blocks along one diagonal."""
    n, chains, m, _ = reduced.shape
    blocks = np.zeros((n, chains * m, chains * m))
    for i in range(chains):
        block = slice(i * m, (i + 1) * m)
        blocks[:, block, block] = reduced[:, i]
    return blocks


def _unit_where_zero(wrenches: Array) -> Matrices:
    zero: Flags = np.all(wrenches == 0, axis=2)
    return np.where(zero[:, :, None], np.eye(wrenches.shape[1]), 0.0)

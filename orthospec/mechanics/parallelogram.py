"""The elasticity of a parallelogram of two equal bars between rigid short links.

The bars' frame has x along the bars, from the slide to the platform, and z across the parallelogram's plane.
The bars end at ± d/2 a from the midpoint between their ends, a = (sin q, cos q, 0) the short links' direction
and q the angle, 0 for a rectangle. Each bar has a revolute about z at both ends and is a spring (6, 6) at its
end at the platform. The pair does not resist translation along y.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from orthospec.arrays import np
from orthospec.mechanics.virtual_joints import (
    chain_stiffness,
    spring_at,
    transmitted_wrenches,
    transported_twists,
)

if TYPE_CHECKING:
    from orthospec.arrays import Array, Matrices

_FORCES, _MOMENTS = [0, 2], [3, 4]


def parallelogram_compliance(bar: Array, *, spacing: float, cos: Array, sin: Array) -> Matrices:
    """D (n, 3, 3) of the pair in the wrenches that a leg with a revolute about a at each end transmits.

    These are a force along −x, a moment about t = a × z = (cos q, −sin q, 0) and a moment about z, all at the
    midpoint. ``bar`` (6, 6), or (n, 6, 6), is the compliance of one bar, d = ``spacing`` [m], and ``cos`` > 0
    and ``sin`` (n,) are those of q.

    The bars carry (σ ± δ)/2, σ and δ each of (f_x, f_z, m_x, m_y), with the work (σᵀCσ + δᵀCδ)/4 where they
    balance the load (f, m_t, m_z):  σ_f = (−f, 0),  σ_m = (m_t − d/2 δ_z) t,  δ_x = −2 m_z / (d cos q). The
    least work over δ_z and over δ's moments, which condense C to h, is this D. For a beam, with
    c_t = C44 cos² q + C55 sin² q and h_zz = C33 − C35²/C55,

        D = diag(C11 / 2,  c_t h_zz / (2 h_zz + d² c_t / 2),  2 C11 / (d cos q)²).

    Bending in the plane does not enter. Entries of the third wrench grow without bound towards q = ±90°.
    """
    h = condensed(bar)
    h_xx, h_xz, h_zz = h[..., 0, 0], h[..., 0, 1], h[..., 1, 1]
    c_x, c_xt = bar[..., 0, 0], bar[..., 0, 3] * cos - bar[..., 0, 4] * sin
    c_t = bar[..., 3, 3] * cos**2 - 2 * bar[..., 3, 4] * sin * cos + bar[..., 4, 4] * sin**2
    both = h_zz + spacing**2 / 4 * c_t
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(both > 0, 0.5 / both, 0.0)
        turn = -2 / (spacing * cos)
        reduced = np.empty_like(cos, shape=(len(cos), 3, 3))
        reduced[:, 0, 0] = c_x / 2 - spacing**2 / 4 * c_xt**2 * share
        reduced[:, 1, 1] = c_t * h_zz * share
        reduced[:, 2, 2] = (h_xx / 2 - h_xz**2 * share) * turn**2
        reduced[:, 0, 1] = reduced[:, 1, 0] = -c_xt * h_zz * share
        reduced[:, 0, 2] = reduced[:, 2, 0] = -spacing / 2 * c_xt * h_xz * share * turn
        reduced[:, 1, 2] = reduced[:, 2, 1] = spacing / 2 * c_t * h_xz * share * turn
    return reduced


def condensed(bar: Array) -> Array:
    """h (..., 2, 2): a bar's compliance (..., 6, 6) to forces along x and z, where moments find none.

    They are those about x and y, which the bar gives way to freely.
    """
    forces, moments = bar[..., _FORCES, :], bar[..., _MOMENTS, :]
    along, across, turning = forces[..., _FORCES], forces[..., _MOMENTS], moments[..., _MOMENTS]
    h: Array = along - across @ np.linalg.pinv(turning, hermitian=True) @ np.swapaxes(across, -1, -2)
    return h


def parallelogram_stiffness(bar: Array, *, spacing: float, cos: Array, sin: Array) -> Matrices:
    """K (n, 6, 6) of the pair at the midpoint, as two chains side by side: revolute, bar, revolute.

    Of rank 5, and 4 where the bars lie in one line, ``cos`` = 0. The bar must not be rigid.
    """
    half = spacing / 2 * np.stack([sin, cos, np.zeros_like(cos)], axis=1)
    return _bar_stiffness(bar, half) + _bar_stiffness(bar, -half)


def _bar_stiffness(bar: Array, arms: Array) -> Matrices:
    """K of a bar between revolutes about z, at the point from which ``arms`` lead to its end.

    The revolutes transmit the same wrenches whatever the distance between them, which is taken as 1 m.
    """
    frames = np.broadcast_to(np.eye(3), (len(arms), 3, 3))
    about_z = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    starts = arms - [1.0, 0.0, 0.0]
    passive = np.stack([transported_twists(about_z, starts), transported_twists(about_z, arms)], axis=1)
    return chain_stiffness(spring_at(bar, frames, arms), transmitted_wrenches(passive))

"""Translational machines with one prismatic actuator and one rigid leg a chain.

Orthoglide, linear Delta, UraneSX, Triglide and Quickstep are members. Slider i moves along the unit axis
e_i through b_i; a leg of length L_i joins the slider point b_i + ρ_i e_i to the platform point p + c_i.
With s_i = b_i + ρ_i e_i − p − c_i the loop closes where |s_i| = L_i (Merlet, *Parallel Robots*, 2006):

    ρ_i = d_i·e_i + β_i sqrt(L_i² − |d_i|² + (d_i·e_i)²),      d_i = p + c_i − b_i,

with β_i = ±1 the branch, the sign of s_i·e_i. Differentiating |s_i|² = L_i² gives row i of J⁻¹ = ∂ρ/∂p,

    s_iᵀ / (s_i·e_i).

For the Orthoglide (e_i the coordinate axes, b_i = c_i = 0) this is the bracket of eq. 14 of Pashkevich,
Chablat and Wenger (2009); J_ρ there is its inverse.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from orthospec.arrays import np

if TYPE_CHECKING:
    from orthospec.arrays import Array, Joints, Matrices, Poses

CLEARANCE = 1e-5
"""Least distance from a serial singularity that counts as inside the reach: |s_i·e_i| / L_i."""


class PrismaticLegs(NamedTuple):
    """The geometry of one machine of the family; rows are chains."""

    axes: Array
    """e_i, unit (3, 3)."""
    bases: Array
    """b_i (3, 3) [m]."""
    joints: Array
    """c_i, from the tool point to the leg's end on the platform (3, 3) [m]."""
    lengths: Array
    """L_i (3,) [m]."""
    branches: Array
    """β_i (3,), 1 or −1."""


def sliders(machine: PrismaticLegs, poses: Poses) -> Joints:
    """ρ (n, 3) [m]; NaN where a leg is too short to close its loop."""
    along, closing = _loops(machine, poses)
    with np.errstate(invalid="ignore"):
        return np.asarray(along + machine.branches * np.sqrt(closing))


def legs(machine: PrismaticLegs, poses: Poses, rho: Joints) -> Array:
    """s (n, 3, 3) [m]: row i leads from the platform to slider i."""
    s = rho[:, :, None] * machine.axes
    s += machine.bases - machine.joints
    s -= poses[:, None, :]
    return s


def inverse_jacobian(machine: PrismaticLegs, poses: Poses, rho: Joints) -> Matrices:
    """J⁻¹ (n, 3, 3): row i is s_iᵀ / (s_i·e_i); infinite or NaN at a serial singularity."""
    s = legs(machine, poses, rho)
    along, _ = _loops(machine, poses)
    with np.errstate(divide="ignore", invalid="ignore"):
        s /= (rho - along)[:, :, None]
    return s


def leg_margins(machine: PrismaticLegs, poses: Poses) -> Array:
    """(s_i·e_i / L_i)² less the clearance (n, 3): >= 0 where leg i closes its loop, smooth in the pose."""
    return np.asarray(_loops(machine, poses)[1] / machine.lengths**2 - CLEARANCE**2)


def unit_legs(machine: PrismaticLegs, poses: Poses, rho: Joints) -> Array:
    """β_i s_i / L_i (n, 3, 3): the rows of J⁻¹ up to the positive factors |s_i·e_i| / L_i."""
    return legs(machine, poses, rho) * (machine.branches / machine.lengths)[:, None]


def volume_margin(rows: Array, sign: float) -> Array:
    """``sign`` times the volume of the unit legs (n,), bounded and smooth.

    It has the sign of ``sign`` det J⁻¹ and is 0 at a parallel singularity, where J⁻¹ loses rank though a
    measure may stay finite; ``sign`` is that of det J⁻¹ in the machine's working assembly.
    """
    a, b, c = (rows[:, i].T for i in range(3))
    volume = a[0] * (b[1] * c[2] - b[2] * c[1])
    volume += a[1] * (b[2] * c[0] - b[0] * c[2])
    volume += a[2] * (b[0] * c[1] - b[1] * c[0])
    return np.asarray(sign * volume)


def pairs_margin(rows: Array, axes: Array) -> Array:
    """Sum of the principal 2 x 2 minors of the unit legs in the frame of independent slides (n,).

    A parallel singularity at which two singular values vanish at once leaves the volume's sign as it was,
    yet parts the workspace: with equal legs the Orthoglide has one on |p| = L, where all three sliders meet.
    There this sum passes through 0. It is 3 where the legs lie along their slides; with unequal legs it also
    leaves out a little beside serial singularities.
    """
    n = (rows.reshape(-1, 3) @ axes.T).reshape(rows.shape)
    minors = [n[:, i, i] * n[:, j, j] - n[:, i, j] * n[:, j, i] for i, j in ((0, 1), (0, 2), (1, 2))]
    return np.asarray(np.sum(minors, axis=0))


def _loops(machine: PrismaticLegs, poses: Poses) -> tuple[Array, Array]:
    """d_i·e_i [m] and (s_i·e_i)² [m^2], (n, 3) each; the second is negative where the loop cannot close."""
    offsets = machine.joints - machine.bases
    along = poses @ machine.axes.T + np.sum(offsets * machine.axes, axis=1)
    square = np.sum(poses**2, axis=1)[:, None] + 2 * poses @ offsets.T + np.sum(offsets**2, axis=1)
    return along, machine.lengths**2 - square + along**2

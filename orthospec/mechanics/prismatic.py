"""Translational machines with one prismatic actuator and one rigid leg a chain.

Orthoglide, linear Delta, UraneSX, Triglide and Quickstep are members. Slider i moves along the unit axis
e_i through b_i; a leg of length L_i joins the slider point b_i + ρ_i e_i to the platform point p + c_i.
With s_i = b_i + ρ_i e_i − p − c_i the loop closes where |s_i| = L_i (Merlet, *Parallel Robots*, 2006):

    ρ_i = d_i·e_i + β_i sqrt(L_i² − |d_i|² + (d_i·e_i)²),      d_i = p + c_i − b_i,

with β_i = ±1 the branch, the sign of s_i·e_i. What L_i² loses is computed as |d_i − (d_i·e_i) e_i|²: so the
way along the slide cancels, over boxes of poses too. Differentiating |s_i|² = L_i² gives row i of J⁻¹,

    s_iᵀ / (s_i·e_i).

For the Orthoglide (e_i the coordinate axes, b_i = c_i) this is the bracket of eq. 14 of Pashkevich,
Chablat and Wenger (2009); J_ρ there is its inverse.

Inside, the poses are the last axis: each component of each leg is one contiguous row.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from orthospec.arrays import np

if TYPE_CHECKING:
    from orthospec.arrays import Array, Joints, Matrices, Poses

CLEARANCE = 1e-5
"""Least distance from a serial singularity that counts as inside the reach: |s_i·e_i| / L_i."""


class PrismaticLegs(NamedTuple):
    """The geometry of one machine of the family; rows are chains.

    Where each of n poses has a machine of its own, the last axis of length 1 is one of n.
    """

    axes: Array
    """e_i, unit (3, 3)."""
    bases: Array
    """b_i (3, 3, 1) [m]."""
    joints: Array
    """c_i, from the tool point to the leg's end on the platform (3, 3, 1) [m]."""
    lengths: Array
    """L_i (3, 1) [m]."""
    branches: Array
    """β_i (3,), 1 or −1."""
    revolutes: Array
    """a_i, unit (3, 3): the first revolute axis, fixed in space, which is a parallelogram's short link."""
    home: Array
    """β_i s_i / L_i (3, 3) at any pose of the working assembly: which side of the singularities counts."""


class Legs(NamedTuple):
    """The legs over a block of n poses."""

    rho: Joints
    """ρ (n, 3) [m]; NaN where a leg is too short to close its loop."""
    s: Array
    """s[i, k] (3, 3, n) [m]: component k of the way from the platform to slider i."""
    along: Array
    """s_i·e_i (3, n) [m]."""
    closing: Array
    """(s_i·e_i)² (3, n) [m^2]; negative where the loop cannot close."""

    @property
    def poses(self) -> int:
        """How many poses there are."""
        return len(self.rho)


def close(machine: PrismaticLegs, poses: Poses) -> Legs:
    """Close the loops of all legs at each pose."""
    if isinstance(poses, np.ndarray) and is_one(machine):
        from orthospec import kernels

        return Legs(*kernels.close_legs(_slides(machine), poses))
    offsets = machine.joints - machine.bases
    p = poses.T.copy()
    axes = machine.axes[:, :, None]
    projected = machine.axes @ p + np.sum(offsets * axes, axis=1)
    across = p + offsets - projected[:, None, :] * axes
    closing = machine.lengths**2 - np.sum(across**2, axis=1)
    with np.errstate(invalid="ignore"):
        along = machine.branches[:, None] * np.sqrt(closing)
    rho = projected + along
    s = along[:, None, :] * axes - across
    return Legs(rho.T, s, along, closing)


def is_one(machine: PrismaticLegs) -> bool:
    """Whether all poses have this one machine, of plain numbers: those that kernels serve."""
    numbers = (machine.joints, machine.bases, machine.lengths)
    return all(isinstance(one, np.ndarray) and one.shape[-1] == 1 for one in numbers)


def _slides(machine: PrismaticLegs) -> Array:
    """What the kernel of the loops is told of each leg (3, 8): axis, offset, length and branch."""
    offsets = (machine.joints - machine.bases)[:, :, 0]
    return np.hstack([machine.axes, offsets, machine.lengths, machine.branches[:, None]])


def inverse_jacobian(legs: Legs) -> Matrices:
    """J⁻¹ (n, 3, 3): row i is s_iᵀ / (s_i·e_i); infinite or NaN at a serial singularity."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.moveaxis(legs.s / legs.along[:, None, :], 2, 0)


def margins(machine: PrismaticLegs, legs: Legs) -> dict[str, Array]:
    """How far the legs are from the singularities (n,) each: >= 0 inside, smooth in the pose.

    ``leg_1`` ... as `leg_margins` tells them, ``singularity`` by the `volume_margin`, ``assembly`` by the
    `pairs_margin`.
    """
    if is_one(machine) and isinstance(legs.s, np.ndarray):
        from orthospec import kernels

        rows = kernels.leg_margins(_scales(machine), legs.s, legs.closing)
        return dict(zip(("leg_1", "leg_2", "leg_3", "singularity", "assembly"), rows, strict=True))
    units = unit_legs(machine, legs)
    return {
        **{f"leg_{i + 1}": row for i, row in enumerate(leg_margins(machine, legs))},
        "singularity": volume_margin(units, machine.home),
        "assembly": pairs_margin(units, machine.home),
    }


def _scales(machine: PrismaticLegs) -> Array:
    """What the kernel of the margins is told of each leg (3, 7)."""
    lengths = machine.lengths[:, 0]
    across = np.linalg.inv(machine.home).T
    alike = np.broadcast_to([np.sign(np.linalg.det(machine.home)), CLEARANCE**2], (3, 2))
    return np.hstack([np.stack([lengths**2, machine.branches / lengths], axis=1), across, alike])


def leg_margins(machine: PrismaticLegs, legs: Legs) -> Array:
    """(s_i·e_i / L_i)² less the clearance (3, n): >= 0 where leg i closes its loop, smooth in the pose."""
    margins: Array = legs.closing / machine.lengths**2 - CLEARANCE**2
    return margins


def unit_legs(machine: PrismaticLegs, legs: Legs) -> Array:
    """β_i s_i / L_i (3, 3, n): the rows of J⁻¹ up to the positive factors |s_i·e_i| / L_i."""
    units: Array = legs.s * (machine.branches[:, None] / machine.lengths)[:, None, :]
    return units


def volume_margin(units: Array, home: Array) -> Array:
    """Volume of the unit legs (n,), positive on home's side; bounded and smooth.

    It has the sign of det J⁻¹ (or its opposite throughout) and is 0 at a parallel singularity, where J⁻¹
    loses rank though a measure may stay finite.
    """
    a, b, c = units
    volume: Array = a[0] * (b[1] * c[2] - b[2] * c[1])
    volume += a[1] * (b[2] * c[0] - b[0] * c[2])
    volume += a[2] * (b[0] * c[1] - b[1] * c[0])
    volume *= np.sign(np.linalg.det(home))
    return volume


def pairs_margin(units: Array, home: Array) -> Array:
    """Sum of the principal 2 x 2 minors of U U_home⁻¹, with U the unit legs (n,).

    A parallel singularity at which two singular values vanish at once leaves the volume's sign as it was,
    yet parts the workspace: with equal legs the Orthoglide has one on |p| = L, where all three sliders meet.
    There this sum passes through 0. It is 3 at home; it may also leave out a little beside serial
    singularities.
    """
    n = np.linalg.inv(home).T @ units
    minors = [n[i, i] * n[j, j] - n[i, j] * n[j, i] for i, j in ((0, 1), (0, 2), (1, 2))]
    margin: Array = minors[0] + minors[1] + minors[2]
    return margin

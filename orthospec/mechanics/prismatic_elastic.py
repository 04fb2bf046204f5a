"""Elasticity of machines with prismatic legs, by the virtual joint method.

Pashkevich, Chablat and Wenger (2009), section 3.2; Mechanism and Machine Theory 44(5), 2009. A chain is an
actuator (a spring along the slide), a foot from its carriage to the leg, and the leg, one bar or a
parallelogram of two; each is a spring at its end, and the platform is rigid. Its passive joints let through
a few wrenches W only: at the leg's end on the platform

    the force u along the leg, the moment t = a × z, and for a parallelogram the moment z,

with a the first revolute axis, x = −u the bar's direction, z the normal of the plane of a and x. With
universal joints (PUU) z is a passive axis at both ends. D = Wᵀ C W is the chain's compliance against them;
`orthospec.mechanics.virtual_joints.parallel_compliance` puts the chains together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from orthospec.arrays import np
from orthospec.mechanics.parallelogram import parallelogram_compliance
from orthospec.mechanics.virtual_joints import parallel_compliance

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.mechanics.prismatic import Legs, PrismaticLegs

BLOCK = 4096
"""Poses at a time: their wrenches stay in the cache."""


class Springs(NamedTuple):
    """The elasticity of one machine's chains."""

    actuator: float
    """Compliance along the slide [m/N]."""
    feet: Array
    """Compliance of each foot at its end, in its bar frame (3, 6, 6); zeros where rigid."""
    bars: Array
    """Compliance of each leg's bar at its end, in its bar frame (3, 6, 6); zeros where rigid."""
    spacing: float | None
    """Distance of a parallelogram's bars [m]; None for one bar between universal joints."""


def compliance(machine: PrismaticLegs, springs: Springs, legs: Legs) -> Array:
    """C (n, 6, 6) at the tool; all inf where the machine is loose, NaN out of reach."""
    found = np.empty((legs.poses, 6, 6))
    for start in range(0, legs.poses, BLOCK):
        part = slice(start, start + BLOCK)
        chains = [_chain(machine, springs, i, legs.s[i, :, part]) for i in range(len(machine.lengths))]
        wrenches, compliances = (np.stack(parts, axis=1) for parts in zip(*chains, strict=True))
        found[part] = parallel_compliance(compliances, wrenches)
    return found


def foot_frame(machine: PrismaticLegs, i: int) -> Array:
    """Rows x, y, z (3, 3): x along the slide towards the tool, y the first revolute axis, squared to it."""
    x = -machine.branches[i] * machine.axes[i]
    z = np.cross(x, machine.revolutes[i])
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


class _Bar(NamedTuple):
    """Directions of one chain over k poses, (3, k) each, and its parallelogram's angle."""

    u: Array
    t: Array
    z: Array
    sine: Array
    cosine: Array


def _bar(machine: PrismaticLegs, i: int, s: Array) -> _Bar:
    u = s / machine.lengths[i]
    a = machine.revolutes[i][:, None]
    z = np.cross(a, u, axis=0)
    cosine = np.sqrt(np.sum(z * z, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        z = z / cosine
    return _Bar(u, np.cross(a, z, axis=0), z, -np.sum(a * u, axis=0), cosine)


def _chain(machine: PrismaticLegs, springs: Springs, i: int, s: Array) -> tuple[Array, Array]:
    """The wrenches at the tool (k, w, 6) that chain i lets through, and its compliance to them (k, w, w)."""
    bar = _bar(machine, i, s)
    moments = (bar.t,) if springs.spacing is None else (bar.t, bar.z)
    wrenches = np.zeros((s.shape[1], 1 + len(moments), 6))
    wrenches[:, 0, :3] = bar.u.T
    wrenches[:, 0, 3:] = np.cross(machine.joints[i][:, None], bar.u, axis=0).T
    for k, moment in enumerate(moments, start=1):
        wrenches[:, k, 3:] = moment.T
    found = _leg(springs, i, bar)
    found[:, 0, 0] += springs.actuator * (machine.axes[i] @ bar.u) ** 2
    if springs.feet[i].any():
        found += _foot(machine, springs, i, bar.u, moments)
    return wrenches, found


def _leg(springs: Springs, i: int, bar: _Bar) -> Array:
    if springs.spacing is not None:
        return parallelogram_compliance(
            springs.bars[i], spacing=springs.spacing, cos=bar.cosine, sin=bar.sine
        )
    c = springs.bars[i]
    w = np.zeros((len(bar.sine), 2, 6))
    w[:, 0, 0] = -1.0
    w[:, 1, 3], w[:, 1, 4] = bar.cosine, -bar.sine
    return np.asarray(w @ c @ np.swapaxes(w, 1, 2))


def _foot(machine: PrismaticLegs, springs: Springs, i: int, u: Array, moments: tuple[Array, ...]) -> Array:
    """At the foot's end the same force and moments act: the force passes through the joint there."""
    frame = foot_frame(machine, i)
    w = np.zeros((u.shape[1], 1 + len(moments), 6))
    w[:, 0, :3] = (frame @ u).T
    for k, moment in enumerate(moments, start=1):
        w[:, k, 3:] = (frame @ moment).T
    return np.asarray(w @ springs.feet[i] @ np.swapaxes(w, 1, 2))

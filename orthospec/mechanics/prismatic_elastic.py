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

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from orthospec.arrays import np
from orthospec.mechanics.inertia import inverse
from orthospec.mechanics.parallelogram import condensed, parallelogram_compliance
from orthospec.mechanics.prismatic import is_one
from orthospec.mechanics.virtual_joints import parallel_compliance, spring_at

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags
    from orthospec.mechanics.prismatic import Legs, PrismaticLegs

LOOSE = 1e-12
"""Least determinant of MᵀM, M the unit moments that the chains hold, at which the platform cannot turn."""
BLOCK = 4096
"""Poses at a time: their wrenches stay in the cache."""


@dataclass(frozen=True)
class Springs:
    """The elasticity of one machine's chains."""

    actuator: float
    """Compliance along the slide [m/N]."""
    feet: Array
    """Compliance of each foot at its end, along the axes of space (3, 6, 6); zeros where rigid."""
    bars: Array
    """Compliance of each leg's bar at its end, in its bar frame (3, 6, 6); zeros where rigid.

    (3, n, 6, 6) where each pose has legs of its own.
    """
    spacing: float | None
    """Distance of a parallelogram's bars [m]; None for one bar between universal joints."""

    @cached_property
    def is_rigid(self) -> bool:
        """Whether the drives alone give."""
        return not (np.any(self.bars != 0) or self.feet.any())

    @cached_property
    def condensed(self) -> Array:
        """h (3, 2, 2) of each leg's bar: see `orthospec.mechanics.parallelogram`."""
        return condensed(self.bars)


def compliance(machine: PrismaticLegs, springs: Springs, legs: Legs) -> Array:
    """C (n, 6, 6) at the tool; all inf where the machine is loose, NaN out of reach."""
    plain = isinstance(legs.s, np.ndarray) and isinstance(springs.bars, np.ndarray) and springs.bars.ndim == 3
    if not (plain and is_one(machine)) or springs.is_rigid:
        return _by_chains(machine, springs, legs.s)
    from orthospec import kernels

    found, safe = kernels.legs_compliance(_numbers(machine, springs), springs.feet, legs.s)
    rest = np.flatnonzero(~safe)
    if len(rest):
        found[rest] = _by_chains(machine, springs, legs.s[:, :, rest])
    return found


def _numbers(machine: PrismaticLegs, springs: Springs) -> Array:
    """What the kernel is told of each leg (3, 21)."""
    C, h = springs.bars, springs.condensed
    entries = [C[:, 0, 0], C[:, 0, 3], C[:, 0, 4], C[:, 3, 3], C[:, 3, 4], C[:, 4, 4]]
    condensations = [h[:, 0, 0], h[:, 0, 1], h[:, 1, 1]]
    directions = [machine.revolutes, machine.joints[:, :, 0], machine.axes]
    drive, half = np.full(3, springs.actuator), np.full(3, (springs.spacing or 0.0) / 2)
    columns = [machine.lengths[:, 0], drive, *entries, *condensations, half]
    return np.hstack([*directions, np.stack(columns, axis=1)])


def _by_chains(machine: PrismaticLegs, springs: Springs, s: Array) -> Array:
    """C (n, 6, 6) from each chain's wrenches and its compliance to them; ``s`` (3, 3, n) is as in `Legs`."""
    units = s / machine.lengths[:, None, :]
    found = np.empty_like(units, shape=(units.shape[2], 6, 6))
    through = _through_drives if springs.is_rigid else parallel_compliance
    for start in range(0, units.shape[2], BLOCK):
        part = slice(start, start + BLOCK)
        bars = springs.bars if springs.bars.ndim == 3 else springs.bars[:, part]
        joints = machine.joints if machine.joints.shape[2] == 1 else machine.joints[:, :, part]
        here = machine._replace(joints=joints), replace(springs, bars=bars)
        found[part] = through(*_chains(*here, units[:, :, part]))
    return found


def _through_drives(compliances: Array, wrenches: Array) -> Array:
    """C (k, 6, 6) where the drives alone give: the moments hold all rotation, and the forces give Σ u uᵀ/D₀₀.

    What `parallel_compliance` comes to then, which takes a hundred times as long over rigid chains.
    """
    forces, moments = wrenches[:, :, 0, :3], wrenches[:, :, 1:, 3:].reshape(len(wrenches), -1, 3)
    with np.errstate(divide="ignore", invalid="ignore"):
        held: Flags = np.linalg.det(np.swapaxes(moments, 1, 2) @ moments) > LOOSE
        stiffness = np.swapaxes(forces / compliances[:, :, 0, 0, None], 1, 2) @ forces
    found = np.zeros_like(wrenches, shape=(len(wrenches), 6, 6))
    found[:, :3, :3] = inverse(stiffness)
    held &= np.isfinite(found).all(axis=(1, 2))
    known: Flags = np.all(np.isfinite(wrenches), axis=(1, 2, 3))
    found = np.where(held[:, None, None], found, np.inf)
    return np.where(known[:, None, None], found, np.nan)


def feet_in_space(machine: PrismaticLegs, foot: Array) -> Array:
    """A foot's compliance (6, 6) in its bar frame, as each chain has it along the axes of space (3, 6, 6).

    The frame's x runs along the slide towards the tool, y is the first revolute axis, squared to it.
    """
    x = -machine.branches[:, None] * machine.axes
    z = np.cross(x, machine.revolutes)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return spring_at(foot, np.stack([x, np.cross(z, x), z], axis=1), np.zeros((3, 3)))


def _chains(machine: PrismaticLegs, springs: Springs, units: Array) -> tuple[Array, Array]:
    """Each chain's compliance (k, 3, w, w) to the wrenches (k, 3, w, 6) that it lets through, at the tool.

    ``units`` (3, 3, k) are the legs' directions u.
    """
    count = 2 if springs.spacing is None else 3
    compliances = np.zeros_like(units, shape=(units.shape[2], 3, count, count))
    wrenches = np.zeros_like(units, shape=(units.shape[2], 3, count, 6))
    for i in range(3):
        bar = _bar(machine.revolutes[i], units[i])
        moments = (bar.t,) if springs.spacing is None else (bar.t, bar.z)
        wrenches[:, i, 0, :3] = bar.u.T
        wrenches[:, i, 0, 3:] = np.cross(machine.joints[i], bar.u, axis=0).T
        for k, moment in enumerate(moments, start=1):
            wrenches[:, i, k, 3:] = moment.T
        compliances[:, i] = _leg(springs, i, bar)
        compliances[:, i, 0, 0] += springs.actuator * (machine.axes[i] @ bar.u) ** 2
        if springs.feet[i].any():
            _add_foot(compliances[:, i], springs.feet[i], (bar.u, *moments))
    return compliances, wrenches


class _Bar(NamedTuple):
    """Directions of one chain over k poses, (3, k) each, and its parallelogram's angle."""

    u: Array
    t: Array
    z: Array
    sine: Array
    cosine: Array


def _bar(revolute: Array, u: Array) -> _Bar:
    around = _crossing(revolute)
    z = around @ u
    cosine = np.sqrt(_dot(z, z))
    with np.errstate(divide="ignore", invalid="ignore"):
        z /= cosine
    return _Bar(u, around @ z, z, -(revolute @ u), cosine)


def _leg(springs: Springs, i: int, bar: _Bar) -> Array:
    """The leg's own compliance (k, w, w)."""
    C, c, s = springs.bars[i], bar.cosine, bar.sine
    if not np.any(C != 0):
        count = 2 if springs.spacing is None else 3
        return np.zeros_like(c, shape=(len(c), count, count))
    if springs.spacing is not None:
        return parallelogram_compliance(C, spacing=springs.spacing, cos=c, sin=s)
    found = np.empty_like(c, shape=(len(c), 2, 2))
    found[:, 0, 0] = C[..., 0, 0]
    found[:, 0, 1] = found[:, 1, 0] = C[..., 0, 4] * s - C[..., 0, 3] * c
    found[:, 1, 1] = C[..., 3, 3] * c**2 - 2 * C[..., 3, 4] * c * s + C[..., 4, 4] * s**2
    return found


def _add_foot(total: Array, foot: Array, loads: tuple[Array, ...]) -> None:
    """At the foot's end the same force (the first load) and moments act: the force passes through it."""
    blocks = foot.reshape(2, 3, 2, 3)
    for j, left in enumerate(loads):
        for k, right in enumerate(loads[: j + 1]):
            work = _dot(left, blocks[min(j, 1), :, min(k, 1)] @ right)
            total[:, j, k] += work
            if j != k:
                total[:, k, j] += work


def _crossing(a: Array) -> Array:
    """The matrix of a × (3, 3)."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _dot(a: Array, b: Array) -> Array:
    found: Array = np.einsum("ik,ik->k", a, b)
    return found

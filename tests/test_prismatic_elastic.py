"""Elasticity of prismatic legs against closed forms, and against eq. 6 of the paper chain by chain."""

from __future__ import annotations

import math

import numpy as np
import pytest

from orthospec.kernels import _kernels
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.mechanics import prismatic, prismatic_elastic
from orthospec.mechanics.virtual_joints import parallel_compliance

L, D_BARS = 0.31, 0.08
E, G = 70e9, 26e9
A, IY, IZ, J = 2.0e-4, 6.0e-9, 3.0e-9, 5.0e-9
STIFFNESS = 2e7
MATERIAL = {"E": E, "G": G}
SECTION = {"given": {"A": A, "Iy": IY, "Iz": IZ, "J": J}}
LEGS = {"section": SECTION, "material": MATERIAL}
SPACING = {"PUU": {}, "PRPaR": {"spacing": D_BARS}}
E_FOOT, G_FOOT = 200e9, 80e9
FOOT = {
    "length": 0.12,
    "section": {"rectangle": {"height": 0.05, "width": 0.03}},
    "material": {"E": E_FOOT, "G": G_FOOT},
}
KINDS = ("PUU", "PRPaR")


def orthoglide(kind="PUU", *, offset=0.0, feet=None, legs=LEGS, lengths=(L, L, L), branch=(1, 1, 1)):
    return Orthoglide.model_validate(
        {
            "leg_lengths": lengths,
            "branch": branch,
            "legs": {**legs, **SPACING[kind], "kind": kind, "offset": offset},
            "feet": feet or "rigid",
            "actuators": {"stiffness": STIFFNESS},
        }
    )


def delta(kind="PUU", *, tilt=0.0, lengths=(0.5, 0.5, 0.5), feet=None):
    return LinearDelta.model_validate(
        {
            "leg_lengths": lengths,
            "base_radius": 0.3,
            "platform_radius": 0.05,
            "rail_tilt": tilt,
            "legs": {**LEGS, **SPACING[kind], "kind": kind},
            "feet": feet or "rigid",
            "actuators": {"stiffness": STIFFNESS},
        }
    )


def random_poses(n, seed, centre=(0.0, 0.0, 0.0)):
    return centre + np.random.default_rng(seed).uniform(-0.1, 0.1, (n, 3))


@pytest.mark.parametrize(("kind", "bars"), [("PUU", 1), ("PRPaR", 2)])
def test_isotropic_pose_is_as_soft_as_one_drive_and_one_leg_in_every_direction(kind, bars):
    C = orthoglide(kind).compliance(np.zeros((1, 3)))[0]
    np.testing.assert_allclose(C[:3, :3], (1 / STIFFNESS + L / (bars * E * A)) * np.eye(3), rtol=1e-12)


def test_rotational_stiffness_at_the_isotropic_pose_is_the_closed_form():
    zero = np.zeros((1, 3))
    puu, pa = (orthoglide(kind).compliance(zero)[0, 3:, 3:] for kind in KINDS)
    np.testing.assert_allclose(puu, L / (G * J) * np.eye(3), rtol=1e-12, atol=1e-20)
    stiffness = 2 * G * J / L + 6 * D_BARS**2 * E * IY / L**3 + D_BARS**2 * E * A / (2 * L)
    np.testing.assert_allclose(pa, np.eye(3) / stiffness, rtol=1e-11, atol=1e-20)


def test_concurrent_universal_legs_act_as_rods():
    machine, poses = orthoglide(lengths=(0.3, 0.32, 0.36)), random_poses(40, 1)
    C = machine.compliance(poses)
    legs = machine.closed_legs(poses)
    K = np.zeros((40, 3, 3))
    for i, length in enumerate(machine.leg_lengths):
        u = legs.s[i].T / length
        rod = u[:, i] ** 2 / STIFFNESS + length / (E * A)
        K += u[:, :, None] * u[:, None, :] / rod[:, None, None]
    np.testing.assert_allclose(np.linalg.inv(C[:, :3, :3]), K, rtol=1e-10, atol=1e-10 * np.abs(K).max())
    np.testing.assert_allclose(C[:, :3, 3:], 0.0, atol=1e-18)


def chain_by_the_paper(machine, i, pose, kind, *, feet):
    """K_i from the bordered matrix of eq. 6, its springs and joints placed one by one."""
    geometry = machine.geometry
    s = machine.closed_legs(pose[None]).s[i, :, 0]
    e, a = geometry.axes[i], geometry.revolutes[i]
    outer, inner = geometry.joints[i, :, 0] + s, geometry.joints[i, :, 0]
    x = -s / np.linalg.norm(s)
    z = np.cross(x, a) / np.linalg.norm(np.cross(x, a))
    y = np.cross(z, x)
    frame = np.array([x, y, z])

    def turn(axis, at):
        return np.concatenate([np.cross(axis, -at), axis])

    def spring(compliance, axes, at):
        # A motion (d, r) at `at` moves the tool, the origin, by d + r × (0 − at).
        shift = np.eye(6)
        shift[:3, 3:] = [[0, -at[2], at[1]], [at[2], 0, -at[0]], [-at[1], at[0], 0]]
        whole = shift @ np.kron(np.eye(2), axes.T)
        return whole @ compliance @ whole.T

    def bar(length, area, iy, iz, torsion, young, shear):
        c = np.diag([length / young / area, length**3 / 3 / young / iz, length**3 / 3 / young / iy, 0, 0, 0])
        c[3:, 3:] = np.diag([length / shear / torsion, length / young / iy, length / young / iz])
        c[1, 5] = c[5, 1] = length**2 / 2 / young / iz
        c[2, 4] = c[4, 2] = -(length**2) / 2 / young / iy
        return c

    def eq6(compliance, passive):
        J_q = np.array(passive).T
        scale = np.diag([1e4] * 6)
        k = J_q.shape[1]
        bordered = np.block([[scale @ compliance @ scale, J_q], [J_q.T, np.zeros((k, k))]])
        return scale @ np.linalg.inv(bordered)[:6, :6] @ scale

    drive = np.concatenate([e, np.zeros(3)])
    base = np.outer(drive, drive) / STIFFNESS
    if feet:
        along = -geometry.branches[i] * e
        across = np.cross(along, a) / np.linalg.norm(np.cross(along, a))
        axes = np.array([along, np.cross(across, along), across])
        h, w = 0.05, 0.03
        foot = bar(0.12, h * w, w * h**3 / 12, h * w**3 / 12, torsion_of_foot(h, w), E_FOOT, G_FOOT)
        base = base + spring(foot, axes, outer)
    one = bar(machine.leg_lengths[i], A, IY, IZ, J, E, G)
    if kind == "PUU":
        passive = [turn(axis, at) for axis in (a, z) for at in (outer, inner)]
        return eq6(base + spring(one, frame, inner), passive)
    bars = sum(
        eq6(
            spring(one, frame, inner + side * D_BARS / 2 * a),
            [turn(z, outer + side * D_BARS / 2 * a), turn(z, inner + side * D_BARS / 2 * a)],
        )
        for side in (1, -1)
    )
    sideways = np.concatenate([y, np.zeros(3)])
    soft = np.linalg.pinv(bars, rcond=1e-13, hermitian=True)
    return eq6(base + soft, [turn(a, outer), turn(a, inner), sideways])


def assert_same_blocks(found, expected):
    """Translation, rotation and their coupling, each beside its own size."""
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            size = np.sqrt(np.abs(expected[rows, rows]).max() * np.abs(expected[columns, columns]).max())
            np.testing.assert_allclose(found[rows, columns], expected[rows, columns], atol=1e-7 * size)


def torsion_of_foot(h, w):
    """Saint-Venant's series for a solid rectangle."""
    long, short = max(h, w), min(h, w)
    terms = sum(math.tanh(n * math.pi * long / 2 / short) / n**5 for n in range(1, 40, 2))
    return long * short**3 / 3 * (1 - 192 * short / math.pi**5 / long * terms)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("feet", [None, FOOT], ids=["rigid", "elastic"])
def test_orthoglide_is_the_sum_of_the_papers_chains(kind, feet):
    machine = orthoglide(kind, offset=0.03, feet=feet, lengths=(0.3, 0.32, 0.36), branch=(1, -1, 1))
    poses = random_poses(12, 2) * [1, -1, 1]
    for pose, C in zip(poses, machine.compliance(poses), strict=True):
        K = sum(chain_by_the_paper(machine, i, pose, kind, feet=feet) for i in range(3))
        assert_same_blocks(C, np.linalg.inv(K))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_linear_delta_is_the_sum_of_the_papers_chains(kind, tilt):
    machine = delta(kind, tilt=tilt, lengths=(0.5, 0.52, 0.55), feet=FOOT)
    for pose in random_poses(8, 3, (0.0, 0.0, -0.2)):
        K = sum(chain_by_the_paper(machine, i, pose, kind, feet=FOOT) for i in range(3))
        found, expected = machine.compliance(pose[None])[0], np.linalg.inv(K)
        np.testing.assert_allclose(
            found[:3, :3], expected[:3, :3], atol=1e-7 * np.abs(expected[:3, :3]).max()
        )
        np.testing.assert_allclose(
            found[3:, 3:], expected[3:, 3:], atol=1e-7 * np.abs(expected[3:, 3:]).max()
        )


@pytest.mark.parametrize("kind", KINDS)
def test_a_third_of_a_turn_maps_a_linear_delta_onto_itself(kind):
    machine, poses = delta(kind, tilt=0.2, feet=FOOT), random_poses(20, 4, (0.0, 0.0, -0.2))
    c, s = -0.5, math.sqrt(0.75)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    both = np.kron(np.eye(2), turn)
    expected = both @ machine.compliance(poses) @ both.T
    found = machine.compliance(poses @ turn.T)
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())


def test_rigid_legs_leave_the_drives_and_transmit_moments_rigidly():
    """C = J c_a Jᵀ, by virtual work, and no rotation."""
    legs = {"section": "rigid"}
    poses = random_poses(10, 5)
    for kind in KINDS:
        machine = orthoglide(kind, legs=legs)
        jacobian = np.linalg.inv(machine.inverse_jacobian(poses))
        C = machine.compliance(poses)
        expected = jacobian @ np.swapaxes(jacobian, 1, 2) / STIFFNESS
        np.testing.assert_allclose(C[:, :3, :3], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        np.testing.assert_allclose(C[:, 3:, :], 0.0, atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_chains_are_what_the_general_method_makes_of_them(kind):
    machine, poses = orthoglide(kind, legs={"section": "rigid"}, offset=0.04), random_poses(20, 8)
    units = prismatic.unit_legs(machine.geometry, machine.closed_legs(poses))
    general = parallel_compliance(*prismatic_elastic._chains(machine.geometry, machine.springs, units))
    found = machine.compliance(poses)
    np.testing.assert_allclose(found, general, rtol=1e-9, atol=1e-12 * np.abs(found).max())
    assert np.isnan(machine.compliance(np.array([[0.4, 0.4, 0.0]]))).all()


@pytest.mark.parametrize("feet", [None, FOOT])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("legs", [LEGS, {"section": "rigid"}])
def test_kernel_puts_the_chains_together_as_the_formulas_do(kind, feet, legs):
    options = {"legs": legs, "feet": feet, "lengths": (0.31, 0.34, 0.29)}
    for branch in ((1, 1, 1), (1, -1, 1)):
        machine = orthoglide(kind, offset=0.03, branch=branch, **options)
        poses = np.concatenate([random_poses(333, 9), [[0.4, 0.4, 0.0]]])
        geometry, springs, closed = machine.geometry, machine.springs, machine.closed_legs(poses)
        expected = prismatic_elastic._by_chains(geometry, springs, closed.s)
        sizes = np.linalg.norm(expected, axis=(1, 2))[:, None, None]
        found = machine.compliance(poses)
        np.testing.assert_allclose(found / sizes, expected / sizes, rtol=0.0, atol=1e-10)
        assert np.isnan(found[-1]).all()
        assert np.isfinite(found[:-1]).all()


def test_kernel_leaves_what_is_not_safe_to_the_general_method():
    """One slide's leg at right angles to its revolute axis is safe, along it no moment is left to turn it."""
    machine = orthoglide("PUU")
    along = machine.geometry.revolutes[0] * L
    legs = machine.closed_legs(np.zeros((3, 3)))
    legs.s[0, :, 1] = along
    found = prismatic_elastic.compliance(machine.geometry, machine.springs, legs)
    assert np.isfinite(found[[0, 2]]).all()
    np.testing.assert_array_equal(found[0], found[2])
    assert not np.isfinite(found[1]).any()


LEGS_OF_ZEROS = (
    np.zeros((3, 21)),
    np.zeros((3, 6, 6)),
    np.zeros((3, 3, 5)),
    np.zeros((5, 6, 6)),
    np.zeros(5, "?"),
)


@pytest.mark.parametrize(
    ("position", "shape", "message"),
    [
        (0, (3, 20), "legs has another shape than \\(3, 21\\)"),
        (1, (3, 6, 5), "feet has another shape"),
        (2, (3, 2, 5), "s has another shape"),
        (3, (4, 6, 6), "out has another shape"),
        (4, (4,), "safe has another shape"),
    ],
)
def test_kernel_refuses_arguments_of_another_shape(position, shape, message):
    arguments = list(LEGS_OF_ZEROS)
    arguments[position] = np.zeros(shape, arguments[position].dtype)
    with pytest.raises(ValueError, match=message):
        _kernels.legs_compliance(*arguments)


@pytest.mark.parametrize("kind", KINDS)
def test_compliance_is_symmetric_and_positive_in_reach_and_nan_out_of_it(kind):
    machine = orthoglide(kind, offset=0.02, feet=FOOT)
    C = machine.compliance(np.concatenate([random_poses(30, 6), [[0.4, 0.4, 0.0]]]))
    np.testing.assert_allclose(C[:-1], np.swapaxes(C[:-1], 1, 2), rtol=1e-9, atol=1e-20)
    assert (np.linalg.eigvalsh(C[:-1]) > 0).all()
    assert np.isnan(C[-1]).all()

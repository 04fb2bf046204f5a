"""The family of prismatic-leg machines: loops close, J⁻¹ is the derivative, margins have the right signs."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.mechanics import prismatic
from orthospec.mechanics.prismatic import CLEARANCE, PrismaticLegs

seeds = st.integers(0, 2**32 - 1)


def random_machine(random: np.random.Generator) -> PrismaticLegs:
    """Tilted rails, as of a linear Delta that somebody leaned against."""
    axes = np.eye(3) + random.uniform(-0.3, 0.3, (3, 3))
    return PrismaticLegs(
        axes=axes / np.linalg.norm(axes, axis=1)[:, None],
        bases=random.uniform(-0.2, 0.2, (3, 3, 1)),
        joints=random.uniform(-0.2, 0.2, (3, 3, 1)),
        lengths=random.uniform(1.0, 2.0, (3, 1)),
        branches=random.choice([1.0, -1.0], 3),
        revolutes=np.roll(np.eye(3), 1, axis=0),
        home=np.eye(3),
    )


def orthogonal_machine(length: float) -> PrismaticLegs:
    return PrismaticLegs(
        axes=np.eye(3),
        bases=np.zeros((3, 3, 1)),
        joints=np.zeros((3, 3, 1)),
        lengths=np.full((3, 1), length),
        branches=np.ones(3),
        revolutes=np.roll(np.eye(3), 1, axis=0),
        home=np.eye(3),
    )


def exact_sliders(machine: PrismaticLegs, pose) -> list:
    """The root of |b + ρe − p − c|² = L² on the branch's side, in 50 digits."""
    found = []
    for e, b, c, length, sign in zip(*machine[:5], strict=True):
        d = [mpmath.mpf(float(c[k, 0])) - mpmath.mpf(float(b[k, 0])) + pose[k] for k in range(3)]
        half = sum(mpmath.mpf(float(e[k])) * d[k] for k in range(3))
        square = sum(mpmath.mpf(float(e[k])) ** 2 for k in range(3))
        rest = sum(x * x for x in d) - mpmath.mpf(float(length[0])) ** 2
        found.append((half + int(sign) * mpmath.sqrt(half**2 - square * rest)) / square)
    return found


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_legs_have_their_lengths_and_stand_on_their_branch(seed):
    random = np.random.default_rng(seed)
    machine, poses = random_machine(random), random.uniform(-0.3, 0.3, (20, 3))
    legs = prismatic.close(machine, poses)
    lengths = np.linalg.norm(legs.s, axis=1)
    np.testing.assert_allclose(lengths, np.tile(machine.lengths, 20), rtol=1e-12)
    along = np.einsum("ikn,ik->ni", legs.s, machine.axes)
    np.testing.assert_allclose(legs.along, along.T, rtol=1e-9)
    assert (along * machine.branches > 0).all()


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_inverse_jacobian_is_the_derivative_of_the_sliders(seed):
    random = np.random.default_rng(seed)
    machine, poses = random_machine(random), random.uniform(-0.3, 0.3, (1, 3))
    found = prismatic.inverse_jacobian(prismatic.close(machine, poses))[0]
    h = mpmath.mpf(10) ** -16
    for k in range(3):
        ends = []
        for step in (h, -h):
            pose = [mpmath.mpf(float(x)) for x in poses[0]]
            pose[k] += step
            ends.append(exact_sliders(machine, pose))
        slope = [float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)]
        np.testing.assert_allclose(found[:, k], slope, rtol=1e-9, atol=1e-9)


def test_a_leg_too_short_gives_nan_without_a_warning():
    machine = random_machine(np.random.default_rng(1))
    far = np.array([[5.0, 5.0, 5.0], [0.0, 0.0, 0.0]])
    legs = prismatic.close(machine, far)
    assert np.isnan(legs.rho[0]).any()
    assert np.isfinite(legs.rho[1]).all()
    assert (prismatic.leg_margins(machine, legs)[:, 0] < 0).any()
    assert np.isnan(prismatic.inverse_jacobian(legs)[0]).any()


@pytest.mark.parametrize("clear", [0.5, 2.0])
def test_leg_margin_changes_sign_at_the_clearance_from_the_serial_singularity(clear):
    machine = orthogonal_machine(2.0)
    # Leg 1 makes the angle asin(clear·CLEARANCE) with the plane across its slide.
    y = 2.0 * np.sqrt(1 - (clear * CLEARANCE) ** 2)
    margin = prismatic.leg_margins(machine, prismatic.close(machine, np.array([[0.0, y, 0.0]])))[0, 0]
    assert margin == pytest.approx((clear**2 - 1) * CLEARANCE**2, rel=1e-4)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_volume_margin_has_the_sign_of_the_determinant(seed):
    random = np.random.default_rng(seed)
    machine, poses = random_machine(random), random.uniform(-1.0, 1.0, (200, 3))
    poses = poses[np.isfinite(prismatic.close(machine, poses).rho).all(axis=1)]
    legs = prismatic.close(machine, poses)
    determinant = np.linalg.det(prismatic.inverse_jacobian(legs))
    units = prismatic.unit_legs(machine, legs)
    for home in (np.eye(3), -np.eye(3)):
        margin = prismatic.volume_margin(units, home)
        assert np.abs(margin).max() <= 1 + 1e-12
        clear = np.abs(margin) > 1e-12
        np.testing.assert_array_equal(np.sign(margin[clear]), home[0, 0] * np.sign(determinant[clear]))


def margins_at(machine: PrismaticLegs, poses):
    units = prismatic.unit_legs(machine, prismatic.close(machine, poses))
    return prismatic.volume_margin(units, machine.home), prismatic.pairs_margin(units, machine.home)


def test_pairs_margin_is_three_where_the_legs_lie_along_their_slides():
    _, pairs = margins_at(orthogonal_machine(1.3), np.zeros((1, 3)))
    assert pairs[0] == pytest.approx(3.0)


def test_pairs_margin_passes_zero_where_the_sliders_meet_though_the_determinant_keeps_its_sign():
    machine = orthogonal_machine(2.0)
    towards = np.array([[-1.0, -1.1, -0.8]]) / np.linalg.norm([1.0, 1.1, 0.8])
    volume, pairs = margins_at(machine, 2.0 * towards * np.array([[0.999], [1.0], [1.001]]))
    assert (volume > -1e-15).all()
    assert volume[1] == pytest.approx(0.0, abs=1e-15)
    assert pairs[0] > 1e-4
    assert pairs[1] == pytest.approx(0.0, abs=1e-14)
    assert pairs[2] < -1e-4


def test_pairs_margin_leaves_out_nothing_that_equal_legs_can_reach():
    """Inside |p| = L the determinant alone decides."""
    poses = np.random.default_rng(8).uniform(-1, 1, (100_000, 3))
    poses = poses[np.linalg.norm(poses, axis=1) < 1]
    volume, pairs = margins_at(orthogonal_machine(1.0), poses)
    known = np.isfinite(volume)
    assert (pairs[known & (volume > 0)] > 0).all()


def as_one_for_each(machine: PrismaticLegs, count: int) -> PrismaticLegs:
    """The same machine as one of many, which no kernel serves."""
    alike = {
        name: np.repeat(getattr(machine, name), count, axis=-1) for name in ("bases", "joints", "lengths")
    }
    return machine._replace(**alike)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_kernels_close_legs_and_tell_margins_as_the_formulas_do(seed):
    random = np.random.default_rng(seed)
    machine, poses = random_machine(random), random.uniform(-2, 2, (300, 3))
    many = as_one_for_each(machine, len(poses))
    fast, plain = prismatic.close(machine, poses), prismatic.close(many, poses)
    for one, other in zip(fast, plain, strict=True):
        # Where a loop is about to open, the root makes of rounding its square root.
        known = np.isfinite(one) & np.isfinite(other)
        assert (known == np.isfinite(other)).mean() > 0.99
        np.testing.assert_allclose(one[known], other[known], rtol=1e-6, atol=1e-12)
    margins, expected = prismatic.margins(machine, plain), prismatic.margins(many, plain)
    assert margins.keys() == expected.keys()
    for name, margin in margins.items():
        np.testing.assert_allclose(margin, expected[name], rtol=1e-12, atol=1e-13, err_msg=name)

"""Kinematic measures: values against numpy's SVD, and convex forms that say the same as the values."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.composite.template import compile_form
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures.demand import bounded_side
from orthospec.measures.kinematic import (
    ConditionNumber,
    Manipulability,
    VelocityTransmission,
    logarithmic_stretch,
    transmission_factors,
)

SIDES = [
    (VelocityTransmission(), "at_least"),
    (VelocityTransmission(), "at_most"),
    (ConditionNumber(), "at_most"),
    (Manipulability(), "at_least"),
]
MEASURES = [VelocityTransmission(), ConditionNumber(), Manipulability()]
seeds = st.integers(0, 2**32 - 1)


def machine_with(inverse_jacobians):
    """A machine that has these J⁻¹ whatever the poses."""
    return SimpleNamespace(inverse_jacobian=lambda _: np.asarray(inverse_jacobians, dtype=float))


def with_singular_values(sigma, seed):
    """J⁻¹ of a J with these singular values, turned at random."""
    random = np.random.default_rng(seed)
    u, v = (np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(2))
    return (u / np.asarray(sigma)) @ v


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(0.01, 100.0), min_size=3, max_size=3), seeds)
def test_values_are_functions_of_the_singular_values(sigma, seed):
    machine, poses = machine_with([with_singular_values(sigma, seed)]), np.zeros((1, 3))
    low, _, high = sorted(sigma)
    np.testing.assert_allclose(VelocityTransmission().values(machine, poses), [[low, high]], rtol=1e-8)
    np.testing.assert_allclose(ConditionNumber().values(machine, poses), [high / low], rtol=1e-8)
    np.testing.assert_allclose(Manipulability().values(machine, poses), [np.prod(sigma)], rtol=1e-8)


def test_values_equal_numpys_svd_over_the_orthoglides_poses():
    machine = Orthoglide(leg_lengths=(1.0, 1.2, 0.9))
    poses = np.random.default_rng(0).uniform(-0.5, 0.35, (2000, 3))
    sigma = np.linalg.svd(np.linalg.inv(machine.inverse_jacobian(poses)), compute_uv=False)
    np.testing.assert_allclose(VelocityTransmission().values(machine, poses), sigma[:, [2, 0]], rtol=1e-9)
    np.testing.assert_allclose(ConditionNumber().values(machine, poses), sigma[:, 0] / sigma[:, 2], rtol=1e-9)
    np.testing.assert_allclose(Manipulability().values(machine, poses), sigma.prod(axis=1), rtol=1e-9)


@pytest.mark.parametrize("sigma", [(0.5, 2.0, 2.0), (0.7, 0.7, 3.0), (1.0, 1.0, 1.0)])
def test_repeated_singular_values_keep_their_digits(sigma):
    inverse = np.array([with_singular_values(sigma, seed) for seed in range(50)])
    np.testing.assert_allclose(transmission_factors(inverse), np.tile(sorted(sigma), (50, 1)), rtol=1e-13)


@pytest.mark.parametrize("singular", [np.diag([1.0, 1.0, 0.0]), np.diag([2.0, 0.0, 0.0])])
def test_parallel_singularity_is_infinite(singular):
    machine, poses = machine_with([singular]), np.zeros((1, 3))
    factors = VelocityTransmission().values(machine, poses)[0]
    assert factors[0] == pytest.approx(1 / singular.max())
    assert factors[1] == np.inf
    assert ConditionNumber().values(machine, poses)[0] == np.inf
    assert Manipulability().values(machine, poses)[0] == np.inf


def test_nearly_singular_values_are_not_squared():
    inverse = with_singular_values((0.5, 1.0, 1e9), 4)[None]
    np.testing.assert_allclose(transmission_factors(inverse)[0], [0.5, 1.0, 1e9], rtol=1e-6)


@pytest.mark.parametrize("measure", MEASURES)
def test_nan_in_gives_nan_out_and_leaves_the_neighbours(measure):
    inverse = np.stack([np.eye(3), np.full((3, 3), np.nan), np.eye(3)])
    values = measure.values(machine_with(inverse), np.zeros((3, 3)))
    assert np.isnan(values[1]).all()
    np.testing.assert_array_equal(values[[0, 2]], np.ones_like(values[[0, 2]]))


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3), seeds)
def test_stretch_has_the_logarithms_of_the_singular_values(sigma, seed):
    stretch = logarithmic_stretch(with_singular_values(sigma, seed)[None])[0]
    np.testing.assert_array_equal(stretch, stretch.T)
    np.testing.assert_allclose(np.linalg.eigvalsh(stretch), np.log(sorted(sigma)), atol=1e-11)


def test_stretch_of_what_is_not_finite_is_nan():
    inverse = np.stack([np.eye(3), np.full((3, 3), np.nan), np.full((3, 3), np.inf)])
    stretch = logarithmic_stretch(inverse)
    np.testing.assert_array_equal(stretch[0], np.zeros((3, 3)))
    assert np.isnan(stretch[1:]).all()


def test_stretch_equals_fifty_digits(exact):
    machine = Orthoglide(leg_lengths=(1.0, 1.2, 0.9))
    poses = np.random.default_rng(5).uniform(-0.4, 0.3, (5, 3))
    found = logarithmic_stretch(machine.inverse_jacobian(poses))
    for pose, stretch in zip(poses, found, strict=True):
        wanted = exact.stretch(exact.inverse_jacobian((1.0, 1.2, 0.9), [float(p) for p in pose]))
        np.testing.assert_allclose(stretch, np.array(wanted.tolist(), dtype=float), rtol=0, atol=1e-13)


@pytest.mark.parametrize(("measure", "side"), SIDES)
def test_slack_of_the_form_is_the_logarithm_of_value_over_bound(least_slack, measure, side):
    """Feasible without slack exactly where the value is within the bound; slack s is worth the factor e^s."""
    machine = Orthoglide(leg_lengths=(1.0, 1.2, 0.9))
    poses = np.random.default_rng(6).uniform(-0.4, 0.3, (12, 3))
    values = bounded_side(measure.values(machine, poses), side)
    form = measure.form(machine, poses, side)
    template = compile_form(form.holds, form.inside.shape[1:])
    sign = 1.0 if side == "at_most" else -1.0
    for inside, value in zip(form.inside, values, strict=True):
        for ratio in (0.5, 0.9, 0.999, 1.001, 1.1, 2.0):
            bound = value * ratio**-sign
            assert least_slack(template, inside, bound) == pytest.approx(max(0.0, np.log(ratio)), abs=1e-8)


@pytest.mark.parametrize(("measure", "side"), SIDES)
def test_form_takes_a_plain_number_as_its_bound(measure, side):
    """As a plugin's author tries it by hand: constraints of one inside, with constants."""
    import cvxpy as cp

    machine = Orthoglide(leg_lengths=(1.0, 1.2, 0.9))
    pose = np.array([[0.1, -0.2, 0.15]])
    value = float(bounded_side(measure.values(machine, pose), side)[0])
    form = measure.form(machine, pose, side)
    sign = 1.0 if side == "at_most" else -1.0
    for ratio, feasible in ((0.99, True), (1.01, False)):
        constraints = form.holds(cp.Constant(form.inside[0]), value * ratio**-sign, 0.0)
        assert all(bool(constraint.value(1e-9)) for constraint in constraints) is feasible


def test_sides_that_mean_nothing_are_not_offered():
    assert ConditionNumber.sides == {"at_most"}
    assert Manipulability.sides == {"at_least"}
    assert VelocityTransmission.sides == {"at_least", "at_most"}

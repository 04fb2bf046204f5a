"""Elastic measures: values against norms and sampled loads, forms that say the same as the values."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from orthospec.composite.template import compile_form
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures.elastic import Deflection, Rotation, RotationalStiffness, Stiffness

WRENCH = (20.0, -5.0, 30.0, 1.0, 2.0, -0.5)
MOMENT = (0.0, 0.0, 0.0, 1.0, 2.0, -0.5)
AT_MOST = {
    "deflection by a force": Deflection(force=100.0),
    "deflection by a wrench": Deflection(wrench=WRENCH),
    "deflection by a moment": Deflection(wrench=MOMENT),
    "rotation by a torque": Rotation(torque=3.0),
    "rotation by a force": Rotation(force=100.0),
    "rotation by a wrench": Rotation(wrench=WRENCH),
}
AT_LEAST = {"stiffness": Stiffness(), "rotational stiffness": RotationalStiffness()}
MEASURES = AT_MOST | AT_LEAST
seeds = st.integers(0, 2**32 - 1)
POSE = np.zeros((1, 3))


def machine_with(*compliances):
    """A machine that has these compliances whatever the poses."""
    return SimpleNamespace(compliance=lambda _: np.array(compliances, dtype=float))


def compliance_of(seed):
    """A compliance of the size that machine tools have: some um/N, coupled over some 0.3 m."""
    root = np.random.default_rng(seed).normal(size=(6, 9)) * np.repeat([1e-4, 4e-4], 3)[:, None]
    return root @ root.T


def side_of(name):
    return "at_most" if name in AT_MOST else "at_least"


def value_of(measure, compliance):
    return float(measure.values(machine_with(compliance), POSE)[0])


def directions(count):
    vectors = np.random.default_rng(7).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_values_are_norms_of_the_blocks(seed):
    c = compliance_of(seed)
    tt, rt, rr = c[:3, :3], c[3:, :3], c[3:, 3:]
    wanted = {
        "deflection by a force": 100.0 * np.linalg.norm(tt, 2),
        "deflection by a wrench": np.linalg.norm((c @ WRENCH)[:3]),
        "deflection by a moment": np.linalg.norm((c @ MOMENT)[:3]),
        "rotation by a torque": 3.0 * np.linalg.norm(rr, 2),
        "rotation by a force": 100.0 * np.linalg.norm(rt, 2),
        "rotation by a wrench": np.linalg.norm((c @ WRENCH)[3:]),
        "stiffness": 1 / np.linalg.norm(tt, 2),
        "rotational stiffness": 1 / np.linalg.norm(rr, 2),
    }
    for name, measure in MEASURES.items():
        assert value_of(measure, c) == pytest.approx(wanted[name], rel=1e-12), name


@pytest.mark.parametrize(
    ("worst", "part", "of_force"),
    [
        (Deflection(force=10.0), slice(0, 3), True),
        (Rotation(force=10.0), slice(3, 6), True),
        (Rotation(torque=10.0), slice(3, 6), False),
    ],
)
def test_no_direction_of_the_load_is_worse_than_the_worst(worst, part, of_force):
    c = compliance_of(3)
    given_by = c[part, :3] if of_force else c[part, 3:]
    moved = np.linalg.norm(10.0 * directions(5000) @ given_by.T, axis=1)
    value = value_of(worst, c)
    assert moved.max() <= value * (1 + 1e-12)
    assert moved.max() == pytest.approx(value, rel=1e-2)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_stiffness_is_that_of_the_machine_with_its_rotations_free(seed):
    c = compliance_of(seed)
    k = np.linalg.inv(c)
    free = k[:3, :3] - k[:3, 3:] @ np.linalg.inv(k[3:, 3:]) @ k[3:, :3]
    assert value_of(Stiffness(), c) == pytest.approx(np.linalg.eigvalsh(free)[0], rel=1e-8)
    assert value_of(Stiffness(), c) >= np.linalg.eigvalsh(k)[0]


def test_stiffness_is_a_force_over_what_it_deflects():
    c = compliance_of(4)
    deflection, rotation = value_of(Deflection(force=50.0), c), value_of(Rotation(torque=2.0), c)
    assert value_of(Stiffness(), c) == pytest.approx(50.0 / deflection, rel=1e-14)
    assert value_of(RotationalStiffness(), c) == pytest.approx(2.0 / rotation, rel=1e-14)


@pytest.mark.parametrize("name", MEASURES)
def test_a_loose_machine_violates_and_nan_stays_nan(name):
    c = compliance_of(5)
    machine = machine_with(c, np.full((6, 6), np.inf), np.full((6, 6), np.nan), c)
    values = MEASURES[name].values(machine, np.zeros((4, 3)))
    assert values[1] == (np.inf if name in AT_MOST else 0.0)
    assert np.isnan(values[2])
    np.testing.assert_array_equal(values[[0, 3]], np.full(2, value_of(MEASURES[name], c)))
    inside = MEASURES[name].form(machine, np.zeros((4, 3)), side_of(name)).inside
    unknown = np.isnan(inside).any(axis=tuple(range(1, inside.ndim)))
    np.testing.assert_array_equal(unknown, [False, True, True, False])


@pytest.mark.parametrize("name", MEASURES)
def test_slack_of_the_form_is_the_logarithm_of_value_over_bound(least_slack, name):
    measure, side = MEASURES[name], side_of(name)
    sign = 1.0 if side == "at_most" else -1.0
    machine = machine_with(*(compliance_of(seed) for seed in range(6)))
    form = measure.form(machine, np.zeros((6, 3)), side)
    template = compile_form(form.holds, form.inside.shape[1:])
    for inside, value in zip(form.inside, measure.values(machine, np.zeros((6, 3))), strict=True):
        for ratio in (0.5, 0.999, 1.001, 2.0):
            needed = least_slack(template, inside, value * ratio**-sign)
            assert needed == pytest.approx(max(0.0, np.log(ratio)), abs=1e-8)


@pytest.mark.parametrize("name", MEASURES)
def test_form_takes_a_plain_number_as_its_bound(name):
    import cvxpy as cp

    measure, c = MEASURES[name], compliance_of(8)
    form = measure.form(machine_with(c), POSE, side_of(name))
    sign = 1.0 if name in AT_MOST else -1.0
    for ratio, feasible in ((0.99, True), (1.01, False)):
        bound = value_of(measure, c) * ratio**-sign
        constraints = form.holds(cp.Constant(form.inside[0]), bound, 0.0)
        assert all(bool(np.all(constraint.value(1e-9))) for constraint in constraints) is feasible


@pytest.mark.parametrize("measure", [Deflection(wrench=MOMENT), Rotation(force=100.0)])
def test_a_coupling_that_is_only_rounding_leaves_the_form_flat(measure):
    """A machine whose legs meet in the tool point has none: its logarithm would be noise."""
    c = np.kron(np.diag([1e-7, 1e-6]), np.eye(3))
    noisy = [c.copy() for _ in range(10)]
    for one, noise in zip(noisy, 1e-22 * np.random.default_rng(9).normal(size=(10, 3, 3)), strict=True):
        one[:3, 3:], one[3:, :3] = noise, noise.T
    assert value_of(measure, c) == 0.0
    inside = measure.form(machine_with(c, *noisy), np.zeros((11, 3)), "at_most").inside
    np.testing.assert_allclose(inside, np.tile(inside[0], (11, 1)), atol=1e-7)


def test_a_machine_that_cannot_turn_has_no_rotation_and_meets_any_bound(least_slack):
    c = np.zeros((6, 6))
    c[:3, :3] = 1e-7 * np.eye(3)
    assert value_of(RotationalStiffness(), c) == np.inf
    for measure in (Rotation(torque=1.0), Rotation(force=1.0), Rotation(wrench=WRENCH)):
        assert value_of(measure, c) == 0.0
        form = measure.form(machine_with(c), POSE, "at_most")
        template = compile_form(form.holds, form.inside.shape[1:])
        assert least_slack(template, form.inside[0], 1e-12) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("legs", [{"kind": "PUU"}, {"kind": "PRPaR", "spacing": 0.08}])
def test_an_orthoglide_of_rigid_legs_turns_nowhere_and_gives_as_its_actuators_do(legs):
    machine = Orthoglide.model_validate(
        {
            "leg_lengths": [0.31, 0.35, 0.4],
            "legs": {**legs, "section": "rigid", "offset": 0.03},
            "actuators": {"stiffness": 5e7},
        }
    )
    poses = np.random.default_rng(3).uniform(-0.1, 0.05, (200, 3))
    assert np.isposinf(RotationalStiffness().values(machine, poses)).all()
    assert np.isfinite(RotationalStiffness().form(machine, poses, "at_least").inside).all()
    slowest = 1 / np.linalg.svd(machine.inverse_jacobian(poses), compute_uv=False)[:, -1]
    np.testing.assert_allclose(Stiffness().values(machine, poses), 5e7 / slowest**2, rtol=1e-9)


def test_the_same_compliance_in_every_direction_keeps_its_digits():
    c = np.kron(np.diag([3e-7, 2e-6]), np.eye(3))
    assert value_of(Deflection(force=100.0), c) == pytest.approx(3e-5, rel=1e-15)
    assert value_of(Rotation(torque=10.0), c) == pytest.approx(2e-5, rel=1e-15)


@pytest.mark.parametrize(
    ("measure", "keys", "message"),
    [
        (Deflection, {}, "one of 'force' and 'wrench' was expected, none given"),
        (
            Deflection,
            {"force": 1.0, "wrench": WRENCH},
            "one of 'force' and 'wrench' was expected, 'force' and 'wrench' given",
        ),
        (Rotation, {}, "one of 'torque', 'force' and 'wrench' was expected, none given"),
        (Rotation, {"torque": 1.0, "force": 1.0}, "was expected, 'torque' and 'force' given"),
        (Deflection, {"wrench": (0.0,) * 6}, "a wrench with a force or a moment in it was expected"),
        (Deflection, {"force": 0.0}, "greater than 0"),
        (Deflection, {"force": "100 N*m"}, "is a torque, a force [N] was expected"),
        (Deflection, {"wrench": [1, 2, 3, "1 N", 0, 0]}, "is a force, a torque [N*m] was expected"),
    ],
)
def test_a_load_is_given_once_and_in_its_unit(measure, keys, message):
    with pytest.raises(ValidationError) as refused:
        measure.model_validate(keys)
    assert message in str(refused.value)

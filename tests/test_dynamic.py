"""Dynamic measures: exact figures of massless legs, sampled directions, and forms that say the same."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from orthospec.composite.template import compile_form
from orthospec.manipulators.base import ActuatorLimits
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures.dynamic import (
    Acceleration,
    ActuatorForce,
    DynamicIsotropy,
    GieNorm,
    JointSpeed,
    ToolSpeed,
)

MEASURES = {
    "gie_norm": (GieNorm(), "at_most"),
    "dynamic_isotropy": (DynamicIsotropy(), "at_most"),
    "acceleration, box": (Acceleration(), "at_least"),
    "acceleration, ellipsoid": (Acceleration(ball="ellipsoid"), "at_least"),
    "joint_speed": (JointSpeed(speed=1.5), "at_most"),
    "tool_speed": (ToolSpeed(), "at_least"),
    "actuator_force from rest": (ActuatorForce(acceleration=10.0), "at_most"),
    "actuator_force": (ActuatorForce(acceleration=10.0, speed=2.0), "at_most"),
    "actuator_force of speed alone": (ActuatorForce(acceleration=0.0, speed=2.0), "at_most"),
}
seeds = st.integers(0, 2**32 - 1)
POSE = np.zeros((1, 3))


def machine_with(inverse, inertia, *, force=np.inf, speed=np.inf, friction=0.0, rest=0.0, bends=0.0):
    """A machine with these matrices (n, 3, 3), whatever the poses."""
    n = len(inverse)
    limits = ActuatorLimits(*(np.broadcast_to(np.asarray(one, float), 3) for one in (force, speed, friction)))
    return SimpleNamespace(
        inverse_jacobian=lambda _: inverse,
        joint_inertia=lambda _: inertia,
        rest_load=lambda _: np.broadcast_to(np.asarray(rest, float), (n, 3)),
        velocity_forces=lambda _: np.broadcast_to(np.asarray(bends, float), (n, 3, 3, 3)),
        actuator_limits=lambda: limits,
    )


def machine_of(seed):
    """Any machine: three actuators that differ, gravity, friction and velocity forces."""
    random = np.random.default_rng(seed)
    root, bends = random.normal(size=(3, 4)), random.normal(size=(1, 3, 3, 3))
    return machine_with(
        np.eye(3)[None] + 0.3 * random.normal(size=(1, 3, 3)),
        (root @ root.T + np.eye(3))[None],
        force=random.uniform(100, 200, 3),
        speed=random.uniform(1, 3, 3),
        friction=random.uniform(0, 10, 3),
        rest=random.uniform(-20, 20, (1, 3)),
        bends=3 * (bends + np.swapaxes(bends, 2, 3)),
    )


def massless_legs(q):
    """The 200 mm Orthoglide at (q, q, q): 1 kg at the tool, 2 kg and 100 N at each slider."""
    length = 0.3105828541230249
    u = q / np.sqrt(length**2 - 2 * q**2)
    inverse = ((1 + u) * np.eye(3) - u)[None]
    jacobian = np.linalg.inv(inverse)
    return machine_with(inverse, jacobian @ jacobian + 2 * np.eye(3), force=100.0)


def value_of(measure, machine):
    return float(measure.values(machine, POSE)[0])


def directions(count):
    vectors = np.random.default_rng(7).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("q", "mass", "acceleration"),
    [(0.0, 3.0, 100 / 3), (0.0732050, 4.1250, 31.2195), (-0.1267949, 9.0000, 28.0056)],
)
def test_massless_legs_have_their_exact_figures(q, mass, acceleration):
    machine = massless_legs(q)
    assert value_of(GieNorm(), machine) == pytest.approx(mass, abs=1e-4)
    assert value_of(Acceleration(), machine) == pytest.approx(acceleration, abs=1e-4)


def test_the_isotropic_pose_is_isotropic():
    machine = massless_legs(0.0)
    assert value_of(DynamicIsotropy(), machine) == pytest.approx(1.0, rel=1e-14)
    assert value_of(Acceleration(ball="ellipsoid"), machine) == pytest.approx(100 / 3, rel=1e-14)
    assert value_of(JointSpeed(speed=2.0), machine) == pytest.approx(2.0, rel=1e-15)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_the_masses_are_those_of_the_kinetic_energy(seed):
    machine = machine_of(seed)
    rates = directions(4000) @ machine.inverse_jacobian(POSE)[0].T
    masses = np.einsum("ki,ij,kj->k", rates, machine.joint_inertia(POSE)[0], rates)
    assert masses.max() <= value_of(GieNorm(), machine) * (1 + 1e-12)
    assert masses.max() == pytest.approx(value_of(GieNorm(), machine), rel=0.02)
    inverse = machine.inverse_jacobian(POSE)[0]
    gie = inverse.T @ machine.joint_inertia(POSE)[0] @ inverse
    assert value_of(DynamicIsotropy(), machine) == pytest.approx(np.linalg.cond(gie), rel=1e-9)


def forces_of(machine, accelerations, speeds):
    """Actuator forces (k, 3) of tool accelerations and speeds (k, 3), friction left out."""
    rows = (machine.joint_inertia(POSE) @ machine.inverse_jacobian(POSE))[0]
    bends = np.einsum("ka,iab,kb->ki", speeds, machine.velocity_forces(POSE)[0], speeds)
    return accelerations @ rows.T + bends + machine.rest_load(POSE)[0]


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_the_guaranteed_acceleration_can_be_had_in_every_direction_and_no_more(seed):
    machine = machine_of(seed)
    limits = machine.actuator_limits()
    radius = value_of(Acceleration(), machine)
    rows = (machine.joint_inertia(POSE) @ machine.inverse_jacobian(POSE))[0]
    worst = np.concatenate([rows, -rows]) / np.tile(np.linalg.norm(rows, axis=1), 2)[:, None]
    tries = np.concatenate([directions(1000), worst])
    forces = np.abs(forces_of(machine, radius * tries, np.zeros_like(tries))) + limits.friction
    assert (forces <= limits.forces * (1 + 1e-12)).all()
    assert (forces / limits.forces).max() == pytest.approx(1.0, rel=1e-12)


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_the_ellipsoid_of_accelerations_lies_in_the_box(seed):
    machine = machine_of(seed)
    limits = machine.actuator_limits()
    left = limits.forces - limits.friction - np.abs(machine.rest_load(POSE)[0])
    to_tool = np.linalg.inv(machine.joint_inertia(POSE)[0] @ machine.inverse_jacobian(POSE)[0])
    wanted = np.linalg.svd(to_tool * left, compute_uv=False)[-1]
    assert value_of(Acceleration(ball="ellipsoid"), machine) == pytest.approx(wanted, rel=1e-9)
    assert wanted <= value_of(Acceleration(), machine) * (1 + 1e-12)


@pytest.mark.parametrize("ball", ["box", "ellipsoid"])
def test_a_machine_that_its_actuators_cannot_hold_has_no_acceleration_to_give(ball):
    machine = machine_with(np.eye(3)[None], 2 * np.eye(3)[None], force=10.0, friction=1.0, rest=(0, 0, 13.0))
    measure = Acceleration(ball=ball)
    assert value_of(measure, machine) == pytest.approx(-2.0)
    held, weaker = (
        measure.form(
            machine_with(np.eye(3)[None], 2 * np.eye(3)[None], force=10.0, friction=1.0, rest=(0, 0, load)),
            POSE,
            "at_least",
        ).inside
        for load in (8.99, 13.0)
    )
    assert np.isfinite([held, weaker]).all()
    assert np.min(weaker) < np.min(held) - 10


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_no_direction_asks_for_more_joint_speed_or_gives_less_tool_speed(seed):
    machine = machine_of(seed)
    rows = machine.inverse_jacobian(POSE)[0]
    worst = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    rates = np.abs(np.concatenate([directions(1000), worst]) @ rows.T)
    assert value_of(JointSpeed(speed=1.5), machine) == pytest.approx(1.5 * rates.max(), rel=1e-12)
    slowest = (machine.actuator_limits().speeds / rates).min()
    assert value_of(ToolSpeed(), machine) == pytest.approx(slowest, rel=1e-12)


@settings(max_examples=50, deadline=None)
@given(seeds, st.floats(0, 20), st.floats(0, 3))
def test_the_force_asked_for_is_the_worst_over_independent_directions(seed, acceleration, speed):
    machine = machine_of(seed)
    rows = (machine.joint_inertia(POSE) @ machine.inverse_jacobian(POSE))[0]
    along = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    ways = np.concatenate([np.linalg.eigh(bend)[1].T for bend in machine.velocity_forces(POSE)[0]])
    ways = np.concatenate([ways, 0.5 * ways, np.zeros((1, 3))])
    a = np.repeat(np.concatenate([along, -along, directions(50)]), len(ways), axis=0)
    v = np.tile(ways, (56, 1))
    forces = np.abs(forces_of(machine, acceleration * a, speed * v)) + machine.actuator_limits().friction
    measure = ActuatorForce(acceleration=acceleration, speed=speed)
    assert value_of(measure, machine) == pytest.approx(forces.max(), rel=1e-12)


@pytest.mark.parametrize(("speed", "force"), [(0.5, 35.0), (3.0, 35.0), (4.0, 71.0)])
def test_a_force_that_speed_takes_from_the_load_is_asked_for_at_rest(least_slack, speed, force):
    """30 N at rest, 5 N of push, and −3 ... −6 N at 1 m/s: 35 N, until the other sign is worse."""
    bends = -np.diag([3.0, 5.0, 6.0]) * np.ones((1, 3, 1, 1))
    machine = machine_with(np.eye(3)[None], np.eye(3)[None], rest=(30, 30, 30), bends=bends)
    measure = ActuatorForce(acceleration=5.0, speed=speed)
    assert value_of(measure, machine) == pytest.approx(force, rel=1e-12)
    form = measure.form(machine, POSE, "at_most")
    template = compile_form(form.holds, form.inside.shape[1:])
    assert least_slack(template, form.inside[0], force / 2) == pytest.approx(np.log(2), abs=1e-8)


def test_a_tool_that_is_held_still_asks_for_gravity_and_friction():
    machine = machine_with(np.eye(3)[None], np.eye(3)[None], rest=(0, 5, -30), friction=2.0)
    assert value_of(ActuatorForce(acceleration=0.0), machine) == 32.0
    assert value_of(ActuatorForce(acceleration=0.0, speed=1.0), machine) == pytest.approx(32.0)


@pytest.mark.parametrize("name", MEASURES)
def test_slack_of_the_form_is_the_logarithm_of_value_over_bound(least_slack, name):
    measure, side = MEASURES[name]
    sign = 1.0 if side == "at_most" else -1.0
    for machine in map(machine_of, range(4)):
        form, value = measure.form(machine, POSE, side), value_of(measure, machine)
        template = compile_form(form.holds, form.inside.shape[1:])
        for ratio in (0.5, 0.999, 1.001, 2.0):
            needed = least_slack(template, form.inside[0], value * ratio**-sign)
            assert needed == pytest.approx(max(0.0, np.log(ratio)), abs=1e-8)


@pytest.mark.parametrize("name", MEASURES)
def test_form_takes_a_plain_number_as_its_bound(name):
    import cvxpy as cp

    measure, side = MEASURES[name]
    machine = machine_of(8)
    form = measure.form(machine, POSE, side)
    sign = 1.0 if side == "at_most" else -1.0
    for ratio, feasible in ((0.99, True), (1.01, False)):
        bound = value_of(measure, machine) * ratio**-sign
        constraints = form.holds(cp.Constant(form.inside[0]), bound, 0.0)
        assert all(bool(np.all(constraint.value(1e-9))) for constraint in constraints) is feasible


@pytest.mark.parametrize("name", MEASURES)
def test_nan_in_gives_nan_out_and_leaves_the_neighbours(name):
    measure, side = MEASURES[name]
    inverse = np.stack([np.eye(3), np.full((3, 3), np.nan), np.eye(3)])
    machine = machine_with(inverse, np.tile(np.eye(3), (3, 1, 1)), force=5.0, speed=1.0)
    machine.velocity_forces = lambda _: np.tile(inverse[:, None], (1, 3, 1, 1))
    values = measure.values(machine, np.zeros((3, 3)))
    np.testing.assert_array_equal(np.isnan(values), [False, True, False])
    inside = measure.form(machine, np.zeros((3, 3)), side).inside
    np.testing.assert_array_equal(
        np.isnan(inside).any(axis=tuple(range(1, inside.ndim))), [False, True, False]
    )


@pytest.mark.parametrize("name", ["acceleration, box", "acceleration, ellipsoid", "tool_speed"])
def test_an_actuator_without_a_limit_limits_nothing(least_slack, name):
    measure, side = MEASURES[name]
    limit = np.array([50.0, np.inf, np.inf])
    machine = machine_with(np.eye(3)[None], 2 * np.eye(3)[None], force=limit, speed=limit / 2)
    assert value_of(measure, machine) == pytest.approx(25.0)
    form = measure.form(machine, POSE, side)
    template = compile_form(form.holds, form.inside.shape[1:])
    assert least_slack(template, form.inside[0], 50.0) == pytest.approx(np.log(2), abs=1e-8)


@pytest.mark.parametrize("name", ["gie_norm", "dynamic_isotropy", "acceleration, box", "actuator_force"])
def test_infinite_inertia_violates_at_a_singularity_and_is_unknown_elsewhere(name):
    measure, side = MEASURES[name]
    inverse = np.array([[[1, 1, 1], [1, 1, 1], [0, 0, 1]], np.eye(3), np.eye(3)], dtype=float)
    inertia = np.stack([np.full((3, 3), np.nan), np.full((3, 3), np.nan), np.eye(3)])
    values = measure.values(machine_with(inverse, inertia, force=10.0), np.zeros((3, 3)))
    assert values[0] == (np.inf if side == "at_most" else 0.0)
    assert np.isnan(values[1])
    assert 0 < values[2] < np.inf


@pytest.mark.parametrize(
    "measure",
    [
        GieNorm(),
        DynamicIsotropy(),
        Acceleration(),
        Acceleration(ball="ellipsoid"),
        ActuatorForce(acceleration=1.0),
    ],
)
def test_the_orthoglide_violates_at_its_parallel_singularity(measure):
    machine = Orthoglide.model_validate(
        {
            "leg_lengths": [0.45] * 3,
            "legs": {"section": {"rectangle": {"height": 0.02, "width": 0.01}}, "material": "steel"},
            "actuators": {"force": 300.0, "mass": 2.0},
            "platform": {"mass": 1.0},
            "gravity": [0, 0, -9.81],
        }
    )
    singular, isotropic = measure.values(machine, np.array([[-0.4, -0.2, -0.05], [0.0, 0.0, 0.0]]))
    assert singular == (0.0 if "at_least" in measure.sides else np.inf)
    assert 0 < isotropic < np.inf


def test_a_joint_that_stands_still_limits_nothing():
    machine = machine_with(np.diag([1.0, 2.0, 0.0])[None], np.eye(3)[None], speed=4.0)
    assert value_of(ToolSpeed(), machine) == pytest.approx(2.0)
    assert np.isfinite(ToolSpeed().form(machine, POSE, "at_least").inside).all()


def test_a_tool_without_mass_in_a_direction_is_not_isotropic_at_all():
    machine = machine_with(np.diag([1.0, 2.0, 0.0])[None], np.eye(3)[None])
    assert value_of(DynamicIsotropy(), machine) == np.inf
    assert value_of(GieNorm(), machine) == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("measure", "keys", "message"),
    [
        (ActuatorForce, {}, "acceleration\n  Field required"),
        (ActuatorForce, {"acceleration": -1.0}, "greater than or equal to 0"),
        (ActuatorForce, {"acceleration": "2 m/s"}, "is a speed, an acceleration [m/s^2] was expected"),
        (JointSpeed, {"speed": 0.0}, "greater than 0"),
        (Acceleration, {"ball": "sphere"}, "'box' or 'ellipsoid'"),
    ],
)
def test_keys_are_checked(measure, keys, message):
    with pytest.raises(ValidationError) as refused:
        measure.model_validate(keys)
    assert message in str(refused.value)

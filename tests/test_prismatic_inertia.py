"""Inertia of prismatic legs: energies of the parts summed by hand, closed forms, differences, gravity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.mechanics import inertia

seeds = st.integers(0, 2**32 - 1)
LEGS = {"section": {"round": {"diameter": 0.02}}, "material": "steel"}
PARTS = {
    "legs": LEGS,
    "actuators": {"mass": 1.7, "force": 120.0, "friction": 4.0},
    "platform": {"mass": 0.8},
    "tool": {"mass": 0.3},
    "payload": {"mass": 0.5},
    "gravity": (0.3, -1.1, -9.81),
}
MACHINES = {
    "orthoglide": Orthoglide(leg_lengths=(0.3, 0.32, 0.35), **PARTS),
    "linear_delta": LinearDelta(
        leg_lengths=(0.5, 0.52, 0.55), base_radius=0.35, platform_radius=0.06, rail_tilt=0.2, **PARTS
    ),
}
machines = pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)


def near(machine, random, n=1):
    """Poses in the middle of the reach."""
    centre = (0.0, 0.0, -0.1) if isinstance(machine, LinearDelta) else (0.0, 0.0, 0.0)
    poses = centre + random.uniform(-0.08, 0.08, (n, 3))
    assert machine.inverse_kinematics(poses)[1].all()
    return poses


def energy(machine, pose, velocity):
    """Kinetic energy, each leg cut into points of Gauss's rule, which is exact for it."""
    geometry = machine.geometry
    rates = machine.inverse_jacobian(pose[None])[0] @ velocity
    total = (0.8 + 0.3 + 0.5) * velocity @ velocity / 2 + 1.7 * rates @ rates / 2
    area, density = math.pi * 0.01**2, 7850.0
    for i in range(3):
        mass = area * density * machine.leg_lengths[i]
        for part in (0.5 - math.sqrt(1 / 12), 0.5 + math.sqrt(1 / 12)):
            moving = (1 - part) * rates[i] * geometry.axes[i] + part * velocity
            total += mass / 2 * moving @ moving / 2
    return total


@machines
@settings(max_examples=20, deadline=None)
@given(seed=seeds)
def test_kinetic_energy_is_that_of_the_parts(machine, seed):
    random = np.random.default_rng(seed)
    pose, velocity = near(machine, random)[0], random.normal(size=3)
    rates = machine.inverse_jacobian(pose[None])[0] @ velocity
    found = rates @ machine.joint_inertia(pose[None])[0] @ rates / 2
    assert found == pytest.approx(energy(machine, pose, velocity), rel=1e-12)


@machines
def test_velocity_forces_are_those_of_lagrange_by_differences(machine):
    poses = near(machine, np.random.default_rng(3), 10)
    found = machine.velocity_forces(poses)
    np.testing.assert_allclose(
        found, inertia.velocity_forces(machine, poses), atol=1e-7 * np.abs(found).max()
    )
    np.testing.assert_allclose(found, np.swapaxes(found, 2, 3), rtol=1e-12)


@machines
def test_rest_load_is_the_slope_of_the_potential_over_the_sliders(machine):
    random = np.random.default_rng(5)
    pose, h = near(machine, random)[0], 1e-6
    gravity = np.array(machine.gravity)
    masses = [7850.0 * math.pi * 0.01**2 * length for length in machine.leg_lengths]

    def potential(p):
        geometry, rho = machine.geometry, machine.inverse_kinematics(p[None])[0][0]
        sliders = geometry.bases[:, :, 0] + rho[:, None] * geometry.axes
        middles = (sliders + p + geometry.joints[:, :, 0]) / 2
        return -gravity @ (1.6 * p + 1.7 * sliders.sum(axis=0) + np.array(masses) @ middles)

    slope = [(potential(pose + h * e) - potential(pose - h * e)) / (2 * h) for e in np.eye(3)]
    found = machine.inverse_jacobian(pose[None])[0].T @ machine.rest_load(pose[None])[0]
    np.testing.assert_allclose(found, slope, rtol=1e-7)


def test_massless_legs_on_the_200_mm_orthoglide_give_the_closed_forms():
    """G = m_p I + m_s J⁻ᵀJ⁻¹: 3 kg at the isotropic pose, 4.125 kg and 9 kg at the cube's corners."""
    side = 0.2
    length = side / (1 / math.sqrt(6) + 1 / math.sqrt(18))
    machine = Orthoglide(
        leg_lengths=(length,) * 3, actuators={"mass": 2.0, "force": 100.0}, platform={"mass": 1.0}
    )
    poses = np.array([[0.0] * 3, [length / math.sqrt(18)] * 3, [-length / math.sqrt(6)] * 3])
    inverse_jacobian, D = machine.inverse_jacobian(poses), machine.joint_inertia(poses)
    G = inertia.at_tool(inverse_jacobian, D)
    expected = np.eye(3) + 2 * np.swapaxes(inverse_jacobian, 1, 2) @ inverse_jacobian
    np.testing.assert_allclose(G, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(G, 2, axis=(1, 2)), [3.0, 4.125, 9.0], rtol=1e-12)
    accelerations = 100.0 / np.linalg.norm(D @ inverse_jacobian, axis=2).max(axis=1)
    np.testing.assert_allclose(accelerations, [33.3333333, 31.2195279, 28.0056], rtol=1e-6)


def test_parallelogram_legs_weigh_two_bars():
    one = Orthoglide(leg_lengths=(0.3,) * 3, **PARTS)
    two = Orthoglide(leg_lengths=(0.3,) * 3, **{**PARTS, "legs": {**LEGS, "kind": "PRPaR", "spacing": 0.08}})
    ranges = np.array([[0.2, 0.4]] * 3)
    assert two.indices(ranges)["leg_2_mass"] == pytest.approx(
        2 * one.indices(ranges)["leg_2_mass"], rel=1e-14
    )
    bar = 7850.0 * math.pi * 0.01**2 * 0.3
    assert one.indices(ranges)["total_mass"] == pytest.approx(3 * (bar + 1.7) + 0.8 + 0.3, rel=1e-12)
    assert one.indices(ranges)["moving_mass"] == pytest.approx(3 * (bar + 1.7) + 1.6, rel=1e-12)


def test_a_foot_moves_with_its_slider():
    foot = {"length": 0.1, "section": {"round": {"diameter": 0.04}}, "material": "aluminium"}
    plain = Orthoglide(leg_lengths=(0.3,) * 3, actuators={"mass": 2.0})
    footed = Orthoglide(leg_lengths=(0.3,) * 3, actuators={"mass": 2.0}, feet=foot)
    mass = 2700.0 * math.pi * 0.02**2 * 0.1
    found = footed.joint_inertia(np.zeros((1, 3))) - plain.joint_inertia(np.zeros((1, 3)))
    np.testing.assert_allclose(found[0], mass * np.eye(3), rtol=1e-12, atol=1e-15)
    assert footed.indices(np.array([[0.2, 0.4]] * 3))["foot_mass"] == pytest.approx(mass, rel=1e-12)


def test_inverse_of_matrices_is_lapacks_and_not_finite_where_singular():
    random = np.random.default_rng(0)
    for d in (2, 3, 5):
        matrices = random.normal(size=(50, d, d))
        np.testing.assert_allclose(inertia.inverse(matrices), np.linalg.inv(matrices), rtol=1e-9, atol=1e-12)
        singular = np.stack([np.ones((d, d)), np.eye(d), np.full((d, d), np.nan)])
        found = inertia.inverse(singular)
        assert not np.isfinite(found[[0, 2]]).any()
        np.testing.assert_array_equal(found[1], np.eye(d))

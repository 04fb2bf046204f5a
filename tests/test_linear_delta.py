"""The linear Delta: kinematics by geometry, three-fold symmetry, and the Orthoglide as one of its forms."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from orthospec.manipulators.linear_delta import AZIMUTHS, LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide

KEYS = {"leg_lengths": (0.5, 0.5, 0.5), "base_radius": 0.3, "platform_radius": 0.05}
TURN = np.array([[-0.5, -math.sqrt(0.75), 0.0], [math.sqrt(0.75), -0.5, 0.0], [0.0, 0.0, 1.0]])
tilts = st.floats(-0.6, math.pi / 2)
seeds = st.integers(0, 2**32 - 1)


def poses_in(seed, n=20):
    return np.random.default_rng(seed).uniform(-0.1, 0.1, (n, 3)) - [0.0, 0.0, 0.25]


@given(tilts, seeds)
def test_legs_reach_from_their_slides_to_the_platform(tilt, seed):
    machine, poses = LinearDelta(**KEYS, rail_tilt=tilt), poses_in(seed)
    rho, _ = machine.inverse_kinematics(poses)
    for i, alpha in enumerate(AZIMUTHS):
        radial = np.array([math.cos(alpha), math.sin(alpha), 0.0])
        rail = math.sin(tilt) * radial + np.array([0.0, 0.0, math.cos(tilt)])
        slider = 0.3 * radial + rho[:, i, None] * rail
        leg = slider - (poses + 0.05 * radial)
        known = np.isfinite(rho[:, i])
        np.testing.assert_allclose(np.linalg.norm(leg, axis=1)[known], 0.5, rtol=1e-12)
        assert (leg @ rail > 0)[known].all()


def test_vertical_slides_stand_at_the_height_of_the_leg():
    """ρ_i = z + sqrt(L² − |(R − r) r_i − (x, y)|²)."""
    machine, poses = LinearDelta(**KEYS), poses_in(1)
    rho, reachable = machine.inverse_kinematics(poses)
    assert reachable.all()
    for i, alpha in enumerate(AZIMUTHS):
        across = 0.25 * np.array([math.cos(alpha), math.sin(alpha)]) - poses[:, :2]
        expected = poses[:, 2] + np.sqrt(0.25 - np.sum(across**2, axis=1))
        np.testing.assert_allclose(rho[:, i], expected, rtol=1e-13)


@settings(max_examples=10, deadline=None)
@given(tilts, seeds)
def test_inverse_jacobian_is_the_slope_of_the_sliders(tilt, seed):
    """Against differences of the loop solved in 50 digits."""
    machine, pose = LinearDelta(**KEYS, rail_tilt=tilt), poses_in(seed, 1)
    if not np.isfinite(machine.inverse_kinematics(pose)[0]).all():
        return
    found, h = machine.inverse_jacobian(pose)[0], mpmath.mpf(10) ** -16

    def slider(i, p):
        c, s = mpmath.cos(2 * mpmath.pi * i / 3), mpmath.sin(2 * mpmath.pi * i / 3)
        t = mpmath.mpf(tilt)
        rail = [mpmath.sin(t) * c, mpmath.sin(t) * s, mpmath.cos(t)]
        d = [p[0] - mpmath.mpf("0.25") * c, p[1] - mpmath.mpf("0.25") * s, p[2]]
        along = sum(a * b for a, b in zip(rail, d, strict=True))
        return along + mpmath.sqrt(mpmath.mpf("0.25") - sum(x * x for x in d) + along**2)

    for k in range(3):
        ends = []
        for step in (h, -h):
            moved = [mpmath.mpf(float(x)) for x in pose[0]]
            moved[k] += step
            ends.append([slider(i, moved) for i in range(3)])
        slope = [float((a - b) / (2 * h)) for a, b in zip(*ends, strict=True)]
        np.testing.assert_allclose(found[:, k], slope, rtol=1e-8, atol=1e-8 * np.abs(found).max())


@given(tilts, seeds)
def test_a_third_of_a_turn_renumbers_the_slides(tilt, seed):
    machine, poses = LinearDelta(**KEYS, rail_tilt=tilt), poses_in(seed)
    rho, reachable = machine.inverse_kinematics(poses)
    turned, turned_reachable = machine.inverse_kinematics(poses @ TURN.T)
    np.testing.assert_allclose(turned, np.roll(rho, 1, axis=1), rtol=1e-10, atol=1e-12)
    margins = np.array(list(machine.reach(poses).values()))
    clear = np.abs(margins).min(axis=0) > 1e-9
    np.testing.assert_array_equal(turned_reachable[clear], reachable[clear])


def test_orthogonal_slides_through_one_point_are_an_orthoglide_stood_on_its_corner():
    keys = {"leg_lengths": (0.4, 0.4, 0.4), "actuators": {"mass": 1.2}, "platform": {"mass": 0.7}}
    keys["legs"] = {"section": {"round": {"diameter": 0.02}}, "material": "steel"}
    tilted = LinearDelta(**keys, base_radius=0.0, platform_radius=0.0, rail_tilt=math.acos(1 / math.sqrt(3)))
    plain = Orthoglide(**keys)
    axes = tilted.geometry.axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    poses = np.random.default_rng(7).uniform(-0.35, 0.35, (500, 3))
    rho, reachable = plain.inverse_kinematics(poses)
    found, found_reachable = tilted.inverse_kinematics(poses @ axes)
    np.testing.assert_array_equal(found_reachable, reachable)
    np.testing.assert_allclose(found, rho, rtol=1e-12, atol=1e-14)
    inside = poses[reachable]
    np.testing.assert_allclose(
        tilted.inverse_jacobian(inside @ axes) @ axes.T, plain.inverse_jacobian(inside), rtol=1e-8, atol=1e-9
    )
    D = plain.joint_inertia(inside)
    np.testing.assert_allclose(tilted.joint_inertia(inside @ axes), D, rtol=1e-7, atol=1e-9 * np.abs(D).max())


def test_vertical_slides_reach_all_that_their_legs_reach():
    """With equal legs no singularity stands between the poses at which all legs close."""
    machine = LinearDelta(**KEYS)
    poses = np.random.default_rng(9).uniform(-0.6, 0.6, (50_000, 3))
    margins = machine.reach(poses)
    closed = np.all([margins[f"leg_{i}"] >= 0 for i in (1, 2, 3)], axis=0)
    assert closed.sum() > 1000
    assert (margins["singularity"][closed] > 0).all()
    assert (margins["assembly"][closed] > 0).all()


def reachable_count(**keys):
    axis = np.linspace(-0.5, 0.5, 31)
    grid = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    legs = {"leg_lengths": (0.4, 0.4, 0.4), "platform_radius": 0.05}
    return int(LinearDelta(**{**legs, **keys}).inverse_kinematics(grid)[1].sum())


@pytest.mark.parametrize("sign", [1, -1])
def test_the_base_radius_of_a_star_only_shifts_its_sliders(sign):
    star = {"rail_tilt": math.pi / 2, "branch": (sign,) * 3}
    counts = {reachable_count(base_radius=radius, **star) for radius in (0.0, 0.05, 0.3)}
    assert len(counts) == 1
    assert counts.pop() > 2000


@given(
    st.floats(-1.57, math.pi / 2),
    st.floats(0.0, 0.5),
    st.floats(0.01, 0.4),
    st.tuples(*[st.sampled_from((1, -1))] * 3),
)
def test_legs_at_home_reach_out_along_their_slides(tilt, base, platform, branch):
    if base == platform and tilt == 0:
        return
    machine = LinearDelta(
        leg_lengths=(0.5, 0.5, 0.5),
        base_radius=base,
        platform_radius=platform,
        rail_tilt=tilt,
        branch=branch,
    )
    geometry = machine.geometry
    assert (np.sum(geometry.axes * geometry.home, axis=1) > 0).all()


@pytest.mark.parametrize("tilt", [0.0, 0.3, -0.3, 0.9, -0.9, 1.3])
@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_the_middle_of_the_machine_is_in_its_reach(tilt, radius):
    """A pose on the axis from which the legs lean out by 45 deg, or in where the base is the narrower."""
    assert reachable_count(base_radius=radius, rail_tilt=tilt) > 2000


def test_horizontal_star_is_singular_in_the_plane_of_its_slides():
    machine = LinearDelta(**KEYS, rail_tilt=math.pi / 2)
    below, above = machine.inverse_kinematics(np.array([[0.0, 0.0, -0.2], [0.0, 0.0, 0.2]]))[1]
    assert below
    assert not above
    assert machine.reach(np.array([[0.0, 0.0, 0.0]]))["singularity"][0] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"platform_radius": 0.3}, "singular at every pose"),
        ({"legs": {"offset": 0.02}}, "platform_radius places the legs' ends"),
        ({"rail_tilt": -1.6}, "greater than"),
        ({"base_radius": -0.1}, "greater than or equal to 0"),
    ],
)
def test_machines_that_cannot_be_are_refused(keys, message):
    with pytest.raises(ValidationError, match=message):
        LinearDelta.model_validate({**KEYS, **keys})


def test_skeleton_joins_slides_legs_and_platform():
    machine = LinearDelta(**KEYS, legs={"kind": "PRPaR", "spacing": 0.08})
    poses = poses_in(2, 4)
    skeleton = machine.skeleton(poses)
    count = len(skeleton.names)
    assert skeleton.segments.shape == (4, count, 2, 3)
    assert skeleton.radii.shape == (count,)
    assert len(set(skeleton.names)) == count
    parts = {name: skeleton.segments[:, k] for k, name in enumerate(skeleton.names)}
    for i in (1, 2, 3):
        bars = [parts[f"bar_{side}_{i}"] for side in ("left", "right")]
        for bar in bars:
            np.testing.assert_allclose(np.linalg.norm(bar[:, 1] - bar[:, 0], axis=1), 0.5, rtol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(bars[0] - bars[1], axis=2), 0.08, rtol=1e-12)
        np.testing.assert_allclose(parts[f"arm_{i}"][:, 1], poses)
        np.testing.assert_allclose(parts[f"slide_{i}"][:, 1], (bars[0] + bars[1])[:, 0] / 2, rtol=1e-12)

"""The Orthoglide: kinematics against closed forms and 50 digits, reach, indices, skeleton."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from orthospec.manipulators.orthoglide import Orthoglide

BRANCHES = list(itertools.product((1, -1), repeat=3))
lengths = st.tuples(*[st.floats(0.2, 3.0)] * 3)
parts = st.tuples(*[st.floats(-0.55, 0.55)] * 3)


def pose_in(lengths, parts):
    """A pose at which every leg closes its loop."""
    return np.array([parts]) * min(lengths)


@pytest.mark.parametrize("branch", BRANCHES)
def test_jacobian_is_the_identity_at_the_origin(branch):
    machine = Orthoglide(leg_lengths=(0.3, 1.0, 2.5), branch=branch)
    np.testing.assert_array_equal(machine.inverse_jacobian(np.zeros((1, 3)))[0], np.eye(3))


@given(st.floats(-0.55, 0.4), st.floats(0.1, 10.0))
def test_singular_values_on_the_diagonal_are_the_closed_form(q, length):
    machine = Orthoglide(leg_lengths=(length,) * 3)
    found = np.linalg.svd(machine.inverse_jacobian(np.full((1, 3), q * length))[0], compute_uv=False)
    u = q / np.sqrt(1 - 2 * q * q)
    expected = sorted([abs(1 - 2 * u), abs(1 + u), abs(1 + u)], reverse=True)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-13)


@given(lengths, parts, st.sampled_from(BRANCHES))
def test_legs_close_their_loops_on_their_branch(lengths, parts, branch):
    pose = pose_in(lengths, parts)
    machine = Orthoglide(leg_lengths=lengths, branch=branch)
    rho, _ = machine.inverse_kinematics(pose)
    s = rho[0][:, None] * np.eye(3) - pose[0]
    np.testing.assert_allclose(np.linalg.norm(s, axis=1), lengths, rtol=1e-12)
    assert (np.diag(s) * branch > 0).all()


@given(lengths, parts, st.sampled_from(BRANCHES))
def test_other_branch_is_the_mirror_image(lengths, parts, branch):
    mirror = np.array(branch, dtype=float)
    pose = pose_in(lengths, parts)
    plain, mirrored = Orthoglide(leg_lengths=lengths), Orthoglide(leg_lengths=lengths, branch=branch)
    rho, reachable = plain.inverse_kinematics(pose)
    rho_m, reachable_m = mirrored.inverse_kinematics(pose * mirror)
    np.testing.assert_allclose(rho_m, rho * mirror, rtol=1e-14)
    np.testing.assert_array_equal(reachable_m, reachable)
    expected = mirror[:, None] * plain.inverse_jacobian(pose)[0] * mirror
    np.testing.assert_allclose(mirrored.inverse_jacobian(pose * mirror)[0], expected, rtol=1e-12, atol=1e-15)


@settings(max_examples=30, deadline=None)
@given(lengths, parts, st.sampled_from(BRANCHES))
def test_kinematics_equal_fifty_digits(exact, lengths, parts, branch):
    pose = pose_in(lengths, parts)
    machine = Orthoglide(leg_lengths=lengths, branch=branch)
    rho, _ = machine.inverse_kinematics(pose)
    given_pose = [float(p) for p in pose[0]]
    np.testing.assert_allclose(
        rho[0], [float(r) for r in exact.sliders(lengths, given_pose, branch)], rtol=1e-12, atol=1e-12
    )
    expected = np.array(exact.inverse_jacobian(lengths, given_pose, branch).tolist(), dtype=float)
    np.testing.assert_allclose(machine.inverse_jacobian(pose)[0], expected, rtol=1e-9, atol=1e-9)


class TestReach:
    def machine(self, **limits):
        return Orthoglide(leg_lengths=(1.0, 1.1, 1.3), joint_limits=limits)

    def test_margins_agree_with_reachable(self):
        machine = self.machine(min=(0.4, 0.5, 0.6), max=1.5)
        poses = np.random.default_rng(0).uniform(-1.4, 1.4, (20_000, 3))
        margins = machine.reach(poses)
        inside = np.all([margin >= -1e-12 for margin in margins.values()], axis=0)
        reachable = machine.inverse_kinematics(poses)[1]
        np.testing.assert_array_equal(inside, reachable)
        assert 0 < np.count_nonzero(reachable) < len(poses)

    @pytest.mark.parametrize("joint", range(3))
    @pytest.mark.parametrize(("side", "key"), [("min", "at_least"), ("max", "at_most")])
    def test_joint_limit_margin_is_relative_and_changes_sign_at_the_limit(self, joint, side, key):
        limits = [0.0 if side == "min" else 9.0] * 3
        limits[joint] = 0.9
        machine = self.machine(**{side: tuple(limits)})
        pose = np.zeros((3, 3))
        pose[:, joint] = np.array([0.9 - 0.01, 0.9, 0.9 + 0.01]) - machine.leg_lengths[joint]
        margin = machine.reach(pose)[f"joint_limits.{joint}.{key}"]
        sign = 1 if side == "min" else -1
        np.testing.assert_allclose(margin, sign * np.array([-0.01, 0, 0.01]) / 0.9, atol=1e-15)
        np.testing.assert_array_equal(machine.inverse_kinematics(pose)[1], margin >= -1e-12)

    def test_a_limit_of_zero_has_a_margin_relative_to_its_leg(self):
        machine = self.machine(min=0.0)
        margin = machine.reach(np.array([[0.0, 0.0, -1.3 + 0.013]]))["joint_limits.2.at_least"]
        assert margin[0] == pytest.approx(0.01)

    def test_one_limit_stands_for_all_sliders(self):
        assert self.machine(max=1.5) == self.machine(max=(1.5, 1.5, 1.5))

    def test_without_joint_limits_there_is_no_margin_of_them(self):
        assert not [key for key in self.machine().reach(np.zeros((1, 3))) if "joint" in key]

    def test_unreachable_poses_have_nan_joints_and_say_so(self):
        rho, reachable = self.machine().inverse_kinematics(np.array([[9.0, 9.0, 9.0], [0.0, 0.0, 0.0]]))
        assert np.isnan(rho[0]).all()
        np.testing.assert_array_equal(reachable, [False, True])
        assert np.isnan(self.machine().inverse_jacobian(np.full((1, 3), 9.0))).any()

    def test_far_side_of_the_parallel_singularity_is_not_reachable(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))
        # On the diagonal det J⁻¹ changes sign at u = 1/2, q = 1/√6.
        q = 1 / np.sqrt(6)
        poses = np.outer([q - 1e-6, q + 1e-6, q + 0.1], np.ones(3))
        np.testing.assert_array_equal(machine.inverse_kinematics(poses)[1], [True, False, False])
        margins = machine.reach(poses)
        assert "singularity" in [key for key, margin in margins.items() if margin[2] < 0]
        determinants = np.linalg.det(machine.inverse_jacobian(poses))
        np.testing.assert_array_equal(np.sign(margins["singularity"]), np.sign(determinants))


class TestDesign:
    def test_refuses_lengths_that_are_not_positive(self):
        with pytest.raises(ValidationError, match="greater than 0"):
            Orthoglide(leg_lengths=(1.0, 0.0, 1.0))

    def test_refuses_limits_without_room(self):
        with pytest.raises(ValidationError, match="not below"):
            Orthoglide(leg_lengths=(1.0, 1.0, 1.0), joint_limits={"min": 0.5, "max": (1.0, 0.5, 1.0)})

    def test_is_frozen(self):
        with pytest.raises(ValidationError, match="frozen"):
            Orthoglide(leg_lengths=(1.0, 1.0, 1.0)).leg_lengths = (2.0, 2.0, 2.0)

    def test_indices_are_their_closed_forms(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.25, 1.5))
        indices = machine.indices(np.array([[0.5, 1.5], [0.25, 2.0], [1.0, 1.25]]))
        assert dict(indices) == {"leg_length_total": 3.75, "stroke": 1.75, "footprint": 1.5 * 2.0}
        assert indices.keys() <= machine.index_units.keys()

    def test_footprint_holds_the_sliders_of_a_negative_branch(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.0, 1.0), branch=(-1, 1, 1))
        assert machine.indices(np.array([[-1.5, -0.5], [0.5, 1.0], [0.0, 1.0]]))["footprint"] == 1.5

    def test_skeleton_joins_slides_legs_and_tool(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.1, 1.3))
        poses = np.random.default_rng(3).uniform(-0.3, 0.3, (7, 3))
        skeleton = machine.skeleton(poses)
        assert skeleton.segments.shape == (7, 6, 2, 3)
        assert skeleton.radii.shape == (6,)
        assert len(skeleton.names) == 6
        legs = skeleton.segments[:, 3:]
        np.testing.assert_allclose(
            np.linalg.norm(legs[:, :, 1] - legs[:, :, 0], axis=2),
            np.tile([1.0, 1.1, 1.3], (7, 1)),
            rtol=1e-12,
        )
        np.testing.assert_array_equal(legs[:, :, 1], np.repeat(poses[:, None, :], 3, axis=1))
        np.testing.assert_array_equal(skeleton.segments[:, :3, 1], legs[:, :, 0])

    def test_a_block_in_hand_is_computed_once(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))
        poses = np.zeros((4, 3))
        poses.flags.writeable = False
        assert machine.inverse_jacobian(poses) is machine.inverse_jacobian(poses)

    def test_a_block_that_may_change_is_computed_anew(self):
        machine = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))
        poses = np.zeros((1, 3))
        before = machine.inverse_jacobian(poses)
        poses[0] = 0.2
        assert not np.array_equal(machine.inverse_jacobian(poses), before)

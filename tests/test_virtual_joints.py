"""Chains and platforms by the virtual joint method, beside the bordered matrix of eq. 6 and known answers."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.mechanics.virtual_joints import (
    actuator,
    chain_stiffness,
    parallel_compliance,
    reduced_compliance,
    spring_at,
    transmitted_wrenches,
    transported_twists,
    transported_wrenches,
)

seeds = st.integers(0, 2**32 - 1)
POSES = 5


def turned(matrices):
    return np.swapaxes(matrices, -1, -2)


def compliances(random, *shape, size=6):
    """Symmetric positive definite matrices of condition number 100."""
    axes, _ = np.linalg.qr(random.standard_normal((*shape, size, size)))
    return (axes * np.geomspace(1, 100, size)) @ turned(axes)


def frames(random, count):
    axes, _ = np.linalg.qr(random.standard_normal((count, 3, 3)))
    return axes * np.linalg.det(axes)[:, None, None]


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def close(found, expected, tolerance=1e-10):
    error = np.abs(found - expected).max(axis=(-1, -2)) / np.abs(expected).max(axis=(-1, -2))
    return bool((error <= tolerance).all())


def stiffness_by_eq6(compliance, passive):
    """The upper left block of the inverse of [[C, J], [Jᵀ, 0]], J with the passive twists as columns."""
    n, k, _ = passive.shape
    bordered = np.zeros((n, 6 + k, 6 + k))
    bordered[:, :6, :6] = compliance
    bordered[:, :6, 6:], bordered[:, 6:, :6] = turned(passive), passive
    return np.linalg.inv(bordered)[:, :6, :6]


class TestTransport:
    @settings(max_examples=50, deadline=None)
    @given(seeds)
    def test_keeps_the_power_of_a_wrench_on_a_twist(self, seed):
        random = np.random.default_rng(seed)
        wrench, twist, arm = random.standard_normal((3, POSES, 6))
        moved = transported_wrenches(wrench, arm[:, :3]), transported_twists(twist, arm[:, :3])
        np.testing.assert_allclose(
            np.sum(moved[0] * moved[1], axis=1), np.sum(wrench * twist, axis=1), rtol=0, atol=1e-12
        )

    def test_gives_a_force_beside_the_tool_point_its_moment(self):
        force = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
        moved = transported_wrenches(force, np.array([[2.0, 0.0, 0.0]]))
        assert moved.tolist() == [[0, 1, 0, 0, 0, 2]]

    def test_turns_the_tool_point_about_an_axis_beside_it(self):
        turn = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]])
        moved = transported_twists(turn, np.array([[2.0, 0.0, 0.0]]))
        assert moved.tolist() == [[0, -2, 0, 0, 0, 1]]


class TestSprings:
    @settings(max_examples=50, deadline=None)
    @given(seeds)
    def test_move_the_tool_point_as_their_own_end_would(self, seed):
        random = np.random.default_rng(seed)
        link = compliances(random)
        axes, arms = frames(random, POSES), random.standard_normal((POSES, 3))
        wrench = random.standard_normal((POSES, 6))
        at_end = transported_wrenches(wrench, -arms).reshape(POSES, 2, 3)
        in_frame = (at_end @ turned(axes)).reshape(POSES, 6) @ link
        expected = transported_twists((in_frame.reshape(POSES, 2, 3) @ axes).reshape(POSES, 6), arms)
        found = np.einsum("nij,nj->ni", spring_at(link, axes, arms), wrench)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    @settings(max_examples=50, deadline=None)
    @given(seeds)
    def test_of_a_link_cut_in_two_add_up_to_the_whole(self, seed):
        """Two cantilevers end to end, with the compliances of a beam of half the length each."""
        random = np.random.default_rng(seed)
        axes, arms = frames(random, POSES), random.standard_normal((POSES, 3))
        half_way = arms - 0.35 * axes[:, 0]
        whole = spring_at(beam(0.7), axes, arms)
        halves = spring_at(beam(0.35), axes, half_way) + spring_at(beam(0.35), axes, arms)
        assert close(halves, whole)

    def test_of_an_actuator_give_way_along_it_alone(self):
        twist = np.array([[0.6, 0.8, 0.0, 0.0, 0.0, 0.0]])
        wrench = np.array([3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
        np.testing.assert_allclose(actuator(twist, 2.0)[0] @ wrench, 10 * twist[0])


def beam(length, axial=1.0, torsion=30.0, bending_y=40.0, bending_z=90.0):
    """A cantilever of this length, with 1/EA, 1/GJ, 1/EI_y and 1/EI_z."""
    compliance = np.diag(
        [
            axial * length,
            bending_z * length**3 / 3,
            bending_y * length**3 / 3,
            torsion * length,
            bending_y * length,
            bending_z * length,
        ]
    )
    compliance[1, 5] = compliance[5, 1] = bending_z * length**2 / 2
    compliance[2, 4] = compliance[4, 2] = -bending_y * length**2 / 2
    return compliance


class TestChains:
    @settings(max_examples=100, deadline=None)
    @given(st.integers(1, 5), seeds)
    def test_equal_the_bordered_matrix_of_eq_6(self, joints, seed):
        random = np.random.default_rng(seed)
        passive, compliance = random.standard_normal((POSES, joints, 6)), compliances(random, POSES)
        found = chain_stiffness(compliance, transmitted_wrenches(passive))
        assert close(found, stiffness_by_eq6(compliance, passive), 1e-7)

    @settings(max_examples=50, deadline=None)
    @given(st.integers(1, 5), st.sampled_from([1e-3, 1.0, 1e3]), seeds)
    def test_transmit_what_does_no_work_on_the_passive_joints(self, joints, length, seed):
        passive = np.random.default_rng(seed).standard_normal((POSES, joints, 6)) * np.repeat([length, 1], 3)
        wrenches = transmitted_wrenches(passive)
        assert wrenches.shape == (POSES, 6 - joints, 6)
        assert (
            np.abs(wrenches @ turned(passive)).max() <= 1e-12 * np.abs(passive).max() * np.abs(wrenches).max()
        )
        assert (np.linalg.matrix_rank(chain_stiffness(np.eye(6), wrenches), 1e-9) == 6 - joints).all()

    def test_count_a_joint_that_another_repeats_once(self):
        random = np.random.default_rng(1)
        passive, compliance = random.standard_normal((POSES, 3, 6)), compliances(random, POSES)
        passive[2, 2] = passive[2, 0] - passive[2, 1]
        wrenches = transmitted_wrenches(passive)
        assert np.any(wrenches != 0, axis=2).sum(axis=1).tolist() == [3, 3, 4, 3, 3]
        found = chain_stiffness(compliance, wrenches)
        assert close(found[2:3], stiffness_by_eq6(compliance[2:3], passive[2:3, :2]))
        assert close(
            np.delete(found, 2, 0), stiffness_by_eq6(*(np.delete(a, 2, 0) for a in (compliance, passive)))
        )

    def test_without_passive_joints_are_their_springs(self):
        compliance = compliances(np.random.default_rng(2), POSES)
        wrenches = transmitted_wrenches(np.empty((POSES, 0, 6)))
        assert close(chain_stiffness(compliance, wrenches), np.linalg.inv(compliance))


def side_by_side(random, chains, transmitted):
    """D and W of random chains, and the sum of their stiffnesses."""
    passive = random.standard_normal((POSES * chains, 6 - transmitted, 6))
    compliance, wrenches = compliances(random, POSES * chains), transmitted_wrenches(passive)
    stiffness = chain_stiffness(compliance, wrenches).reshape(POSES, chains, 6, 6).sum(axis=1)
    reduced = reduced_compliance(compliance, wrenches)
    shape = (POSES, chains, transmitted)
    return reduced.reshape(*shape, transmitted), wrenches.reshape(*shape, 6), stiffness


class TestPlatforms:
    @settings(max_examples=100, deadline=None)
    @given(st.sampled_from([(3, 2), (3, 3), (6, 1), (2, 3), (2, 5), (1, 6), (4, 4)]), seeds)
    def test_add_the_stiffnesses_of_their_chains(self, sizes, seed):
        reduced, wrenches, stiffness = side_by_side(np.random.default_rng(seed), *sizes)
        found = parallel_compliance(reduced, wrenches)
        conditions = np.linalg.cond(stiffness)
        product = found @ stiffness
        assert (np.abs(product - np.eye(6)).max(axis=(1, 2)) <= 1e-12 * conditions).all()
        np.testing.assert_array_equal(found, turned(found))

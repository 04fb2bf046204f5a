"""Chains and platforms by the virtual joint method, beside the bordered matrix of eq. 6 and known answers."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.mechanics import virtual_joints
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


def exact_compliance(reduced, wrenches):
    """(Σ Wᵀ D⁻¹ W)⁻¹ of one pose in mpmath."""
    stiffness = mpmath.zeros(6)
    for d, w in zip(reduced, wrenches, strict=True):
        rows = mpmath.matrix(w.tolist())
        stiffness += rows.T * mpmath.inverse(mpmath.matrix(d.tolist())) * rows
    return np.array(mpmath.inverse(stiffness).tolist(), dtype=float)


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

    def test_of_rigid_chains_are_the_limit_of_stiffer_and_stiffer_ones(self):
        random = np.random.default_rng(3)
        reduced, wrenches, _ = side_by_side(random, 3, 3)
        soft = np.diag([1.0, 1.0, 0.0])
        rigid = parallel_compliance(soft @ reduced @ soft, wrenches)
        stiff = [
            parallel_compliance(soft @ reduced @ soft + least * np.diag([0, 0, 1.0]), wrenches)
            for least in (2e-4, 1e-4)
        ]
        assert np.abs(stiff[1] - rigid).max() <= 0.6 * np.abs(stiff[0] - rigid).max()
        assert close(2 * stiff[1] - stiff[0], rigid, 1e-6)

    @pytest.mark.parametrize(("ratio", "tolerance"), [(1e-6, 1e-10), (1e-10, 1e-8), (1e-12, 1e-7)])
    def test_of_nearly_rigid_chains_equal_fifty_digits(self, ratio, tolerance):
        wrenches = np.random.default_rng(12).standard_normal((POSES, 3, 3, 6))
        reduced = np.tile(np.diag([1.0, ratio, 2 * ratio]), (POSES, 3, 1, 1))
        with mpmath.workdps(50):
            expected = [exact_compliance(*chains) for chains in zip(reduced, wrenches, strict=True)]
        found = virtual_joints._by_forces(reduced, wrenches)
        assert close(found, np.array(expected), tolerance)
        assert (np.linalg.eigvalsh(found)[:, 0] >= -1e-15 * np.abs(found).max(axis=(1, 2))).all()

    def test_of_chains_rigid_against_moments_turn_by_exactly_nothing(self):
        random = np.random.default_rng(13)
        forces = np.concatenate(
            [random.standard_normal((POSES, 3, 1, 3)), np.zeros((POSES, 3, 1, 3))], axis=3
        )
        moments = np.concatenate(
            [np.zeros((POSES, 3, 2, 3)), random.standard_normal((POSES, 3, 2, 3))], axis=3
        )
        wrenches = np.concatenate([forces, moments], axis=2)
        wrenches = transported_wrenches(wrenches, random.standard_normal((POSES, 3, 1, 3)))
        reduced = np.tile(np.diag([1e-8, 0.0, 0.0]), (POSES, 3, 1, 1))
        found = parallel_compliance(reduced, wrenches)
        assert not found[:, 3:].any()
        assert not found[:, :, 3:].any()
        assert (np.linalg.eigvalsh(found[:, :3, :3])[:, 0] > 1e-10).all()

    def test_do_not_feel_the_rows_that_fill_up_a_chain(self):
        reduced, wrenches, _ = side_by_side(np.random.default_rng(14), 4, 2)
        reduced[:, 0] = 0.0
        filled, rows = np.zeros((POSES, 4, 3, 3)), np.zeros((POSES, 4, 3, 6))
        filled[:, :, :2, :2], filled[:, :, 2, 2], rows[:, :, :2] = 1e-16 * reduced, 1.0, wrenches
        found = 1e16 * parallel_compliance(filled, rows)
        assert close(found, parallel_compliance(reduced, wrenches))

    def test_of_rigid_chains_alone_are_rigid(self):
        wrenches = np.random.default_rng(4).standard_normal((POSES, 3, 3, 6))
        assert not parallel_compliance(np.zeros((POSES, 3, 3, 3)), wrenches).any()

    def test_of_rigid_and_elastic_chains_give_only_where_the_rigid_ones_let_them(self):
        """Four rigid wrenches leave two twists, in which two chains of one spring each give."""
        random = np.random.default_rng(5)
        wrenches, reduced = random.standard_normal((POSES, 6, 1, 6)), np.zeros((POSES, 6, 1, 1))
        reduced[:, 4:] = random.uniform(1, 2, (POSES, 2, 1, 1))
        inverse = np.linalg.inv(wrenches[:, :, 0])
        expected = inverse @ (reduced[:, :, 0] * turned(inverse))
        assert close(parallel_compliance(reduced, wrenches), expected)

    def test_do_not_depend_on_the_route(self):
        """One rigid pose among elastic ones sends that one alone by the forces."""
        reduced, wrenches, stiffness = side_by_side(np.random.default_rng(6), 3, 3)
        by_stiffness = parallel_compliance(reduced, wrenches)
        by_forces = virtual_joints._by_forces(reduced, wrenches)
        assert close(by_forces, by_stiffness, 1e-14 * np.linalg.cond(stiffness).max())
        reduced[2, 0] = 0.0
        np.testing.assert_array_equal(
            np.delete(parallel_compliance(reduced, wrenches), 2, 0), np.delete(by_stiffness, 2, 0)
        )

    @pytest.mark.parametrize("rigid", [False, True])
    def test_that_are_loose_have_infinite_compliance(self, rigid):
        reduced, wrenches, _ = side_by_side(np.random.default_rng(7), 3, 3)
        along = np.random.default_rng(8).standard_normal(6)
        wrenches[1] -= (wrenches[1] @ along)[..., None] * along / (along @ along)
        if rigid:
            reduced[1, 0] = 0.0
        found = parallel_compliance(reduced, wrenches)
        assert np.isposinf(found[1]).all()
        assert np.isfinite(np.delete(found, 1, 0)).all()

    def test_on_too_few_wrenches_are_loose(self):
        reduced, wrenches, _ = side_by_side(np.random.default_rng(9), 1, 5)
        assert np.isposinf(parallel_compliance(reduced, wrenches)).all()

    def test_of_what_is_not_a_number_are_not_numbers(self):
        reduced, wrenches, _ = side_by_side(np.random.default_rng(10), 3, 3)
        reduced[0, 1, 2, 2], wrenches[3, 0, 0, 0] = np.nan, np.nan
        found = parallel_compliance(reduced, wrenches)
        assert np.isnan(found).all(axis=(1, 2)).tolist() == [True, False, False, True, False]

    @pytest.mark.parametrize("rigid", [False, True])
    @pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3])
    def test_do_not_depend_on_the_unit_of_length(self, scale, rigid):
        reduced, wrenches, _ = side_by_side(np.random.default_rng(11), 3, 3)
        if rigid:
            reduced[:, 0] = 0.0
        units = np.repeat([1.0, scale], 3)
        found = parallel_compliance(reduced, wrenches * units) * units[:, None] * units
        assert close(found, parallel_compliance(reduced, wrenches), 1e-9)


class TestUniversalJoints:
    """Three legs between universal joints that meet at the tool point."""

    ACTUATOR, LEG = 3e-8, 2e-9

    def platform(self, seed):
        """Compliance at the tool, of legs along u whose joints turn about a and z at either end."""
        random = np.random.default_rng(seed)
        slides = np.broadcast_to(np.eye(3), (POSES, 3, 3))
        u = unit(slides + random.uniform(-0.5, 0.5, (POSES, 3, 3)))
        parts = [self.chain(slides[:, i], u[:, i], unit(np.roll(slides[:, i], 1, axis=-1))) for i in range(3)]
        reduced, wrenches = (np.stack(part, axis=1) for part in zip(*parts, strict=True))
        return u, slides, parallel_compliance(reduced, wrenches)

    def chain(self, slide, u, a):
        z = unit(np.cross(a, u))
        frame = np.stack([-u, np.cross(z, -u), z], axis=1)
        leg = np.diag([self.LEG, 1e-6, 2e-6, 1e-4, 2e-4, 3e-4])
        turns = np.concatenate([np.zeros((POSES, 2, 3)), np.stack([a, z], axis=1)], axis=2)
        passive = np.concatenate([turns, transported_twists(turns, 0.3 * u[:, None])], axis=1)
        wrenches = transmitted_wrenches(passive)
        twist = np.concatenate([slide, np.zeros((POSES, 3))], axis=1)
        springs = spring_at(leg, frame, np.zeros((POSES, 3))) + actuator(twist, self.ACTUATOR)
        return reduced_compliance(springs, wrenches), wrenches

    @settings(max_examples=30, deadline=None)
    @given(seeds)
    def test_give_the_closed_form_and_no_coupling(self, seed):
        u, slides, found = self.platform(seed)
        along = np.sum(u * slides, axis=2)
        springs = 1 / (self.ACTUATOR * along**2 + self.LEG)
        stiffness = np.einsum("nk,nki,nkj->nij", springs, u, u)
        assert close(found[:, :3, :3], np.linalg.inv(stiffness), 1e-9)
        assert np.abs(found[:, :3, 3:]).max() <= 1e-12 * np.abs(found[:, 3:, 3:]).max()

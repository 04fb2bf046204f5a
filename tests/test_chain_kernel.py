"""The kernel of platforms on chains equals its twin, and says where it would not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.kernels import _kernels, chain_compliance, twin

SIZES = [(3, 1), (1, 6), (6, 1), (3, 2), (3, 3), (2, 4), (2, 5), (4, 3), (7, 2)]
HELD = [(chains, m) for chains, m in SIZES if chains * m >= 6]
seeds = st.integers(0, 2**32 - 1)


def compliances(random, count, chains, m):
    """Of condition number 10 at most."""
    axes, _ = np.linalg.qr(random.standard_normal((count, chains, m, m)))
    matrices = (axes * np.geomspace(1, 10, m)) @ np.swapaxes(axes, 2, 3)
    return 0.5 * (matrices + np.swapaxes(matrices, 2, 3))


def platforms(seed, count, chains, m):
    random = np.random.default_rng(seed)
    return compliances(random, count, chains, m), random.standard_normal((count, chains, m, 6))


def stiffnesses(reduced, wrenches):
    return (np.swapaxes(wrenches, 2, 3) @ np.linalg.solve(reduced, wrenches)).sum(axis=1)


class TestCompliance:
    @settings(max_examples=300, deadline=None)
    @given(st.sampled_from(HELD), st.integers(1, 20), seeds)
    def test_equals_the_twin(self, sizes, count, seed):
        reduced, wrenches = platforms(seed, count, *sizes)
        found, safe = chain_compliance(reduced, wrenches)
        expected, conditions = (
            twin.chain_compliance(reduced, wrenches),
            np.linalg.cond(stiffnesses(reduced, wrenches)),
        )
        error = np.abs(found - expected).max(axis=(1, 2)) / np.abs(expected).max(axis=(1, 2))
        assert (error <= 1e-14 * conditions)[safe].all()
        assert safe[conditions < 1e5].all()
        assert np.isnan(found[~safe]).all()

    def test_is_exactly_symmetric(self):
        found, safe = chain_compliance(*platforms(1, 100, 3, 3))
        assert safe.any()
        np.testing.assert_array_equal(found[safe], np.swapaxes(found, 1, 2)[safe])

    @pytest.mark.parametrize("sizes", HELD)
    def test_of_a_node_has_the_same_bits_in_any_company(self, sizes):
        reduced, wrenches = platforms(2, 23, *sizes)
        together, safe = chain_compliance(reduced, wrenches)
        for node in range(23):
            alone, alone_safe = chain_compliance(reduced[node : node + 1], wrenches[node : node + 1])
            np.testing.assert_array_equal(alone[0], together[node])
            assert alone_safe[0] == safe[node]

    @pytest.mark.parametrize("exponent", [-200, -30, 30, 200])
    def test_scales_by_powers_of_two_without_an_error(self, exponent):
        reduced, wrenches = platforms(3, 50, 3, 3)
        found, safe = chain_compliance(reduced, wrenches)
        scaled, as_safe = chain_compliance(reduced * 2.0**exponent, wrenches)
        np.testing.assert_array_equal(scaled, found * 2.0**exponent)
        np.testing.assert_array_equal(as_safe, safe)

    def test_is_as_safe_and_as_exact_in_any_unit_of_length(self):
        reduced, wrenches = platforms(4, 50, 3, 3)
        found, safe = chain_compliance(reduced, wrenches)
        units = np.repeat([1.0, 2.0**10], 3)
        longer, as_safe = chain_compliance(reduced, wrenches * units)
        np.testing.assert_array_equal(longer * units[:, None] * units, found)
        np.testing.assert_array_equal(as_safe, safe)

    def test_comes_from_the_lower_triangles_alone(self):
        reduced, wrenches = platforms(5, 20, 3, 3)
        upper = np.triu(np.full((3, 3), np.nan), 1)
        np.testing.assert_array_equal(
            chain_compliance(np.tril(reduced) + upper, wrenches)[0], chain_compliance(reduced, wrenches)[0]
        )

    def test_takes_a_zero_wrench_of_unit_compliance_for_none(self):
        reduced, wrenches = platforms(6, 20, 3, 2)
        padded, rows = np.zeros((20, 3, 3, 3)), np.zeros((20, 3, 3, 6))
        padded[:, :, :2, :2], padded[:, :, 2, 2], rows[:, :, :2] = reduced, 1.0, wrenches
        np.testing.assert_array_equal(
            chain_compliance(padded, rows)[0], chain_compliance(reduced, wrenches)[0]
        )


class TestSafety:
    @pytest.mark.parametrize("node", [0, 7, 8, 12])
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_is_denied_to_what_is_not_finite_and_to_that_node_alone(self, node, bad):
        reduced, wrenches = platforms(7, 13, 3, 3)
        expected, safe = chain_compliance(reduced, wrenches)
        assert safe.all()
        for array in (reduced, wrenches):
            spoilt = array.copy()
            spoilt[node, 1, 2, 1] = bad
            found, safe = chain_compliance(*(spoilt if a is array else a for a in (reduced, wrenches)))
            assert np.flatnonzero(~safe).tolist() == [node]
            assert np.isnan(found[node]).all()
            np.testing.assert_array_equal(np.delete(found, node, 0), np.delete(expected, node, 0))

    @pytest.mark.parametrize("compliance", [0.0, 1e-9, -1.0])
    def test_is_denied_to_a_chain_that_is_rigid_in_some_direction(self, compliance):
        reduced, wrenches = platforms(8, 10, 3, 2)
        axis = np.array([0.6, 0.8])
        across = np.array([0.8, -0.6])
        reduced[4, 2] = np.outer(axis, axis) + compliance * np.outer(across, across)
        _, safe = chain_compliance(reduced, wrenches)
        assert np.flatnonzero(~safe).tolist() == [4]

    def test_is_denied_to_a_loose_platform(self):
        reduced, wrenches = platforms(9, 10, 3, 3)
        wrenches[3, :, :, 5] = wrenches[3, :, :, 4]
        _, safe = chain_compliance(reduced, wrenches)
        assert np.flatnonzero(~safe).tolist() == [3]

    def test_is_denied_to_too_few_wrenches(self):
        found, safe = chain_compliance(*platforms(10, 9, 3, 1))
        assert not safe.any()
        assert np.isnan(found).all()

    def test_is_denied_without_chains(self):
        _, safe = chain_compliance(np.empty((2, 0, 3, 3)), np.empty((2, 0, 3, 6)))
        assert not safe.any()


def zeros(*shape, dtype="f8"):
    return np.zeros(shape, dtype=dtype)


def flags(count):
    return zeros(count, dtype="u1")


CHAINS = zeros(2, 3, 6, 6)


class TestArguments:
    def test_may_be_without_nodes(self):
        found, safe = chain_compliance(zeros(0, 3, 2, 2), zeros(0, 3, 2, 6))
        assert found.shape == (0, 6, 6)
        assert safe.shape == (0,)

    def test_of_the_wrong_shape_are_refused(self):
        with pytest.raises(ValueError, match="wrenches has another shape"):
            chain_compliance(zeros(2, 3, 2, 2), zeros(2, 3, 3, 6))
        with pytest.raises(ValueError, match="compliances has the wrong number of dimensions"):
            chain_compliance(zeros(2, 3, 3), zeros(2, 3, 3, 6))

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (
                (zeros(2, 3, 7, 7), zeros(2, 3, 7, 6), zeros(2, 6, 6), flags(2)),
                "compliances has another shape",
            ),
            (
                (zeros(2, 3, 0, 0), zeros(2, 3, 0, 6), zeros(2, 6, 6), flags(2)),
                "compliances has another shape",
            ),
            (
                (zeros(2, 3, 2, 3), zeros(2, 3, 2, 6), zeros(2, 6, 6), flags(2)),
                "compliances has another shape",
            ),
            ((zeros(2, 3, 2, 2), zeros(2, 4, 2, 6), zeros(2, 6, 6), flags(2)), "wrenches has another shape"),
            ((zeros(2, 3, 2, 2), zeros(2, 3, 2, 5), zeros(2, 6, 6), flags(2)), "wrenches has another shape"),
            ((zeros(2, 3, 2, 2), zeros(2, 3, 2, 6), zeros(3, 6, 6), flags(2)), "out has another shape"),
            ((zeros(2, 3, 2, 2), zeros(2, 3, 2, 6), zeros(2, 6, 5), flags(2)), "out has another shape"),
            ((zeros(2, 3, 2, 2), zeros(2, 3, 2, 6), zeros(2, 6, 6), flags(3)), "safe has another shape"),
            ((CHAINS, zeros(2, 3, 6, 6), CHAINS[0, :2], flags(2)), "out overlaps"),
            ((zeros(2, 3, 6, 6), CHAINS, CHAINS[1, 1:], flags(2)), "out overlaps"),
        ],
    )
    def test_wrong_ones_are_named(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            _kernels.chain_compliance(*arguments)

    def test_that_share_memory_with_the_flags_are_refused(self):
        out = zeros(2, 6, 6)
        with pytest.raises(ValueError, match="safe overlaps"):
            _kernels.chain_compliance(
                zeros(2, 3, 2, 2), zeros(2, 3, 2, 6), out, out.view("u1").reshape(-1)[:2]
            )

    @pytest.mark.parametrize("position", range(4))
    def test_of_the_wrong_type_are_named(self, position):
        arguments = [zeros(2, 3, 2, 2), zeros(2, 3, 2, 6), zeros(2, 6, 6), flags(2)]
        arguments[position] = arguments[position].astype("f4")
        name = ("compliances", "wrenches", "out", "safe")[position]
        with pytest.raises(TypeError, match=f"{name} has the wrong type"):
            _kernels.chain_compliance(*arguments)

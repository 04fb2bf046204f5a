"""The kernels of positive definite matrices and of rows equal their twins, and say where they would not."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.intervals import Interval
from orthospec.kernels import (
    _kernels,
    positive_inverse,
    positive_solve,
    row_norms,
    symmetric_eigenvalues,
    twin,
)

EPS = np.finfo(float).eps
SIZES = range(1, 7)
seeds = st.integers(0, 2**32 - 1)


def definite(seed, count, size, condition=100.0):
    random = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(random.standard_normal((count, size, size)))
    matrices = (axes * np.geomspace(1, condition, size)) @ np.swapaxes(axes, 1, 2)
    return 0.5 * (matrices + np.swapaxes(matrices, 1, 2))


def right_sides(seed, count, size, columns):
    return np.random.default_rng(seed).standard_normal((count, size, columns))


class TestPositiveMatrices:
    @settings(max_examples=200, deadline=None)
    @given(st.sampled_from(SIZES), st.integers(1, 70), st.integers(1, 5), seeds)
    def test_equal_the_twins(self, size, count, columns, seed):
        matrices, right = definite(seed, count, size), right_sides(seed, count, size, columns)
        inverse, safe = positive_inverse(matrices)
        assert safe.all()
        np.testing.assert_allclose(inverse, twin.positive_inverse(matrices), rtol=0, atol=1e-13)
        for b in (right, right[:, :, 0]):
            solution, safe = positive_solve(matrices, b)
            assert safe.all()
            np.testing.assert_allclose(solution, twin.positive_solve(matrices, b), rtol=0, atol=1e-12)

    @pytest.mark.parametrize("size", [2, 3, 6])
    @pytest.mark.parametrize("condition", [1e2, 1e5])
    def test_are_right_to_rounding_times_the_condition(self, size, condition):
        matrices = definite(1, 8, size, condition)
        inverse, safe = positive_inverse(matrices)
        assert safe.any()
        with mpmath.workdps(40):
            for found, matrix in zip(inverse[safe], matrices[safe], strict=True):
                exact = mpmath.matrix(matrix.tolist()) ** -1
                error = max(
                    abs(mpmath.mpf(float(found[i, j])) - exact[i, j])
                    for i in range(size)
                    for j in range(size)
                )
                assert error <= 4 * EPS * condition

    @pytest.mark.parametrize("size", SIZES)
    def test_are_exactly_symmetric_and_from_the_lower_triangles_alone(self, size):
        matrices = definite(2, 40, size)
        inverse, _ = positive_inverse(matrices)
        np.testing.assert_array_equal(inverse, np.swapaxes(inverse, 1, 2))
        spoilt = matrices.copy()
        spoilt[:, *np.triu_indices(size, 1)] = np.nan
        np.testing.assert_array_equal(positive_inverse(spoilt)[0], inverse)

    @pytest.mark.parametrize("size", SIZES)
    def test_have_the_same_bits_in_any_company_and_order(self, size):
        matrices, right = definite(3, 75, size), right_sides(3, 75, size, 3)
        inverse, solution = positive_inverse(matrices)[0], positive_solve(matrices, right)[0]
        for node in range(75):
            one = slice(node, node + 1)
            np.testing.assert_array_equal(positive_inverse(matrices[one])[0][0], inverse[node])
            np.testing.assert_array_equal(positive_solve(matrices[one], right[one])[0][0], solution[node])
        lain = np.asfortranarray(matrices), np.asfortranarray(right)
        np.testing.assert_array_equal(positive_inverse(lain[0][::-2])[0], inverse[::-2])
        np.testing.assert_array_equal(positive_solve(lain[0][::-2], lain[1][::-2])[0], solution[::-2])

    def test_are_as_safe_and_as_exact_in_any_units(self):
        matrices, right = definite(4, 50, 6), right_sides(4, 50, 6, 2)
        units = 2.0 ** np.array([0, -200, 30, 150, -3, 10])
        found, safe = positive_inverse(matrices * units[:, None] * units)
        assert safe.all()
        np.testing.assert_array_equal(found * units[:, None] * units, positive_inverse(matrices)[0])
        solution, _ = positive_solve(matrices * units[:, None] * units, right * units[:, None])
        np.testing.assert_array_equal(solution * units[:, None], positive_solve(matrices, right)[0])

    @pytest.mark.parametrize("size", SIZES)
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 0.0])
    @pytest.mark.parametrize("node", [0, 31, 32, 40])
    def test_that_are_not_safe_are_nan_and_the_others_untouched(self, size, bad, node):
        matrices, right = definite(5, 41, size), right_sides(5, 41, size, 2)
        inverse, solution = positive_inverse(matrices)[0], positive_solve(matrices, right)[0]
        spoilt = matrices.copy()
        spoilt[node, size - 1, 0 if np.isinf(bad) else size - 1] = bad
        for found, safe, expected in (
            (*positive_inverse(spoilt), inverse),
            (*positive_solve(spoilt, right), solution),
        ):
            assert np.flatnonzero(~safe).tolist() == [node]
            assert np.isnan(found[node]).all()
            np.testing.assert_array_equal(np.delete(found, node, 0), np.delete(expected, node, 0))

    @pytest.mark.parametrize(("pivot", "is_safe"), [(1.1e-6, True), (0.9e-6, False), (-1.0, False)])
    def test_are_safe_by_their_pivots_beside_the_diagonal(self, pivot, is_safe):
        matrices = np.array([[[1.0, 1.0], [1.0, 1.0 + pivot]]])
        assert positive_inverse(matrices)[1].tolist() == [is_safe]
        assert positive_solve(matrices, np.ones((1, 2)))[1].tolist() == [is_safe]

    def test_do_not_answer_for_a_right_side_that_is_not_finite(self):
        matrices, right = definite(6, 5, 3), right_sides(6, 5, 3, 2)
        right[1, 0, 0] = np.nan
        solution, safe = positive_solve(matrices, right)
        assert safe.all()
        assert np.isnan(solution[1, :, 0]).all()
        assert np.isfinite(solution[1, :, 1]).all()

    def test_may_be_none_or_without_columns(self):
        assert positive_inverse(np.empty((0, 3, 3)))[0].shape == (0, 3, 3)
        assert positive_solve(np.empty((0, 3, 3)), np.empty((0, 3)))[0].shape == (0, 3)
        solution, safe = positive_solve(definite(7, 5, 3), np.empty((5, 3, 0)))
        assert solution.shape == (5, 3, 0)
        assert safe.all()


class TestRowNorms:
    @settings(max_examples=200, deadline=None)
    @given(st.integers(0, 70), st.integers(1, 7), st.integers(0, 7), seeds)
    def test_have_the_bits_of_the_twin(self, count, rows, columns, seed):
        matrices = np.random.default_rng(seed).standard_normal((count, rows, columns))
        expected = twin.row_norms(matrices)
        np.testing.assert_array_equal(row_norms(matrices), expected)
        for view in (
            np.asfortranarray(matrices),
            np.concatenate([matrices, matrices], axis=2)[:, :, columns:],
        ):
            np.testing.assert_array_equal(row_norms(view), expected)
        np.testing.assert_array_equal(row_norms(matrices[::-2]), expected[::-2])

    def test_of_long_rows_equal_the_twin(self):
        matrices = np.random.default_rng(1).standard_normal((20, 3, 100))
        np.testing.assert_allclose(row_norms(matrices), twin.row_norms(matrices), rtol=1e-14)

    def test_overflow_and_vanish_as_the_twin(self):
        extremes = [1e200, -1e200, 1e-200, 0.0, np.inf, -np.inf, np.nan, 1e154]
        matrices = np.random.default_rng(2).choice(extremes, (200, 3, 3))
        with np.errstate(over="ignore"):
            expected = twin.row_norms(matrices)
        np.testing.assert_array_equal(row_norms(matrices), expected)

    def test_of_intervals_are_intervals_around_those_of_their_middles(self):
        matrices = np.random.default_rng(3).standard_normal((9, 3, 3))
        found = row_norms(Interval(matrices - 1e-9, matrices + 1e-9))
        assert isinstance(found, Interval)
        assert ((found.lo <= row_norms(matrices)) & (row_norms(matrices) <= found.hi)).all()


def zeros(*shape, dtype="f8"):
    return np.zeros(shape, dtype=dtype)


def flags(count):
    return zeros(count, dtype="u1")


SHARED = zeros(3, 3, 3)
ODD = np.zeros((2, 3, 3), dtype=[("skip", "i4"), ("value", "f8")])["value"]
"""Its strides are no whole numbers of its elements."""


class TestArguments:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ((zeros(2, 3, 2), zeros(2, 3, 2), flags(2)), "matrices has another shape"),
            ((zeros(2, 7, 7), zeros(2, 7, 7), flags(2)), "matrices has another shape"),
            ((zeros(2, 0, 0), zeros(2, 0, 0), flags(2)), "matrices has another shape"),
            ((zeros(2, 3, 3), zeros(3, 3, 3), flags(2)), "out has another shape"),
            ((zeros(2, 3, 3), zeros(2, 3, 2), flags(2)), "out has another shape"),
            ((zeros(2, 3, 3), zeros(2, 3, 3), flags(1)), "safe has another shape"),
            ((SHARED[:2], SHARED[1:], flags(2)), "out overlaps"),
            ((zeros(3, 3, 3), SHARED, SHARED.view("u1").reshape(-1)[:3]), "safe overlaps"),
            ((SHARED, zeros(3, 3, 3), SHARED.view("u1").reshape(-1)[:3]), "safe overlaps"),
        ],
    )
    def test_wrong_ones_of_the_inverse_are_named(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            _kernels.positive_inverse(*arguments)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ((zeros(2, 3, 2), zeros(2, 3, 1), zeros(2, 3, 1), flags(2)), "matrices has another shape"),
            ((zeros(2, 3, 3), zeros(2, 2, 1), zeros(2, 2, 1), flags(2)), "right has another shape"),
            ((zeros(2, 3, 3), zeros(1, 3, 1), zeros(2, 3, 1), flags(2)), "right has another shape"),
            ((zeros(2, 3, 3), zeros(2, 3, 1), zeros(2, 3, 2), flags(2)), "out has another shape"),
            ((zeros(2, 3, 3), zeros(2, 3, 1), zeros(2, 3, 1), flags(3)), "safe has another shape"),
            ((zeros(2, 3, 3), SHARED[:2], SHARED[1:], flags(2)), "out overlaps"),
            ((SHARED[:2], zeros(2, 3, 3), SHARED[1:], flags(2)), "out overlaps"),
            (
                (zeros(3, 3, 3), SHARED, zeros(3, 3, 3), SHARED.view("u1").reshape(-1)[:3]),
                "safe overlaps",
            ),
        ],
    )
    def test_wrong_ones_of_the_solution_are_named(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            _kernels.positive_solve(*arguments)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ((zeros(2, 3, 4), zeros(2, 4)), "out has another shape"),
            ((zeros(2, 3, 4), zeros(1, 3)), "out has another shape"),
            ((SHARED, SHARED[0]), "out overlaps"),
        ],
    )
    def test_wrong_ones_of_the_norms_are_named(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            _kernels.row_norms(*arguments)

    def test_between_elements_are_taken_by_copy_or_refused(self):
        with pytest.raises(TypeError, match="matrices has the wrong type"):
            _kernels.positive_inverse(ODD, zeros(2, 3, 3), flags(2))
        with pytest.raises(TypeError, match="matrices has the wrong type"):
            _kernels.row_norms(ODD, zeros(2, 3))
        assert not positive_inverse(ODD)[1].any()
        assert not positive_solve(np.ones((2, 1, 1)), ODD[:, :1])[0].any()
        assert not row_norms(ODD).any()
        assert not symmetric_eigenvalues(ODD).any()

    def test_of_the_wrong_shape_are_refused(self):
        for shape in ((3, 3), (2, 3, 4)):
            with pytest.raises(ValueError, match=r"expected \(n, m, m\)"):
                positive_inverse(np.zeros(shape))
        with pytest.raises(ValueError, match="right has the shape"):
            positive_solve(np.zeros((2, 3, 3)), np.zeros(3))
        with pytest.raises(ValueError, match="right has another shape"):
            positive_solve(np.zeros((2, 3, 3)), np.zeros((3, 3)))
        with pytest.raises(ValueError, match=r"expected \(n, r, c\)"):
            row_norms(np.zeros((3, 3)))

    def test_of_the_wrong_type_are_named(self):
        with pytest.raises(TypeError, match="right has the wrong type"):
            _kernels.positive_solve(zeros(2, 3, 3), zeros(2, 3, 1, dtype="f4"), zeros(2, 3, 1), flags(2))
        with pytest.raises(TypeError, match="safe has the wrong type"):
            _kernels.positive_inverse(zeros(2, 3, 3), zeros(2, 3, 3), zeros(2))
        with pytest.raises(TypeError, match="out has the wrong type"):
            _kernels.row_norms(zeros(2, 3, 3), zeros(2, 3, dtype="f4"))

"""Each kernel equals its twin, and gives known answers where the twin would be too slow or too coarse."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.kernels import (
    _kernels,
    cube_sizes,
    gram_eigenvalues,
    singular_values,
    symmetric_eigenvalues,
    symmetric_eigenvectors,
    twin,
)

EPS = np.finfo(float).eps
DENSITIES = (0.0, 0.3, 0.7, 0.9, 0.97, 1.0)


def noise(shape, density, seed):
    return (np.random.default_rng(seed).random(shape) < density).astype(np.uint8)


def boxes(shape, seed):
    """A union of boxes with a few nodes knocked out."""
    random = np.random.default_rng(seed)
    mask = np.zeros(shape, dtype=np.uint8)
    for _ in range(random.integers(1, 4)):
        ends = [np.sort(random.integers(0, n + 1, size=2)) for n in shape]
        mask[tuple(slice(low, high) for low, high in ends)] = 1
    return mask & (random.random(shape) > 0.01)


shapes = st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(1, 9))
seeds = st.integers(0, 2**32 - 1)


class TestCubeSizes:
    @settings(max_examples=1500, deadline=None)
    @given(shapes, st.sampled_from(DENSITIES), seeds)
    def test_equals_twin_on_noise(self, shape, density, seed):
        mask = noise(shape, density, seed)
        np.testing.assert_array_equal(cube_sizes(mask), twin.cube_sizes(mask))

    @settings(max_examples=1000, deadline=None)
    @given(shapes, seeds)
    def test_equals_twin_on_boxes(self, shape, seed):
        mask = boxes(shape, seed)
        np.testing.assert_array_equal(cube_sizes(mask), twin.cube_sizes(mask))

    @settings(max_examples=300, deadline=None)
    @given(st.permutations([3, 4, 70]), st.sampled_from(DENSITIES), seeds)
    def test_equals_twin_on_slabs_along_each_axis(self, shape, density, seed):
        mask = noise(shape, density, seed)
        np.testing.assert_array_equal(cube_sizes(mask), twin.cube_sizes(mask))

    @pytest.mark.parametrize("row", [1, 2, 15, 16, 17, 31, 32, 33, 63, 64, 65, 255, 256, 257, 300])
    @pytest.mark.parametrize("density", [0.5, 0.99, 1.0])
    def test_equals_twin_on_rows_about_the_width_of_registers_and_cells(self, row, density):
        mask = noise((5, 4, row), density, seed=row)
        np.testing.assert_array_equal(cube_sizes(mask), twin.cube_sizes(mask))

    def test_equals_twin_on_a_ball(self):
        x, y, z = np.ogrid[-1:1:40j, -1:1:45j, -1:1:50j]
        mask = x**2 + y**2 + z**2 <= 0.9
        np.testing.assert_array_equal(cube_sizes(mask), twin.cube_sizes(mask))

    @pytest.mark.parametrize("shape", [(0, 3, 4), (3, 0, 4), (3, 4, 0), (0, 0, 0)])
    def test_of_a_mask_without_nodes_has_none(self, shape):
        assert cube_sizes(np.zeros(shape, dtype=np.uint8)).shape == shape

    @pytest.mark.parametrize("shape", [(1, 1, 1), (1, 7, 20), (7, 1, 20), (20, 7, 1)])
    def test_in_one_layer_are_the_mask(self, shape):
        mask = noise(shape, 0.8, seed=1)
        np.testing.assert_array_equal(cube_sizes(mask), mask)

    @pytest.mark.parametrize(
        ("shape", "cell"),
        [
            ((255, 257, 260), np.uint8),
            ((257, 260, 255), np.uint8),
            ((256, 256, 256), np.uint16),
            ((2, 3, 70_000), np.uint8),
        ],
    )
    def test_of_a_full_mask_grow_to_the_nearest_side(self, shape, cell):
        sizes = cube_sizes(np.ones(shape, dtype=np.uint8))
        i, j, k = np.ogrid[tuple(slice(0, n) for n in shape)]
        assert sizes.dtype == cell
        assert (sizes == np.minimum(np.minimum(i, j), k) + 1).all()

    @pytest.mark.parametrize("edge", [40, 257])
    def test_of_a_full_mask_with_one_hole_clear_the_hole(self, edge):
        hole = edge // 3
        mask = np.ones((edge, edge, edge), dtype=np.uint8)
        mask[hole, hole, hole] = 0
        i, j, k = np.ogrid[:edge, :edge, :edge]
        nearest, farthest = np.minimum(np.minimum(i, j), k), np.maximum(np.maximum(i, j), k)
        expected = np.where(nearest >= hole, np.minimum(nearest + 1, farthest - hole), nearest + 1)
        assert (cube_sizes(mask) == expected).all()

    def test_do_not_depend_on_the_width_of_the_cells(self):
        mask = noise((20, 30, 40), 0.98, seed=2)
        wide = np.empty(mask.shape, dtype=np.uint16)
        _kernels.cube_sizes(mask, wide)
        np.testing.assert_array_equal(wide, cube_sizes(mask))

    def test_count_every_nonzero_node_as_one(self):
        mask = noise((5, 6, 40), 0.9, seed=3)
        values = mask * np.random.default_rng(4).integers(1, 256, mask.shape, dtype=np.uint8)
        np.testing.assert_array_equal(cube_sizes(values), cube_sizes(mask))
        np.testing.assert_array_equal(cube_sizes(mask != 0), cube_sizes(mask))

    def test_of_a_strided_mask_are_those_of_its_copy(self):
        mask = noise((12, 10, 14), 0.95, seed=5)
        view = mask.T[::2, ::-1]
        np.testing.assert_array_equal(cube_sizes(view), cube_sizes(view.copy()))


def symmetric(matrices):
    """The symmetric matrices with these lower triangles."""
    return np.tril(matrices) + np.swapaxes(np.tril(matrices, -1), 1, 2)


def with_spectrum(spectrum, count, seed):
    """Symmetric matrices with about this spectrum, turned at random."""
    size = len(spectrum)
    turns, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((count, size, size)))
    return symmetric((turns * np.asarray(spectrum, dtype=float)) @ np.swapaxes(turns, 1, 2))


def worst_error(matrices):
    """The greatest error of an eigenvalue beside the norm of its matrix, in units of EPS, by 50 digits."""
    worst = 0.0
    with mpmath.workdps(50):
        for matrix, computed in zip(matrices, symmetric_eigenvalues(matrices), strict=True):
            exact = sorted(mpmath.eigsy(mpmath.matrix(matrix.tolist()), eigvals_only=True))
            norm = max(abs(value) for value in exact) or 1
            error = max(abs(mpmath.mpf(float(c)) - e) for c, e in zip(computed, exact, strict=True))
            worst = max(worst, float(error / norm))
    return worst / EPS


entries = st.floats(allow_nan=False, allow_infinity=False)
SIZES = (2, 3, 4, 5, 6)
ROUNDING = {2: 2, 3: 4, 4: 8, 5: 8, 6: 8}
"""By size, the greatest error in units of EPS; LAPACK's is as great on the same matrices."""
COUNTS = {2: 100, 3: 100, 4: 30, 5: 12, 6: 12}
"""Matrices that mpmath is asked for: it takes 40 ms for one of 6 x 6."""


class TestSymmetricEigenvalues:
    @pytest.mark.parametrize("size", SIZES)
    def test_equal_the_twin_at_random(self, size):
        matrices = symmetric(np.random.default_rng(6).standard_normal((10_000, size, size)))
        expected = twin.symmetric_eigenvalues(matrices)
        norms = np.abs(expected).max(axis=1, keepdims=True)
        assert (np.abs(symmetric_eigenvalues(matrices) - expected) <= 16 * EPS * norms).all()

    @pytest.mark.parametrize("size", SIZES)
    def test_equal_the_twin_where_entries_and_eigenvalues_repeat(self, size):
        """Small integers, a third of them 0: blocks, rank one, and shifts that are eigenvalues."""
        random = np.random.default_rng(23)
        matrices = symmetric(random.choice([0, 0, 1, -1, 2, -2], (30_000, size, size)).astype(float))
        expected = twin.symmetric_eigenvalues(matrices)
        norms = np.abs(expected).max(axis=1, keepdims=True)
        assert (np.abs(symmetric_eigenvalues(matrices) - expected) <= 16 * EPS * norms).all()

    @pytest.mark.parametrize("size", SIZES)
    def test_are_right_to_rounding_at_random(self, size):
        matrices = symmetric(np.random.default_rng(7).standard_normal((COUNTS[size], size, size)))
        assert worst_error(matrices) <= ROUNDING[size]

    @pytest.mark.parametrize("size", SIZES)
    @pytest.mark.parametrize("least", [1e-20, 1e-150])
    def test_are_right_to_rounding_where_entries_are_of_all_sizes(self, size, least):
        random = np.random.default_rng(24)
        powers = random.uniform(np.log10(least), 0, (COUNTS[size], size, size))
        assert worst_error(symmetric(random.choice([-1, 1], powers.shape) * 10.0**powers)) <= ROUNDING[size]
        steps = np.geomspace(1, least, size)
        graded = symmetric(random.standard_normal((COUNTS[size], size, size)) * steps[:, None] * steps)
        assert worst_error(graded) <= ROUNDING[size]
        assert worst_error(symmetric(graded[:, ::-1, ::-1])) <= ROUNDING[size]

    @pytest.mark.parametrize("split", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-15, 1e-16, 0.0])
    @pytest.mark.parametrize(
        ("base", "direction"),
        [((1, 1, 2), (0, 1, 0)), ((1, 2, 2), (0, 0, 1)), ((1, 1, 1), (-1, 0, 1)), ((-1, 0, 0), (0, 0, 1))],
        ids=["low pair", "high pair", "triple", "pair at zero"],
    )
    def test_are_right_to_rounding_where_they_meet(self, base, direction, split):
        spectrum = np.asarray(base) + split * np.asarray(direction)
        assert worst_error(with_spectrum(spectrum, 25, seed=8)) <= 4

    @pytest.mark.parametrize("split", [1e-8, 1e-15, 0.0])
    @pytest.mark.parametrize(
        "base",
        [(1, 1), (1, 1, 1, 1, 1, 1), (1, 1, 1, 2, 2, 2), (0, 0, 0, 0, 0, 1), (-1, -1, 0, 0, 1, 1)],
        ids=["both", "all", "two triples", "one alone", "three pairs"],
    )
    def test_of_other_sizes_are_right_to_rounding_where_they_meet(self, base, split):
        spectrum = np.asarray(base) + split * np.arange(len(base))
        assert worst_error(with_spectrum(spectrum, 8, seed=8)) <= ROUNDING[len(base)]

    @pytest.mark.parametrize("size", [2, 3, 6])
    @pytest.mark.parametrize("off_diagonal", [1e-8, 1e-16, 1e-100, 1e-160, 1e-300, 5e-324])
    def test_are_right_to_rounding_beside_a_multiple_of_the_identity(self, off_diagonal, size):
        random = np.random.default_rng(9).uniform(-1, 1, (COUNTS[size] // 4, size, size))
        assert worst_error(np.eye(size) + symmetric(random * off_diagonal)) <= ROUNDING[size]

    @pytest.mark.parametrize("size", [2, 3, 6])
    @pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-150, 1e-90, 1e90, 1e150, 1e300])
    def test_are_right_to_rounding_at_any_scale(self, scale, size):
        matrices = symmetric(
            np.random.default_rng(10).uniform(-1, 1, (COUNTS[size] // 4, size, size)) * scale
        )
        smallest = np.finfo(float).smallest_subnormal
        assert worst_error(matrices) <= ROUNDING[size] + 4 * smallest / scale / EPS

    def test_are_right_to_rounding_with_one_small_entry_everywhere(self):
        matrices = symmetric(np.random.default_rng(11).standard_normal((60, 3, 3)))
        row, column = np.tril_indices(3)
        which = np.arange(60) % 6
        matrices[np.arange(60), row[which], column[which]] *= 1e-9
        assert worst_error(symmetric(matrices)) <= 4

    @settings(max_examples=300, deadline=None)
    @given(st.lists(entries, min_size=1, max_size=6))
    def test_of_a_diagonal_matrix_are_its_entries(self, diagonal):
        assert symmetric_eigenvalues(np.diag(diagonal)[None])[0].tolist() == sorted(diagonal)

    @settings(max_examples=200, deadline=None)
    @given(st.integers(1, 6), st.data())
    def test_ascend(self, size, data):
        values = data.draw(st.lists(st.floats(-1e3, 1e3), min_size=size**2, max_size=size**2))
        eigenvalues = symmetric_eigenvalues(np.reshape(values, (1, size, size)))[0]
        assert (np.diff(eigenvalues) >= 0).all()

    @pytest.mark.parametrize("size", SIZES)
    def test_scale_by_powers_of_two_without_an_error(self, size):
        matrices = symmetric(np.random.default_rng(12).standard_normal((200, size, size)))
        expected = symmetric_eigenvalues(matrices)
        for exponent in (-900, -305, -299, -1, 3, 299, 305, 900):
            scale = 2.0**exponent
            np.testing.assert_array_equal(symmetric_eigenvalues(matrices * scale), expected * scale)

    @pytest.mark.parametrize("size", [1, 2, 3, 6, 7])
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_of_a_matrix_that_is_not_finite_are_nan_and_of_the_others_untouched(self, size, bad):
        matrices = symmetric(np.random.default_rng(13).standard_normal((size * size, size, size)))
        expected = symmetric_eigenvalues(matrices)
        lower = zip(*np.tril_indices(size), strict=True)
        for n, (row, column) in enumerate(lower):
            spoilt = matrices.copy()
            spoilt[n, row, column] = bad
            eigenvalues = symmetric_eigenvalues(spoilt)
            assert np.isnan(eigenvalues[n]).all()
            np.testing.assert_array_equal(np.delete(eigenvalues, n, axis=0), np.delete(expected, n, axis=0))

    @pytest.mark.parametrize("size", SIZES)
    def test_have_the_same_bits_in_any_company(self, size):
        random = np.random.default_rng(22)
        powers = 10.0 ** random.uniform(-18, 0, (75, size, size))
        matrices = symmetric(
            random.standard_normal(powers.shape) * np.where(random.random(75) < 0.5, 1.0, powers.T).T
        )
        together, gram = symmetric_eigenvalues(matrices), gram_eigenvalues(matrices)
        for node in range(75):
            np.testing.assert_array_equal(symmetric_eigenvalues(matrices[node : node + 1])[0], together[node])
            np.testing.assert_array_equal(gram_eigenvalues(matrices[node : node + 1])[0], gram[node])

    @pytest.mark.parametrize("size", [2, 3, 6, 7])
    def test_come_from_the_lower_triangle_alone(self, size):
        matrices = symmetric(np.random.default_rng(14).standard_normal((10, size, size)))
        spoilt = np.tril(matrices) + np.triu(np.full_like(matrices, np.nan), 1)
        spoilt[:, *np.tril_indices(size)] = matrices[:, *np.tril_indices(size)]
        np.testing.assert_array_equal(symmetric_eigenvalues(spoilt), symmetric_eigenvalues(matrices))

    @pytest.mark.parametrize("size", [0, 7, 9])
    def test_of_other_sizes_equal_the_twin(self, size):
        matrices = symmetric(np.random.default_rng(15).standard_normal((50, size, size)))
        np.testing.assert_array_equal(symmetric_eigenvalues(matrices), twin.symmetric_eigenvalues(matrices))

    @pytest.mark.parametrize("size", [2, 3])
    def test_of_no_matrices_are_none(self, size):
        assert symmetric_eigenvalues(np.empty((0, size, size))).shape == (0, size)

    @pytest.mark.parametrize("size", SIZES)
    def test_of_strided_and_integer_matrices_are_those_of_their_copies(self, size):
        matrices = symmetric(np.random.default_rng(16).integers(-9, 9, (70, size, size)))
        expected = symmetric_eigenvalues(matrices.astype(float).copy())
        np.testing.assert_array_equal(symmetric_eigenvalues(matrices), expected)
        np.testing.assert_array_equal(symmetric_eigenvalues(matrices[::-2]), expected[::-2])
        along = np.moveaxis(np.ascontiguousarray(np.moveaxis(matrices.astype(float), 0, 2)), 2, 0)
        np.testing.assert_array_equal(symmetric_eigenvalues(along), expected)


def conditioned(size, count, seed):
    """B and the diagonal of D of positive definite D B D: B well-conditioned, D over eight powers of ten."""
    random = np.random.default_rng(seed)
    halves = random.standard_normal((count, size, 2 * size))
    halves /= np.linalg.norm(halves, axis=2, keepdims=True)
    return halves @ np.swapaxes(halves, 1, 2), 10.0 ** random.uniform(-8, 0, (count, size))


class TestSymmetricEigenvectors:
    """Residuals are told beside the norm of each matrix, in units of EPS."""

    def assert_exact(self, matrices, bound):
        eigenvalues, vectors = symmetric_eigenvectors(matrices)
        size = matrices.shape[1]
        norms = np.abs(eigenvalues).max(axis=1)[:, None, None]
        gram = np.swapaxes(vectors, 1, 2) @ vectors
        assert (np.diff(eigenvalues, axis=1) >= 0).all()
        assert np.abs(gram - np.eye(size)).max() <= 20 * EPS
        assert (np.abs(matrices @ vectors - vectors * eigenvalues[:, None, :]) <= bound * EPS * norms).all()
        expected = twin.symmetric_eigenvectors(matrices)[0][:, :, None]
        assert (np.abs(eigenvalues[:, :, None] - expected) <= 16 * EPS * norms).all()

    @pytest.mark.parametrize("size", [1, *SIZES, 7])
    def test_are_orthonormal_and_leave_rounding_at_random(self, size):
        random = np.random.default_rng(25)
        self.assert_exact(symmetric(random.standard_normal((3000, size, size))), 16)
        self.assert_exact(symmetric(random.choice([0, 0, 1, -1, 2.0], (3000, size, size))), 16)
        self.assert_exact(symmetric(10.0 ** random.uniform(-30, 0, (3000, size, size))), 16)

    @pytest.mark.parametrize("split", [1e-8, 1e-15, 0.0])
    @pytest.mark.parametrize(
        "base", [(1, 1), (1, 1, 1), (1, 2, 2), (0, 0, 1), (1, 1, 1, 1, 1, 1), (-1, -1, 0, 0, 1, 1)]
    )
    def test_are_where_eigenvalues_meet(self, base, split):
        self.assert_exact(with_spectrum(np.asarray(base) + split * np.arange(len(base)), 300, seed=26), 16)

    @pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
    def test_are_at_any_scale(self, scale):
        matrices = symmetric(np.random.default_rng(27).uniform(-1, 1, (50, 3, 3)))
        eigenvalues, vectors = symmetric_eigenvectors(matrices * scale)
        expected, others = symmetric_eigenvectors(matrices)
        np.testing.assert_allclose(eigenvalues, expected * scale, rtol=1e-13)
        np.testing.assert_allclose(vectors, others, rtol=0, atol=1e-13)

    @pytest.mark.parametrize("size", [2, 3, 6])
    def test_have_every_eigenvalue_of_a_definite_matrix_to_rounding_of_itself(self, size):
        core, units = conditioned(size, 10, seed=28)
        matrices = symmetric(core * units[:, :, None] * units[:, None, :])
        found, _ = symmetric_eigenvectors(matrices)
        with mpmath.workdps(60):
            for eigenvalues, matrix, condition in zip(found, matrices, np.linalg.cond(core), strict=True):
                exact = sorted(mpmath.eigsy(mpmath.matrix(matrix.tolist()), eigvals_only=True))
                for computed, e in zip(eigenvalues, exact, strict=True):
                    assert abs(computed - e) <= 8 * EPS * condition * e

    @pytest.mark.parametrize("size", [2, 3, 6])
    def test_of_a_diagonal_matrix_are_the_axes(self, size):
        diagonal = np.array([3.0, -1.0, 2.0, 1e-300, 1e-20, -5.0])[:size]
        eigenvalues, vectors = symmetric_eigenvectors(np.diag(diagonal)[None])
        np.testing.assert_array_equal(eigenvalues[0], np.sort(diagonal))
        np.testing.assert_array_equal(vectors[0], np.eye(size)[:, np.argsort(diagonal)])

    @pytest.mark.parametrize("size", [1, 2, 3, 6, 7])
    def test_have_the_same_bits_in_any_company_beside_what_is_not_finite_and_in_any_order(self, size):
        matrices = symmetric(np.random.default_rng(29).standard_normal((70, size, size)))
        expected = symmetric_eigenvectors(matrices)
        for node in (0, 31, 32, 69):
            for found, wanted in zip(
                symmetric_eigenvectors(matrices[node : node + 1]), expected, strict=True
            ):
                np.testing.assert_array_equal(found[0], wanted[node])
            spoilt = matrices.copy()
            spoilt[node, size - 1, 0] = np.nan if node % 2 else np.inf
            for found, wanted in zip(symmetric_eigenvectors(spoilt), expected, strict=True):
                assert np.isnan(found[node]).all()
                np.testing.assert_array_equal(np.delete(found, node, 0), np.delete(wanted, node, 0))
        lain = np.asfortranarray(np.tril(matrices) + np.triu(np.full_like(matrices, np.nan), 1))
        lain[:, *np.diag_indices(size)] = matrices[:, *np.diag_indices(size)]
        for found, wanted in zip(symmetric_eigenvectors(lain[::-2]), expected, strict=True):
            np.testing.assert_array_equal(found, wanted[::-2])

    def test_of_no_matrices_are_none(self):
        assert [one.shape for one in symmetric_eigenvectors(np.empty((0, 3, 3)))] == [(0, 3), (0, 3, 3)]


class TestSingularValues:
    @pytest.mark.parametrize("size", [2, 3, 4, 5, 6, 7])
    def test_equal_lapacks_at_random_also_where_they_are_far_apart(self, size):
        random = np.random.default_rng(17)
        matrices = random.standard_normal((2000, size, size)) * np.geomspace(1, 1e-7, size)
        expected = np.linalg.svd(matrices, compute_uv=False)[:, ::-1]
        found = singular_values(matrices)
        apart = found[:, -1:] / found[:, :1]
        # The square of what is still told by the eigenvalues of the gram matrix is their ratio.
        error = np.abs(found - expected) / expected
        assert (error <= np.where(apart < 1e3, 8 * EPS * apart**2 + 16 * EPS, 64 * EPS * apart)).all()

    def test_equal_lapacks_where_they_meet_and_vanish(self):
        turns, _ = np.linalg.qr(np.random.default_rng(18).standard_normal((2, 200, 3, 3)))
        for spectrum in ([1, 1, 1], [1, 1, 2], [1, 2, 2], [0, 1, 2], [0, 0, 1], [1e-12, 1, 1]):
            matrices = (turns[0] * np.array(spectrum, dtype=float)) @ turns[1]
            assert np.abs(singular_values(matrices) - spectrum).max() <= 32 * EPS

    def test_of_what_is_not_finite_are_nan_and_of_nothing_nothing(self):
        matrices = np.array([np.eye(3), np.full((3, 3), np.inf), np.full((3, 3), np.nan), np.zeros((3, 3))])
        np.testing.assert_array_equal(singular_values(matrices)[:, 0], [1, np.nan, np.nan, 0])
        assert singular_values(np.empty((0, 3, 3))).shape == (0, 3)

    @pytest.mark.parametrize("size", SIZES)
    def test_squared_are_those_of_the_gram_matrix(self, size):
        matrices = np.random.default_rng(19).standard_normal((300, size, size))
        gram = np.swapaxes(matrices, 1, 2) @ matrices
        expected = symmetric_eigenvalues(gram)
        assert (np.abs(gram_eigenvalues(matrices) - expected) <= 32 * EPS * expected[:, -1:]).all()

    @pytest.mark.parametrize("size", [2, 3, 6])
    def test_do_not_depend_on_how_the_matrices_lie(self, size):
        matrices = np.random.default_rng(20).standard_normal((130, size, size))
        for view in (matrices[::-1], np.swapaxes(matrices, 1, 2), np.moveaxis(matrices.T.copy(), 2, 0)):
            np.testing.assert_array_equal(singular_values(view), singular_values(view.copy()))
            np.testing.assert_array_equal(symmetric_eigenvalues(view), symmetric_eigenvalues(view.copy()))


def zeros(*shape, dtype="u1"):
    return np.zeros(shape, dtype=dtype)


def frozen(array):
    array.flags.writeable = False
    return array


MASK = zeros(2, 3, 4)
MATRICES = zeros(2, 3, 3, dtype="f8")


class TestArguments:
    @pytest.mark.parametrize(
        ("mask", "out", "exception", "message"),
        [
            ([[[1]]], zeros(1, 1, 1), TypeError, "mask: expected an array of uint8 or bool"),
            (zeros(2, 3, 4), None, TypeError, "out: expected an array of uint8 or uint16"),
            (zeros(2, 3, 4, dtype="f8"), zeros(2, 3, 4), TypeError, "mask has the wrong type of element"),
            (zeros(2, 3, 4), zeros(2, 3, 4, dtype="i1"), TypeError, "out has the wrong type of element"),
            (zeros(2, 3, 4), zeros(2, 3, 4, dtype=">u2"), TypeError, "out has the wrong type of element"),
            (zeros(3, 4), zeros(2, 3, 4), ValueError, "mask has the wrong number of dimensions"),
            (zeros(2, 3, 4), zeros(1, 2, 3, 4), ValueError, "out has the wrong number of dimensions"),
            (zeros(2, 3, 4).T, zeros(4, 3, 2), ValueError, "mask is not C-contiguous"),
            (zeros(2, 3, 4), zeros(2, 3, 8)[:, :, ::2], ValueError, "out is not C-contiguous"),
            (zeros(2, 3, 4), frozen(zeros(2, 3, 4)), ValueError, "out is read-only"),
            (zeros(2, 3, 4), zeros(2, 4, 3), ValueError, "out has another shape than mask"),
            (MASK, MASK, ValueError, "out overlaps mask"),
            (zeros(256, 256, 256), zeros(256, 256, 256), ValueError, "out is too narrow"),
        ],
    )
    def test_wrong_ones_of_cube_sizes_are_named(self, mask, out, exception, message):
        with pytest.raises(exception, match=message):
            _kernels.cube_sizes(mask, out)

    @pytest.mark.parametrize(
        ("matrices", "out", "exception", "message"),
        [
            (1.0, zeros(2, 3, dtype="f8"), TypeError, "matrices: expected an array of float64"),
            (zeros(2, 3, 3, dtype="f4"), zeros(2, 3, dtype="f8"), TypeError, "matrices has the wrong type"),
            (zeros(2, 3, 3, dtype="f8"), zeros(2, 3, dtype="f4"), TypeError, "out has the wrong type"),
            (zeros(3, 3, dtype="f8"), zeros(2, 3, dtype="f8"), ValueError, "matrices has the wrong number"),
            (zeros(2, 3, 3, dtype="f8"), zeros(6, dtype="f8"), ValueError, "out has the wrong number"),
            (zeros(2, 3, 2, dtype="f8"), zeros(2, 3, dtype="f8"), ValueError, "matrices has another shape"),
            (zeros(2, 7, 7, dtype="f8"), zeros(2, 7, dtype="f8"), ValueError, "matrices has another shape"),
            (zeros(2, 0, 0, dtype="f8"), zeros(2, 0, dtype="f8"), ValueError, "matrices has another shape"),
            (zeros(2, 2, 2, dtype="f8"), zeros(2, 3, dtype="f8"), ValueError, "out has another shape"),
            (zeros(2, 3, 3, dtype="f8"), zeros(3, 3, dtype="f8"), ValueError, "out has another shape"),
            (zeros(2, 3, 3, dtype="f8"), zeros(2, 2, dtype="f8"), ValueError, "out has another shape"),
            (MATRICES, MATRICES[1, :2], ValueError, "out overlaps matrices"),
            (MATRICES[::-1], MATRICES[0, :2], ValueError, "out overlaps matrices"),
        ],
    )
    def test_wrong_ones_of_the_eigenvalues_are_named(self, matrices, out, exception, message):
        with pytest.raises(exception, match=message):
            _kernels.symmetric_eigenvalues(matrices, out)

    @pytest.mark.parametrize(
        ("matrices", "out", "vectors", "message"),
        [
            (zeros(2, 7, 7, dtype="f8"), zeros(2, 7, dtype="f8"), zeros(2, 7, 7, dtype="f8"), "matrices has"),
            (zeros(2, 3, 3, dtype="f8"), zeros(2, 2, dtype="f8"), zeros(2, 3, 3, dtype="f8"), "out has"),
            (zeros(2, 3, 3, dtype="f8"), zeros(2, 3, dtype="f8"), zeros(2, 3, 2, dtype="f8"), "vectors has"),
            (MATRICES, zeros(2, 3, dtype="f8"), MATRICES, "vectors overlaps"),
            (zeros(2, 3, 3, dtype="f8"), MATRICES[0, :2], MATRICES, "vectors overlaps"),
        ],
    )
    def test_wrong_ones_of_the_eigenvectors_are_named(self, matrices, out, vectors, message):
        with pytest.raises(ValueError, match=message):
            _kernels.symmetric_eigenvectors(matrices, out, vectors)

    def test_of_a_kernel_may_be_read_only_where_they_are_read(self):
        mask, out = frozen(np.ones((2, 2, 2), dtype=np.uint8)), zeros(2, 2, 2)
        _kernels.cube_sizes(mask, out)
        assert out.max() == 2

    def test_that_fail_are_let_go(self):
        mask = bytearray(8)
        with pytest.raises(ValueError, match="mask has the wrong number of dimensions"):
            _kernels.cube_sizes(mask, zeros(2, 2, 2))
        mask.append(0)
        assert len(mask) == 9

    @pytest.mark.parametrize("mask", [zeros(3, 4), zeros(2, 3, 4, 5), zeros(), np.float64(1.0)])
    def test_of_the_wrong_shape_are_refused_by_cube_sizes(self, mask):
        with pytest.raises((TypeError, ValueError), match="mask has the wrong"):
            cube_sizes(mask)

    @pytest.mark.parametrize("shape", [(3, 3), (2, 3, 4), (3,)])
    def test_of_the_wrong_shape_are_refused_by_the_eigenvalues(self, shape):
        with pytest.raises(ValueError, match=r"expected \(n, m, m\)"):
            symmetric_eigenvalues(np.zeros(shape))

"""The forms that measures share: matrix logarithms, and convex sizes divided by themselves."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.composite.template import compile_form
from orthospec.measures.forms import convex_size, matrix_logarithm, semidefinite_logarithm

seeds = st.integers(0, 2**32 - 1)


def turned(eigenvalues, seed):
    """A symmetric matrix with these eigenvalues, turned at random."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return (turn * np.asarray(eigenvalues)) @ turn.T


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(1e-3, 1e3), min_size=3, max_size=3), seeds)
def test_a_matrix_has_the_logarithms_of_its_eigenvalues(eigenvalues, seed):
    found = matrix_logarithm(turned(eigenvalues, seed)[None])[0]
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_allclose(np.linalg.eigvalsh(found), np.log(sorted(eigenvalues)), atol=1e-9)


def test_what_has_no_logarithm_is_nan_and_leaves_its_neighbours():
    bad = [
        np.full((3, 3), np.nan),
        np.full((3, 3), np.inf),
        np.diag([1.0, 1.0, 0.0]),
        np.diag([1.0, -1.0, 1.0]),
    ]
    found = matrix_logarithm(np.stack([np.eye(3), *bad, np.e * np.eye(3)]))
    assert np.isnan(found[1:-1]).all()
    np.testing.assert_array_equal(found[0], np.zeros((3, 3)))
    np.testing.assert_allclose(found[-1], np.eye(3), atol=1e-15)


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_a_semidefinite_matrix_keeps_the_logarithm_of_its_greatest_eigenvalue(rank):
    eigenvalues = np.array([3e-7, 2e-7, 1e-7]) * (np.arange(3) < rank)
    found = semidefinite_logarithm(turned(eigenvalues, 1)[None])[0]
    assert np.linalg.eigvalsh(found)[-1] == pytest.approx(np.log(3e-7), abs=1e-12)


def test_the_logarithm_of_zero_is_finite_and_far_below_all_others():
    found = semidefinite_logarithm(np.zeros((1, 3, 3)))
    assert np.linalg.eigvalsh(found[0])[-1] < -700


def test_a_matrix_with_a_negative_eigenvalue_is_no_semidefinite_one():
    assert np.isnan(semidefinite_logarithm(np.diag([1.0, -1e-6, 1.0])[None])).all()


def sized(matrices, floor=0.0):
    size = np.linalg.norm(matrices, 2, axis=(1, 2))
    return convex_size(
        matrices.reshape(-1, 9),
        size,
        lambda y, limit: [cp.sigma_max(cp.reshape(y, (3, 3), order="C")) <= limit],
        np.full(len(matrices), floor),
    )


def test_a_linearised_size_is_right_to_first_order_on_both_sides_of_a_kink(least_slack):
    """σ_max = 2(1 + |t|) along t, whose central difference at the kink is 0."""

    def along(t):
        return 2 * np.array([np.diag([1 + ti, 1 - ti, 0.5]) for ti in t])

    h = 1e-6
    low, here, high = sized(along([-h, 0.0, h])).inside
    slope = (high - low) / (2 * h)
    form = sized(along([0.0]))
    template = compile_form(form.holds, form.inside.shape[1:])
    for t in (-0.1, -0.01, 0.01, 0.1):
        needed = least_slack(template, here + slope * t, 2.0)
        assert needed == pytest.approx(np.log(1 + abs(t)), abs=t**2)


def test_a_size_of_nothing_but_rounding_is_divided_by_its_floor():
    random = np.random.default_rng(2)
    inside = sized(1e-16 * random.normal(size=(20, 3, 3)), floor=1e-7).inside
    np.testing.assert_allclose(inside[:, :-1], 0.0, atol=1e-8)
    np.testing.assert_array_equal(inside[:, -1], np.full(20, np.log(1e-7)))


def test_a_size_that_is_not_known_is_nan():
    parts = np.array([[1.0, np.nan], [3.0, 4.0]])
    form = convex_size(
        parts, np.linalg.norm(parts, axis=1), lambda y, limit: [cp.norm(y) <= limit], np.zeros(2)
    )
    assert np.isnan(form.inside[0, -1])
    np.testing.assert_allclose(form.inside[1], [0.6, 0.8, np.log(5.0)], rtol=1e-15)

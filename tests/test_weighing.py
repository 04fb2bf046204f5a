"""Conditions that cannot all hold: against closed forms and linear programs, and never against a point."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from orthospec.intervals.linear import Linear
from orthospec.workspace.weighing import cannot_all_hold


def forms(c, g, r=0.0):
    c = np.asarray(c, dtype=float)
    return Linear(c, np.asarray(g, dtype=float), np.broadcast_to(r, c.shape).astype(float))


@pytest.mark.parametrize(("rest", "excluded"), [(0.0, True), (0.09, True), (0.11, False)])
def test_two_that_are_opposed(rest, excluded):
    """0.1 + u and 0.1 − u: half of each is 0.1, whatever u."""
    assert cannot_all_hold(forms([[0.1, 0.1]], [[[1.0], [-1.0]]], rest)).tolist() == [excluded]


def test_three_in_a_plane_of_any_scale():
    """Their slopes are (1, 0), (−1, 1) and (−1, −1), which cancel as 2 : 1 : 1."""
    scales = np.array([1.0, 1e-6, 1e5])
    slopes = np.array([[1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]])
    for level, excluded in ((1e-3, True), (-1e-3, False)):
        found = cannot_all_hold(forms([level * scales], [slopes * scales[:, None]]))
        assert found.tolist() == [excluded]


def test_one_alone_suffices_and_what_is_not_known_counts_not():
    one = forms([[2.0, np.nan], [np.nan, np.nan], [0.5, 0.5]], np.ones((3, 2, 1)), [[0.5, np.nan]] * 3)
    assert cannot_all_hold(one).tolist() == [True, False, False]
    assert cannot_all_hold(forms(np.zeros((0, 4)), np.zeros((0, 4, 3)))).tolist() == []


def test_it_never_excludes_a_point_and_finds_most_of_what_a_linear_program_does():
    random = np.random.default_rng(0)
    n, k, d = 300, 5, 3
    slopes = random.normal(size=(n, k, d))
    point = random.uniform(-1, 1, (n, d))
    at = np.einsum("nkd,nd->nk", slopes, point)
    assert not cannot_all_hold(forms(-at - 1e-12 * random.uniform(size=(n, k)), slopes)).any()
    c, r = random.normal(0.3, 0.5, (n, k)), random.uniform(0, 0.1, (n, k))
    found = cannot_all_hold(forms(c, slopes, r))
    possible = np.array([_is_possible(*one) for one in zip(c - r, slopes, strict=True)])
    assert not (found & possible).any()
    assert found.sum() > 0.75 * (~possible).sum() > 50


def _is_possible(c, g):
    return linprog(np.zeros(g.shape[1]), A_ub=g, b_ub=-c, bounds=(-1, 1)).status == 0

"""Critical points: known maxima wherever they may stand, all of those that tie, and plateaus."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.workspace.critical import KEPT, MOST, find_peaks, highest_peaks, worst_points

inner = st.floats(-0.49, 0.49)


def hump(u, peak):
    """A turned, uneven hill with its top at ``peak``."""
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(len(peak),) * 2))[0]
    d = (u - np.asarray(peak)) @ turn * np.array([1.0, 1.4, 0.8])[: len(peak)]
    return 3.0 * np.exp(-(d**2).sum(axis=1)) + 0.05 * (d**3).sum(axis=1)


def best_of(peaks, k):
    mine = np.flatnonzero(peaks.of == k)
    return mine[peaks.value[mine].argmax()]


@settings(max_examples=40, deadline=None)
@given(st.tuples(inner, inner, inner))
def test_a_maximum_inside_is_found_to_many_digits(top):
    peaks = find_peaks(lambda u: hump(u, top)[None], 3)
    assert peaks.greatest(1)[0] == pytest.approx(3.0, abs=1e-9)
    np.testing.assert_allclose(peaks.u[best_of(peaks, 0)], top, atol=1e-5)


@settings(max_examples=40, deadline=None)
@given(st.tuples(inner, inner), st.sampled_from([(axis, end) for axis in range(3) for end in (-0.5, 0.5)]))
def test_a_maximum_on_a_face_is_found(rest, face):
    axis, end = face
    top = np.insert(np.array(rest), axis, end)
    slope = np.sign(end)

    def function(u):
        return (2 * slope * u[:, axis] - ((np.delete(u - top, axis, axis=1)) ** 2).sum(axis=1))[None]

    peaks = find_peaks(function, 3)
    assert peaks.greatest(1)[0] == pytest.approx(1.0, abs=1e-10)
    np.testing.assert_allclose(peaks.u[best_of(peaks, 0)], top, atol=1e-5)


@pytest.mark.parametrize("along", range(3))
@pytest.mark.parametrize("place", [-0.31, 0.0, 0.123456])
def test_a_maximum_on_an_edge_is_found(along, place):
    others = [k for k in range(3) if k != along]

    def function(u):
        return (u[:, others[0]] - 2 * u[:, others[1]] - np.cosh(3 * (u[:, along] - place)))[None]

    peaks = find_peaks(function, 3)
    assert peaks.greatest(1)[0] == pytest.approx(0.5, abs=1e-11)
    u = peaks.u[best_of(peaks, 0)]
    np.testing.assert_array_equal(u[others], [0.5, -0.5])
    assert u[along] == pytest.approx(place, abs=1e-5)


@pytest.mark.parametrize("corner", list(product((-0.5, 0.5), repeat=3)))
def test_a_maximum_in_a_corner_is_exactly_there(corner):
    peaks = find_peaks(lambda u: (u @ np.array(corner) + 0.1 * np.sin(u).sum(axis=1))[None], 3)
    np.testing.assert_array_equal(peaks.u[best_of(peaks, 0)], corner)


def test_all_maxima_of_a_symmetric_function_are_found():
    peaks = find_peaks(lambda u: (u**2).sum(axis=1)[None], 3)
    corners = {tuple(u) for u, value in zip(peaks.u, peaks.value, strict=True) if value > 0.75 - 1e-12}
    assert corners == set(product((-0.5, 0.5), repeat=3))


def test_all_tied_maxima_inside_are_found():
    peaks = find_peaks(lambda u: -((u**2 - 0.26**2) ** 2).sum(axis=1)[None], 3)
    for top in product((-0.26, 0.26), repeat=3):
        assert np.abs(peaks.u - top).max(axis=1).min() < 1e-5


def two_bells(height):
    """One bell of height 1, and one so high at the opposite place."""

    def function(u):
        bells = [np.exp(-20 * ((u - place) ** 2).sum(axis=1)) for place in (0.3, -0.3)]
        return np.maximum(bells[0], height * bells[1])[None]

    return function


@pytest.mark.parametrize(("height", "joins"), [(0.98, True), (0.3, False)])
def test_near_greatest_maxima_are_critical_too_and_far_lower_ones_are_not(height, joins):
    peaks = find_peaks(two_bells(height), 3)
    assert np.abs(peaks.u - 0.3).max(axis=1).min() < 1e-5
    assert bool(np.abs(peaks.u + 0.3).max(axis=1).min() < 1e-5) is joins


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_plateau_gives_few_points(d):
    peaks = find_peaks(lambda u: np.ones((1, len(u))), d)
    assert 1 <= len(peaks.u) <= MOST
    assert (peaks.value == 1).all()


def test_each_function_has_its_own_points():
    def functions(u):
        return np.stack([hump(u, (0.1, 0.2)), -hump(u, (0.1, 0.2)), u[:, 0]])

    peaks = find_peaks(functions, 2)
    assert set(peaks.of) == {0, 1, 2}
    np.testing.assert_allclose(peaks.value, functions(peaks.u)[peaks.of, np.arange(len(peaks.u))], atol=1e-15)
    assert peaks.greatest(3)[2] == 0.5
    assert peaks.u[best_of(peaks, 2)][0] == 0.5


def test_a_known_point_finds_what_the_lattice_misses():
    def function(u):
        return (-0.1 * u[:, 0] + 2 * np.exp(-4e4 * ((u - 0.0517) ** 2).sum(axis=1)))[None]

    assert find_peaks(function, 2).greatest(1)[0] < 0.1
    known = find_peaks(function, 2, known=np.array([[0.052, 0.0512]]))
    assert known.greatest(1)[0] == pytest.approx(1.99483, abs=1e-5)


def test_what_cannot_be_computed_is_the_worst_of_all():
    def function(u):
        return np.where(u[:, 0] > 0.4, np.inf, u[:, 0])[None]

    assert find_peaks(function, 3).greatest(1)[0] == np.inf


def test_values_of_minus_infinity_do_no_harm():
    peaks = find_peaks(lambda u: np.stack([np.full(len(u), -np.inf), u[:, 0]]), 3)
    np.testing.assert_array_equal(peaks.greatest(2), [-np.inf, 0.5])


def test_the_highest_peak_of_each_function_is_climbed_up_a_cone():
    """Newton has no curvature to go by at the top of a cone."""

    def functions(u):
        cone = -np.abs(
            (u - np.array([0.111, -0.237, 0.049])) @ np.array([[1, 2, 0], [0, 1, 1], [1, 0, 1]])
        ).sum(axis=1)
        return np.stack([cone, -u[:, 2]])

    found = highest_peaks(functions, find_peaks(functions, 3), 2)
    np.testing.assert_array_equal(found.of, [0, 1])
    assert found.value[1] == 0.5
    assert found.value[0] > find_peaks(functions, 3).greatest(2)[0]
    assert found.value[0] == pytest.approx(0.0, abs=1e-4)


def test_a_flat_peaks_many_points_do_not_crowd_out_a_corner():
    many = np.column_stack([np.linspace(-0.05, 0.05, 3 * KEPT), np.zeros(3 * KEPT)])
    u = np.vstack([many, [[0.5, 0.5]]])
    values = np.concatenate([-1e-3 * many[:, 0] ** 2, [-0.2]])[None]
    kept = worst_points(values, u)
    assert len(kept) == KEPT
    assert len(u) - 1 in kept
    assert int(values.argmax()) in kept


def test_the_worst_point_of_each_row_is_kept_and_one_that_is_not_known_is_not():
    u = np.column_stack([np.linspace(-0.5, 0.5, 4 * KEPT), np.zeros(4 * KEPT)])
    values = np.stack([u[:, 0], -2.0 - u[:, 0]])
    values[1, -1] = np.inf
    kept = worst_points(values, u)
    assert {0, len(u) - 2} <= set(kept)
    assert len(u) - 1 not in kept


@pytest.mark.parametrize("known", [np.array([[0.2, 0.5], [-0.13, 0.5]]), None])
def test_points_on_a_ridge_stay_where_they_are(known):
    """What changes by rounding only along a ridge is no rise: points would wander, and become ever more."""
    peaks = find_peaks(lambda u: (u[:, 1] + 1e-16 * np.sin(1e3 * u[:, 0]))[None], 2, known=known)
    places = {tuple(u) for u in peaks.u}
    assert len(places) <= 3 + (0 if known is None else len(known))
    assert known is None or {tuple(u) for u in known} <= places


def test_of_many_known_points_the_greatest_count():
    """A spike that no lattice meets, known beside more points of a plateau than are looked at."""
    spike = np.array([0.123, 0.234, 0.345])

    def functions(u):
        return np.exp(-np.sum((u - spike) ** 2, axis=1, keepdims=True).T / 1e-8)

    known = np.vstack([np.random.default_rng(0).uniform(-0.5, 0, (2 * MOST, 3)), spike])
    assert find_peaks(functions, 3).greatest(1)[0] < 1e-6
    assert find_peaks(functions, 3, known).greatest(1)[0] == pytest.approx(1.0)

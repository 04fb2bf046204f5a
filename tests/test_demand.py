"""Demands: bounds held to the last bit but one, their excess, and their levels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.measures import Demand, Level
from orthospec.measures.demand import LITTLE, bounded_side, excess
from orthospec.measures.kinematic import ConditionNumber, VelocityTransmission

positive = st.floats(1e-6, 1e6)
bounds = st.just(0.0) | positive | positive.map(lambda bound: -bound)


def demand(**bounds):
    return Demand("transmission", VelocityTransmission(), bounds, (Level({"at_most": 1.5}),), "s.yaml:3:5")


def test_each_side_bounds_its_own_column():
    values = np.array([[0.5, 2.0], [0.4, 2.0], [0.5, 2.1], [0.6, 1.9]])
    np.testing.assert_array_equal(demand(at_least=0.5, at_most=2.0).meets(values), [True, False, False, True])
    np.testing.assert_array_equal(demand(at_least=0.5).meets(values), [True, False, True, True])
    np.testing.assert_array_equal(bounded_side(values, "at_least"), values[:, 0])
    np.testing.assert_array_equal(bounded_side(values, "at_most"), values[:, 1])
    np.testing.assert_array_equal(bounded_side(values[:, 0], "at_most"), values[:, 0])


def test_a_bound_holds_within_rounding_and_no_further():
    condition = Demand("condition", ConditionNumber(), {"at_most": 3.0})
    values = np.array([3.0, 3.0 * (1 + 5e-13), 3.0 * (1 + 2e-12)])
    np.testing.assert_array_equal(condition.meets(values), [True, True, False])
    least = Demand("x", VelocityTransmission(), {"at_least": 0.5})
    np.testing.assert_array_equal(
        least.meets(np.array([0.5, 0.5 * (1 - 5e-13), 0.5 * (1 - 2e-12)])), [True, True, False]
    )


def test_nan_does_not_meet_and_infinity_meets_only_from_below():
    values = np.array([np.nan, np.inf])
    np.testing.assert_array_equal(
        Demand("x", ConditionNumber(), {"at_most": 3.0}).meets(values), [False, False]
    )
    np.testing.assert_array_equal(
        Demand("x", ConditionNumber(), {"at_least": 3.0}).meets(values), [False, True]
    )


def test_a_level_keeps_the_measure_and_place():
    whole = demand(at_least=0.5)
    level = whole.at(whole.levels[0])
    assert dict(level.bounds) == {"at_most": 1.5}
    assert (level.name, level.measure, level.place) == (whole.name, whole.measure, whole.place)
    assert level.levels == ()


@given(positive, positive)
def test_excess_of_positive_values_is_the_logarithm_of_the_ratio(value, bound):
    values = np.array([value])
    assert excess(values, bound, "at_most")[0] == pytest.approx(np.log(value / bound), abs=1e-12)
    if value >= LITTLE * bound:
        assert excess(values, bound, "at_least")[0] == pytest.approx(np.log(bound / value), abs=1e-12)


def test_excess_goes_on_straight_where_a_value_is_little_or_negative():
    values = 3.0 * LITTLE * np.array([1 + 1e-6, 1.0, 1 - 1e-6, 0.5, -0.5, -1000.0, 0.0])
    found = excess(values, 3.0, "at_least")
    slopes = np.diff(found[:3]) / np.diff(values[:3])
    assert slopes[0] == pytest.approx(slopes[1], rel=1e-5)
    np.testing.assert_allclose(found[3:6], -np.log(LITTLE) + np.array([0.5, 1.5, 1001.0]), rtol=1e-12)
    assert np.isinf(found[6])


@given(st.floats(-1e6, 1e6), bounds, st.sampled_from(["at_least", "at_most"]))
def test_excess_has_the_sign_of_the_violation(value, bound, side):
    found = excess(np.array([value]), bound, side)[0]
    holds = value >= bound if side == "at_least" else value <= bound
    assert (found <= 0) == holds


@pytest.mark.parametrize(("bound", "expected"), [(0.0, 0.3), (-2.0, 1.15)])
def test_excess_over_a_bound_that_is_not_positive_is_the_relative_difference(bound, expected):
    assert excess(np.array([0.3]), bound, "at_most")[0] == pytest.approx(expected)


def test_excess_at_the_ends():
    values = np.array([np.nan, np.inf, 0.0])
    np.testing.assert_array_equal(excess(values, 2.0, "at_most"), [np.nan, np.inf, -1.0])
    np.testing.assert_array_equal(excess(values, 2.0, "at_least"), [np.nan, -np.inf, np.inf])

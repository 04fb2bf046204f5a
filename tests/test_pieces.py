"""The pieces of an expression: their greatest or least is the expression."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.quantities import Expression
from orthospec.quantities.expressions import GOAL_CALLS
from orthospec.quantities.pieces import MOST, pieces

VALUES = st.fixed_dictionaries({name: st.floats(0.1, 10) for name in "abcd"})

EXPRESSIONS = [
    "max(a, b)",
    "min(a, b)",
    "2 * max(a, b) - min(c, d)",
    "-min(a, max(b, c)) / 3",
    "max(a, b, c) * -2 + sqrt(max(c, d))",
    "max(a, b) * max(c, d)",
    "1 / max(a, b)",
    "exp(min(a, b) / 10) - max(c, -d)",
    "a + b",
]


@pytest.mark.parametrize("text", EXPRESSIONS)
@given(values=VALUES)
def test_the_greatest_and_the_least_of_the_pieces_are_the_expression(text, values):
    expression = Expression(text)
    whole = expression.value(values)
    assert max(piece.value(values) for piece in pieces(expression, "max")) == pytest.approx(whole, rel=1e-12)
    assert min(piece.value(values) for piece in pieces(expression, "min")) == pytest.approx(whole, rel=1e-12)


def test_a_max_that_a_goal_rises_with_is_taken_apart_and_a_product_is_not():
    assert [piece.text for piece in pieces(Expression("max(a, b) + c"), "max")] == ["a + c", "b + c"]
    assert len(pieces(Expression("max(a, b) + c"), "min")) == 1
    assert len(pieces(Expression("max(a, b) * c"), "max")) == 1


def test_calls_on_measures_stand_in_the_pieces():
    goal = Expression("max(worst(stiffness), a)", GOAL_CALLS)
    assert [piece.text for piece in pieces(goal, "max")] == ["worst(stiffness)", "a"]


def test_of_too_many_pieces_some_stay_whole():
    goal = Expression(" + ".join(["max(a, b)"] * 10))
    found = pieces(goal, "max")
    assert 1 < len(found) <= MOST
    values = {"a": 1.0, "b": 2.0}
    assert max(piece.value(values) for piece in found) == goal.value(values)

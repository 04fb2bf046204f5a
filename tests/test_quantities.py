"""Units against pint, expressions against Python's own arithmetic, and the field types in a model."""

from __future__ import annotations

import math
import pickle
import re
from decimal import Decimal
from fractions import Fraction
from typing import Annotated

import jsonschema
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, Field, ValidationError

from orthospec.quantities import (
    Angle,
    Expression,
    ExpressionError,
    Extreme,
    Length,
    Number,
    Quantity,
    UnitError,
)
from orthospec.quantities.expressions import GOAL_CALLS
from orthospec.quantities.fields import read, resolve
from orthospec.quantities.units import UNITS, parse_unit

PINT = pint.UnitRegistry()
PINT_NAMES = {"%": "percent", "1": "dimensionless", "°": "degree", "Nm": "N*m", "mNm": "mN*m", "kNm": "kN*m"}
COMPOUNDS = [
    "N/m", "N/um", "N/mm", "N/µm", "kN/mm", "N*m", "m/s", "mm/s", "m/min", "mm/min", "m/s^2", "mm/s^2",
    "kg/m^3", "kg/dm^3", "g/cm^3", "kg*m^2", "m^2", "mm^2", "cm^2", "m^4", "mm^4", "cm^4", "1/s", "rad/s^2",
]  # fmt: skip


@pytest.mark.parametrize("unit", [*UNITS, *COMPOUNDS, "N*m/rad"])
def test_every_unit_is_as_large_as_pint_says(unit: str) -> None:
    theirs = PINT.Quantity(1.0, PINT_NAMES.get(unit, unit)).to_base_units()
    ours = parse_unit(unit)
    assert ours.to_si("1") == pytest.approx(theirs.magnitude, rel=1e-14)
    dimensions = [theirs.dimensionality.get(name, 0) for name in ("[length]", "[mass]", "[time]")]
    assert list(ours.dimension[:3]) == dimensions


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("310.58 mm", "m", 0.31058),
        ("-126.795 mm", "m", -0.126795),
        ("90 deg", "rad", math.pi / 2),
        ("180 °", "rad", math.pi),
        ("10 N/um", "N/m", 1e7),
        ("15 m/min", "m/s", 0.25),
        ("2.7 kg/dm^3", "kg/m^3", 2700.0),
        ("70 GPa", "Pa", 7e10),
        ("3 kg·m²", "kg*m^2", 3.0),
        ("5 μm", "m", 5e-6),
        ("1e-3 m", "m", 1e-3),
        ("5 %", "1", 0.05),
    ],
)
def test_a_quantity_is_converted_to_the_nearest_float(text: str, unit: str, value: float) -> None:
    assert read(text, unit) == value


@given(st.decimals(-(10**6), 10**6, places=6), st.sampled_from(["mm", "µm", "km", "in", "cm"]))
def test_conversion_rounds_once(number: Decimal, unit: str) -> None:
    numerator, denominator, _ = UNITS[unit]
    exact = Fraction(number) * Fraction(numerator) / Fraction(denominator)
    assert read(f"{number:f} {unit}", "m") == float(exact)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("310 kg", "m", "310 kg is a mass, a length [m] was expected"),
        ("310 mm", "1", "310 mm is a length, a number was expected"),
        ("5 N*m", "N*m/rad", "5 N*m is a torque, a rotational stiffness [N*m/rad] was expected"),
        ("1 kg/s", "m", "1 kg/s is a quantity, a length [m] was expected"),
        ("310mm", "m", "'310mm': a space is missing between number and unit, '310 mm'"),
        ("2 base", "m", "'2 base': unknown unit 'base'; a product is written '2 * base'"),
        ("310 MM", "m", "'310 MM': unknown unit 'MM'; did you mean 'mm'?"),
        ("1 kN*mn", "N", "'1 kN*mn': unknown unit 'mn'; did you mean 'mN'?"),
        ("10 N / um", "N/m", "'10 N / um': 'N / um' is not a unit; one is written like mm, N/um or kg*m^2, "
                             "without blanks"),
        ("1e999 m", "m", "1e999 m is too large"),
    ],
)  # fmt: skip
def test_a_wrong_quantity_is_told_in_plain_words(text: str, unit: str, message: str) -> None:
    with pytest.raises(UnitError, match=re.escape(message) + "$"):
        read(text, unit)


def test_a_name_is_never_a_unit() -> None:
    assert resolve("2*m + h", "m", {"m": 3.0, "h": 1.0}) == 7.0


def expressions() -> st.SearchStrategy[str]:
    numbers = st.floats(0.1, 9.0).map(lambda x: repr(round(x, 3)))
    leaves = numbers | st.sampled_from(["base", "third", "pi"])

    def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return (
            st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "**"]), inner).map(
                lambda t: f"({' '.join(t)})"
            )
            | inner.map(lambda e: f"-{e}")
            | st.tuples(st.sampled_from(["sqrt", "sin", "cos", "exp", "log"]), inner).map(
                lambda t: f"{t[0]}({t[1]})"
            )
            | st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(
                lambda t: f"{t[0]}({t[1]}, {t[2]})"
            )
        )

    return st.recursive(leaves, grown, max_leaves=8)


@given(expressions())
def test_an_expression_is_worth_what_python_says(text: str) -> None:
    names = {"base": 1.25, "third": -0.5}
    functions = {name: getattr(math, name) for name in ("sqrt", "sin", "cos", "exp", "log", "pi")}
    try:
        expected = eval(text, {"__builtins__": {}}, {**functions, "min": min, "max": max, **names})
    except (ValueError, ZeroDivisionError, OverflowError, TypeError):
        expected = None
    if isinstance(expected, int | float) and math.isfinite(expected):
        assert Expression(text).value(names) == pytest.approx(expected, rel=1e-12)
    else:
        with pytest.raises(ExpressionError, match="has no value"):
            Expression(text).value(names)


@given(expressions())
def test_the_normal_form_is_the_same_expression(text: str) -> None:
    once = Expression(text)
    assert Expression(once.text) == once
    assert Expression(once.text).text == once.text
    assert pickle.loads(pickle.dumps(once)) == once


@given(st.text(max_size=40) | st.text("0123456789.e+-*/()abx, ", max_size=60))
def test_no_text_does_more_than_raise(text: str) -> None:
    try:
        value = resolve(text, None, {"a": 1.0})
    except (ExpressionError, UnitError):
        return
    assert math.isfinite(value)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "().__class__", "base.real", "base[0]", "[1, 2]", "{1}",
        "lambda: 1", "base if 1 else 2", "base and 1", "not base", "base < 2", "f'{base}'", "'base'", "1j",
        "(yield)", "a := 1", "max(*base)", "max(base, key=base)", "sum(base, 1)", "open(base)",
        "base @ base", "base // 2", "base % 2", "base & 1", "~base", "0x10", "1_000", "True", "None",
        "print", "", " ", "base base", "max(base", "base)", "+", "base +", "sqrt()", "sqrt(1, 2)", "max(1)",
        "worst(base)", "9**9**9**9", "1e400", "sqrt(-1)", "1/0", "log(0)", "exp(1000)", "(-8)**(1/3)",
        "0**-1", "(" * 400, "-" * 600 + "1", "1+" * 600 + "1", "9" * 400,
    ],
)  # fmt: skip
def test_nothing_outside_the_language_runs(text: str) -> None:
    with pytest.raises((ExpressionError, UnitError)):
        resolve(text, None, {"base": 1.0})


def test_an_expression_knows_its_names_and_extremes() -> None:
    goal = Expression("worst(transmission) + 2 * base", GOAL_CALLS)
    assert goal.names == {"base"}
    assert goal.extremes == {Extreme("worst", "transmission")}
    assert goal.value({"base": 1.0}, {("worst", "transmission"): 3.0}) == 5.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bsae * 2", "unknown name 'bsae'; did you mean 'base'?"),
        ("squrt(base)", "unknown function 'squrt'; did you mean 'sqrt'?"),
        ("base^2", "'base^2' is not an expression: '^' has no meaning here; a power is written **"),
        ("2(base)", "'2(base)' is not allowed"),
        ("3.5base", "'3.5base': unknown unit 'base'; a product is written '3.5 * base'"),
        ("base + 3x", "'base + 3x' is not an expression: write * after 3 for a product"),
        ("worst(base)", "worst() can stand in a goal only"),
        ("sqrt(base - 2)", "'sqrt(base - 2)' has no value at base = 1: a root, logarithm or power that"),
        ("1 / (base - 1)", "'1 / (base - 1)' has no value at base = 1: division by zero"),
        ("max(base", "'max(base' is not an expression: a parenthesis is not closed"),
    ],
)  # fmt: skip
def test_a_wrong_expression_is_told_in_plain_words(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        resolve(text, None, {"base": 1.0})


class Bar(BaseModel):
    length: Annotated[Length, Field(gt=0)]
    tilt: Angle = 0.0
    ratio: Number = 1.0
    inertia: Annotated[float, Quantity("kg*m^2")] = 0.0


def test_fields_take_numbers_quantities_and_expressions() -> None:
    given = {"length": "2 * base", "tilt": "90 deg", "ratio": 2, "inertia": "3 kg*mm^2"}
    bar = Bar.model_validate(given, context={"variables": {"base": 0.25}})
    assert bar == Bar(length=0.5, tilt=math.pi / 2, ratio=2.0, inertia=3e-6)


def test_without_context_an_expression_without_names_is_computed() -> None:
    assert Bar.model_validate({"length": "1/4"}).length == 0.25


@pytest.mark.parametrize(
    "given", [True, None, math.nan, math.inf, -math.inf, 10**400, [], {}, "", "nan", "inf"]
)
def test_fields_refuse_what_is_not_a_finite_number(given: object) -> None:
    with pytest.raises(ValidationError):
        Bar.model_validate({"length": given})


def test_a_constraint_binds_the_si_value() -> None:
    with pytest.raises(ValidationError, match="greater than 0"):
        Bar.model_validate({"length": "-1 mm"})


def test_the_schema_tells_the_unit_and_takes_both_ways_of_writing() -> None:
    schema = Bar.model_json_schema()
    length = schema["properties"]["length"]
    assert length["x-unit"] == "m"
    assert length["anyOf"][0] == {"type": "number", "exclusiveMinimum": 0}
    validator = jsonschema.Draft202012Validator(schema)
    assert validator.is_valid({"length": 0.3})
    assert validator.is_valid({"length": "310 mm"})
    assert not validator.is_valid({"length": -0.3})


def test_a_unit_that_does_not_exist_is_refused_where_the_class_is_written() -> None:
    with pytest.raises(UnitError, match="unknown unit 'furlong'"):
        Quantity("furlong")

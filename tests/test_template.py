"""Convex forms compiled to cone rows: they say what the constraint says, for every kind of cone."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.composite.template import compile_form
from orthospec.measures import logarithm


def half_line(x, bound, slack):
    return [x <= bound + slack]


def half_line_in_logarithms(x, bound, slack):
    return [x <= logarithm(bound) + slack]


def second_order_cone(x, bound, slack):
    return [cp.norm(x) <= bound + slack]


def semidefinite(x, bound, slack):
    return [x << (bound + slack) * np.eye(3)]


def largest_eigenvalue(x, bound, slack):
    return [cp.lambda_max(x) <= bound + slack]


def exponential(x, bound, slack):
    return [cp.sum(cp.exp(x)) <= bound + slack]


def with_auxiliary(x, bound, slack):
    width = cp.Variable()
    return [width * np.eye(3) << x, x << (width + bound + slack) * np.eye(3)]


def equation(x, bound, slack):
    part = cp.Variable(3)
    return [x == part + 1, cp.max(part) <= bound + slack]


def eigenvalues(x):
    return np.linalg.eigvalsh(x)


FORMS = {
    "half-line": (half_line, (), lambda x, b: float(x) - b),
    "logarithm": (half_line_in_logarithms, (), lambda x, b: float(x) - np.log(b)),
    "second-order cone": (second_order_cone, (4,), lambda x, b: np.linalg.norm(x) - b),
    "semidefinite cone": (semidefinite, (3, 3), lambda x, b: eigenvalues(x)[-1] - b),
    "spectral function": (largest_eigenvalue, (3, 3), lambda x, b: eigenvalues(x)[-1] - b),
    "exponential cone": (exponential, (3,), lambda x, b: np.exp(x).sum() - b),
    "auxiliary variable": (with_auxiliary, (3, 3), lambda x, b: eigenvalues(x)[-1] - eigenvalues(x)[0] - b),
    "equation": (equation, (3,), lambda x, b: x.max() - 1 - b),
}


@pytest.fixture(scope="module")
def template():
    compiled = {name: compile_form(holds, shape) for name, (holds, shape, _) in FORMS.items()}
    return compiled.__getitem__


@pytest.mark.parametrize("name", FORMS)
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), bound=st.floats(0.1, 5.0))
def test_rows_need_the_slack_that_the_constraint_needs(template, least_slack, name, seed, bound):
    _, shape, excess = FORMS[name]
    inside = np.random.default_rng(seed).normal(size=shape)
    if len(shape) == 2:
        inside = (inside + inside.T) / 2
    expected = max(0.0, excess(inside, bound))
    assert least_slack(template(name), inside, bound) == pytest.approx(expected, abs=1e-8, rel=1e-8)


@pytest.mark.parametrize("name", FORMS)
def test_rows_and_columns_fit_the_cones_and_the_inside(template, name):
    form, shape = template(name), FORMS[name][1]
    sizes = {"psd": lambda n: n * (n + 1) // 2}
    count = sum(sizes.get(kind, int)(size) for kind, size in form.cones)
    assert form.offset.shape == form.on_slack.shape == (count,)
    assert form.on_inside.shape == (count, int(np.prod(shape)) + 2)
    assert len(form.on_auxiliary) == count


@pytest.mark.parametrize("name", ["spectral function", "semidefinite cone", "auxiliary variable"])
def test_a_symmetric_inside_needs_no_rows_that_say_so(template, name):
    assert "zero" not in [kind for kind, _ in template(name).cones]


def test_the_cones_are_those_asked_for(template):
    assert [kind for kind, _ in template("half-line").cones] == ["nonneg"]
    assert "soc" in [kind for kind, _ in template("second-order cone").cones]
    assert ("psd", 3) in template("semidefinite cone").cones
    assert [cone for cone in template("exponential cone").cones if cone[0] == "exp"] == [("exp", 3)] * 3
    assert "zero" in [kind for kind, _ in template("equation").cones]


@pytest.mark.parametrize(
    "holds",
    [
        lambda x, bound, slack: [cp.norm(x) >= bound - slack],
        lambda x, bound, slack: [cp.sum(x) * bound <= slack],
        lambda x, bound, slack: [cp.lambda_min(cp.diag(x)) <= bound + slack],
    ],
)
def test_a_form_that_is_not_convex_is_refused(holds):
    with pytest.raises(ValueError, match="not convex"):
        compile_form(holds, (3,))


def test_a_form_that_needs_another_cone_is_refused():
    def power(x, bound, slack):
        return [cp.constraints.PowCone3D(x[0], x[1], bound + slack, 0.3)]

    with pytest.raises(ValueError, match="power cone"):
        compile_form(power, (2,))

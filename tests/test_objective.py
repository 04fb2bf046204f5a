"""Goals as rows: kinks taken apart, so that a tie at the optimum costs nothing."""

from pathlib import Path

import numpy as np
import pytest

from orthospec.optimise import solve
from orthospec.optimise.objective import GoalObjective
from orthospec.optimise.space import DesignSpace
from orthospec.spec import load_spec

SPECS = Path(__file__).parents[1] / "specs"


def spec_with(name, *overrides):
    return load_spec(SPECS / name, ["workspace.divisions=10", "optimise.starts=3", "proof=false", *overrides])


def test_the_greater_of_two_legs_ends_in_the_tie_of_equal_legs():
    goal = 'goals={longest: {minimise: "max(base, third)", goal: 1.3}}'
    finding = solve(spec_with("orthoglide-1x1x0.8.yaml", goal)).finding
    assert finding.attainment is not None
    assert finding.attainment.factor == pytest.approx(0.1475348022, abs=1e-8)
    assert finding.search is not None
    assert finding.search.subproblems <= 15


def test_stroke_is_minimised_over_three_joints_that_tie():
    finding = solve(spec_with("orthoglide-200.yaml", "goals={s: {minimise: stroke, goal: 200 mm}}")).finding
    legs, q = finding.design.values["leg"], finding.evaluation.prescribed.cuboid
    assert legs == 0.5
    low, high = q.low[0], q.high[0]
    # A symmetric cube: the slider is farthest out at (high, 0, 0) and farthest in at the low corner.
    stroke = (high + legs) - (low + np.sqrt(legs**2 - 2 * low**2))
    assert finding.attainment.goals["s"].value == pytest.approx(stroke, rel=1e-8)
    assert finding.search.subproblems <= 30


def test_rows_of_a_leading_joint_never_exceed_the_goal_s_own_row():
    spec = spec_with("orthoglide-200.yaml", "goals={s: {minimise: stroke + footprint, goal: 1}}")
    space = DesignSpace(spec)
    z = space.scaled(spec.default_values())
    objective = GoalObjective(space, z)
    assert len(objective.owners) == 4
    ends = np.array([0.1, 0.4, 0.1, 0.4, 0.1, 0.399])
    from orthospec.workspace.layout import Point

    rows = objective.rows(space.machine(z), Point(z, np.zeros((1, 3)), 1.0, ends))
    assert (rows[1:] <= rows[0]).all()
    assert rows[0] == pytest.approx(0.3 + 0.16 - 1)


def test_a_spec_without_goals_that_cannot_be_met_names_what_conflicts():
    spec = spec_with("orthoglide-200.yaml", "goals={}", "variables.leg={min: 250 mm, max: 300 mm}")
    finding = solve(spec).finding
    assert finding.status == "infeasible"
    assert {(limit.kind, limit.name) for limit in finding.limits} == {
        ("bound", "transmission"),
        ("variable", "leg"),
    }


def test_without_measures_the_reach_alone_has_one_cuboid_also_where_each_would_have_its_own():
    spec = spec_with("orthoglide-200.yaml", "measures={}", "workspace.together=false")
    finding = solve(spec).finding
    assert finding.status == "attained"
    assert finding.design.values["leg"] == 0.25
    assert finding.evaluation.joint is not None
    # Legs of 250 mm reach a cube of (1/sqrt 3 + 1/sqrt 6) L without passing a singularity.
    assert finding.evaluation.joint.scale * 0.2 == pytest.approx(0.25 * (3**-0.5 + 6**-0.5), rel=1e-6)

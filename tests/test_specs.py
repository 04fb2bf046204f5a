"""The figures that the specs in ``specs/`` must give, each in at most 30 subproblems."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

SPECS = sorted(path.stem for path in (Path(__file__).parents[1] / "specs").glob("*.yaml"))
SOLVED = {
    "orthoglide-200": ({"leg": 0.3105828541}, 0.0105828541),
    "orthoglide-1x1x0.8": ({"base": 1.4475348021, "third": 1.4475348021}, 0.1475348021),
    "orthoglide-1x1x0.8-sum": ({"base": 1.4415023, "third": 1.4589037}, 0.3419083578),
    "orthoglide-1x1x0.8-third-hard": ({"base": 1.4240449719, "third": 1.5}, 0.1240449719),
    "orthoglide-condition": ({"leg": 0.32623139}, 1.0),
    "orthoglide-scale": ({"leg": 0.31058285}, 0.5),
}
EVALUATED = {"orthoglide-joint-limits", "orthoglide-two-measures"}


@pytest.mark.parametrize("name", SOLVED)
def test_spec_ends_in_its_known_optimum(outcome_of, name):
    variables, factor = SOLVED[name]
    finding = outcome_of(name).finding
    assert finding.status == "compromise"
    # A smooth trade-off is flat in its variables: half the digits of its factor.
    digits = 1e-5 if name.endswith("sum") else 1e-8
    assert dict(finding.design.values) == pytest.approx(variables, rel=digits)
    assert finding.attainment.factor == pytest.approx(factor, rel=1e-6)
    assert finding.evaluation.holds
    assert finding.search.subproblems <= 30
    assert finding.errors == ()


@pytest.mark.parametrize("name", SOLVED)
def test_no_solve_of_a_spec_takes_more_than_30_subproblems(outcome_of, name):
    solves = outcome_of(name).log["solves"]
    assert 1 <= len(solves) <= 3
    assert all(solve["iterates"][-1]["subproblems"] <= 30 for solve in solves if solve["iterates"])


def test_every_spec_has_its_figures_here():
    assert set(SPECS) == EVALUATED | set(SOLVED)


def test_200_mm_cube_has_its_corners_on_the_diagonal_and_its_stroke(outcome_of):
    evaluation = outcome_of("orthoglide-200").finding.evaluation
    np.testing.assert_allclose(evaluation.prescribed.cuboid.low, [-0.1267949192] * 3, atol=2e-9)
    np.testing.assert_allclose(evaluation.prescribed.cuboid.high, [0.0732050808] * 3, atol=2e-9)
    assert evaluation.indices["stroke"] == pytest.approx(0.256993, abs=5e-7)
    assert evaluation.joint.grid_scale == 0.975
    assert evaluation.joint.scale == pytest.approx(1.0, abs=1e-6)


def test_least_total_length_of_the_flat_cuboid(outcome_of):
    finding = outcome_of("orthoglide-1x1x0.8-sum").finding
    assert finding.attainment.goals["total"].value == pytest.approx(4.3419083578, rel=1e-9)


def test_a_goal_of_weight_zero_is_held_hard(outcome_of):
    goals = outcome_of("orthoglide-1x1x0.8-third-hard").finding.attainment.goals
    assert goals["third_leg"].attained
    assert not goals["base_legs"].attained
    assert goals["base_legs"].value == pytest.approx(1.4240449719, rel=1e-8)


def test_best_worst_condition_is_three(outcome_of):
    finding = outcome_of("orthoglide-condition").finding
    assert finding.attainment.goals["isotropy"].value == pytest.approx(3.0, rel=1e-7)
    assert finding.evaluation.measures["condition"].highest.value == pytest.approx(3.0, rel=1e-7)


def test_greatest_scale_is_two(outcome_of):
    finding = outcome_of("orthoglide-scale").finding
    assert finding.attainment.goals["room"].value == pytest.approx(2.0, rel=1e-7)
    cuboid = finding.evaluation.joint.cuboid
    assert cuboid.high[0] - cuboid.low[0] == pytest.approx(0.2, rel=1e-7)


def test_cube_with_joint_limits_is_held_by_a_pose_inside_a_face(outcome_of):
    joint = outcome_of("orthoglide-joint-limits").finding.evaluation.joint
    side = 0.04 + 0.33 / np.sqrt(6)
    assert joint.scale * 0.17 == pytest.approx(side, abs=1e-8)
    np.testing.assert_allclose(joint.cuboid.low, [0.04 - side] * 3, atol=1e-8)
    np.testing.assert_allclose(joint.cuboid.high, [0.04] * 3, atol=1e-8)


def test_two_measures_together_have_less_room_than_each_alone(outcome_of):
    evaluation = outcome_of("orthoglide-two-measures").finding.evaluation
    own = {name: record.largest.scale / 2 for name, record in evaluation.measures.items()}
    assert own["condition"] == pytest.approx(0.6130618, abs=5e-8)
    assert own["transmission"] == pytest.approx(0.6439505, abs=1e-7)
    assert evaluation.joint.scale / 2 == pytest.approx(0.5838576, abs=5e-8)
    np.testing.assert_allclose(evaluation.joint.cuboid.low, [-0.3481553] * 3, atol=1e-7)
    np.testing.assert_allclose(evaluation.joint.cuboid.high, [0.2357023] * 3, atol=1e-7)

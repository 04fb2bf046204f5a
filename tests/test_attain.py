"""Goal attainment of specs: known optima, every kind of goal, and honest endings."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
import pytest

from orthospec import registry
from orthospec.measures import Measure
from orthospec.optimise import attain, evaluate_spec, remembering, run, solve
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Stopped
from orthospec.optimise.workers import Here

HEAD = """\
orthospec: 1
workspace: {{size: [{size}, {size}, {size}], divisions: 5}}
manipulator: {{use: orthoglide, leg_lengths: [leg, leg, leg]}}
variables: {{leg: {{min: {least}, max: {most}}}}}
optimise: {{starts: 1}}
measures:
{measures}
goals:
{goals}
"""
TRANSMISSION = "  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}"
SHORTEST = HEAD.format(
    size=0.2, least=0.25, most=0.5, measures=TRANSMISSION, goals="  l: {minimise: leg, goal: 0.3}"
)
LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))

FLAT = """\
orthospec: 1
workspace: {{size: [1, 1, 0.8], divisions: 5}}
manipulator: {{use: orthoglide, leg_lengths: [base, base, third]}}
variables: {{base: {{min: 1.0, max: 3.0, start: 2.0}}, third: {{min: 1.0, max: 3.0}}}}
optimise: {{starts: 1}}
measures:
  transmission: {{use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {goals}
"""


@pytest.fixture(scope="module", autouse=True)
def without_prices():
    """Half of a solve goes into the prices of what binds, which have tests of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "find_limits", lambda *_: ())
        yield


@pytest.fixture(scope="module")
def infeasible(cube):
    """Legs too short for the cube."""
    goal = "  legs: {minimise: leg, goal: 290 mm}"
    return cube(goal, least=0.28, most=0.3, settings=("optimise.starts=2",))


@pytest.fixture(scope="module")
def flat(spec_of):
    """The finding of the 1 x 1 x 0.8 case under these goals."""
    return lambda goals: solve(spec_of(FLAT.format(goals=goals))).finding


@pytest.fixture(scope="module")
def cube(spec_of):
    """The finding of a cube on equal legs."""

    def find(goals, measures=TRANSMISSION, *, size=0.2, least=0.25, most=0.5, settings=()):
        text = HEAD.format(size=size, least=least, most=most, measures=measures, goals=goals)
        return solve(spec_of(text, *settings)).finding

    return find


class TestKnownOptima:
    @pytest.mark.parametrize(
        ("weights", "factor", "lengths"),
        [((1, 1), 0.1475348, (1.4475348, 1.4475348)), ((0.1, 1), 0.5487218, (1.3548722, 1.8487218))],
    )
    def test_weights_share_out_the_slack(self, flat, weights, factor, lengths):
        goals = (
            "{{b: {{minimise: base, goal: 1.3, weight: {}}}, t: {{minimise: third, goal: 1.3, weight: {}}}}}"
        )
        finding = flat(goals.format(*weights))
        assert finding.attainment.factor == pytest.approx(factor, abs=6e-8)
        assert tuple(finding.design.values.values()) == pytest.approx(lengths, abs=6e-8)
        assert finding.search.subproblems <= 30

    def test_least_sum_of_two_lengths(self, flat):
        finding = flat("{sum: {minimise: base + third, goal: 2.5}}")
        assert finding.attainment.goals["sum"].value == pytest.approx(2.8806560584, rel=1e-9)
        assert finding.search.subproblems <= 30

    def test_relative_weights_are_those_of_the_goals(self, flat):
        base = "b: {minimise: base, goal: 1.2, weight: relative}"
        finding = flat(f"{{{base}, t: {{minimise: third, goal: 1.6, weight: relative}}}}")
        goals, factor = finding.attainment.goals, finding.attainment.factor
        assert goals["b"].weight == 1.2
        assert goals["b"].value == pytest.approx(1.2 * (1 + factor), rel=1e-8)
        assert goals["t"].value == pytest.approx(1.6 * (1 + factor), rel=1e-8)

    def test_greatest_of_two_lengths_has_no_trouble_with_its_kink(self, flat):
        finding = flat('{longest: {minimise: "max(base, third)", goal: 1.3}}')
        assert finding.attainment.factor == pytest.approx(0.1475348, abs=6e-8)

    def test_goals_that_are_easy_are_attained_with_room_to_spare(self, flat):
        finding = flat("{b: {minimise: base, goal: 1.6}, t: {minimise: third, goal: 1.7}}")
        assert finding.status == "attained"
        assert finding.attainment.factor < 0
        assert all(goal.attained for goal in finding.attainment.goals.values())


class TestKindsOfGoals:
    def test_match_of_weight_zero_is_met_exactly(self, cube):
        finding = cube("  legs: {match: leg, goal: 330 mm}")
        assert finding.status == "attained"
        assert finding.attainment.factor is None
        assert finding.design.values["leg"] == pytest.approx(0.33, rel=1e-9)

    def test_match_with_a_weight_comes_as_near_as_it_can(self, cube):
        finding = cube("  legs: {match: leg, goal: 300 mm, weight: 1}")
        assert finding.status == "compromise"
        assert finding.attainment.factor == pytest.approx(LEG - 0.3, abs=1e-9)

    def test_match_from_above_and_below(self, cube):
        finding = cube("  legs: {match: leg, goal: 600 mm, weight: 2}")
        assert finding.attainment.factor == pytest.approx(0.05, abs=1e-10)

    def test_maximise(self, cube):
        finding = cube("  legs: {maximise: leg, goal: 450 mm}")
        assert finding.attainment.factor == pytest.approx(-0.05, abs=1e-10)
        assert finding.status == "attained"

    def test_a_goal_on_the_stroke_is_traded_against_the_legs(self, cube):
        """Around the origin stroke = a + L − sqrt(L² − a²/2), and L² = 0.11 where both miss alike."""
        wide = "  transmission: {use: velocity_transmission, at_least: 0.3, at_most: 4}"
        finding = cube(
            "  legs: {minimise: leg, goal: 300 mm}\n  travel: {minimise: stroke, goal: 200 mm}", wide
        )
        assert finding.design.values["leg"] == pytest.approx(np.sqrt(0.11), abs=1e-8)
        assert finding.evaluation.indices["stroke"] == pytest.approx(0.2 + np.sqrt(0.11) - 0.3, abs=1e-8)
        assert finding.attainment.factor == pytest.approx(np.sqrt(0.11) - 0.3, abs=1e-8)

    def test_highest_in_the_unfavourable_direction_goes_to_its_bound(self, cube):
        condition = "  condition: {use: condition_number, at_most: 3}"
        finding = cube("  poor: {maximise: highest(condition), goal: 10}", condition)
        assert finding.evaluation.measures["condition"].highest.value == pytest.approx(3.0, rel=1e-7)
        assert finding.attainment.factor == pytest.approx(7.0, rel=1e-7)

    def test_lowest_in_the_unfavourable_direction_goes_to_its_bound(self, cube):
        finding = cube("  slow: {minimise: lowest(transmission), goal: 0.2}")
        assert finding.attainment.factor == pytest.approx(0.3, rel=1e-7)

    def test_lowest_in_the_favourable_direction(self, cube):
        """The longest legs, and the cube as far up as σ_max = 2 lets it: u = 1/4 at its upper corner."""
        finding = cube("  quick: {maximise: lowest(transmission), goal: 1}", most=LEG * 1.2)
        record = finding.evaluation.measures["transmission"]
        assert finding.design.values["leg"] == pytest.approx(1.2 * LEG, rel=1e-9)
        assert finding.attainment.factor == pytest.approx(1 - record.lowest.value, abs=1e-8)
        leg = 1.2 * LEG
        low = leg / np.sqrt(18) - 0.2
        v = -low / np.sqrt(leg**2 - 2 * low**2)
        assert record.lowest.value == pytest.approx(1 / (1 + 2 * v), rel=1e-8)

    def test_scale_is_a_goal_among_others(self, cube):
        """Scale and leg go together: a leg of LEG has scale 1."""
        finding = cube(
            "  room: {maximise: scale, goal: 1.5}\n  legs: {minimise: leg, goal: 300 mm, weight: 0.1}"
        )
        leg, scale = finding.design.values["leg"], finding.evaluation.joint.scale
        assert scale == pytest.approx(leg / LEG, rel=1e-7)
        assert 1.5 - scale == pytest.approx((leg - 0.3) / 0.1, abs=1e-7)

    def test_the_scale_that_is_told_is_of_the_cuboid_over_which_the_other_goals_are(self, cube):
        """The largest cuboid for the bounds alone is larger, and its measure worse than asked for."""
        even = "  even: {minimise: highest(transmission), goal: 1.5, weight: 0}"
        finding = cube("  big: {maximise: scale, goal: 1.9}\n" + even, size=0.1, most=0.31)
        told, evaluation = finding.attainment.goals, finding.evaluation
        assert finding.status == "compromise"
        assert told["even"].value == pytest.approx(1.5, rel=1e-8)
        assert told["big"].value == evaluation.prescribed.scale < evaluation.joint.scale - 0.1
        assert finding.attainment.factor == pytest.approx(1.9 - evaluation.prescribed.scale, rel=1e-9)

    def test_a_design_evaluated_for_its_scale_is_measured_over_the_cuboid_of_that_scale(self, spec_of):
        text = SHORTEST.replace("l: {minimise: leg, goal: 0.3}", "l: {maximise: scale, goal: 2}")
        found = evaluate_spec(spec_of(text), {"leg": 1.2 * LEG}).finding
        assert found.attainment.goals["l"].value == pytest.approx(1.2, rel=1e-8)
        assert found.evaluation.prescribed.cuboid == found.evaluation.joint.cuboid
        assert found.evaluation.measures["transmission"].highest.value == pytest.approx(2.0, rel=1e-7)

    def test_what_is_kept_of_a_spec_without_a_goal_on_the_scale_does_not_serve_one_with_it(
        self, spec_of, tmp_path
    ):
        """Its cuboid is another one, though machine and measures are the same."""
        text = SHORTEST.replace("l: {minimise: leg, goal: 0.3}", "l: {maximise: scale, goal: 2}")
        with remembering(Here(), tmp_path) as workers:
            plain = evaluate_spec(spec_of(SHORTEST), {"leg": 1.2 * LEG}, workers=workers).finding
            found = evaluate_spec(spec_of(text), {"leg": 1.2 * LEG}, workers=workers).finding
        assert plain.evaluation.prescribed.scale == 1
        assert found.evaluation.prescribed.cuboid == found.evaluation.joint.cuboid
        assert found.attainment.goals["l"].value == pytest.approx(1.2, rel=1e-8)

    def test_hard_goals_alone_have_no_factor(self, cube):
        finding = cube("  legs: {minimise: leg, goal: 320 mm, weight: 0}")
        assert finding.status == "attained"
        assert finding.attainment.factor is None
        assert LEG * (1 - 1e-9) <= finding.design.values["leg"] <= 0.32 * (1 + 1e-9)

    @pytest.mark.parametrize("goal", ["minimise: leg, goal: 0", "maximise: -leg, goal: 0"])
    def test_a_goal_of_zero_has_no_size_of_its_own_and_is_attained_all_the_same(self, cube, goal):
        finding = cube(f"  legs: {{{goal}}}")
        assert finding.attainment.factor == pytest.approx(LEG, rel=1e-8)
        assert finding.search.subproblems <= 30

    @pytest.mark.parametrize(
        "goal",
        ["sqrt(max(0, leg - 0.45)) + leg", "log(max(1e-3, leg - 0.45)) + leg", "exp(min(900, leg)) + leg"],
    )
    @pytest.mark.parametrize("most", [0.5, 0.44])
    def test_a_piece_without_a_value_leaves_the_goal_its_own(self, cube, goal, most):
        """sqrt(leg − 0.45) has none where the goal is least, or anywhere."""
        finding = cube(f"  l: {{minimise: '{goal}', goal: 0.3}}", most=most)
        assert finding.status in {"compromise", "attained"}
        assert finding.design.values["leg"] == pytest.approx(LEG, rel=1e-8)

    @pytest.mark.parametrize("start", [0.3, 0.34, 0.45])
    def test_weights_that_vary_with_the_design_count_as_they_are_there(self, cube, start):
        """λ = (L − 0.3) 0.3/L for the one and 0.5 − L for the other, the least where they are equal."""
        shorter = "  short: {minimise: leg, goal: 0.3, weight: leg / 0.3}"
        longer = "  long: {maximise: leg, goal: 0.5, weight: 1}"
        finding = cube(f"{shorter}\n{longer}", settings=(f"variables.leg.start={start}",))
        best = 0.1 + np.sqrt(0.1)
        assert finding.design.values["leg"] == pytest.approx(best, rel=1e-8)
        assert finding.attainment.factor == pytest.approx(0.5 - best, rel=1e-7)

    @pytest.mark.parametrize("start", [0.27, 0.32, 0.45])
    def test_a_goal_that_turns_with_an_extreme_is_attained_from_either_side(self, cube, start):
        """Between its bounds the greatest factor falls as legs grow; wanted is 1.7."""
        goals = "  near: {minimise: (highest(transmission) - 1.7)**2 * 10, goal: 0.001}"
        finding = cube(goals, settings=(f"variables.leg.start={start}",))
        assert finding.status == "attained"
        assert finding.evaluation.measures["transmission"].highest.value == pytest.approx(1.7, abs=0.011)


class TestWorkspace:
    def test_apart_each_measure_has_its_own_cuboid(self, cube):
        """κ <= 3 asks for the longer legs; together both would ask for longer ones still."""
        both = TRANSMISSION + "\n  condition: {use: condition_number, at_most: 3}"
        goal = "  legs: {minimise: leg, goal: 300 mm}"
        side = 0.4 / np.sqrt(1.32) + (2 / 7) / np.sqrt(1 + 8 / 49)
        apart = cube(goal, both, settings=("workspace.together=false",))
        joint = cube(goal, both)
        assert apart.design.values["leg"] == pytest.approx(0.2 / side, rel=1e-8)
        assert joint.design.values["leg"] == pytest.approx(0.2 / 0.5838576, rel=1e-7)
        assert apart.evaluation.holds
        assert apart.evaluation.joint is None

    def test_the_region_holds_the_cuboid(self, cube):
        """Centred by force, the upper corner decides: u = q / sqrt(L² − 2q²) = 1/4 at q = 100 mm."""
        region = "workspace.region={min: [-0.1, -0.1, -0.1], max: [0.1, 0.1, 0.1]}"
        finding = cube("  legs: {minimise: leg, goal: 300 mm}", settings=(region,))
        assert finding.design.values["leg"] == pytest.approx(0.1 * np.sqrt(18), rel=1e-8)
        np.testing.assert_allclose(finding.evaluation.prescribed.cuboid.high, [0.1] * 3, atol=1e-9)

    def test_starts_whose_cuboid_leaves_the_reach_get_there(self, cube):
        """Legs of 100 mm cannot reach around a 200 mm cube."""
        settings = ("optimise.starts=1", "variables.leg.start=0.11")
        finding = cube("  legs: {minimise: leg, goal: 300 mm}", least=0.1, settings=settings)
        assert finding.design.values["leg"] == pytest.approx(LEG, rel=1e-8)
        assert finding.search.designs == 1

    def test_without_measures_the_reach_alone_decides(self, cube):
        finding = cube("  legs: {minimise: leg, goal: 100 mm}", "  {}", least=0.1)
        assert finding.design.values["leg"] == pytest.approx(
            0.2 / (1 / np.sqrt(3) + 1 / np.sqrt(6)), rel=1e-6
        )


class TestEndings:
    def test_too_short_legs_are_infeasible_and_named(self, infeasible):
        assert infeasible.status == "infeasible"
        named = {(limit.kind, limit.name, limit.side) for limit in infeasible.limits}
        assert ("variable", "leg", "at_most") in named
        assert ("bound", "transmission", "at_most") in named
        assert infeasible.design.values["leg"] == pytest.approx(0.3, rel=1e-9)
        sentences = " / ".join(infeasible.search.conflicts)
        assert "transmission" in sentences
        assert "leg" in sentences

    def test_the_least_violation_is_that_of_the_best_design(self, infeasible):
        """At 300 mm the least excess e^s of both bounds: the side as a function of s equals 200 mm."""
        low, high = 0.0, 1.0
        for _ in range(100):
            s = (low + high) / 2
            least, most = 0.5 * np.exp(-s), 2 * np.exp(s)
            v = min((1 / least - 1) / 2, 1 - 1 / most)
            u = min((1 - 1 / most) / 2, 1 / least - 1)
            room = 0.3 * (v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u))
            low, high = (low, s) if room >= 0.2 else (s, high)
        assert infeasible.search.least_violation == pytest.approx(high, rel=1e-6)

    def test_what_was_searched_is_told(self, infeasible):
        assert infeasible.search.designs == 2
        assert 1 <= infeasible.search.starts <= 2
        assert infeasible.search.subproblems <= 60

    def test_a_hard_goal_that_conflicts_is_named(self, cube):
        finding = cube("  legs: {minimise: leg, goal: 300 mm, weight: 0}")
        assert finding.status == "infeasible"
        assert ("goal", "legs") in {(limit.kind, limit.name) for limit in finding.limits}

    def test_a_solve_that_ran_out_of_subproblems_says_so(self, cube, monkeypatch):
        monkeypatch.setattr(attain, "FIRST", 1)
        monkeypatch.setattr(attain, "minimise", partial(attain.minimise, most=2))
        finding = cube("  l: {minimise: leg, goal: 0.3}", settings=("variables.leg.start=0.49",))
        (note,) = finding.notes
        assert note.about == "optimise"
        assert "given up after" in note.message

    def test_the_same_spec_gives_the_same_numbers(self, cube):
        goal = "  legs: {minimise: leg, goal: 300 mm}"
        first, second = cube(goal), cube(goal)
        assert first.design.values == second.design.values
        assert first.attainment == second.attainment
        assert first.search == second.search
        assert first.evaluation.joint == second.evaluation.joint
        assert first.evaluation.measures == second.evaluation.measures
        np.testing.assert_array_equal(first.evaluation.joints, second.evaluation.joints)

    def test_progress_names_its_stages(self, spec_of):
        told = []
        solve(spec_of(SHORTEST, "optimise.starts=8"), progress=lambda *step: told.append(step[0]))
        stages = list(dict.fromkeys(what.partition(",")[0] for what in told))
        assert stages[:2] == ["designs on the coarse grid", "refining the better starts"]
        assert {"refining the better starts, 2 of 4: subproblem 7", "grid"} <= set(told)

    def test_ctrl_c_keeps_what_was_found(self, spec_of):
        def stop(stage, done, _):
            if stage.startswith("solving") and done == 1:
                raise KeyboardInterrupt

        outcome = solve(spec_of(SHORTEST, "optimise.starts=3"), progress=stop)
        assert outcome.interrupted
        assert outcome.finding.status == "unfinished"
        assert outcome.finding.search.starts == 1
        assert outcome.finding.design.values["leg"] == pytest.approx(LEG, rel=1e-8)

    def test_ctrl_c_in_the_middle_of_a_solve_keeps_where_it_stood(self, spec_of, monkeypatch):
        minimise_fully = attain.minimise

        def minimise(*arguments, on_iterate, **options):
            def follow(here, iterate):
                on_iterate(here, iterate)
                if iterate.subproblems >= 5:
                    raise KeyboardInterrupt

            return minimise_fully(*arguments, on_iterate=follow, **options)

        monkeypatch.setattr("orthospec.optimise.attain.minimise", minimise)
        outcome = solve(spec_of(SHORTEST))
        assert outcome.interrupted
        assert outcome.finding.search.subproblems >= 5
        assert outcome.finding.design.values["leg"] == pytest.approx(LEG, rel=0.1)


class OutOfOrder:
    """Workers that have refined the first and third start, and are stopped in the middle of the second."""

    def each(self, task, space, items, progress=None):
        done = list(Here().each(task, space, items, progress))
        if task is not attain.BEGIN:
            yield from done
            return
        yield done[0]
        yield done[2]
        raise Stopped(replace(done[1][1], factor=9.0))


def test_what_a_stopped_solve_leaves_takes_no_others_place(spec_of):
    found = hunt(DesignSpace(spec_of(SHORTEST, "optimise.starts=8")), OutOfOrder())
    assert found.interrupted
    assert len(found.begun) == 3
    assert sorted(one.factor for one in found.begun.values())[-1] == 9.0


class Radius(Measure):
    """A stranger's measure that gives only numbers: the tool's distance from the origin."""

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    broken: bool = False

    def values(self, manipulator, poses):  # noqa: ARG002
        if self.broken:
            raise ArithmeticError("out of order")
        return np.linalg.norm(poses, axis=1)


@pytest.fixture
def radius(monkeypatch):
    """`radius` stands among the measures."""
    find = registry.find_measure
    monkeypatch.setattr(registry, "find_measure", lambda name: Radius if name == "radius" else find(name))


@pytest.mark.usefixtures("radius")
class TestStrangers:
    def test_a_measure_of_numbers_alone_leads_to_an_optimum(self, cube):
        """Within 180 mm of the origin: the far corner of the cube is 0.2·√3/2 = 173.2 mm away at best."""
        measures = TRANSMISSION + "\n  far: {use: radius, at_most: 180 mm}"
        finding = cube("  legs: {minimise: leg, goal: 300 mm}", measures)
        far = finding.evaluation.measures["far"].highest
        assert far.value == pytest.approx(0.18, rel=1e-8)
        corner = 0.18 / np.sqrt(3)
        assert finding.evaluation.prescribed.cuboid.low[0] == pytest.approx(-corner, abs=1e-8)
        q = 0.2 - corner
        assert finding.design.values["leg"] == pytest.approx(q * np.sqrt(18), rel=1e-7)

    def test_a_measure_that_raises_fails_the_run_and_is_named(self, cube):
        measures = TRANSMISSION + "\n  far: {use: radius, at_most: 180 mm, broken: true}"
        finding = cube("  legs: {minimise: leg, goal: 300 mm}", measures)
        assert finding.status == "failed"
        (error,) = finding.errors
        assert "far" in error.name
        assert "out of order" in error.message
        assert error.place is not None
        assert finding.evaluation.measures["transmission"].largest.scale > 0


class TestEvaluateSpec:
    def test_values_of_the_variables_choose_the_design(self, spec_of):
        spec = spec_of(SHORTEST)
        found = evaluate_spec(spec, {"leg": LEG}).finding
        assert found.status == "evaluated"
        assert found.evaluation.joint.scale == pytest.approx(1.0, abs=1e-9)
        assert found.attainment.goals["l"].value == LEG
        assert evaluate_spec(spec).finding.design.values == {"leg": 0.375}

    def test_a_sweep_leaves_out_the_points_without_a_machine_and_says_so(self, spec_of):
        sweep = "sweep: {variable: leg, from: -0.1, to: 0.3, points: 3}\n"
        found = evaluate_spec(spec_of(SHORTEST + sweep)).finding
        assert found.status == "evaluated"
        assert [finding.design.values["leg"] for finding in found.sweep] == pytest.approx([0.1, 0.3])
        (note,) = found.notes
        assert found.errors == ()
        assert note.about == "sweep"
        assert note.place is not None
        assert "at leg = -0.1: no machine can be built" in note.message

    def test_a_sweep_evaluates_along_its_variable(self, spec_of):
        found = evaluate_spec(
            spec_of(SHORTEST + "sweep: {variable: leg, from: 0.3, to: 0.4, points: 3}\n")
        ).finding
        assert [finding.design.values["leg"] for finding in found.sweep] == pytest.approx([0.3, 0.35, 0.4])
        for finding in found.sweep:
            scale = finding.evaluation.joint.scale
            assert scale == pytest.approx(finding.design.values["leg"] / LEG, rel=1e-8)

"""Catalogues: each branch is the problem with the choice in its place, and the best of all is kept."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from orthospec.errors import SpecError, UsageError
from orthospec.optimise import branch, evaluate_spec, solve
from orthospec.optimise.branch import hunt_branches
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.show import show

FLAT = """\
orthospec: 1
variables:
  base: {min: 1.0, max: 3.0}
  third: {choices: [1.6, 1.3, 2.0]}
manipulator: {use: orthoglide, leg_lengths: [base, base, third]}
workspace: {size: [1, 1, 0.8], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {sum: {minimise: 2 * base + third, goal: 4}}
optimise: {starts: 1}
"""
BARE = """\
orthospec: 1
variables: {leg: {choices: [300 mm, 320 mm, 310.6 mm]}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {minimise: leg, goal: 300 mm}}
optimise: {starts: 1}
"""


@pytest.fixture(scope="module")
def flat(spec_of):
    spec = spec_of(FLAT)
    return spec, solve(spec).finding


def test_each_branch_is_the_problem_with_the_choice_written_into_it(flat, spec_of):
    for one in flat[1].search.branches:
        third = one.choices["third"]
        text = FLAT.replace("  third: {choices: [1.6, 1.3, 2.0]}\n", "").replace("third", repr(third))
        best = hunt(DesignSpace(spec_of(text)), Here()).best
        assert one.factor == pytest.approx(best.factor * best.unit, abs=1e-8)


def test_the_best_branch_is_kept(flat):
    finding = flat[1]
    assert [one.choices["third"] for one in finding.search.branches] == [1.6, 1.3, 2.0]
    assert finding.design.values["third"] == 1.6
    assert finding.attainment.factor == pytest.approx(min(one.factor for one in finding.search.branches))


def test_a_catalogue_alone_is_searched_to_its_best_entry(spec_of):
    """310.5829 mm is the least leg: of the catalogue 310.6 mm, and 300 mm holds nowhere."""
    finding = solve(spec_of(BARE)).finding
    assert finding.design.values["leg"] == 0.3106
    assert [one.choices["leg"] for one in finding.search.branches] == [0.3106, 0.32, 0.3]
    assert [one.found for one in finding.search.branches] == [True, True, False]
    assert finding.search.branches[2].least_violation > 0.01


def test_where_a_choice_decides_the_other_goal_is_as_good_as_the_choice_lets_it_be(spec_of):
    """The third leg of 1.6 m misses its goal by 0.3; the base beside it comes to less."""
    base, third = "base: {minimise: base, goal: 1.3}", "leg: {minimise: third, goal: 1.3}"
    alone = FLAT.replace("sum: {minimise: 2 * base + third, goal: 4}", base)
    found = solve(spec_of(alone.replace(base, f"{base}, {third}"))).finding
    assert found.attainment.factor == pytest.approx(0.3)
    assert found.design.values["third"] == 1.6
    shortest = solve(spec_of(alone.replace("[1.6, 1.3, 2.0]", "[1.6]"))).finding
    assert found.design.values["base"] == pytest.approx(shortest.design.values["base"], abs=1e-8)


def test_another_choice_has_its_price(spec_of):
    """λ is by how much the legs are longer than 300 mm."""
    spec = spec_of(BARE)
    content = yaml.safe_load(yaml.safe_dump(compose(spec, solve(spec).finding)))
    assert [one.get("cost") for one in content["search"]["branches"]] == [0.0, pytest.approx(0.0094), None]


def test_choices_are_no_ends_of_a_range(flat):
    assert {limit.kind for limit in flat[1].limits} == {"goal", "bound"}


def test_one_design_is_evaluated_at_the_start_or_the_middle_of_the_catalogue(spec_of):
    assert spec_of(BARE).default_values() == {"leg": 0.3106}
    started = spec_of(BARE.replace("310.6 mm]", "310.6 mm], start: 300 mm"))
    assert evaluate_spec(started).finding.design.values == {"leg": 0.3}


def test_too_many_combinations_are_screened_and_the_result_says_how_many(spec_of, monkeypatch):
    monkeypatch.setattr(branch, "MOST", 2)
    spec = spec_of(FLAT)
    found = solve(spec).finding
    assert found.search.combinations == 3
    assert [one.choices["third"] for one in found.search.branches] == [1.6, 1.3]
    text = show(compose(spec, found), width=100, colour=False, spec=spec)
    assert "Of 3 combinations the 2 best on a coarse grid." in text


def test_progress_says_which_combination_is_searched(spec_of):
    told = set()
    hunt_branches(spec_of(FLAT), Here(), lambda what, *_: told.add(what.partition(": ")[0]))
    assert {f"combination {k} of 3" for k in (1, 2, 3)} <= told


def test_more_combinations_than_can_be_tried_are_refused(spec_of, monkeypatch):
    monkeypatch.setattr(branch, "MOST_SCREENED", 2)
    with pytest.raises(UsageError, match="3 combinations; at most 2"):
        hunt_branches(spec_of(FLAT), Here())


def test_ctrl_c_keeps_the_branches_that_are_done(spec_of, monkeypatch):
    done = []

    def stopped_at_the_second(space, workers, progress=None):
        found = hunt(space, workers, progress)
        done.append(space)
        found.interrupted = len(done) == 2
        return found

    monkeypatch.setattr(branch, "hunt", stopped_at_the_second)
    outcome = solve(spec_of(FLAT))
    assert outcome.interrupted
    assert outcome.finding.status == "unfinished"
    assert len(outcome.finding.search.branches) == 2
    assert outcome.finding.design.values["third"] == 1.6


def test_the_order_of_a_catalogue_and_a_spec_without_one_leave_the_hash_as_it_is(spec_of):
    assert spec_of(BARE).sha256() == spec_of(BARE.replace("300 mm, 320 mm", "320 mm, 300 mm", 1)).sha256()
    ranged = spec_of(BARE.replace("choices: [300 mm, 320 mm, 310.6 mm]", "min: 300 mm, max: 320 mm"))
    assert ranged.canonical()["variables"] == {"leg": {"min": 0.3, "max": 0.32, "start": 0.31}}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            "{choices: [0.3, 0.31], max: 0.4}",
            "either 'choices', or 'min' and 'max' were expected",
        ),
        ("{choices: [0.3, 310 mm, 0.3]}", "0.3 stands in the catalogue twice"),
        ("{choices: [310 mm, 3 kg]}", "one kind of quantity was expected"),
        ("{choices: [0.3, 0.31], start: 0.32}", "start 0.32 is not one of the choices"),
        ("{choices: []}", "1 value or more"),
        ("{choices: [0.3, leg]}", "'leg' is not a number or quantity"),
    ],
)
def test_mistakes_in_a_catalogue_are_told(spec_of, given, said):
    with pytest.raises(SpecError, match=said):
        spec_of(BARE.replace("{choices: [300 mm, 320 mm, 310.6 mm]}", given))


def test_a_result_tells_the_branches_and_is_shown_with_them(flat):
    spec, finding = flat
    content = yaml.safe_load(yaml.safe_dump(compose(spec, finding)))
    assert content["search"]["combinations"] == 3
    assert [one["found"] for one in content["search"]["branches"]] == [True] * 3
    text = " ".join(show(content, width=100, colour=False, spec=spec).split())
    assert "third 1.6 m one of 1.3 m, 1.6 m, 2 m" in text
    assert "Choices third λ 1.6 m 0.390844 taken 1.3 m 0.540991 λ rises by 0.15 2 m 0.678571" in text


def test_no_spec_of_the_repository_has_another_hash_for_the_catalogues_it_does_not_have(spec_of):
    text = (Path(__file__).parents[1] / "specs" / "orthoglide-200.yaml").read_text(encoding="utf-8")
    assert all("choices" not in one for one in spec_of(text).canonical()["variables"].values())

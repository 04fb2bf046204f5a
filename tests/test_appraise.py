"""Designs measured as a result tells them: on a coarser grid where the spec's would be too large."""

from __future__ import annotations

import pytest

from orthospec.errors import GridTooLarge
from orthospec.optimise import evaluate_spec, solve
from orthospec.result import compose
from orthospec.workspace import grid

SPEC = """\
orthospec: 1
variables: {leg: {min: 310 mm, max: 400 mm, start: 350 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {minimise: leg, goal: 300 mm}}
optimise: {starts: 1}
"""


@pytest.fixture
def small(monkeypatch):
    """Grids of few nodes are too large."""
    monkeypatch.setattr(grid, "MOST_NODES", 200_000)
    monkeypatch.setattr(grid, "COARSENED", 50_000)


@pytest.mark.usefixtures("small")
def test_a_design_found_is_measured_on_a_coarser_grid_and_told_with_a_note(spec_of):
    spec = spec_of(SPEC, "workspace.divisions=30")
    outcome = solve(spec)
    content = compose(spec, outcome.finding)
    assert outcome.finding.status == "compromise"
    assert content["workspace"]["joint"]["scale"] == pytest.approx(1, abs=1e-6)
    assert sum(content["workspace"]["joint"]["nodes"].values()) < 200_000
    (note,) = content["notes"]
    assert "errors" not in content
    assert note["place"] == "--set workspace.divisions=30"
    assert "would be too large with 30" in note["message"]


@pytest.mark.usefixtures("small")
def test_points_of_a_pareto_set_are_measured_on_a_coarser_grid_too(spec_of):
    text = SPEC.replace(
        "goals: {", "pareto: {points: 3}\ngoals: {wide: {minimise: highest(transmission), goal: 1.9}, "
    )
    finding = solve(spec_of(text, "workspace.divisions=30")).finding
    assert len(finding.pareto) >= 2
    assert {note.about for note in finding.notes} == {"workspace.divisions"}
    assert finding.errors == ()


@pytest.mark.usefixtures("small")
def test_a_grid_that_is_too_large_from_the_beginning_is_refused(spec_of):
    with pytest.raises(GridTooLarge, match=r"more than 2e\+05"):
        evaluate_spec(spec_of(SPEC, "workspace.divisions=30"))

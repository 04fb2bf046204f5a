"""A result in words: what each status says, units, widths, and texts without a spec at hand."""

from __future__ import annotations

import copy
import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.errors import UsageError
from orthospec.show import ProgressLine, Silence, explain, installed, show, show_installed
from orthospec.show.labels import labels
from orthospec.show.numbers import Numbers, percent
from orthospec.show.page import Page
from orthospec.spec import Spec, load_spec

SPEC = """\
orthospec: 1
title: Orthoglide for a 200 mm cube
variables:
  leg: {min: 250 mm, max: 500 mm}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, 0.33], joint_limits: {max: 400 mm}}
workspace: {size: [200 mm, 200 mm, 200 mm]}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.5]}}
goals:
  length: {minimise: leg, goal: 300 mm}
  stretch: {minimise: highest(transmission), goal: 2, weight: 0}
  total: {minimise: 2*leg, goal: 0.6}
"""

CUBOID = {"min": [-0.126795, -0.126795, -0.1268], "max": [0.073205, 0.073205, 0.0732]}
LARGEST = {
    "scale": 0.99999999988,
    "grid_scale": 0.975,
    "ties": 25,
    **CUBOID,
    "nodes": {"meets": 391114, "violates": 620432, "unreachable": 1236545, "failed": 0},
}
CONTENT: dict[str, Any] = {
    "orthospec": 1,
    "title": "Orthoglide for a 200 mm cube",
    "status": "compromise",
    "attainment": {
        "factor": 0.010582854,
        "goals": {
            "length": {"value": 0.31058285, "goal": 0.3, "weight": 1.0, "attained": False},
            "stretch": {"value": 2.0, "goal": 2.0, "weight": 0.0, "attained": True},
            "total": {"value": None, "goal": 0.6, "weight": 1.0, "attained": False},
        },
    },
    "variables": {"leg": 0.31058285},
    "manipulator": {
        "use": "orthoglide",
        "leg_lengths": [0.31058285, 0.31058285, 0.33],
        "joint_limits": {"max": [0.4, 0.4, 0.4]},
        "branch": [1, 1, 1],
    },
    "indices": {"stroke": 0.256993, "footprint": 0.147293},
    "joints": {"min": [0.126795, 0.126795, 0.13], "max": [0.383788, 0.383788, 0.39]},
    "workspace": {
        "prescribed": {**CUBOID, "holds": True},
        "joint": LARGEST,
        "measures": {
            "transmission": {
                **LARGEST,
                "lowest": {"value": 0.5000000000001, "at": [-0.126795, -0.126795, -1e-12]},
                "highest": {"value": 2.0, "at": [0.073205, 0.073205, 0.073205]},
                "levels": [{"at_most": 1.5, **LARGEST}],
                "poses": {"Q0": [0.9, 1.1], "far": None},
            }
        },
    },
    "limits": [
        {
            "kind": "bound",
            "name": "transmission",
            "side": "at_most",
            "at": [[0.1, 0.1, k / 10] for k in range(6)],
            "gain": 0.000995639,
            "cost": 0.00237307,
        },
        {"kind": "joint", "name": "joint_limits.0.at_most", "side": "at_most", "gain": 0.0, "cost": 1e-4},
        {"kind": "variable", "name": "leg", "side": "at_least", "gain": None, "cost": None},
        {"kind": "goal", "name": "length", "gain": 0.003, "cost": 0.003},
    ],
    "search": {"designs": 8, "refined": 4, "distinct": 3, "starts": 3, "subproblems": 7},
    "provenance": {"orthospec": "0.1.0", "spec_sha256": "00"},
}


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Spec:
    path = tmp_path_factory.mktemp("spec") / "spec.yaml"
    path.write_text(SPEC)
    return load_spec(path)


def _text(spec: Spec | None = None, *, width: int = 80, colour: bool = False, **changes: Any) -> str:
    return show({**copy.deepcopy(CONTENT), **changes}, width=width, colour=colour, spec=spec)


def test_a_whole_result_reads_as_an_engineer_writes(spec: Spec) -> None:
    text = _text(spec)
    for line in (
        "Orthoglide for a 200 mm cube",
        "  Best compromise: every bound holds, not every goal is met (λ = 0.0105829).",
        "  length   310.583 mm    300 mm       1  missed by 10.5829 mm  minimise leg",
        "  leg  310.583 mm  within 250 ... 500 mm",
        "  leg_lengths   310.583  310.583  330 mm",
        "  joint_limits  max 3 x 400 mm",
        "  footprint     0.147293 m^2",
        "  joints 1, 2   126.795 ... 383.788 mm",
        "  joint 3       130 ... 390 mm",
        "  prescribed cuboid  200 x 200 x 200 mm, every bound holds",
        "    from  (-126.795, -126.795, -126.800) mm",
        "    on the grid alone: scale 0.975 in 25 places",
        "    nodes: 391114 meet, 620432 violate, 1236545 out of reach",
        "  transmission: velocity_transmission, at least 0.5 and at most 2",
        "    lowest              0.5  at (-126.795, -126.795, 0.000) mm",
        "    scale, at most 1.5  1    on the grid alone 0.975",
        "    at Q0   0.9 ... 1.1",
        "    at far  out of reach",
        "  measure transmission: at most 2",
        "    and at 2 more",
        "    1 % looser: λ falls by 0.000996; 1 % tighter: λ rises by 0.00237",
        "  reach: joint_limits.0 at most",
        "    1 % looser: no gain; 1 % tighter: λ rises by 0.0001",
        "  variable leg: at least 250 mm",
        "  goal length: minimise leg",
    ):
        assert line in text.splitlines()


def test_a_cuboid_that_stands_shrunk_says_so_wherever_something_is_told_over_it(spec: Spec) -> None:
    workspace = {**CONTENT["workspace"], "prescribed": {**CUBOID, "scale": 0.25, "holds": False}}
    text = _text(spec, workspace=workspace, status="infeasible")
    assert "prescribed cuboid  200 x 200 x 200 mm, shrunk to 25 %, not every bound holds" in text
    assert "Measures over the prescribed cuboid shrunk to 25 %" in text
    said = "The prescribed cuboid is shrunk to 25 %: joints, indices and measures are told over that."
    assert said in " ".join(text.split())


def test_hard_goals_and_goals_without_a_value_are_told(spec: Spec) -> None:
    lines = [line.split() for line in _text(spec, width=100).splitlines()]
    assert ["stretch", "2", "2", "hard", "met", "minimise", "highest(transmission)"] in lines
    assert ["total", "-", "0.6", "1", "missed", "minimise", "2", "*", "leg"] in lines


def test_without_its_spec_a_result_is_readable_too() -> None:
    text = _text()
    assert "  leg  0.310583" in text.splitlines()
    assert "  transmission" in text.splitlines()
    assert "  measure transmission: at most" in text.splitlines()


def test_lengths_are_in_metres_where_the_cuboid_is_a_metre_or_more(spec: Spec) -> None:
    large = {"min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.3], "holds": False}
    text = _text(workspace={"prescribed": large, "joint": LARGEST, "measures": {}})
    assert "  prescribed cuboid  1 x 1 x 0.8 m, not every bound holds" in text.splitlines()
    assert "    from  (-0.50000, -0.50000, -0.50000) m" in text.splitlines()
    assert "mm" not in text.replace("200 mm cube", "")
    assert "mm" in _text(spec).replace("200 mm cube", "")


@pytest.mark.parametrize(
    ("status", "said"),
    [
        ("attained", "every goal is met"),
        ("infeasible", "No design was found in which every bound holds."),
        ("evaluated", "Evaluated: every bound holds in the prescribed cuboid."),
        ("unfinished", "Stopped before the end; what follows is the best design found so far."),
        ("failed", "A plugin failed"),
    ],
)
def test_each_status_has_its_sentence(status: str, said: str) -> None:
    assert said in _text(status=status)


def test_without_goals_none_is_said_to_be_met() -> None:
    text = " ".join(_text(status="attained", attainment=None).split())
    assert "Found: every bound holds. There is no goal, so that any design that holds will do." in text
    assert "Attained" not in text


def test_stopped_while_starts_are_refined_no_places_are_told() -> None:
    search = {"designs": 8, "refined": 3, "distinct": 0, "starts": 0, "subproblems": 9}
    text = " ".join(_text(status="unfinished", search=search).split())
    assert "Searched: 8 designs on a coarse grid; 3 refined; 0 solved to the end." in text


def test_where_nothing_was_found_it_says_what_was_searched_and_what_conflicts(spec: Spec) -> None:
    search = {"designs": 8, "refined": 4, "distinct": 2, "starts": 1, "subproblems": 7}
    search["least_violation"] = math.log(1.4)
    text = " ".join(_text(spec, status="infeasible", search=search).split())
    said = "Searched: 8 designs on a coarse grid; 4 refined, leading to 2 places; 1 solved to the end."
    assert said in text
    assert "The best point found misses its bounds by up to 40 %" in text
    assert "What conflicts measure transmission: at most 2" in text


@pytest.mark.parametrize(
    ("part", "said"), [(0.0492, "4.9 %"), (0.999, "100 %"), (33.19, "3300 %"), (1e-6, "0.0001 %")]
)
def test_a_part_is_told_with_two_digits_and_without_an_exponent(part: float, said: str) -> None:
    assert percent(part) == said


def test_an_evaluated_design_that_does_not_hold_is_called_so() -> None:
    workspace = {**CONTENT["workspace"], "prescribed": {**CUBOID, "holds": False}}
    assert "not every bound holds in the prescribed cuboid" in _text(status="evaluated", workspace=workspace)


def test_a_cuboid_that_could_not_be_placed_is_told() -> None:
    nowhere = {**LARGEST, "scale": 0.0, "grid_scale": 0.0, "ties": 0, "min": None, "max": None}
    text = _text(status="evaluated", workspace={"joint": nowhere, "measures": {}})
    assert "prescribed cuboid: no place was found for it" in text
    assert "  largest cuboid     none" in text.splitlines()
    assert "not every bound holds" in text


def test_a_sweep_is_a_table_and_failures_and_notes_stand_at_the_end(spec: Spec) -> None:
    design = {key: CONTENT[key] for key in ("variables", "manipulator", "indices", "joints", "workspace")}
    sweep = [{**design, "variables": {"leg": leg}} for leg in (0.25, 0.31, 0.5)]
    errors = [{"name": "transmission", "place": "spec.yaml:8:3", "message": "gave NaN"}]
    notes = [{"name": "sweep", "place": "spec.yaml:20:1", "message": "at leg = 0.01: no machine"}]
    lines = _text(spec, sweep=sweep, errors=errors, notes=notes).splitlines()
    start = lines.index("Sweep along leg")
    assert lines[start + 1].split() == [
        "leg",
        "holds",
        "scale",
        *["transmission", "lowest"],
        *["transmission", "highest"],
    ]
    assert lines[start + 3].split() == ["310", "mm", "yes", "1", "0.5", "2"]
    assert lines[start + 6].split() == ["leg", "transmission", "at", "Q0", "transmission", "at", "far"]
    assert lines[start + 8].split() == ["310", "mm", "0.9", "...", "1.1", "out", "of", "reach"]
    assert lines[-5:] == [
        "Failures",
        "  transmission (spec.yaml:8:3): gave NaN",
        "",
        "Notes",
        "  sweep (spec.yaml:20:1): at leg = 0.01: no machine",
    ]


@pytest.mark.parametrize("width", [72, 80, 100])
def test_lines_fit(spec: Spec, width: int) -> None:
    assert max(map(len, _text(spec, width=width).splitlines())) <= width


def test_colour_changes_no_letter(spec: Spec) -> None:
    coloured = _text(spec, colour=True)
    assert "\033[33mmissed by 10.5829 mm\033[0m" in coloured
    plain = coloured
    for code in (0, 1, 2, 31, 32, 33):
        plain = plain.replace(f"\033[{code}m", "")
    assert plain == _text(spec)


def test_columns_that_do_not_fit_follow_in_a_further_table() -> None:
    page = Page(width=40, colour=False)
    page.table(["leg", "scale", "a longer name of a column", "b"], [["1", "0.5", "2", "3"]])
    assert [line.split() for line in str(page).splitlines()] == [
        ["leg", "scale", "a", "longer", "name", "of", "a", "column"],
        ["1", "0.5", "2"],
        [],
        ["leg", "b"],
        ["1", "3"],
    ]


@given(st.floats(-1e6, 1e6))
def test_six_digits_are_kept(number: float) -> None:
    for numbers, factor, unit in ((Numbers(True), 1000, "mm"), (Numbers(False), 1, "m")):
        text, shown = numbers.value(number, "m").split()
        assert shown == unit
        assert float(text) == pytest.approx(number * factor, rel=5e-6, abs=0)


def test_units_stand_once_where_they_are_shared() -> None:
    numbers = Numbers(millimetres=True)
    assert numbers.pose([0.0123456, -1e-9], ["m", "m"]) == "(12.346, 0.000) mm"
    assert numbers.pose([0.01, 0.5], ["m", "rad"]) == "(10.000 mm, 0.50000 rad)"
    assert numbers.pose([1.0, None], ["1", "1"]) == "(1.00000, -)"
    assert numbers.interval(None, 0.5, "m") == "- ... 500 mm"
    assert numbers.several([1, 1, 1]) == "1  1  1"


BUILTIN = [one["name"] for one in installed() if one["distribution"] == "orthospec"]


@pytest.mark.parametrize("name", BUILTIN)
def test_every_builtin_is_explained_within_80_columns(name: str) -> None:
    text = explain(name, width=80, colour=False)
    assert text.startswith(f"{name}\n")
    assert "of orthospec 0." in text
    assert max(map(len, text.splitlines())) <= 80


def test_an_explanation_has_unit_sides_keys_and_indices() -> None:
    lines = [line.split() for line in explain("orthoglide", width=80, colour=False).splitlines()]
    assert lines[15][:7] == ["indices", "leg_length_total", "[m],", "stroke", "[m],", "footprint", "[m^2],"]
    assert any(line[:3] == ["leg_lengths", "m", "required"] for line in lines)
    limits = lines[lines.index(["Keys", "of", "joint_limits"]) :]
    assert ["max", "m", "optional"] in [line[:3] for line in limits]
    measure = explain("deflection", width=80, colour=False)
    assert "bounds  at_most" in measure
    assert "needs   compliance of the machine" in measure
    assert "wrench  N, N*m  optional" in measure


def test_a_part_is_explained_once_for_all_places_that_it_stands_in() -> None:
    text = explain("linear_delta", width=80, colour=False)
    for line in (
        "  base_radius      m      required  Radius of the circle on which the slides",
        "  friction   N    optional  Coulomb friction, which takes its part of the force;",
        "Keys of legs.section.round, feet.section.round",
        "Keys of legs.material, feet.material",
        "Keys of platform, tool, payload",
    ):
        assert line in text.splitlines()
    said = " ".join(text.split())
    assert "Section of a foot; in place of its keys 'rigid'." in said
    assert "in place of its keys 'steel', 'aluminium', 'titanium' or 'carbon'." in said
    assert "hinges; 'PUU' or 'PRPaR'." in said


def test_an_unknown_name_lists_what_is_installed() -> None:
    with pytest.raises(UsageError, match=r"did you mean 'velocity_transmission'\? installed: .*orthoglide"):
        explain("velocity", width=80, colour=False)


def test_the_plugins_are_listed_with_their_distributions() -> None:
    entries = [one for one in installed() if one["distribution"] == "orthospec"]
    assert {one["kind"] for one in entries} == {"manipulator", "measure"}
    text = show_installed(
        [*entries, {**entries[0], "name": "bad", "fault": "cannot be loaded"}], width=80, colour=False
    )
    assert "velocity_transmission  orthospec 0." in text
    assert "    cannot be loaded" in text.splitlines()


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def _clock(*times: float) -> Any:
    ticks: Iterator[float] = iter(times)
    return lambda: next(ticks)


def test_progress_is_one_line_redrawn_on_a_terminal() -> None:
    stream = _Terminal()
    with ProgressLine(stream, _clock(0, 1, 1.01, 75)) as progress:
        progress("grid", 1, 4)
        progress("grid", 2, 4)
        progress("start 1", 0, 0)
    assert stream.getvalue() == "\r\033[Kgrid 25 %, 1 s\r\033[Kstart 1, 1 min 15 s\r\033[K"


def test_progress_is_a_plain_line_now_and_then_elsewhere() -> None:
    stream = io.StringIO()
    with ProgressLine(stream, _clock(0, 1, 6, 7)) as progress:
        for done in (1, 2, 3):
            progress("grid", done, 4)
    assert stream.getvalue() == "grid 50 %, 6 s, this step some 10 s more\n"


def test_silence_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with Silence() as progress:
        progress("grid", 1, 4)
    assert capsys.readouterr() == ("", "")


def test_limits_alike_are_told_together_and_those_without_a_price_in_one_sentence(spec: Spec) -> None:
    joint = {"kind": "joint", "side": "at_most", "at": [[0.0, 0.0, 0.1]], "gain": 0.01, "cost": None}
    free = {"kind": "joint", "name": "joint_limits.0.at_least", "side": "at_least", "gain": 0.0, "cost": 0.0}
    limits = [{**joint, "name": f"joint_limits.{k}.at_most"} for k in (2, 0)]
    text = _text(spec, limits=[*limits, free, {**free, "kind": "bound", "name": "transmission"}])
    lines = text.splitlines()
    start = lines.index("  reach: joint_limits.0, 2 at most")
    assert lines[start + 1 :] == [
        "    at (0.000, 0.000, 100.000) mm",
        "    1 % looser: λ falls by 0.01; 1 % tighter: no design found",
        "  reached too, without gain or cost: reach: joint_limits.0 at least; measure",
        "  transmission: at least 0.5",
    ]


def test_a_result_of_the_specs_folder_of_another_time_is_readable(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC.replace("leg", "bar"))
    assert "  leg  0.310583" in show(CONTENT, width=80, colour=False, spec=None).splitlines()
    other = SPEC.replace("leg, leg, 0.33", "bar, bar, 0.33").replace("  leg:", "  bar:")
    path.write_text(other.replace("minimise: leg", "minimise: bar").replace("2*leg", "2*bar"))
    assert "  leg  0.310583" in show(CONTENT, width=80, colour=False, spec=load_spec(path)).splitlines()


TILTED = """\
orthospec: 1
variables: {tilt: {min: 5 deg, max: 20 deg}, leg: {min: 0.3, max: 0.5}}
manipulator:
  {use: linear_delta, leg_lengths: [leg, leg, leg], base_radius: 0.3, platform_radius: 0.05, rail_tilt: tilt}
workspace: {size: [200 mm, 200 mm, 100 mm]}
measures: {transmission: {use: velocity_transmission, at_most: 2}}
goals: {small: {minimise: footprint, goal: 1500 cm^2}, stroke: {minimise: stroke, goal: 0.3}}
"""


def test_a_variable_s_unit_is_its_field_s_and_a_goal_s_its_index_s(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(TILTED)
    spec = load_spec(path)
    known = labels(spec, spec.default_values())
    assert known.fields["rail_tilt",].units == ("deg",)
    assert known.fields["leg_lengths",].units == ("m",)
    assert known.indices["footprint"] == "cm^2"
    assert known.indices["stroke"] == "m"

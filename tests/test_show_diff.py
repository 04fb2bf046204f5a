"""A comparison as text and as JSON: units, signs, widths, colours, and what is left out."""

from __future__ import annotations

import copy
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.compare import Comparison, Side, compare, read_side, rows
from orthospec.optimise import Outcome
from orthospec.result import compose
from orthospec.show import diff_content, show_diff
from orthospec.spec import load_spec
from orthospec.spec.writing import dump

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "diff.md").read_text(encoding="utf-8")
A = """\
orthospec: 1
variables:
  leg: {min: 250 mm, max: 500 mm}
manipulator:
  use: orthoglide
  leg_lengths: [leg, leg, 330 mm]
  legs: {kind: PRPaR, section: {round: {diameter: 20 mm}}, material: steel, spacing: 80 mm}
  actuators: {stiffness: 50 N/um, mass: 2 kg}
  gravity: [0, 0, -9.81 m/s^2]
workspace: {size: [200 mm, 200 mm, 200 mm]}
measures:
  cutting: {use: deflection, force: 100 N, at_most: 15 um}
goals:
  length: {minimise: leg, goal: 300 mm}
"""
CHANGES = {
    "500 mm": "0.45",
    "[leg, leg, 330": "[leg, leg, 340",
    "diameter: 20 mm": "diameter: 22 mm",
    "steel": "aluminium",
    "50 N/um": "40 N/um",
    "mass: 2 kg": "mass: 1 + leg",
    "[200 mm, 200 mm, 200 mm]": "[210 mm, 210 mm, 210 mm]",
    "at_most: 15 um": "at_most: 0.02 mm, levels: {at_most: [10 um]}",
    "measures:": "measures:\n  sent: {use: velocity_transmission, at_most: 2}",
}
TEXT = """\
A  a.yaml
B  b.yaml

variables
                                         A          B     B - A
  leg.max                           500 mm     450 mm    -50 mm    -10 %
  leg.start                         375 mm     350 mm    -25 mm  -6.67 %

manipulator
  actuators.mass               2 kg -> 1 + leg
  actuators.stiffness              50 N/um    40 N/um  -10 N/um    -20 %
  leg_lengths.2                     330 mm     340 mm    +10 mm  +3.03 %
  legs.material                steel -> aluminium
  legs.section.round.diameter        20 mm      22 mm     +2 mm    +10 %

workspace
  size.0 ... 2                      200 mm     210 mm    +10 mm     +5 %

measures
  cutting.at_most                  0.015 mm    0.02 mm  +0.005 mm  +33.3 %
  cutting.levels               only in B  at_most: [0.01 mm]
  sent                         only in B  use: velocity_transmission, at_most: 2

13 values differ, 20 the same.
"""


@pytest.fixture
def specs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Comparison:
    monkeypatch.chdir(tmp_path)
    b = A
    for old, new in CHANGES.items():
        assert old in b
        b = b.replace(old, new)
    return compare(side("a.yaml", A), side("b.yaml", b))


def side(name: str, text: str) -> Any:
    Path(name).write_text(text)
    return read_side(Path(name))


def squeezed(text: str) -> list[list[str]]:
    return [re.split(r" {2,}", line.strip()) for line in text.splitlines()]


def test_a_spec_is_told_in_its_own_units(specs: Comparison) -> None:
    told = show_diff(specs, changed=False, width=80, colour=False)
    assert squeezed(told) == squeezed(TEXT)
    assert told == show_diff(specs, changed=True, width=80, colour=False)


def test_the_columns_stand_under_their_heads(specs: Comparison) -> None:
    lines = show_diff(specs, changed=False, width=80, colour=False).splitlines()
    head = next(line for line in lines if line.split() == ["A", "B", "B", "-", "A"])
    assert head.strip().endswith("B - A")
    rows = [line for line in lines if line.endswith(" %")]
    assert len(rows) == 7
    assert len({len(line) for line in rows}) == 1
    assert all(line[len(head) - 1] != " " and line[len(head)] == " " for line in rows)


@pytest.mark.parametrize("width", [40, 60, 80, 100])
def test_lines_fit_and_no_number_is_lost(specs: Comparison, width: int) -> None:
    told = show_diff(specs, changed=False, width=width, colour=False)
    assert max(map(len, told.splitlines())) <= max(width, 56)
    wide = show_diff(specs, changed=False, width=1000, colour=False)
    assert re.findall(r"[\d.]*\d", told) == re.findall(r"[\d.]*\d", wide)


def test_colour_changes_no_word(specs: Comparison) -> None:
    plain, painted = (show_diff(specs, changed=False, width=80, colour=one) for one in (False, True))
    assert "\033" not in plain
    assert re.sub(r"\033\[\d+m", "", painted) == plain
    assert "\033[32monly in B\033[0m" in painted


def test_the_same_is_said_in_words(specs: Comparison) -> None:
    told = show_diff(compare(specs.a, specs.a), changed=False, width=100, colour=False)
    assert told.splitlines()[-1].startswith("No difference in meaning")
    assert len(told.splitlines()) == 4


def test_json_has_a_row_for_each_value_in_si(specs: Comparison) -> None:
    every, changed = (diff_content(specs, changed=one) for one in (False, True))
    assert (every["kind"], every["a"], every["b"], every["same"]) == ("spec", "a.yaml", "b.yaml", False)
    assert changed["rows"] == [row for row in every["rows"] if row["state"] != "same"]
    rows = {row["what"]: row for row in every["rows"]}
    bound = rows["measures.cutting.at_most"]
    assert (bound["state"], bound["a"], bound["b"]) == ("changed", 15e-6, 20e-6)
    assert bound["difference"] == pytest.approx(5e-6, rel=1e-9)
    assert bound["relative"] == pytest.approx(1 / 3, rel=1e-9)
    assert rows["measures.sent"]["a"] is None
    assert rows["measures.sent"]["b"] == {"use": "velocity_transmission", "at_most": 2.0}
    assert rows["variables.leg.min"]["difference"] == 0.0


def result(**changes: Any) -> dict[str, Any]:
    goal = {"value": 0.31, "goal": 0.3, "weight": 1.0, "attained": False}
    content = {
        "orthospec": 1,
        "status": "compromise",
        "attainment": {"factor": 0.01, "goals": {"length": goal}},
        "variables": {"leg": 0.31},
        "manipulator": {"use": "orthoglide", "leg_lengths": [0.31, 0.31, 0.33]},
        "indices": {"stroke": 0.25},
        "workspace": {"prescribed": {"min": [0, 0, 0.0], "max": [0.2, 0.2, 0.2], "holds": True}},
        "limits": [{"kind": "variable", "name": "leg", "side": "at_least", "gain": 1e-3, "cost": None}],
    }
    return copy.deepcopy(content) | changes


def of_results(folder: Path, a: dict[str, Any], b: dict[str, Any], *, spec: str = A) -> Comparison:
    for name, content in (("a", a), ("b", b)):
        (folder / name).mkdir()
        (folder / name / "result.yaml").write_text(dump(content))
        (folder / name / "spec.yaml").write_text(spec)
    return compare(*(read_side(folder / name, name=name) for name in "ab"))


def test_of_results_goals_and_variables_are_told_the_same_or_not(tmp_path: Path) -> None:
    limits = [{"kind": "variable", "name": "leg", "side": "at_least", "gain": 2e-3, "cost": 1e-3}]
    found = of_results(tmp_path, result(), result(status="attained", limits=limits, indices={"stroke": 0.26}))
    whole = squeezed(show_diff(found, changed=False, width=80, colour=False))
    assert whole == squeezed("""\
A  a
B  b

Status
  compromise -> attained

Goals
                              A       B   B - A
  λ                        0.01    0.01    same
  length                 310 mm  310 mm    same

Design variables
  leg                    310 mm  310 mm    same

Indices
  stroke                 250 mm  260 mm  +10 mm   +4 %

What limits the design: what λ gains by 1 % looser, and costs by 1 % tighter
  variable.leg.at_least.gain  0.001  0.002  +0.001  +100 %
  variable.leg.at_least.cost  - -> 0.001

4 values differ, 11 the same.
""")
    changed = show_diff(found, changed=True, width=80, colour=False)
    assert "Goals" not in changed
    assert "stroke" in changed


def test_where_a_section_is_too_wide_one_unit_stands_for_two_numbers(tmp_path: Path) -> None:
    longer = {"indices": {"leg_1_mass": 2.125125, "leg_2_mass": 2.125125, "stroke": 0.25125}}
    shorter = {"indices": {"leg_1_mass": 2.0, "leg_2_mass": 2.0, "stroke": 0.2625}}
    found = of_results(tmp_path, result(**longer), result(**shorter))

    def told(width: int) -> list[str]:
        return show_diff(found, changed=True, width=width, colour=False).splitlines()[4:-2]

    assert told(100) == [
        " " * 38 + "A         B         B - A",
        "  leg_1_mass ... leg_2_mass  2.12513 kg      2 kg  -0.125125 kg  -5.89 %",
        "  stroke                      251.25 mm  262.5 mm     +11.25 mm  +4.48 %",
    ]
    assert told(70)[1:] == [
        "  leg_1_mass ... leg_2_mass  2.12513      2 kg  -0.125125 kg  -5.89 %",
        "  stroke                      251.25  262.5 mm     +11.25 mm  +4.48 %",
    ]
    assert told(60)[1:] == [
        "  leg_1_mass ... leg_2_mass",
        "    2.12513      2 kg  -0.125125 kg  -5.89 %",
        "  stroke",
        "     251.25  262.5 mm     +11.25 mm  +4.48 %",
    ]


def test_without_specs_numbers_have_no_units(tmp_path: Path) -> None:
    found = of_results(tmp_path, result(), result(indices={"stroke": 0.26}), spec="")
    told = show_diff(found, changed=True, width=80, colour=False)
    assert ["stroke", "0.25", "0.26", "+0.01", "+4 %"] in squeezed(told)


@given(a=st.floats(0.1, 10), b=st.floats(0.1, 10))
def test_a_difference_has_a_sign(a: float, b: float) -> None:
    sides = [Side(name, "spec", {"x": {"y": one}}, None) for name, one in (("a", a), ("b", b))]
    found = Comparison(sides[0], sides[1], tuple(rows(sides[0].content, sides[1].content)))
    told = show_diff(found, changed=False, width=80, colour=False)
    if found.changed:
        assert re.search(rf" {'[+]' if b > a else '-'}[\d.e-]+  +{'[+]' if b > a else '-'}[\d.e+-]+ %", told)


DOCUMENTED = re.findall(r"<!-- diff: (.*?) -->\n```text\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)


def test_the_example_of_specs_is_what_is_printed(tmp_path: Path) -> None:
    settings, text = DOCUMENTED[0]
    spec = ROOT / "specs" / "orthoglide-200.yaml"
    changed = load_spec(spec, shlex.split(settings))
    (tmp_path / "b.yaml").write_text(changed.source)
    found = compare(read_side(spec), read_side(tmp_path / "b.yaml"))
    assert show_diff(found, changed=False, width=80, colour=False).split("\n\n", 1)[1] == text


def test_the_example_of_results_is_what_is_printed(
    tmp_path: Path, outcome_of: Callable[..., Outcome]
) -> None:
    folders, text = DOCUMENTED[1]
    sides = []
    for folder in folders.split():
        name = Path(folder).name
        spec = load_spec(ROOT / "specs" / f"{name}.yaml")
        (tmp_path / name).mkdir()
        (tmp_path / name / "spec.yaml").write_text(spec.source)
        (tmp_path / name / "result.yaml").write_text(dump(compose(spec, outcome_of(name).finding)))
        sides.append(read_side(tmp_path / name, name=folder))
    told = show_diff(compare(*sides), changed=False, width=80, colour=False)
    assert told.startswith(text.removesuffix("...\n"))

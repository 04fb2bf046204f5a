"""What a new user gets wrong, and the words with which `check` answers: each mistake with its place."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest

from orthospec import registry
from orthospec.errors import SpecError, UsageError
from orthospec.manipulators import Manipulator
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures.kinematic import ConditionNumber
from orthospec.spec import load_spec

SPEC = """\
orthospec: 1
title: Orthoglide
variables:
  base: {min: 1.0, max: 3.0, start: 2.0}
  third: {min: 1.0, max: 3.0}
manipulator:
  use: orthoglide
  leg_lengths: [base, base, third]
workspace:
  size: [1, 1, 0.8]
  divisions: 40
measures:
  transmission:
    use: velocity_transmission
    at_least: 0.5
    at_most: 2
goals:
  base_legs: {minimise: base, goal: 1.3}
  third_leg: {minimise: third, goal: 1.3}
"""


def mistakes(spec: str, folder: Path, *overrides: str) -> list[str]:
    """The lines that the user reads, without the folder."""
    path = folder / "spec.yaml"
    path.write_text(spec, encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        load_spec(path, overrides)
    return str(caught.value).replace(f"{folder}/", "").splitlines()


CHANGES = {
    "a misspelt section": ("goals:", "gaols:", ["17:1: unknown key 'gaols'; did you mean 'goals'?"]),
    "a comma in a number": (
        "base: {min: 1.0, max: 3.0",
        "base: {min: 1,000 mm, max: 3.0",
        ["4:17: unknown key '000 mm'; a comma ends an entry: write 1000, and 600.5"],
    ),
    "a misspelt key": ("divisions", "divsions", ["11:3: unknown key 'divsions'; did you mean 'divisions'?"]),
    "a misspelt bound": (
        "at_least: 0.5", "at_lest: 0.5", ["15:5: unknown key 'at_lest'; did you mean 'at_least'?"],
    ),
    "a misspelt field of the machine": (
        "leg_lengths:", "leg_length:",
        [
            "6:1: 'leg_lengths' is missing: Lengths of the legs of the three slides [m]",
            "8:3: unknown key 'leg_length'; did you mean 'leg_lengths'?",
        ],
    ),
    "an unknown machine": (
        "use: orthoglide", "use: ortoglide",
        [
            "7:8: unknown manipulator 'ortoglide'; did you mean 'orthoglide'? "
            f"installed: {', '.join(registry.names(registry.MANIPULATORS))}"
        ],
    ),
    "a forgotten section": (
        "workspace:\n  size: [1, 1, 0.8]\n  divisions: 40\n", "",
        ["1:1: 'workspace' is missing: The prescribed cuboid"],
    ),
    "an unknown variable": (
        "[base, base, third]", "[base, bsae, third]", ["8:23: unknown name 'bsae'; did you mean 'base'?"],
    ),
    "a wrong unit": (
        "[base, base, third]", "[base, base, 310 kg]",
        ["8:29: 310 kg is a mass, a length [m] was expected"],
    ),
    "no space before the unit": (
        "[base, base, third]", "[base, base, 310mm]",
        ["8:29: '310mm': a space is missing between number and unit, '310 mm'"],
    ),
    "a unit in capitals": (
        "[base, base, third]", "[base, base, 310 MM]",
        ["8:29: '310 MM': unknown unit 'MM'; did you mean 'mm'?"],
    ),
    "two legs": ("[base, base, third]", "[base, third]", ["8:16: 3 values were expected, 2 given"]),
    "one leg for three": ("[base, base, third]", "1 m", ["8:16: a list [ ... ] was expected, '1 m' given"]),
    "an expression for a list": (
        "[base, base, third]", "base", ["8:16: a list [ ... ] was expected, 'base' given"],
    ),
    "legs that are never positive": (
        "[base, base, third]", "[base, base, third - 9]",
        ["8:29: more than 0 was expected, 'third - 9' is -7, and so at every other design tried"],
    ),
    "a branch that is true": (
        "use: orthoglide\n", "use: orthoglide\n  branch: [1, true, 1]\n",
        ["8:15: a number was expected, true or false given"],
    ),
    "a count that is true": (
        "divisions: 40", "divisions: true", ["11:14: a whole number was expected, true given"],
    ),
    "a power with ^": (
        "minimise: base", "minimise: base^2",
        ["18:25: 'base^2' is not an expression: '^' has no meaning here; a power is written **"],
    ),
    "a comma without quotes": (
        "minimise: base", "minimise: max(base, third)",
        ['18:25: an expression with a comma needs quotes here: "max(base, third)"'],
    ),
    "a goal without its value": (
        "minimise: base, goal: 1.3", "minimise: base", ["18:3: 'goal' is missing: The value aimed at"],
    ),
    "two senses": (
        "minimise: base,", "minimise: base, maximise: third,",
        ["18:3: one of minimise, maximise and match was expected, minimise and maximise given"],
    ),
    "a sense by the sign of a weight": (
        "minimise: base, goal: 1.3", "minimise: base, goal: 1.3, weight: -1",
        ["18:50: 0 or more was expected, -1 given; minimise and maximise tell the sense"],
    ),
    "relative to zero": (
        "minimise: base, goal: 1.3", "minimise: base, goal: 0, weight: relative",
        ["18:48: 'relative' has no meaning at goal 0; give the weight as a number"],
    ),
    "a goal without a value": (
        "minimise: base, goal: 1.3", "minimise: log(base - 5), goal: 1.3",
        ["18:3: 'log(base - 5)' has no value at base = 2: a root, logarithm or power that does not exist,"
         " and so at every other design tried"],
    ),
    "a weight that is below 0 everywhere": (
        "minimise: base, goal: 1.3", "minimise: base, goal: 1.3, weight: base - 4",
        ["18:3: the weight of goal base_legs is -2 here, and so at every other design tried"],
    ),
    "a goal on an unknown index": (
        "minimise: base", "minimise: strok", ["18:25: unknown name 'strok'; did you mean 'stroke'?"],
    ),
    "a goal on an unknown measure": (
        "minimise: base", "minimise: highest(transmision)",
        ["18:25: unknown measure 'transmision' in highest(); did you mean 'transmission'?"],
    ),
    "the worst of a measure with two bounds": (
        "minimise: base", "minimise: worst(transmission)",
        ["18:25: worst(transmission) needs one bound, and transmission has both bounds; "
         "write lowest() or highest()"],
    ),
    "a measure for its extreme": (
        "minimise: base", "minimise: transmission",
        ["18:25: 'transmission' is a measure; write worst(transmission), lowest(transmission) or "
         "highest(transmission)"],
    ),
    "a misspelt weight": (
        "minimise: base, goal: 1.3", "minimise: base, goal: 1.3, weight: relativ",
        ["18:50: unknown name 'relativ'; did you mean 'relative'?"],
    ),
    "a goal's value in a wrong unit": (
        "minimise: base, goal: 1.3", "minimise: stroke, goal: 1.3 kg",
        ["18:39: 1.3 kg is a mass, a length [m] was expected"],
    ),
    "bounds that exclude each other": (
        "at_least: 0.5", "at_least: 5",
        ["15:15: at_least 5 is above at_most 2: nothing meets both"],
    ),
    "a side that means nothing": (
        "velocity_transmission", "condition_number",
        ["15:5: condition_number has no 'at_least'; it knows at_most"],
    ),
    "a measure that asks for nothing": (
        "    at_least: 0.5\n    at_most: 2\n", "",
        ["13:3: 'transmission' asks for nothing: give it 'at_least', 'at_most' or 'levels', or name it in a "
         "goal"],
    ),
    "a bound that is not a number": (
        "at_most: 2", "at_most: .nan", ["16:14: a number was expected, nan is not finite"],
    ),
    "a range upside down": ("min: 1.0, max: 3.0}", "min: 3.0, max: 1.0}", ["5:16: min 3 is not below max 1"]),
    "a start outside the range": ("start: 2.0", "start: 200", ["4:37: start 200 is not within 1 ... 3"]),
    "half a range": ("third: {min: 1.0, max: 3.0}", "third: {min: 1.0}", ["5:3: 'max' is missing"]),
    "a range of two kinds": (
        "third: {min: 1.0, max: 3.0}", "third: {min: 1 kg, max: 3 m}",
        ["5:3: one kind of quantity was expected, but min is a mass, max is a length"],
    ),
    "a variable that depends on another": (
        "third: {min: 1.0, max: 3.0}", "third: {min: base, max: 3.0}",
        ["5:16: 'base' is not a number or quantity, and no variable can stand here"],
    ),
    "a catalogue with a value twice": (
        "third: {min: 1.0, max: 3.0}", "third: {choices: [1, 2, 1]}",
        ["5:27: 1 stands in the catalogue twice"],
    ),
    "a catalogue and a range": (
        "third: {min: 1.0, max: 3.0}", "third: {choices: [1, 2], max: 3}",
        ["5:3: either 'choices', or 'min' and 'max' were expected, both given"],
    ),
    "a variable with the name of a function": (
        "  third: {min: 1.0, max: 3.0}\n", "  third: {min: 1.0, max: 3.0}\n  max: {min: 1, max: 2}\n",
        ["6:3: 'max' has a meaning in expressions; give the variable another name"],
    ),
    "a variable with the name of an index": (
        "  third: {min: 1.0, max: 3.0}\n", "  third: {min: 1.0, max: 3.0}\n  stroke: {min: 1, max: 2}\n",
        ["6:3: 'stroke' is an index of the machine; give the variable another name"],
    ),
    "a variable with a hyphen": (
        "  third: {min: 1.0, max: 3.0}\n", "  third: {min: 1.0, max: 3.0}\n  leg-x: {min: 1, max: 2}\n",
        ["6:3: 'leg-x' cannot be a variable's name: letters, digits and _ only"],
    ),
    "a negative size": ("0.8]", "-0.8]", ["10:16: more than 0 was expected, -0.8 given"]),
    "a region smaller than the cuboid": (
        "divisions: 40", "region: {min: [-1, -1, 0], max: [1, 1, 0.5]}",
        ["11:42: the region is 0.5 wide here, less than the cuboid's 0.8"],
    ),
    "a region upside down": (
        "divisions: 40", "region: {min: [1, -1, 0], max: [-1, 1, 2]}",
        ["11:35: the region's max -1 is not above its min 1"],
    ),
    "a pose of two numbers": (
        "goals:", "poses: {Q0: [0, 0]}\ngoals:", ["17:13: 3 values were expected, 2 given"],
    ),
    "a sweep along nothing": (
        "goals:", "sweep: {variable: bse, from: 1, to: 2}\ngoals:",
        ["17:19: unknown variable 'bse'; did you mean 'base'?"],
    ),
    "a proof without slack": (
        "goals:", "proof: {slack: 0}\ngoals:", ["17:16: more than 0 was expected, 0 given"],
    ),
    "a result to start from": (
        "use: orthoglide\n  leg_lengths: [base, base, third]", "from: solved/result.yaml",
        ["7:9: 'solved/result.yaml': no such file or directory"],
    ),
    "a bound that no machine meets": (
        "at_least: 0.5\n    at_most: 2", "at_most: -2",
        ["15:14: velocity_transmission is never below 0: no machine meets at_most -2"],
    ),
    "parts of a leg": (
        "use: orthoglide\n",
        "use: orthoglide\n"
        "  legs: {kind: PU, section: {round: {diameter: 20 mm, wall: 10 mm}}, material: steal}\n",
        [
            "8:16: 'PUU' or 'PRPaR' was expected, 'PU' given",
            "8:37: a wall of 0.01 m does not fit: more than 0 and less than 0.01 m, half of the smallest "
            "outer size, was expected (no wall: solid)",
            "8:80: unknown material 'steal'; did you mean 'steel'? known here: steel, aluminium, titanium, "
            "carbon",
        ],
    ),
    "the scale of a joint cuboid that is not there": (
        "divisions: 40", "together: false\ngoals: {size: {maximise: scale, goal: 2}}\nunused:",
        ["12:26: 'scale' is that of the joint cuboid, and with 'together: false' there is none",
         "13:1: unknown key 'unused'; known here: orthospec, title, notes, variables, manipulator, "
         "workspace, measures, goals, poses, sweep, optimise, pareto, proof",
         "19:1: duplicate key 'goals', first given at 12:1"],
    ),
    "a later format": (
        "orthospec: 1", "orthospec: 2",
        ["1:12: this version reads specs of format 1, written 'orthospec: 1'; 2 given"],
    ),
    "a key given twice": (
        "divisions: 40", "size: [2, 2, 2]", ["11:3: duplicate key 'size', first given at 10:3"],
    ),
    "a tab": (
        "  divisions: 40", "\tdivisions: 40", ["11:1: a tab indents this line; YAML takes spaces only"],
    ),
    "a negative length": ("[base, base, third]", "[base, base, -310 mm]",
        ["8:29: more than 0 was expected, '-310 mm' is -0.31"],
    ),
    "two joint limits": (
        "use: orthoglide\n", "use: orthoglide\n  joint_limits: {min: [1, 2]}\n",
        ["8:23: 3 values were expected, 2 given"],
    ),
    "a measure in the place of an axis": (
        "  transmission:\n", "  axis_x:\n",
        ["13:3: 'axis_x' is a coordinate of the measures' fields; give the measure another name"],
    ),
    "a measure under the name of an axis": (
        "  transmission:\n", "  z:\n",
        ["13:3: 'z' is a coordinate of the measures' fields; give the measure another name"],
    ),
    "a measure in the place of least and greatest": (
        "  transmission:\n", "  end:\n",
        ["13:3: 'end' is a coordinate of the measures' fields; give the measure another name"],
    ),
    "a size of four": ("0.8]", "0.8, 1]", ["10:9: 3 values were expected at most, 4 given"]),
    "a level that is no list": (
        "at_most: 2", "levels: {at_most: 1.5}", ["16:23: a list [ ... ] was expected, 1.5 given"],
    ),
    "a proof whose slack is a length": (
        "goals:", "proof: {slack: 1 mm}\ngoals:", ["17:16: 1 mm is a length, a number was expected"],
    ),
    "a proof whose slack is a variable": (
        "goals:", "proof: {slack: base}\ngoals:", ["17:16: unknown name 'base'; no names are known here"],
    ),
    "a proof that is true": (
        "goals:", "proof: true\ngoals:",
        ["17:8: a mapping was expected, true given; or false was expected, true given"],
    ),
    "a misspelt key of a proof": (
        "goals:", "proof: {slak: 1}\ngoals:", ["17:9: unknown key 'slak'; did you mean 'slack'?"],
    ),
    "a root of nothing": (
        "[base, base, third]", "[base, base, sqrt(third - 9)]",
        ["8:29: 'sqrt(third - 9)' has no value at third = 2: a root, logarithm or power that does not exist, "
         "and so at every other design tried"],
    ),
    "joint limits upside down": (
        "use: orthoglide\n", "use: orthoglide\n  joint_limits: {min: 2, max: 1}\n",
        ["8:17: min 2 m is not below max 1 m"],
    ),
    "a colon without a space": (
        "use: orthoglide", "use:orthoglide",
        ["8:14: a ':' where none can stand; is the indentation wrong, or a quote missing?"],
    ),
    "a tolerance of an unknown field": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {leg_length: 1 mm}\n",
        ["9:15: unknown field 'leg_length'; did you mean 'leg_lengths'?"],
    ),
    "a tolerance of a field that takes none": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {branch: 1}\n",
        ["9:15: 'branch' takes no tolerance; known here: leg_lengths"],
    ),
    "a tolerance that is no length": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {leg_lengths: 1 kg}\n",
        ["9:28: 1 kg is a mass, a length [m] was expected"],
    ),
    "a tolerance below 0": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {leg_lengths: -1 mm}\n",
        ["9:28: 0 or more was expected, -0.001 given"],
    ),
    "a tolerance with a variable": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {leg_lengths: base}\n",
        ["9:28: 'base' is not a number or quantity, and no variable can stand here"],
    ),
    "a tolerance as great as the field": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: {leg_lengths: 2 m}\n",
        ["9:28: less than the field's own 2 was expected, 2 given"],
    ),
    "a tolerance of nothing": (
        "  leg_lengths: [base, base, third]\n",
        "  leg_lengths: [base, base, third]\n  tolerance: 1 mm\n",
        ["9:14: a mapping was expected, '1 mm' given"],
    ),
    "a list for a mapping": (
        "  base_legs: {minimise: base, goal: 1.3}\n  third_leg: {minimise: third, goal: 1.3}\n",
        "  - {minimise: base, goal: 1.3}\n", ["18:3: a mapping was expected, a list given"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", CHANGES)
def test_a_mistake_is_answered_with_its_place_and_what_was_expected(what: str, tmp_path: Path) -> None:
    old, new, expected = CHANGES[what]
    assert SPEC.count(old) >= 1
    assert mistakes(SPEC.replace(old, new, 1), tmp_path) == [f"spec.yaml:{line}" for line in expected]


@pytest.mark.parametrize("written", ["{min: 1 m, max: 3000 mm}", "{choices: [100 cm, 2 m]}"])
def test_a_goal_on_a_variable_is_of_the_kind_that_its_values_are_written_in(
    written: str, tmp_path: Path
) -> None:
    spec = SPEC.replace("third: {min: 1.0, max: 3.0}", f"third: {written}")
    wrong = spec.replace("third, goal: 1.3", "third, goal: 1.3 kg")
    assert mistakes(wrong, tmp_path) == ["spec.yaml:19:38: 1.3 kg is a mass, a length [m] was expected"]
    (tmp_path / "spec.yaml").write_text(spec.replace("third, goal: 1.3", "third, goal: 1300 mm"))
    assert load_spec(tmp_path / "spec.yaml").goals[1].goal == 1.3


def test_an_empty_spec_is_told_how_one_starts_and_an_empty_setting_that_it_is_one(tmp_path: Path) -> None:
    assert mistakes("", tmp_path) == ["spec.yaml:1:1: the file is empty; a spec starts with 'orthospec: 1'"]
    assert mistakes(SPEC, tmp_path, "title=#") == ["--set title=#: there is no value after the ="]


def test_all_mistakes_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    spec = SPEC
    for old, new in (
        ("title", "titel"),
        ("divisions: 40", "divisions: x"),
        ("use: velocity", "use: velocty"),
    ):
        spec = spec.replace(old, new)
    spec = spec.replace("[base, base, third]", "[base, bsae, 3 kg]").replace("goal: 1.3}", "goal: x}", 1)
    places = [line.split(": ")[0] for line in mistakes(spec, tmp_path)]
    assert [place.split(":")[1] for place in places] == ["2", "8", "8", "11", "14", "18"]


def test_a_wrong_variable_does_not_make_its_uses_wrong(tmp_path: Path) -> None:
    spec = SPEC.replace("base: {min: 1.0", "base: {min: one", 1)
    assert mistakes(spec, tmp_path) == [
        "spec.yaml:4:15: 'one' is not a number or quantity, and no variable can stand here"
    ]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("workspace.divisons=80", "unknown key 'divisons'; did you mean 'divisions'?"),
        ("workspace.divisions=many", "a whole number was expected, 'many' given"),
        ("manipulator.leg_lengths.3=1", "there is no 'manipulator.leg_lengths.3' in the spec"),
        ("manipulator.leg_lengths.0=310 kg", "310 kg is a mass, a length [m] was expected"),
        ("workspace.size.0.x=1", "there is no 'workspace.size.0.x' in the spec"),
        ("divisions", "write KEY=VALUE, like workspace.divisions=80"),
        ("workspace.size=[1, 2", "a list in [ ] is not closed, or lacks a comma"),
        ("title=[1, 2]", "a text was expected, a list given"),
    ],
)
def test_a_wrong_setting_is_told_by_its_own_words(override: str, message: str, tmp_path: Path) -> None:
    assert mistakes(SPEC, tmp_path, override) == [f"--set {override}: {message}"]


def test_a_measure_in_metres_a_second_is_refused_where_joints_turn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Orthoglide, "joint_units", ("rad", "rad", "rad"))
    spec = SPEC.replace("    at_least: 0.5\n", "    speed: 1 m/s\n").replace(
        "velocity_transmission", "joint_speed"
    )
    (told,) = mistakes(spec, tmp_path)
    assert "joint_speed needs the machine's sliding joints, and orthoglide offers none" in told


class Elastic(ConditionNumber):
    needs: ClassVar[frozenset[str]] = frozenset({"compliance", "actuator_forces"})


def test_what_a_machine_does_not_offer_is_told_at_the_measure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "find_measure", lambda _: Elastic)
    for method in ("compliance", "actuator_limits"):
        monkeypatch.setattr(Orthoglide, method, getattr(Manipulator, method), raising=False)
    spec = SPEC.replace("    at_least: 0.5\n", "").replace("velocity_transmission", "elastic")
    offers = "and orthoglide offers none"
    assert mistakes(spec, tmp_path) == [
        f"spec.yaml:13:3: elastic needs the machine's actuator forces, {offers}",
        f"spec.yaml:13:3: elastic needs the machine's compliance, {offers}",
    ]


def test_what_measures_and_goals_need_of_the_machine_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = {"compliance": (), "actuator_forces": ("actuators.force",), "stroke": ("legs.mass", "feet")}
    monkeypatch.setattr(registry, "find_measure", lambda _: Elastic)
    for method in ("compliance", "actuator_limits"):
        monkeypatch.setattr(Orthoglide, method, lambda *_: None, raising=False)
    monkeypatch.setattr(Orthoglide, "missing", lambda _, what: given[what])
    spec = SPEC.replace("    at_least: 0.5\n", "").replace("velocity_transmission", "elastic")
    spec = spec.replace("minimise: base", "minimise: base + stroke")
    assert mistakes(spec, tmp_path) == [
        "spec.yaml:13:3: elastic needs the machine's actuator forces: give actuators.force",
        "spec.yaml:17:25: stroke is not known: give legs.mass, feet",
    ]


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"spec\.yaml: no such file or directory"):
        load_spec(tmp_path / "spec.yaml")
    with pytest.raises(UsageError, match="is a directory"):
        load_spec(tmp_path)


def test_a_file_that_is_not_text(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_bytes(b"orthospec: 1\ntitle: \xe9\n")
    with pytest.raises(SpecError, match=r"spec\.yaml:2:8: not UTF-8 text; save the file as UTF-8"):
        load_spec(path)


def test_a_misspelt_plugin_hides_no_other_mistake(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(
        "orthospec: 1\n"
        "manipulator: {use: orthoglid, leg_lengths: [1, 1]}\n"
        "workspace: {size: [1, 1, 1 kg]}\n"
        "measures:\n"
        "  transmission: {use: velocity_transmision, at_mots: 2}\n"
    )
    with pytest.raises(SpecError) as caught:
        load_spec(path)
    assert [(m.line, m.message.split(";")[0].split(": give")[0]) for m in caught.value.mistakes] == [
        (2, "unknown manipulator 'orthoglid'"),
        (2, "3 values were expected, 2 given"),
        (3, "1 kg is a mass, a length [m] was expected"),
        (5, "'transmission' asks for nothing"),
        (5, "unknown measure 'velocity_transmision'"),
        (5, "unknown key 'at_mots'"),
    ]

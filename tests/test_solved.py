"""A second spec on the machine of a solved one: what is taken, what may be added, what is refused."""

from __future__ import annotations

import hashlib
import io
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from pydantic import BaseModel, ConfigDict

from orthospec import registry
from orthospec.errors import SpecError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.optimise import Outcome, evaluate_spec, solve
from orthospec.quantities import Length, Mass
from orthospec.result import compose, read_result, write_result
from orthospec.result import spec_of as spec_beside
from orthospec.spec import load_spec
from orthospec.spec.writing import dump

SPECS = Path(__file__).parents[1] / "specs"

SECOND = """\
orthospec: 1
variables:
  ratio: {min: 1, max: 9}
manipulator:
  from: ../geometry/result.yaml
workspace:
  size: [200 mm, 200 mm, 200 mm]
  divisions: 10
measures:
  isotropy: {use: condition_number, at_most: ratio}
goals:
  isotropy: {minimise: ratio, goal: 1}
"""
FIXED = SECOND.replace("at_most: ratio", "at_most: 5")


@pytest.fixture(scope="session")
def solved(outcome_of: Callable[..., Outcome], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The result folder of the 200 mm Orthoglide."""
    folder = tmp_path_factory.mktemp("solved") / "geometry"
    spec = load_spec(SPECS / "orthoglide-200.yaml")
    write_result(folder, spec, compose(spec, outcome_of("orthoglide-200").finding), {})
    return folder


@pytest.fixture
def first(solved: Path, tmp_path: Path) -> Path:
    """A copy of it to spoil, where the second spec looks for it."""
    return Path(shutil.copytree(solved, tmp_path / "geometry")) / "result.yaml"


@pytest.fixture
def second(first: Path) -> Path:
    """The second spec, in a folder of its own."""
    path = first.parents[1] / "drives" / "spec.yaml"
    path.parent.mkdir()
    path.write_text(SECOND)
    return path


class Rods(BaseModel):
    """What a geometry leaves open, in part."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: str = "round"
    width: Length | None = None


class Fitted(Orthoglide):
    """An Orthoglide with more to add."""

    rods: Rods = Rods()
    carriage: Mass | None = None


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """`orthoglide` stands for `Fitted`."""
    monkeypatch.setattr(registry, "find_manipulator", lambda _: Fitted)


def mistakes(spec: Path, *settings: str) -> list[str]:
    with pytest.raises(SpecError) as caught:
        load_spec(spec, settings)
    return str(caught.value).replace(f"{spec.parent}/", "").splitlines()


def change(result: Path, **entries: object) -> None:
    """Set top-level entries of a result; None takes one out."""
    content = {**yaml.safe_load(result.read_text()), **entries}
    result.write_text(dump({key: value for key, value in content.items() if value is not None}))


def machine_of(spec: Path, *settings: str) -> Orthoglide:
    loaded = load_spec(spec, settings)
    return loaded.design(loaded.default_values()).manipulator


class TestWhatIsTaken:
    def test_is_the_solved_machine_with_the_range_of_its_joints_as_limits(self, first, second):
        content, machine = read_result(first), machine_of(second)
        assert list(machine.leg_lengths) == content["manipulator"]["leg_lengths"]
        assert list(machine.joint_limits.min) == content["joints"]["min"]
        assert list(machine.joint_limits.max) == content["joints"]["max"]

    def test_holds_the_solved_cuboid_within_these_limits(self, first, second):
        second.write_text(FIXED)
        evaluation = evaluate_spec(load_spec(second)).finding.evaluation
        assert evaluation.prescribed.holds
        assert evaluation.joint.scale == pytest.approx(1, abs=1e-9)
        before = read_result(first)["workspace"]["prescribed"]
        assert evaluation.prescribed.cuboid.low == pytest.approx(before["min"], abs=1e-9)

    def test_leads_to_an_optimum_of_the_second_spec(self, first, second):
        """At the corners of the 200 mm cube the factors are 1/2 ... 2."""
        spec = load_spec(second)
        finding = solve(spec).finding
        assert finding.attainment.goals["isotropy"].value == pytest.approx(4, rel=1e-8)
        assert compose(spec, finding)["provenance"]["from"] == {
            "path": "../geometry/result.yaml",
            "sha256": hashlib.sha256(first.read_bytes()).hexdigest(),
        }

    def test_may_be_named_by_the_result_folder_or_a_setting(self, first, second):
        assert load_spec(second, ["manipulator.from=../geometry"]).solved.path == "../geometry"
        second.write_text(SECOND.replace("from: ../geometry/result.yaml", "from: nothing"))
        whole = load_spec(second, ["manipulator.from=../geometry/result.yaml"])
        assert whole.solved.sha256 == hashlib.sha256(first.read_bytes()).hexdigest()

    def test_lies_relative_to_the_current_folder_for_standard_input(self, first, monkeypatch):
        monkeypatch.chdir(first.parents[1])
        text = SECOND.replace("../geometry", "geometry").encode()
        monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(text)))
        assert load_spec(Path("-")).solved.path == "geometry/result.yaml"


class TestTheResultFolder:
    def test_stands_alone(self, first, second, tmp_path):
        second.write_text(FIXED)
        spec = load_spec(second)
        write_result(tmp_path / "out", spec, compose(spec, evaluate_spec(spec).finding), {})
        shutil.rmtree(first.parent)
        again = spec_beside(tmp_path / "out")
        assert again is not None
        assert again.solved is None
        assert again.canonical() == spec.canonical()
        machines = [one.design({"ratio": 2}).manipulator for one in (spec, again)]
        assert machines[0] == machines[1]

    def test_has_the_hash_of_the_machine_and_not_of_its_path(self, first, second):
        before = load_spec(second).sha256()
        shutil.copytree(first.parent, first.parents[1] / "elsewhere")
        assert load_spec(second, ["manipulator.from=../elsewhere/result.yaml"]).sha256() == before
        content = yaml.safe_load(first.read_text())
        change(first, manipulator={**content["manipulator"], "leg_lengths": [0.4, 0.4, 0.4]})
        assert load_spec(second).sha256() != before


class TestJointLimits:
    def test_of_the_spec_stand_in_place_of_the_range(self, second):
        limits = machine_of(second, "manipulator.joint_limits={max: 390 mm}").joint_limits
        assert (limits.min, limits.max) == (None, (0.39, 0.39, 0.39))

    def test_are_none_where_the_spec_gives_an_empty_mapping(self, second):
        limits = machine_of(second, "manipulator.joint_limits={}").joint_limits
        assert (limits.min, limits.max) == (None, None)

    def test_of_the_solved_machine_are_kept(self, first, second):
        content = yaml.safe_load(first.read_text())
        change(first, manipulator={**content["manipulator"], "joint_limits": {"max": [0.5, 0.5, 0.5]}})
        limits = machine_of(second).joint_limits
        assert (limits.min, limits.max) == (None, (0.5, 0.5, 0.5))
        assert machine_of(second, "manipulator.joint_limits.min=0.1").joint_limits.min == (0.1, 0.1, 0.1)


@pytest.mark.usefixtures("fitted")
class TestKeysBeside:
    def test_may_have_tolerances_which_are_no_field_of_the_machine(self, second):
        spec = load_spec(second, ["manipulator.tolerance={leg_lengths: 0.1 mm}"])
        assert spec.tolerances == pytest.approx({"leg_lengths": 1e-4}, rel=1e-12)
        assert load_spec(second).tolerances == {}

    def test_add_what_is_open_at_any_depth(self, first, second):
        content = yaml.safe_load(first.read_text())
        change(first, manipulator={**content["manipulator"], "rods": {"kind": "square"}})
        settings = ("manipulator.rods.width=20 mm", "manipulator.carriage=ratio / 2")
        loaded = load_spec(second, settings)
        machine = loaded.design({"ratio": 3}).manipulator
        assert (machine.rods, machine.carriage) == (Rods(kind="square", width=0.02), 1.5)

    def test_change_nothing(self, first, second):
        content = yaml.safe_load(first.read_text())
        change(first, manipulator={**content["manipulator"], "rods": {"kind": "square"}})
        second.write_text(
            SECOND.replace("workspace:", "  leg_lengths: [1, 1, 1]\n  rods: {kind: round}\nworkspace:", 1)
        )
        only = "is solved in ../geometry/result.yaml and cannot be changed here; keys beside 'from' only add"
        assert mistakes(second) == [
            f"spec.yaml:6:3: 'leg_lengths' {only}",
            f"spec.yaml:7:10: 'rods.kind' {only}",
        ]
        second.write_text(SECOND)
        setting = "manipulator.leg_lengths.0=1"
        assert mistakes(second, setting) == [f"--set {setting}: 'leg_lengths' {only}"]

    def test_that_would_move_the_joints_are_refused(self, second):
        second.write_text(SECOND.replace("workspace:", "  branch: [1, 1, -1]\nworkspace:", 1))
        assert mistakes(second) == [
            "spec.yaml:5:3: the keys beside it move the joints of the machine solved in"
            " ../geometry/result.yaml; they only add"
        ]

    def test_are_checked_like_any_others(self, second):
        second.write_text(
            SECOND.replace("workspace:", "  carriage: 3 mm\n  rods: {heigth: 1}\n  hands: 1\nworkspace:", 1)
        )
        found = [line.split("; ")[0] for line in mistakes(second)]
        assert found[0] == "spec.yaml:6:13: 3 mm is a length, a mass [kg] was expected"
        assert [line.split(": ", 1)[0] for line in found] == [
            "spec.yaml:6:13",
            "spec.yaml:7:10",
            "spec.yaml:8:3",
        ]

    def test_do_not_hold_a_use(self, second):
        second.write_text(SECOND.replace("from:", "use: orthoglide\n  from:"))
        assert mistakes(second) == ["spec.yaml:4:1: one of 'use' and 'from' was expected, both given"]


WRONG = {
    "infeasible": ({"status": "infeasible"}, "has no solved machine: its status is infeasible"),
    "failed": ({"status": "failed"}, "has no solved machine: its status is failed"),
    "stopped": ({"status": "unfinished"}, "has no solved machine: its status is unfinished"),
    "out of reach": ({"joints": None}, "has no solved machine: its cuboid leaves the reach"),
    "another format": ({"orthospec": 2}, "is a result of format 2; format 1 is read here"),
    "no machine": ({"manipulator": None}, "is not a whole result: 'manipulator' is missing or wrong"),
    "a spec": (
        {"status": None},
        "is a spec; 'orthospec run' makes a result of it; a result's result.yaml was expected",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_result_without_a_solved_machine_is_refused_at_from(what: str, first: Path, second: Path) -> None:
    entries, message = WRONG[what]
    change(first, **entries)
    assert mistakes(second) == [f"spec.yaml:5:9: '../geometry/result.yaml' {message}"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff", "is not a result: not UTF-8 text"),
        (b"- 1\n", "is not a result; a result's result.yaml was expected"),
        (b"a: 1\na: 2\n", "cannot be read: line 2: duplicate key 'a', first given at 1:1"),
        (b"a: [1\n", "cannot be read: line 1: a list in [ ] is not closed, or lacks a comma"),
    ],
)
def test_what_is_no_result_is_told_in_one_line(
    content: bytes, message: str, first: Path, second: Path
) -> None:
    first.write_bytes(content)
    assert mistakes(second) == [f"spec.yaml:5:9: '../geometry/result.yaml' {message}"]


def test_a_result_that_is_not_there(second: Path) -> None:
    second.write_text(SECOND.replace("result.yaml", "results.yaml"))
    assert mistakes(second) == ["spec.yaml:5:9: '../geometry/results.yaml': no such file or directory"]


def test_a_machine_that_is_not_installed_or_has_other_fields_now(first: Path, second: Path) -> None:
    machine = yaml.safe_load(first.read_text())["manipulator"]
    change(first, manipulator={**machine, "use": "hexaglide"})
    (line,) = mistakes(second)
    assert line.startswith("spec.yaml:5:9: the machine of '../geometry/result.yaml': unknown manipulator")
    change(first, manipulator={**machine, "wheels": 4})
    (line,) = mistakes(second)
    assert "is not one of orthoglide as installed: wheels: unknown key 'wheels'" in line

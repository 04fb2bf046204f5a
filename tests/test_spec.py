"""A spec read, resolved to SI, and built into designs; its canonical form; what checking costs."""

from __future__ import annotations

import contextlib
import copy
import io
import pickle
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from orthospec.errors import PluginFault, SpecError, UnbuildableDesign, UsageError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Level
from orthospec.spec import Region, Spec, Sweep, Variable, Workspace, load_spec
from orthospec.spec.model import ProofKeys
from orthospec.spec.strict_yaml import parse
from orthospec.spec.writing import dump

SPEC = """\
orthospec: 1
title: everything that this version serves
notes: {free: [text, 1]}
variables:
  base: {min: 1000 mm, max: 3, start: 2.0}
  third: {min: 1.0, max: 3.0}
manipulator:
  use: orthoglide
  leg_lengths: [base, 1500 mm, "max(base, third) / 2"]
  joint_limits: {max: 4 * base}
workspace:
  size: [1, 1000 mm, 0.8]
  divisions: 40
  region: {min: [-1, -1, -1], max: [1, 1, 1 m]}
measures:
  transmission:
    use: velocity_transmission
    at_least: 1 / base
    at_most: 2
    levels: {at_most: [1.5, 180 %], at_least: [0.1 * third]}
  condition: {use: condition_number}
goals:
  base_legs: {minimise: base, goal: 1.3, weight: relative}
  size: {maximise: scale, goal: third, weight: 0}
  even: {match: base - third, goal: 0}
  dexterity: {minimise: 2 * highest(condition), goal: 3}
  stroke: {minimise: stroke, goal: 250 mm, weight: 1 mm}
poses: {Q0: [0, 0, -100 mm]}
sweep: {variable: base, from: 1, to: 3000 mm, points: 5}
optimise: {starts: 3, seed: 7}
"""


@pytest.fixture
def spec_file(tmp_path: Path) -> Path:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC, encoding="utf-8")
    return path


@pytest.fixture
def spec(spec_file: Path) -> Spec:
    return load_spec(spec_file)


def test_the_parts_are_resolved_to_si(spec: Spec) -> None:
    assert spec.title == "everything that this version serves"
    assert spec.variables == {"base": Variable(1.0, 3.0, 2.0), "third": Variable(1.0, 3.0, 2.0)}
    region = Region((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert spec.workspace == Workspace((1.0, 1.0, 0.8), 40, region, together=True)
    assert spec.poses == {"Q0": (0.0, 0.0, -0.1)}
    assert spec.sweep == Sweep("base", 1.0, 3.0, 5)
    assert (spec.optimise.starts, spec.optimise.seed) == (3, 7)
    assert spec.source == SPEC


def test_a_design_is_a_machine_with_what_is_asked_of_it(spec: Spec, spec_file: Path) -> None:
    design = spec.design({"base": 1.25, "third": 2.0})
    assert design.values == {"base": 1.25, "third": 2.0}
    assert isinstance(design.manipulator, Orthoglide)
    assert design.manipulator.leg_lengths == (1.25, 1.5, 1.0)
    assert design.manipulator.joint_limits.max == (5.0, 5.0, 5.0)
    transmission, condition = design.demands
    assert transmission.bounds == {"at_least": 0.8, "at_most": 2.0}
    assert transmission.levels == (Level({"at_least": 0.2}), Level({"at_most": 1.5}), Level({"at_most": 1.8}))
    assert transmission.place == f"{spec_file}:16:3"
    assert (condition.name, condition.bounds, condition.levels) == ("condition", {}, ())
    goals = {goal.name: (goal.sense, goal.expression.text, goal.goal, goal.weight) for goal in design.goals}
    assert goals == {
        "base_legs": ("minimise", "base", 1.3, 1.3),
        "size": ("maximise", "scale", 2.0, 0.0),
        "even": ("match", "base - third", 0.0, 0.0),
        "dexterity": ("minimise", "2 * highest(condition)", 3.0, 1.0),
        "stroke": ("minimise", "stroke", 0.25, 0.001),
    }


def test_a_design_at_the_default_values(spec: Spec) -> None:
    assert spec.default_values() == {"base": 2.0, "third": 2.0}
    assert spec.design(spec.default_values()).manipulator.model_dump()["leg_lengths"] == (2.0, 1.5, 1.0)


def test_a_design_is_built_in_a_fraction_of_a_millisecond(spec: Spec) -> None:
    spec.design(spec.default_values())
    times = []
    for _ in range(20):
        began = time.perf_counter()
        spec.design({"base": 1.5, "third": 2.5})
        times.append(time.perf_counter() - began)
    assert min(times) < 2e-4


def test_values_must_be_those_of_the_variables(spec: Spec) -> None:
    with pytest.raises(UsageError, match=r"\(base, third\), given are base"):
        spec.design({"base": 1.0})


def test_an_unbuildable_design_says_where_and_why(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC.replace("leg_lengths: [base,", "leg_lengths: [base - 1.5,"), encoding="utf-8")
    spec = load_spec(path)
    message = (
        "no machine can be built at base = 1.25, third = 2: leg_lengths.0: more than 0 was expected, "
        "'base - 1.5' is -0.25"
    )
    with pytest.raises(UnbuildableDesign) as caught:
        spec.design({"base": 1.25, "third": 2.0})
    assert str(caught.value) == message


def test_a_start_without_a_machine_is_no_mistake_where_others_have_one(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC.replace("leg_lengths: [base,", "leg_lengths: [base - 2.5,"), encoding="utf-8")
    spec = load_spec(path)
    with pytest.raises(UnbuildableDesign):
        spec.design(spec.default_values())
    assert spec.design({"base": 3.0, "third": 1.0}).manipulator


def test_a_spec_travels_to_other_processes(spec: Spec) -> None:
    copied = pickle.loads(pickle.dumps(spec))
    assert copied.design(copied.default_values()) == spec.design(spec.default_values())


def test_standard_input_is_a_dash(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(SPEC.encode())))
    assert load_spec(Path("-")).place(("measures", "condition")) == "-:21:3"


def test_settings_change_the_spec_and_its_source(spec_file: Path) -> None:
    changes = [
        "workspace.divisions=80",
        'manipulator.leg_lengths.1="310 mm"',
        "goals.size=",
        "poses.Q1=[0, 0, 1]",
    ]
    with pytest.raises(SpecError, match=r"--set goals\.size=: a mapping was expected, nothing given"):
        load_spec(spec_file, changes)
    changes[2] = "optimise={seed: 1}"
    changed = load_spec(spec_file, changes)
    assert changed.workspace.divisions == 80
    assert changed.poses["Q1"] == (0.0, 0.0, 1.0)
    spec_file.write_text(changed.source, encoding="utf-8")
    again = load_spec(spec_file)
    assert again.canonical() == changed.canonical()
    assert again.sha256() == changed.sha256()


def test_the_hash_is_of_what_the_spec_means(spec: Spec, tmp_path: Path) -> None:
    same = (
        SPEC.replace("1500 mm", "1.5")
        .replace("title: everything", "title: all")
        .replace("1 / base", "1/base")
    )
    other = SPEC.replace("1500 mm", "1.6")
    for text, is_equal in ((f"# a comment\n{same}", True), (other, False)):
        path = tmp_path / "other.yaml"
        path.write_text(text, encoding="utf-8")
        assert (load_spec(path).sha256() == spec.sha256()) is is_equal


def test_the_canonical_form_is_plain_and_without_title_and_notes(spec: Spec) -> None:
    canonical = spec.canonical()
    assert not {"title", "notes"} & canonical.keys()
    assert canonical["manipulator"]["leg_lengths"] == ["base", 1.5, "max(base, third) / 2"]
    assert parse(dump(canonical), "canonical").data["measures"]["transmission"]["levels"][2] == {
        "at_most": 1.8
    }


def test_the_plugins_in_use_are_known_with_their_versions(spec: Spec) -> None:
    assert [(plugin.name, plugin.distribution) for plugin in spec.plugins] == [
        ("orthoglide", "orthospec"),
        ("condition_number", "orthospec"),
        ("velocity_transmission", "orthospec"),
    ]


def test_the_least_spec_is_four_lines(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(
        "orthospec: 1\nmanipulator: {use: orthoglide, leg_lengths: [1, 1, 1]}\nworkspace: {size: [1, 1, 1]}\n"
        "measures:\n",
        encoding="utf-8",
    )
    spec = load_spec(path)
    assert spec.workspace == Workspace((1.0, 1.0, 1.0), 20, None, together=True)
    assert spec.design({}).demands == ()
    assert (spec.optimise.starts, spec.optimise.seed) == (8, 0)


PLUGIN = """
from typing import ClassVar
from pydantic import model_validator
from orthospec.measures import Measure
from orthospec.quantities import Length

class Faulty(Measure):
    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    needs: ClassVar[frozenset[str]] = frozenset({"compliance"})
    clearance: Length = 0.0

    @model_validator(mode="after")
    def _breaks(self):
        if self.clearance > 1:
            raise KeyError("oh")
        return self

    def values(self, manipulator, poses):
        return poses[:, 0]
"""


@pytest.fixture
def faulty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A plugin whose validator fails, and a spec that uses it."""
    (tmp_path / "made_up_faulty.py").write_text(PLUGIN)
    info = tmp_path / "made_up_faulty-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: made-up-faulty\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[orthospec.measures]\nfaulty = made_up_faulty:Faulty\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    path = tmp_path / "spec.yaml"
    path.write_text(
        "orthospec: 1\nmanipulator: {use: orthoglide, leg_lengths: [1, 1, 1]}\nworkspace: {size: [1, 1, 1]}\n"
        "measures:\n  gap: {use: faulty, clearance: 2 m, at_least: 1 mm}\n"
    )
    return path


def test_a_plugin_that_breaks_is_named_with_its_place(faulty: Path) -> None:
    with pytest.raises(PluginFault, match=r"spec\.yaml:5:3: plugin faulty: KeyError: 'oh'"):
        load_spec(faulty)


def test_what_a_measure_needs_of_the_machine_is_asked_for(
    faulty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Orthoglide, "compliance", lambda *_: None, raising=False)
    monkeypatch.setattr(Orthoglide, "missing", lambda _, what: (f"legs.section for {what}",))
    with pytest.raises(SpecError) as caught:
        load_spec(faulty, ["measures.gap.clearance=1 mm"])
    expected = "spec.yaml:5:3: faulty needs the machine's compliance: give legs.section for compliance"
    assert str(caught.value).endswith(expected)


def test_checking_imports_nothing_heavy(spec_file: Path) -> None:
    program = (
        "import sys, pathlib; from orthospec.spec import load_spec; load_spec(pathlib.Path(sys.argv[1])); "
        "print(*sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-P", "-c", program, str(spec_file)], capture_output=True, text=True, check=True
    )
    loaded = set(run.stdout.split())
    assert "orthospec.measures.kinematic" in loaded
    assert not {"numpy", "numpy._core", "scipy", "cvxpy", "clarabel", "matplotlib", "pint"} & loaded


WRONG = st.none() | st.booleans() | st.floats() | st.sampled_from(
    [-1, 0, 1e300, "", "x", "base", "310 kg", "1 mm", "1/0", "é", [], {}, [1], {"x": 1}, "DELETE"]
)  # fmt: skip


def paths(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path, *(found for key, value in inner for found in paths(value, (*path, key)))]


CONTENT = parse(SPEC, "spec.yaml").data


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.tuples(st.sampled_from(paths(CONTENT)[1:]), WRONG), min_size=1, max_size=3))
def test_whatever_is_wrong_is_told_with_a_place_or_runs(tmp_path: Path, changes: list[Any]) -> None:
    content = copy.deepcopy(CONTENT)
    for (*parents, last), value in changes:
        here = content
        try:
            for key in parents:
                here = here[key]
            if value == "DELETE":
                del here[last]
            else:
                here[last] = copy.deepcopy(value)
        except (KeyError, IndexError, TypeError):
            continue
    path = tmp_path / "spec.yaml"
    path.write_text(dump(content), encoding="utf-8")
    try:
        spec = load_spec(path)
    except SpecError as error:
        places = [mistake.line for mistake in error.mistakes]
        assert places
        assert min(places) > 0
        return
    assert len(spec.sha256()) == 64
    with contextlib.suppress(UnbuildableDesign):
        assert spec.design(spec.default_values()).manipulator


def test_the_slack_of_a_proof_may_be_a_part_in_per_cent(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC + "proof: {slack: 1 %}\n", encoding="utf-8")
    assert load_spec(path).proof == ProofKeys(slack=0.01)

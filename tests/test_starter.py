"""The spec that `init` writes: checked, solved, and each key behind a # good when it is used."""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

import jsonschema
import numpy as np
import pytest
from pydantic import Field

from orthospec import registry
from orthospec.errors import UsageError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.quantities import Length
from orthospec.show.keys import keys_of
from orthospec.spec import load_spec, schema
from orthospec.spec.model import LevelKeys, OptimiseKeys, ProofKeys, SpecKeys, SweepKeys, WorkspaceKeys
from orthospec.spec.strict_yaml import parse
from orthospec.starter import starting_spec, write_start

MACHINES = registry.names(registry.MANIPULATORS)


@pytest.fixture(scope="module")
def text_of() -> Mapping[str, str]:
    """The spec of each installed machine."""
    return {machine: starting_spec(machine, "orthospec.schema.json") for machine in MACHINES}


@pytest.mark.parametrize("machine", MACHINES)
def test_it_is_checked_and_solved_within_its_range(
    machine: str, text_of: Mapping[str, str], spec_of: Any
) -> None:
    spec = spec_of(text_of[machine], "workspace.divisions=4", "optimise.starts=1")
    space = DesignSpace(spec)
    best = hunt(space, Here()).best
    assert best is not None
    assert best.feasible
    ((name, variable),) = spec.variables.items()
    assert variable.min < space.values(best.end.design)[name] < variable.start


@pytest.mark.parametrize("machine", MACHINES)
def test_each_key_behind_a_sharp_can_be_used(machine: str, text_of: Mapping[str, str], spec_of: Any) -> None:
    behind = re.findall(r"^ *#\w+:", text_of[machine], re.MULTILINE)
    assert len(behind) >= 10
    spec = spec_of(re.sub(r"^( *)#(\w+:)", r"\1\2", text_of[machine], flags=re.MULTILINE))
    assert spec.pareto == 5
    assert spec.sweep.points == 5
    assert set(spec.variables) == {"base_radius" if machine == "rotary_delta" else "leg_length", "other"}


@pytest.mark.parametrize("machine", MACHINES)
def test_every_key_of_the_format_and_of_the_machine_is_in_it(
    machine: str, text_of: Mapping[str, str]
) -> None:
    words = set(re.findall(r"\w+", text_of[machine]))
    served = {"orientation", "tolerance"}  # these are kept for later versions
    for part in (SpecKeys, WorkspaceKeys, LevelKeys, SweepKeys, OptimiseKeys, ProofKeys):
        names = {field.alias or name for name, field in part.model_fields.items()}
        assert names - served <= words, part
    assert {key.path[0] for key in keys_of(registry.find_manipulator(machine)).keys} <= words
    assert set(MACHINES) | set(registry.names(registry.MEASURES)) <= words


@pytest.mark.parametrize("machine", MACHINES)
def test_it_fits_a_terminal_and_the_schema_that_its_first_line_names(
    machine: str, text_of: Mapping[str, str]
) -> None:
    lines = text_of[machine].splitlines()
    assert lines[0] == "# yaml-language-server: $schema=orthospec.schema.json"
    assert max(map(len, lines)) < 80
    jsonschema.Draft202012Validator(schema()).validate(parse(text_of[machine], "spec.yaml").data)


def test_it_is_written_with_its_schema_and_replaces_no_spec(tmp_path: Path) -> None:
    spec, beside = write_start(str(tmp_path / "mine"), "orthoglide")
    assert spec == tmp_path / "mine.yaml"
    assert load_spec(spec).manipulator.use == "orthoglide"
    assert json.loads(beside.read_text()) == schema()
    spec.write_text("kept")
    with pytest.raises(UsageError, match=r"mine\.yaml is there already"):
        write_start(str(tmp_path / "mine.yaml"), "orthoglide")
    assert spec.read_text() == "kept"


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file or directory"):
        write_start(str(tmp_path / "none" / "mine"), "orthoglide")


class _Unknown(Orthoglide):
    """A machine with a key that has no example."""

    reserve: Length
    """Length in hand [m]."""


class _Inches(Orthoglide):
    """A machine given in inches."""

    reserve: Annotated[Length, Field(examples=["1 in"])]
    """Length in hand [m]."""
    leg_lengths: Annotated[tuple[Length, Length, Length], Field(examples=[["20 in"] * 3])]


class _Wrong(_Inches):
    """A machine whose example is no length."""

    leg_lengths: Annotated[tuple[Length, Length, Length], Field(examples=[("20 kg",) * 3])]


class _Nowhere(_Inches):
    """A machine that reaches no pose."""

    axes: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def inverse_kinematics(self, poses: Any) -> Any:
        return np.full((len(poses), 3), np.nan), np.zeros(len(poses), dtype=bool)


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A class in the orthoglide's place."""

    def put(made_of: type) -> None:
        monkeypatch.setattr(registry, "find_manipulator", lambda _: made_of)

    return put


def test_a_key_without_an_example_is_named(install: Any) -> None:
    install(_Unknown)
    with pytest.raises(UsageError, match="orthoglide gives no example of reserve"):
        starting_spec("orthoglide", None)


def test_lengths_stay_in_the_unit_of_the_example(install: Any, spec_of: Any) -> None:
    """All lengths grow with the legs: 20 inches are 508 mm, and the cube is a round number of inches."""
    install(_Inches)
    text = starting_spec("orthoglide", None)
    assert "leg_length: {min: 10 in, max: 40 in, start: 20 in}" in text
    assert "reserve: 1 in" in text
    (edge, *_) = spec_of(text).workspace.size
    assert 0.3 < edge / 0.508 < 0.45
    assert edge / 0.0254 == pytest.approx(round(edge / 0.0254))


@pytest.mark.parametrize(
    ("made_of", "said"), [(_Nowhere, "there is no cuboid"), (_Wrong, "leg_lengths: 20 kg is a mass")]
)
def test_examples_that_make_no_machine_are_told(install: Any, made_of: type, said: str) -> None:
    install(made_of)
    with pytest.raises(UsageError, match=f"^orthoglide: .*{said}"):
        starting_spec("orthoglide", None)


def test_a_planar_machine_gets_a_square_that_it_can_have_and_a_region(
    install: Any, tmp_path: Path, spec_of: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The manual's has κ <= k in a square of side L (k − 1) / sqrt(1 + k²), and its slides have no end."""
    page = (Path(__file__).parents[1] / "docs" / "plugins.md").read_text(encoding="utf-8")
    source = page.split("<!-- module: biglide -->\n```python\n")[1].split("\n```")[0]
    (tmp_path / "planar_of_the_manual.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    install(importlib.import_module("planar_of_the_manual").Biglide)
    text = starting_spec("orthoglide", None)
    spec = spec_of(text)
    assert spec.workspace.region is not None
    (bound,) = spec.measures
    side = 0.4 * (bound.bounds["at_most"] - 1) / np.sqrt(1 + bound.bounds["at_most"] ** 2)
    assert spec.workspace.size[0] == spec.workspace.size[1] < side
    assert spec.workspace.size[0] > 0.6 * side

"""The JSON Schema: valid, current, and of one mind with `load_spec` about the form of a spec."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from orthospec.quantities.units import parse_unit
from orthospec.spec import schema
from orthospec.spec.strict_yaml import parse

WORDS = """
$schema $defs $ref type title description default properties additionalProperties required items prefixItems
minItems maxItems minimum maximum exclusiveMinimum exclusiveMaximum anyOf allOf oneOf enum const examples
if then enumDescriptions
"""
"""Those in use here of the keywords in src/languageservice/jsonSchema.ts of redhat-developer's
yaml-language-server, which VS Code's YAML extension runs; ``prefixItems`` is checked from its
Draft2020Validator on, and passed over before."""
NOTED = frozenset({"x-unit"})
"""What others pass over."""
SPECS = sorted((Path(__file__).parent.parent / "specs").glob("*.yaml"))
SPEC = """\
orthospec: 1
title: a spec with most keys
variables:
  base: {min: 1.0, max: 3000 mm, start: 2.0}
manipulator:
  use: orthoglide
  leg_lengths: [base, "max(base, 1)", 1500 mm]
  joint_limits: {min: 0.1, max: [1, 2, 4 * base]}
  branch: [1, 1, -1]
  legs: {kind: PRPaR, section: {round: {diameter: 20 mm, wall: base / 500}}, material: steel, spacing: 80 mm}
  feet: {length: 60 mm, section: rigid, material: {E: 70 GPa, nu: 0.33}, mass: 0}
  actuators: {force: 500 N, stiffness: 20 N/um}
  platform: {mass: 2}
  gravity: [0, 0, -9.81 m/s^2]
workspace: {size: [1, 1, 0.8], region: {min: [-1, -1, -1], max: [1, 1, 1 m]}, together: false}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.5, 1.8]}}
goals:
  base: {minimise: worst(transmission), goal: 1.3, weight: relative}
poses: {Q0: [0, 0, 0]}
sweep: {variable: base, from: 1, to: 3}
optimise: {starts: 3, seed: 7}
pareto: {points: 5}
proof: {slack: 1e-4, boxes: 1000}
"""


@pytest.fixture(scope="module")
def validator() -> Any:
    made = schema()
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


def content(text: str) -> Any:
    return parse(text, "spec.yaml").data


def test_a_full_spec_is_accepted(validator: Any) -> None:
    assert list(validator.iter_errors(content(SPEC))) == []


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_the_shipped_specs_are_accepted(validator: Any, path: Path) -> None:
    assert list(validator.iter_errors(content(path.read_text(encoding="utf-8")))) == []


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("title:", "titel:", []),
        ("joint_limits: {min", "joint_limits: {minimum", ["manipulator", "joint_limits"]),
        ("kind: PRPaR", "kind: RRR", ["manipulator", "legs"]),
        ("{round: {diameter: 20 mm", "{circle: {diameter: 20 mm", ["manipulator", "legs"]),
        ("material: steel", "material: cheese", ["manipulator", "legs"]),
        ("section: rigid", "section: stiff", ["manipulator", "feet"]),
        ("force: 500 N", "thrust: 500 N", ["manipulator", "actuators"]),
        ("platform: {mass: 2}", "platform: 2", ["manipulator", "platform"]),
        ("use: orthoglide", "use: hexaglide", ["manipulator", "use"]),
        ("  leg_lengths", "  leg_length", ["manipulator"]),
        (", 1500 mm]", "]", ["manipulator", "leg_lengths"]),
        ("use: velocity_transmission", "use: condition_number", ["measures", "transmission"]),
        ("at_most: 2,", "at_most: 2, stiffness: 1,", ["measures", "transmission"]),
        ("together: false", "together: no way", ["workspace", "together"]),
        ("seed: 7", "seed: -7", ["optimise", "seed"]),
        ("minimise: worst(transmission)", "maximise: base, minimise: base", ["goals", "base"]),
        ("orthospec: 1", "orthospec: 2", ["orthospec"]),
    ],
)
def test_a_wrong_form_is_refused_where_it_stands(
    validator: Any, old: str, new: str, where: list[str]
) -> None:
    errors = list(validator.iter_errors(content(SPEC.replace(old, new))))
    assert where in [list(error.absolute_path) for error in errors]


def test_editors_know_every_keyword_of_it(validator: Any) -> None:
    schemas = list(_schemas(validator.schema))
    assert len(schemas) > 500
    assert {word for one in schemas for word in one} - {*WORDS.split()} - NOTED == set()
    references = {one["$ref"] for one in schemas if "$ref" in one}
    assert references == {f"#/$defs/{name}" for name in validator.schema["$defs"]}


def test_editors_write_no_default_that_means_nothing_and_show_one_title(validator: Any) -> None:
    top, *others = _schemas(validator.schema)
    assert top["title"] == "orthospec spec, format 1"
    assert [one for one in others if "title" in one] == []
    assert [one for one in others if "null" in json.dumps(one.get("default", 0))] == []
    workspace = validator.schema["$defs"]["WorkspaceKeys"]["properties"]
    assert workspace["divisions"]["default"] == 20
    assert workspace["together"]["default"] is True


@pytest.mark.parametrize("section", ["ManipulatorKeys", "MeasureKeys"])
def test_each_name_is_told_in_a_line_and_bounds_in_their_unit(validator: Any, section: str) -> None:
    about = validator.schema["$defs"][section]
    told = dict(
        zip(about["properties"]["use"]["enum"], about["properties"]["use"]["enumDescriptions"], strict=True)
    )
    assert all(told.values())
    if section == "MeasureKeys":
        bounds = _named(about, "gie_norm")["properties"]
        assert bounds["at_most"]["description"].endswith("[kg].")
        assert bounds["at_least"] is False


def test_every_key_is_described_and_plugins_tell_their_units(validator: Any) -> None:
    definitions = validator.schema["$defs"]
    sections = {name: one for name, one in definitions.items() if "." not in name}
    assert {"WorkspaceKeys", "GoalKeys", "VariableKeys", "SweepKeys", "ProofKeys"} < sections.keys()
    for name, section in {"": validator.schema, **sections}.items():
        for key, about in section["properties"].items():
            assert about.get("description"), f"{name}.{key}"
    orthoglide = _named(definitions["ManipulatorKeys"], "orthoglide")
    assert orthoglide["properties"]["leg_lengths"]["prefixItems"][0]["x-unit"] == "m"
    assert "manipulators.orthoglide.JointLimits" in definitions


@pytest.mark.parametrize("section", ["ManipulatorKeys", "MeasureKeys"])
def test_plugins_keys_are_described_at_any_depth_and_their_numbers_have_units(
    validator: Any, section: str
) -> None:
    definitions = validator.schema["$defs"]
    for branch in definitions[section]["allOf"]:
        own = dict(_keys(branch["then"], definitions))
        assert own or section == "MeasureKeys"
        assert [key for key, about in own.items() if not about.get("description")] == []
        numbers = [key for key, about in own.items() if "'number'" in str(about)]
        assert [key for key in numbers if "x-unit" not in str(own[key])] == []


def test_quantities_are_shown_by_examples_that_can_be_written(validator: Any) -> None:
    texts = set(re.findall(r"a quantity like '(.*?)'", json.dumps(validator.schema)))
    assert {"10 mm", "1 N/m", "50 %"} <= texts
    for text in texts:
        number, unit = text.split()
        assert unit != "1"
        assert parse_unit(unit).to_si(number) > 0


def _schemas(schema: Any) -> Iterator[dict[str, Any]]:
    """A schema and all that stand in it."""
    if isinstance(schema, list):
        for inner in schema:
            yield from _schemas(inner)
    elif isinstance(schema, dict):
        yield schema
        for word, inner in schema.items():
            if word in ("properties", "$defs"):
                yield from _schemas(list(inner.values()))
            elif word not in ("default", "const", "enum", "examples", "required"):
                yield from _schemas(inner)


def _named(section: Any, name: str) -> Any:
    """What the schema asks of a section with this `use`."""
    return next(one["then"] for one in section["allOf"] if one["if"]["properties"]["use"]["const"] == name)


def _keys(schema: Any, definitions: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Each key of a plugin's own with its schema, those of parts under dotted names."""
    if "$ref" in schema:
        yield from _keys(definitions[schema["$ref"].removeprefix("#/$defs/")], definitions, path)
    for key, about in schema.get("properties", {}).items():
        if isinstance(about, dict) and key not in ("at_least", "at_most"):
            yield path + key, about
            yield from _keys(about, definitions, f"{path}{key}.")
    for inner in schema.get("anyOf", []):
        yield from _keys(inner, definitions, path)

"""What a result's names mean: units, bounds and goals, from the spec that stands beside it.

A result is readable without its spec or plugins too; then numbers have no units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from orthospec.errors import OrthospecError
from orthospec.quantities.fields import is_quantity
from orthospec.quantities.units import parse_unit
from orthospec.show.numbers import UNKNOWN

if TYPE_CHECKING:
    from pydantic import BaseModel

    from orthospec.spec import Design, Goal, Spec, Variable

_LENGTH_AXES = frozenset({"x", "y", "z"})


@dataclass(frozen=True)
class Asked:
    """A measure as the spec asks for it."""

    use: str
    unit: str
    bounds: Mapping[str, float]


@dataclass(frozen=True)
class Aim:
    """A goal in words, "minimise leg", and its unit."""

    words: str
    unit: str


@dataclass(frozen=True)
class Labels:
    """Units by name; empty where nothing is known."""

    axes: tuple[str, ...] = ("m", "m", "m")
    """Units of a pose's coordinates."""
    joints: tuple[str, ...] = ()
    size: tuple[float, ...] = ()
    fields: Mapping[str, str] = field(default_factory=dict)
    """Of the manipulator's fields."""
    indices: Mapping[str, str] = field(default_factory=dict)
    variables: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, Variable] = field(default_factory=dict)
    measures: Mapping[str, Asked] = field(default_factory=dict)
    goals: Mapping[str, Aim] = field(default_factory=dict)


def labels(spec: Spec | None, variables: Mapping[str, float]) -> Labels:
    """What is known of the names in a result whose variables have these values."""
    if spec is None:
        return Labels()
    try:
        design = spec.design(variables)
    except OrthospecError:
        return Labels()
    uses = {plan.name: plan.blueprint.use for plan in spec.measures}
    known = Labels(
        axes=tuple("m" if axis in _LENGTH_AXES else "rad" for axis in design.manipulator.axes),
        joints=design.manipulator.joint_units,
        size=spec.workspace.size,
        fields=field_units(type(design.manipulator)),
        indices=design.manipulator.index_units,
        ranges=spec.variables,
        measures={one.name: Asked(uses[one.name], one.measure.unit, one.bounds) for one in design.demands},
    )
    units = {name: _unit_of_variable(spec, name, known.fields) for name in spec.variables}
    aims = {goal.name: _aim(goal, design, {**known.indices, **units}) for goal in design.goals}
    return Labels(**{**vars(known), "variables": units, "goals": aims})


def field_units(model: type[BaseModel]) -> dict[str, str]:
    """The unit of each field whose numbers all have the same one."""
    schema = model.model_json_schema()
    found = {}
    for name, inner in schema.get("properties", {}).items():
        units = set(units_in(inner, schema.get("$defs", {})))
        if len(units) == 1:
            found[name] = units.pop()
    return found


def units_in(schema: Any, definitions: Mapping[str, Any]) -> Iterator[str]:
    """The units that stand somewhere in a part of a class's JSON schema."""
    if isinstance(schema, dict):
        if "$ref" in schema:
            yield from units_in(definitions.get(schema["$ref"].rpartition("/")[2]), definitions)
        elif "x-unit" in schema:
            yield schema["x-unit"]
        else:
            schema = list(schema.values())
    if isinstance(schema, list):
        for inner in schema:
            yield from units_in(inner, definitions)


def _unit_of_variable(spec: Spec, name: str, fields: Mapping[str, str]) -> str:
    """The unit that its range is given in, else that of the manipulator's fields where it stands alone."""
    given = spec.document.data["variables"][name]
    for value in given.values():
        if isinstance(value, str) and is_quantity(value):
            return _si(value.split()[-1])
    stands_in = {
        fields.get(key, UNKNOWN) for key, value in spec.manipulator.keys.items() if _has(value, name)
    }
    return stands_in.pop() if len(stands_in) == 1 else UNKNOWN


def _si(unit: str) -> str:
    """The SI unit of the same kind, where it is one that engineers write."""
    dimension = parse_unit(unit).dimension
    usual = ("1", "m", "rad", "kg", "s", "N", "N*m", "N/m", "m/s", "m/s^2", "Pa", "m^2")
    return next((one for one in usual if parse_unit(one).dimension == dimension), UNKNOWN)


def _has(value: Any, name: str) -> bool:
    """Whether a bare name stands somewhere in a field's value."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list):
        return any(_has(inner, name) for inner in value)
    return isinstance(value, str) and value.strip() == name


def _aim(goal: Goal, design: Design, units: Mapping[str, str]) -> Aim:
    text = goal.expression.text
    unit = "1" if text == "scale" else units.get(text, UNKNOWN)
    for kind, name in goal.expression.extremes:
        if text == f"{kind}({name})":
            unit = next(one.measure.unit for one in design.demands if one.name == name)
    return Aim(f"{goal.sense} {text}", unit)

"""What a result's names mean: units, bounds and goals, from the spec that stands beside it.

A number is told in the unit that the spec gives it in, where it gives one. A result is readable without its
spec or plugins too; then numbers have no units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from orthospec.errors import OrthospecError
from orthospec.quantities.fields import is_quantity
from orthospec.quantities.units import UnitError, parse_unit
from orthospec.show.keys import Path, keys_of
from orthospec.show.numbers import UNKNOWN

if TYPE_CHECKING:
    from pydantic import BaseModel

    from orthospec.measures import Demand
    from orthospec.spec import Goal, Spec, Variable

_LENGTH_AXES = frozenset({"x", "y", "z"})


@dataclass(frozen=True)
class Field:
    """A key of a machine or measure, as it was asked for."""

    units: tuple[str, ...] = ()
    """One for all of its numbers, or one for each."""
    default: Any = None
    word: str = ""
    """What the spec has in place of the keys of a part: a material's name."""


@dataclass(frozen=True)
class Asked:
    """A measure as the spec asks for it."""

    use: str
    unit: str
    bounds: Mapping[str, float]
    keys: Mapping[str, Any]
    """Its own ones, resolved."""
    fields: Mapping[Path, Field]


@dataclass(frozen=True)
class Aim:
    """A goal in words, "minimise leg", its unit, and whether its weight is its own magnitude."""

    words: str
    unit: str
    relative: bool


@dataclass(frozen=True)
class Labels:
    """Units by name; empty where nothing is known."""

    axes: tuple[str, ...] = ("m", "m", "m")
    """Units of a pose's coordinates."""
    joints: tuple[str, ...] = ()
    size: tuple[float, ...] = ()
    fields: Mapping[Path, Field] = field(default_factory=dict)
    """Of the manipulator."""
    tolerances: Mapping[str, float] = field(default_factory=dict)
    """Of its fields."""
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
    given = {name: _units_given(spec.document.data["variables"][name]) for name in spec.variables}
    written = {name: unit for name, units in given.items() if (unit := next(units, None)) is not None}
    known = Labels(
        axes=tuple("m" if axis in _LENGTH_AXES else "rad" for axis in design.manipulator.axes),
        joints=design.manipulator.joint_units,
        size=spec.workspace.size,
        fields=fields_of(type(design.manipulator), spec.manipulator.keys, written),
        tolerances=spec.tolerances,
        indices=design.manipulator.index_units,
        ranges=spec.variables,
        measures={one.name: _asked(spec, one, written) for one in design.demands},
    )
    units = {name: written.get(name) or _unit_where_it_stands(spec, name, known.fields) for name in given}
    aims = {goal.name: _aim(spec, goal, known.measures, {**known.indices, **units}) for goal in design.goals}
    aimed_at = {goal.expression.text: aims[goal.name].unit for goal in design.goals}
    indices = {name: aimed_at.get(name, unit) for name, unit in known.indices.items()}
    return Labels(**{**vars(known), "indices": indices, "variables": units, "goals": aims})


def fields_of(
    made_of: type[BaseModel], written: Any, variables: Mapping[str, str] | None = None
) -> dict[Path, Field]:
    """The keys of a class at any depth, in the units that ``written`` gives them in.

    A bare name stands for the unit that its variable is written in.
    """
    return {
        key.path: Field(
            units=_as_written(key.units, _at(written, key.path), variables=variables or {}),
            default=key.default,
            word=_word(_at(written, key.path)) if key.part is not None else "",
        )
        for key in keys_of(made_of).every()
    }


def _at(written: Any, path: Path) -> Any:
    for name in path:
        written = written.get(name) if isinstance(written, Mapping) else None
    return written


def _word(written: Any) -> str:
    return written if isinstance(written, str) else ""


def _as_written(
    units: tuple[str, ...], *written: Any, variables: Mapping[str, str] = MappingProxyType({})
) -> tuple[str, ...]:
    """The first unit of the same kind that is written, for a field whose numbers have one unit."""
    if len(units) != 1:
        return units
    for name in (name for one in written for name in _units_given(one, variables)):
        try:
            if parse_unit(name).dimension == parse_unit(units[0]).dimension:
                return (name,)
        except UnitError:
            continue
    return units


def _units_given(written: Any, variables: Mapping[str, str] = MappingProxyType({})) -> Iterator[str]:
    if isinstance(written, Mapping):
        written = list(written.values())
    for one in written if isinstance(written, list) else [written]:
        if isinstance(one, list):
            yield from _units_given(one, variables)
        elif isinstance(one, str) and is_quantity(one):
            yield one.split()[-1]
        elif isinstance(one, str) and one.strip() in variables:
            yield variables[one.strip()]


def _asked(spec: Spec, demand: Demand, variables: Mapping[str, str]) -> Asked:
    written = spec.document.data["measures"][demand.name]
    bounds = [written.get(key) for key in ("at_least", "at_most", "levels")]
    own = next(plan.blueprint for plan in spec.measures if plan.name == demand.name)
    return Asked(
        use=own.use,
        unit=_as_written((demand.measure.unit,), *bounds, variables=variables)[0],
        bounds=demand.bounds,
        keys=demand.measure.model_dump(mode="json", by_alias=True, exclude_none=True),
        fields=fields_of(type(demand.measure), own.keys, variables),
    )


def _unit_where_it_stands(spec: Spec, name: str, fields: Mapping[Path, Field]) -> str:
    """The unit of the manipulator's fields that are this variable alone."""
    stands_in = {
        unit
        for path, one in fields.items()
        for unit in one.units
        if _has(_at(spec.manipulator.keys, path), name)
    }
    return stands_in.pop() if len(stands_in) == 1 else UNKNOWN


def _has(value: Any, name: str) -> bool:
    """Whether a bare name stands somewhere in a field's value."""
    if isinstance(value, list):
        return any(_has(inner, name) for inner in value)
    return isinstance(value, str) and value.strip() == name


def _aim(spec: Spec, goal: Goal, measures: Mapping[str, Asked], units: Mapping[str, str]) -> Aim:
    text = goal.expression.text
    unit = "1" if text == "scale" else units.get(text, UNKNOWN)
    for kind, name in goal.expression.extremes:
        if text == f"{kind}({name})":
            unit = measures[name].unit
    written = spec.document.data["goals"][goal.name]
    if unit == UNKNOWN:
        unit = next(_units_given(written["goal"]), UNKNOWN)
    else:
        (unit,) = _as_written((unit,), written["goal"])
    return Aim(f"{goal.sense} {text}", unit, written.get("weight") == "relative")

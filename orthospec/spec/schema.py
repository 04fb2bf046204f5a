"""JSON Schema of the spec file with the installed plugins' fields in it, for editors and other tools.

It knows names, types, units and defaults; what only `orthospec check` can tell (expressions over known names,
dimensions of quantities, bounds that fit together) is left to it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pydantic.errors import PydanticInvalidForJsonSchema

from orthospec import registry
from orthospec.errors import PluginFault, UsageError
from orthospec.spec.model import ManipulatorKeys, MeasureKeys, SpecKeys

if TYPE_CHECKING:
    from pydantic import BaseModel

    from orthospec.measures import Measure

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema() -> dict[str, Any]:
    """The schema (draft 2020-12); a plugin that cannot be loaded has its name in it and no fields."""
    top = SpecKeys.model_json_schema()
    definitions = top["$defs"]
    _add_plugins(definitions, registry.MANIPULATORS, registry.find_manipulator, ManipulatorKeys)
    _add_plugins(definitions, registry.MEASURES, registry.find_measure, MeasureKeys)
    definitions["ManipulatorKeys"]["oneOf"] = [{"required": ["use"]}, {"required": ["from"]}]
    return {"$schema": DIALECT, **top, "title": "orthospec spec, format 1"}


def _add_plugins(
    definitions: dict[str, Any], group: str, find: Callable[[str], type[BaseModel]], beside: type[BaseModel]
) -> None:
    keys = definitions[beside.__name__]
    names = registry.names(group)
    keys["properties"]["use"] = {
        "type": "string",
        "enum": list(names),
        "description": keys["properties"]["use"]["description"],
    }
    keys["allOf"] = []
    for name in names:
        try:
            made_of = find(name)
            then = _plugin(definitions, f"{group.removeprefix('orthospec.')}.{name}", made_of)
        except (PluginFault, UsageError, PydanticInvalidForJsonSchema):
            continue
        then["properties"] = dict.fromkeys(keys["properties"], True) | _bounds(made_of) | then["properties"]
        named = {"properties": {"use": {"const": name}}, "required": ["use"]}
        keys["allOf"].append({"if": named, "then": then})


def _plugin(definitions: dict[str, Any], prefix: str, made_of: type[BaseModel]) -> dict[str, Any]:
    """A plugin's own keys, closed; the classes inside go to the definitions under names of their own."""
    own = made_of.model_json_schema(ref_template=f"#/$defs/{prefix}.{{model}}")
    for name, inner in own.pop("$defs", {}).items():
        definitions[f"{prefix}.{name}"] = inner
    return {"additionalProperties": False, "properties": {}, **own}


def _bounds(made_of: type[BaseModel]) -> dict[str, Any]:
    """The sides that a measure knows, with its unit; a manipulator has none."""
    from orthospec.measures import Measure

    if not issubclass(made_of, Measure):
        return {}
    return {side: _bound(made_of, side) for side in ("at_least", "at_most")}


def _bound(made_of: type[Measure], side: str) -> Any:
    return {"x-unit": made_of.unit} if side in made_of.sides else False

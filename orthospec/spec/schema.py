"""JSON Schema of the spec file with the installed plugins' fields in it, for editors and other tools.

It knows names, types, units and defaults; what only `orthospec check` can tell (expressions over known names,
dimensions of quantities, bounds that fit together) is left to it. Units stand under ``x-unit``, and in the
descriptions, which editors show.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pydantic.errors import PydanticInvalidForJsonSchema

from orthospec import registry
from orthospec.described import description
from orthospec.errors import PluginFault, UsageError
from orthospec.spec.model import ManipulatorKeys, MeasureKeys, SpecKeys

if TYPE_CHECKING:
    from pydantic import BaseModel

    from orthospec.measures import Measure

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TITLE = "orthospec spec, format 1"
_NAMED = frozenset({"properties", "$defs"})
_DATA = frozenset({"default", "const", "enum", "examples", "required"})


def schema() -> dict[str, Any]:
    """The schema (draft 2020-12); a plugin that cannot be loaded has its name in it and no fields."""
    top = SpecKeys.model_json_schema()
    definitions = top["$defs"]
    _add_plugins(definitions, registry.MANIPULATORS, registry.find_manipulator, ManipulatorKeys)
    _add_plugins(definitions, registry.MEASURES, registry.find_measure, MeasureKeys)
    definitions["ManipulatorKeys"]["oneOf"] = [{"required": ["use"]}, {"required": ["from"]}]
    return {"$schema": DIALECT, **_tidy(top), "title": TITLE}


def _add_plugins(
    definitions: dict[str, Any], group: str, find: Callable[[str], type[BaseModel]], beside: type[BaseModel]
) -> None:
    keys = definitions[beside.__name__]
    names = registry.names(group)
    keys["properties"]["use"] = {
        "type": "string",
        "enum": list(names),
        "enumDescriptions": [""] * len(names),
        "description": keys["properties"]["use"]["description"],
    }
    keys["allOf"] = []
    for number, name in enumerate(names):
        try:
            made_of = find(name)
            then = _plugin(definitions, f"{group.removeprefix('orthospec.')}.{name}", made_of)
        except (PluginFault, UsageError, PydanticInvalidForJsonSchema):
            continue
        then["properties"] = dict.fromkeys(keys["properties"], True) | _bounds(made_of) | then["properties"]
        named = {"properties": {"use": {"const": name}}, "required": ["use"]}
        keys["allOf"].append({"if": named, "then": then})
        keys["properties"]["use"]["enumDescriptions"][number] = _first_lines(made_of)


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
    if side not in made_of.sides:
        return False
    told = str(description(MeasureKeys, side))
    unit = "" if made_of.unit == "1" else f" [{made_of.unit}]"
    return {"description": told.replace(", in the measure's unit", unit), "x-unit": made_of.unit}


def _first_lines(made_of: type[BaseModel]) -> str:
    """The first paragraph of a class's docstring, for a list of choices."""
    return " ".join(inspect.cleandoc(made_of.__doc__ or "").partition("\n\n")[0].replace("`", "").split())


def _tidy(schema: Any) -> Any:
    """Without what an editor would only be led astray by.

    A title is shown in place of the schema's own, and a default is written into the file: a key that is left
    out would come as null.
    """
    if isinstance(schema, list):
        return [_tidy(inner) for inner in schema]
    if not isinstance(schema, Mapping):
        return schema
    tidy = {}
    for word, inner in schema.items():
        if word == "title" or (word == "default" and _is_nothing(inner)):
            continue
        if word in _NAMED:
            tidy[word] = {name: _tidy(one) for name, one in inner.items()}
        else:
            tidy[word] = inner if word in _DATA else _tidy(inner)
    return tidy


def _is_nothing(default: Any) -> bool:
    if isinstance(default, Mapping):
        return all(map(_is_nothing, default.values()))
    return default is None

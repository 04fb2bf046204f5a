"""The keys of a plugin's class, its parts' keys included: units, defaults and meanings, from its JSON schema.

A part is a key that takes keys itself; it may stand behind a union, and a word may stand in its place
(``feet: rigid``, ``material: steel``).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from pydantic import BaseModel

Path: TypeAlias = tuple[str, ...]
"""Names from the class down to the key."""


@dataclass(frozen=True)
class Key:
    """One key that a plugin's section of the spec may have."""

    path: Path
    units: tuple[str, ...]
    """One for all of its numbers, or one for each; none where there are no numbers, or where it is a part."""
    required: bool
    default: Any
    meaning: str
    words: tuple[str, ...]
    """What may be written in place of numbers or of a part's keys."""
    part: Part | None


@dataclass(frozen=True)
class Part:
    """Keys that belong together: those of a class, or of a key that takes keys."""

    meaning: str
    keys: tuple[Key, ...]
    text: str
    """Its schema: equal for the same part in two places."""

    def every(self) -> Iterator[Key]:
        """Its keys and those of the parts inside, depth first."""
        for key in self.keys:
            yield key
            if key.part is not None:
                yield from key.part.every()


def keys_of(made_of: type[BaseModel]) -> Part:
    """The keys of a class; where it contains itself they are told once."""
    schema = made_of.model_json_schema()
    definitions = schema.get("$defs", {})
    return _part(list(_leaves(schema, definitions)), definitions, ())


def _part(
    schemas: list[Mapping[str, Any]], definitions: Mapping[str, Any], path: Path, within: tuple[str, ...] = ()
) -> Part:
    text = _text(schemas)
    keys = [
        _key(inner, definitions, (*path, name), name in schema.get("required", ()), (*within, text))
        for schema in schemas
        for name, inner in schema.get("properties", {}).items()
    ]
    return Part(_told(schemas[0]), tuple(keys), text)


def _text(schemas: list[Mapping[str, Any]]) -> str:
    return json.dumps([schema.get("properties") for schema in schemas], sort_keys=True)


def _key(
    schema: Mapping[str, Any],
    definitions: Mapping[str, Any],
    path: Path,
    required: bool,
    within: tuple[str, ...],
) -> Key:
    leaves = list(_leaves(schema, definitions))
    parts = [leaf for leaf in leaves if "properties" in leaf]
    closed = _text(parts) in within
    return Key(
        path=path,
        units=() if parts else _units(leaves, definitions),
        required=required,
        default=schema.get("default"),
        meaning=_told(schema),
        words=tuple(dict.fromkeys(word for leaf in leaves for word in _words(leaf))),
        part=_part(parts, definitions, path, within) if parts and not closed else None,
    )


def _leaves(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """What may stand in a place, unions and references taken apart; a quantity is one leaf."""
    if "x-unit" in schema:
        yield schema
    elif "$ref" in schema:
        yield from _leaves(definitions.get(schema["$ref"].rpartition("/")[2], {}), definitions)
    elif "anyOf" in schema:
        for inner in schema["anyOf"]:
            yield from _leaves(inner, definitions)
    else:
        yield schema


def _units(leaves: list[Mapping[str, Any]], definitions: Mapping[str, Any]) -> tuple[str, ...]:
    every = list(_units_in(leaves, definitions))
    if len(set(every)) <= 1:
        return tuple(every[:1])
    rows = [leaf["prefixItems"] for leaf in leaves if "prefixItems" in leaf]
    return tuple(_units_in(rows[0], definitions)) if rows else tuple(dict.fromkeys(every))


def _units_in(
    schema: Any, definitions: Mapping[str, Any], seen: frozenset[str] = frozenset()
) -> Iterator[str]:
    """The units that stand somewhere in a part of a class's JSON schema."""
    if isinstance(schema, Mapping):
        name = schema.get("$ref", "").rpartition("/")[2]
        if "x-unit" in schema:
            yield schema["x-unit"]
        elif name and name not in seen:
            yield from _units_in(definitions.get(name), definitions, seen | {name})
        elif not name:
            schema = list(schema.values())
    if isinstance(schema, list):
        for inner in schema:
            yield from _units_in(inner, definitions, seen)


def _words(leaf: Mapping[str, Any]) -> list[str]:
    said = leaf.get("enum", [leaf["const"]] if "const" in leaf else [])
    return [word for word in said if isinstance(word, str)]


def _told(schema: Mapping[str, Any]) -> str:
    return " ".join(schema.get("description", "").replace("`", "").split())

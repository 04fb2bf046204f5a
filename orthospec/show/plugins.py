"""What is installed, and what one manipulator or measure is: formula, unit, keys, where it comes from."""

from __future__ import annotations

import difflib
import inspect
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from orthospec import registry
from orthospec.errors import OrthospecError, UsageError
from orthospec.show.labels import units_in
from orthospec.show.page import Page

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Measure

KINDS = {registry.MANIPULATORS: "manipulator", registry.MEASURES: "measure"}
NO_VALUE: tuple[Any, ...] = (None, {}, [])


class Key(NamedTuple):
    """One key that a plugin's part of the spec may have."""

    name: str
    unit: str
    default: str
    meaning: str


def installed() -> list[dict[str, str]]:
    """Each installed name with its kind and distribution, and what is wrong with it if it cannot be used."""
    found = []
    for one in registry.installed():
        entry = {
            "name": one.name,
            "kind": KINDS[one.group],
            "distribution": one.distribution,
            "version": one.version,
        }
        try:
            _load(one.group, one.name)
        except OrthospecError as error:
            entry["fault"] = str(error)
        found.append(entry)
    return found


def show_installed(entries: list[dict[str, str]], *, width: int, colour: bool) -> str:
    """The text of `installed`."""
    page = Page(width=width, colour=colour)
    for kind in KINDS.values():
        mine = [one for one in entries if one["kind"] == kind]
        if not mine:
            continue
        page.heading(f"{kind.capitalize()}s")
        page.rows([(one["name"], f"{one['distribution']} {one['version']}") for one in mine])
        for one in mine:
            if "fault" in one:
                page.sentence(one["fault"], indent=4, manner="bad")
    return str(page)


def explain(name: str, *, width: int, colour: bool) -> str:
    """What is known of one name; `UsageError`, with all names, for one that is not installed."""
    groups = [group for group in KINDS if name in registry.names(group)]
    if not groups:
        raise UsageError(_unknown(name))
    page = Page(width=width, colour=colour)
    for group in groups:
        owner = registry.distribution_of(group, name)
        made_of = _load(group, name)
        page.heading(name)
        page.sentence(f"{KINDS[group]} of {owner.distribution} {owner.version}", manner="dim")
        _documentation(page, made_of)
        _facts(page, made_of)
        page.heading("Keys")
        keys = list(keys_of(made_of.model_json_schema()))
        page.rows([(key.name, key.unit, key.default, key.meaning) for key in keys] or [("none of its own",)])
    return str(page)


def keys_of(
    schema: Mapping[str, Any], prefix: str = "", top: Mapping[str, Any] | None = None
) -> Iterator[Key]:
    """The keys in a class's JSON schema, those of parts under dotted names."""
    definitions = (top or schema).get("$defs", {})
    for name, inner in schema.get("properties", {}).items():
        part = definitions.get(inner.get("$ref", "").rpartition("/")[2], {})
        if "properties" in part:
            yield from keys_of(part, f"{prefix}{name}.", top or schema)
            continue
        units = sorted(set(units_in(inner, definitions)))
        default = inner.get("default")
        given = "required" if name in schema.get("required", ()) else "optional"
        if default not in NO_VALUE:
            given = json.dumps(default)
        yield Key(prefix + name, ", ".join(units), given, " ".join(inner.get("description", "").split()))


def _load(group: str, name: str) -> type[Manipulator] | type[Measure]:
    return registry.find_measure(name) if group == registry.MEASURES else registry.find_manipulator(name)


def _documentation(page: Page, made_of: type) -> None:
    """The class's docstring: paragraphs wrapped, indented lines kept as they are."""
    text = inspect.cleandoc(made_of.__doc__ or "It has no description.").replace("`", "")
    for paragraph in text.split("\n\n"):
        page.gap()
        if paragraph.startswith(" "):
            page.rows([(line.rstrip(),) for line in paragraph.splitlines()])
        else:
            page.sentence(paragraph)


def _facts(page: Page, made_of: type[Manipulator] | type[Measure]) -> None:
    from orthospec.measures import Measure

    rows: list[tuple[str, str]]
    if issubclass(made_of, Measure):
        rows = [("unit", made_of.unit), ("bounds", " and ".join(sorted(made_of.sides)))]
        rows += [("needs", " and ".join(sorted(made_of.needs)))] if made_of.needs else []
    else:
        indices = ", ".join(f"{name} [{unit}]" for name, unit in made_of.index_units.items())
        rows = [
            ("pose", ", ".join(made_of.axes)),
            ("joints", ", ".join(f"{k} [{unit}]" for k, unit in enumerate(made_of.joint_units, start=1))),
            ("indices", indices or "none"),
        ]
    page.gap()
    page.rows(rows)


def _unknown(name: str) -> str:
    every = sorted({known for group in KINDS for known in registry.names(group)})
    close = [known for known in every if name in known] or difflib.get_close_matches(name, every, n=1)
    meant = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown manipulator or measure '{name}'; {meant}installed: {', '.join(every) or 'none'}"

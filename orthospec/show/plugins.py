"""What is installed, and what one manipulator or measure is: formula, unit, keys, where it comes from."""

from __future__ import annotations

import difflib
import inspect
from typing import TYPE_CHECKING, Any

from orthospec import registry
from orthospec.errors import OrthospecError, UsageError
from orthospec.show.keys import Key, Part, keys_of
from orthospec.show.page import Page

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Measure

KINDS = {registry.MANIPULATORS: "manipulator", registry.MEASURES: "measure"}


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


def explained(name: str) -> list[dict[str, Any]]:
    """What is known of one name as plain data, one entry for each group that has it."""
    from orthospec.measures import Measure

    found = []
    for group in _groups(name):
        owner, made_of = registry.distribution_of(group, name), _load(group, name)
        facts: dict[str, Any]
        if issubclass(made_of, Measure):
            facts = {"unit": made_of.unit, "sides": sorted(made_of.sides), "needs": sorted(made_of.needs)}
        else:
            facts = {
                "axes": list(made_of.axes),
                "joint_units": list(made_of.joint_units),
                "index_units": dict(made_of.index_units),
            }
        keys = [
            {
                "name": ".".join(key.path),
                "units": list(key.units),
                "required": key.required,
                "default": key.default,
                "meaning": key.meaning,
            }
            for key in keys_of(made_of).every()
        ]
        found.append(
            {
                "name": name,
                "kind": KINDS[group],
                "distribution": owner.distribution,
                "version": owner.version,
                "description": inspect.cleandoc(made_of.__doc__ or ""),
                **facts,
                "keys": keys,
            }
        )
    return found


def _groups(name: str) -> list[str]:
    groups = [group for group in KINDS if name in registry.names(group)]
    if not groups:
        raise UsageError(_unknown(name))
    return groups


def explain(name: str, *, width: int, colour: bool) -> str:
    """What is known of one name; `UsageError`, with all names, for one that is not installed."""
    groups = _groups(name)
    page = Page(width=width, colour=colour)
    for group in groups:
        owner = registry.distribution_of(group, name)
        made_of = _load(group, name)
        page.heading(name)
        page.sentence(f"{KINDS[group]} of {owner.distribution} {owner.version}", manner="dim")
        _documentation(page, made_of)
        _facts(page, made_of)
        _keys(page, keys_of(made_of))
    return str(page)


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
        rows += [("needs", f"{' and '.join(sorted(made_of.needs))} of the machine")] if made_of.needs else []
    else:
        indices = ", ".join(f"{name} [{unit}]" for name, unit in made_of.index_units.items())
        rows = [
            ("pose", ", ".join(made_of.axes)),
            ("joints", ", ".join(f"{k} [{unit}]" for k, unit in enumerate(made_of.joint_units, start=1))),
            ("indices", indices or "none"),
        ]
    page.gap()
    page.rows(rows)


def _keys(page: Page, whole: Part) -> None:
    """The keys in a table, then those of each part in one of its own; a part in several places once."""
    page.heading("Keys")
    page.rows([_row(key) for key in whole.keys] or [("none of its own",)])
    parts: dict[str, list[Key]] = {}
    for key in whole.every():
        if key.part is not None:
            parts.setdefault(key.part.text, []).append(key)
    for keys in parts.values():
        part = keys[0].part
        assert part is not None
        page.heading(f"Keys of {', '.join('.'.join(key.path) for key in keys)}")
        page.sentence(part.meaning)
        page.rows([_row(key) for key in part.keys])


def _row(key: Key) -> tuple[str, str, str, str]:
    """Name, unit, what stands where it is left out, meaning; the unit is not told twice."""
    units = ", ".join(unit for unit in dict.fromkeys(key.units) if unit != "1")
    given = "required" if key.required else _default(key.default)
    meaning = key.meaning.replace(f" [{', '.join(dict.fromkeys(key.units))}]", "")
    if key.words:
        meaning = f"{meaning.rstrip('.')}; {_choice(key)}."
    return key.path[-1], units, given, meaning


def _choice(key: Key) -> str:
    """What may be written in place of a part's keys, or which words there are."""
    words = [f"'{word}'" for word in key.words]
    listed = " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))
    return f"in place of its keys {listed}" if key.part is not None else listed


def _default(default: Any) -> str:
    if default in (None, []) or isinstance(default, dict):
        return "optional"
    if isinstance(default, list):
        return " ".join(map(_default, default))
    return f"{default:g}" if isinstance(default, int | float) else str(default)


def _unknown(name: str) -> str:
    every = sorted({known for group in KINDS for known in registry.names(group)})
    close = [known for known in every if name in known] or difflib.get_close_matches(name, every, n=1)
    meant = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown manipulator or measure '{name}'; {meant}installed: {', '.join(every) or 'none'}"

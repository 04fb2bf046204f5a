"""``--set KEY=VALUE``: a spec changed from the command line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from orthospec.errors import Mistake, SpecError
from orthospec.spec.document import Document, Path
from orthospec.spec.strict_yaml import parse


def override(document: Document, settings: Iterable[str]) -> None:
    """Set each KEY=VALUE in the document; keys are dotted, list items count from 0, a value is YAML."""
    for setting in settings:
        label = f"--set {setting}"
        key, equals, text = setting.partition("=")
        if not equals or not all(key.split(".")):
            raise SpecError([Mistake(label, 0, 0, "write KEY=VALUE, like workspace.divisions=80")])
        _put(document, key.split("."), _value(text, label), label)


def _value(text: str, label: str) -> Any:
    if not text.strip():
        return None
    try:
        read = parse(text, label, empty="there is no value after the =")
    except SpecError as error:
        raise SpecError([Mistake(label, 0, 0, mistake.message) for mistake in error.mistakes]) from None
    if read.mistakes:
        raise SpecError([Mistake(label, 0, 0, mistake.message) for mistake in read.mistakes])
    return read.data


def _put(document: Document, keys: list[str], value: Any, label: str) -> None:
    """Put a value at dotted keys; mappings on the way that are not there yet are made."""
    here, path = document.data, Path()
    for at, key in enumerate(keys):
        step = _step(here, key)
        if step is None:
            raise SpecError([Mistake(label, 0, 0, f"there is no '{'.'.join(keys[: at + 1])}' in the spec")])
        path = (*path, step)
        if at == len(keys) - 1:
            here[step] = value
        elif isinstance(here, dict) and here.get(key) is None:
            here[step] = {}
            document.overridden[path] = label
        here = here[step]
    document.overridden[path] = label


def _step(here: Any, key: str) -> str | int | None:
    if isinstance(here, dict):
        return key
    if isinstance(here, list) and key.isdecimal() and int(key) < len(here):
        return int(key)
    return None

"""``--set KEY=VALUE``: a spec changed from the command line, and written out as it is then run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml

from orthospec.errors import Mistake, SpecError
from orthospec.spec.document import Document, Path
from orthospec.spec.strict_yaml import parse, scalar


def override(document: Document, settings: Iterable[str]) -> None:
    """Set each KEY=VALUE in the document; keys are dotted, list items count from 0, a value is YAML."""
    for setting in settings:
        label = f"--set {setting}"
        key, equals, text = setting.partition("=")
        if not equals or not all(key.split(".")):
            raise SpecError([Mistake(label, 0, 0, "write KEY=VALUE, like workspace.divisions=80")])
        _put(document, key.split("."), _value(text, label), label)


def dump(data: Any) -> str:
    """YAML that `parse` reads back as the same data, the same bytes for the same data."""
    return yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None
    )


def _value(text: str, label: str) -> Any:
    if not text.strip():
        return None
    try:
        read = parse(text, label)
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


class _Dumper(yaml.SafeDumper):
    """Quotes the strings that unquoted would be read as something else."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        """Write each part out, however often it is used."""
        return True


def _string(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = None if text.isprintable() and isinstance(scalar(text), str) else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _string)

"""A starting spec as a file, and beside it the schema by which editors complete and check it."""

from __future__ import annotations

import json
from pathlib import Path

from orthospec.errors import UsageError
from orthospec.spec import schema
from orthospec.starter.text import starting_spec

SCHEMA = "orthospec.schema.json"


def write_start(name: str, machine: str) -> tuple[Path, Path]:
    """Write NAME.yaml and the schema, which is made anew; their paths.

    Raises `UsageError` where there is such a spec already, or it cannot be written.
    """
    path = Path(name) if name.endswith((".yaml", ".yml")) else Path(f"{name}.yaml")
    if path.exists():
        raise UsageError(f"{path} is there already: give another name, or remove it first")
    text, beside = starting_spec(machine, SCHEMA), path.with_name(SCHEMA)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
        beside.write_text(json.dumps(schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{error.filename}: {(error.strerror or 'cannot be written').lower()}") from None
    return path, beside

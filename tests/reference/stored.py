"""Reference numbers as files: CASE.KIND.json holds a machine, and one line for each pose asked about."""

from __future__ import annotations

import importlib.metadata
import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from machines import MACHINES

FOLDER = Path(__file__).parent
EVERY = 40
"""With --check, the poses that are computed anew."""

Asked = Callable[[str], Mapping[str, np.ndarray]]
"""From a case to its columns: what is asked, a row for each pose."""
Answers = Callable[..., Mapping[str, np.ndarray]]
"""From a machine and a row of what is asked to the answers, by name."""


def run(kind: str, program: str, asked: Asked, answers: Answers, *, tolerance: float) -> None:
    """Write the files of one kind; with --check, compare a few poses with those that stand there."""
    check = sys.argv[1:] == ["--check"]
    for case, machine in MACHINES.items():
        given = asked(case)
        rows = list(zip(*given.values(), strict=True))[:: EVERY if check else 1]
        found = [answers(machine, *row) for row in rows]
        names = [*given, *found[0]]
        table = [
            [_rounded(x) for x in (*row, *answer.values())] for row, answer in zip(rows, found, strict=True)
        ]
        path = FOLDER / f"{case}.{kind}.json"
        if check:
            _compare(path, names, table, tolerance)
        else:
            version = {program: importlib.metadata.version(program)}
            _write(path, {"program": version, "machine": machine, "columns": names}, table)


def _write(path: Path, head: Mapping[str, Any], table: list[Any]) -> None:
    """The rows one a line, so that a change shows where it is."""
    rows = ",\n".join(json.dumps(row) for row in table)
    text = json.dumps(head, indent=1).removesuffix("\n}") + f',\n "rows": [\n{rows}\n]}}\n'
    path.write_text(text, encoding="utf-8")


def _compare(path: Path, names: list[str], table: list[Any], tolerance: float) -> None:
    stored = json.loads(path.read_text(encoding="utf-8"))
    if stored["columns"] != names:
        sys.exit(f"{path.name}: the columns are {stored['columns']}, not {names}")
    for i, name in enumerate(names):
        known = np.array([row[i] for row in stored["rows"][::EVERY]])
        new = np.array([row[i] for row in table])
        error = np.max(np.linalg.norm(new - known, axis=1) / np.linalg.norm(known, axis=1))
        print(f"{path.name}: {name} agrees to {error:.0e}")
        if not error <= tolerance:
            sys.exit(f"{path.name}: {name} differs by more than {tolerance:.0e}")


def _rounded(value: np.ndarray) -> list[float]:
    return [float(f"{x:.8e}") for x in np.ravel(value)]

"""What is compared: two specs or two results, read from their files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from orthospec.compare.contents import ORDERED, of_result, of_spec
from orthospec.compare.rows import Row, rows
from orthospec.errors import UsageError
from orthospec.result import Result, read_result, spec_of
from orthospec.spec import Spec, load_spec

Kind: TypeAlias = Literal["spec", "result"]

OF_RESULTS_ALONE = re.compile(rb"^status[ \t]*:", re.MULTILINE)
"""The key that a result has and a spec has not."""
_FLOOR = {"factor": 1e-9, "gain": 1e-9, "cost": 1e-9}
"""λ and what is a difference of two: near 0 a relative difference is rounding."""


@dataclass(frozen=True)
class Side:
    """One of the two."""

    name: str
    """As the user gave it."""
    kind: Kind
    content: Mapping[str, Any]
    spec: Spec | None
    """The spec itself, or that beside the result."""
    result: Result | None = None


@dataclass(frozen=True)
class Comparison:
    """Two sides of one kind, value by value."""

    a: Side
    b: Side
    rows: tuple[Row, ...]

    @property
    def changed(self) -> tuple[Row, ...]:
        """The rows that differ; none where the two mean the same."""
        return tuple(row for row in self.rows if row.state != "same")


def read_side(path: Path, *, stands_for: Path | None = None, name: str | None = None) -> Side:
    """A spec, a result folder or its ``result.yaml``.

    A copy without neighbours may say which file it ``stands_for``: what it names is looked for beside that.
    Raises `UsageError` where there is nothing to read, `SpecError` with all mistakes.
    """
    called, at = name or str(path), stands_for or path
    if path.is_dir() or _is_result(path):
        result = Result.model_validate(read_result(path))
        return Side(called, "result", of_result(result), spec_of(at), result)
    spec = load_spec(path, at=at)
    return Side(called, "spec", of_spec(spec), spec)


def _is_result(path: Path) -> bool:
    """Told by the file's bytes; what cannot be read is left to the reader of specs, which says so."""
    try:
        return path.is_file() and OF_RESULTS_ALONE.search(path.read_bytes()) is not None
    except OSError:
        return False


def compare(a: Side, b: Side) -> Comparison:
    """The rows of both; raises `UsageError` for a spec and a result."""
    if a.kind != b.kind:
        raise UsageError(
            f"{a.name} is a {a.kind} and {b.name} is a {b.kind}: two specs or two results were expected;"
            " a result folder has the spec that it came from in spec.yaml"
        )
    return Comparison(a, b, (*_reordered(a, b), *rows(a.content, b.content, floor=_FLOOR)))


def _reordered(a: Side, b: Side) -> list[Row]:
    """Sections of specs whose common entries stand in another order."""
    found = []
    for section in ORDERED if a.kind == "spec" else ():
        ours, theirs = (list(side.content.get(section, {})) for side in (a, b))
        before, after = [n for n in ours if n in theirs], [n for n in theirs if n in ours]
        if before != after:
            found.append(Row((section,), "changed", before, after))
    return found

"""Two nested contents as rows, one for each value: where it stands, what it is on either side, how far apart.

>>> [(row.what, row.state) for row in rows({"legs": [0.25, 0.3]}, {"legs": [0.25, 0.35]})]
[('legs.0', 'same'), ('legs.1', 'changed')]
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root."""
State: TypeAlias = Literal["same", "changed", "added", "removed"]

SAME = 1e-9
"""Numbers that differ by less, relative to the greater, are the same: processors agree no better."""


@dataclass(frozen=True)
class Row:
    """One value on either side; where a whole part is on one side only, that part. Numbers are in SI."""

    path: Path
    state: State
    a: Any
    b: Any

    @property
    def what(self) -> str:
        """The path as ``--set`` takes it: ``manipulator.leg_lengths.0``."""
        return ".".join(map(str, self.path))

    @property
    def difference(self) -> float | None:
        """B − A, exactly 0 where they are the same; None unless both are numbers."""
        if not (_is_number(self.a) and _is_number(self.b)):
            return None
        return 0.0 if self.state == "same" else float(self.b - self.a)

    @property
    def relative(self) -> float | None:
        """The difference as a part of |A|; None where that is 0."""
        return None if self.difference is None or self.a == 0 else self.difference / abs(self.a)


def rows(a: Any, b: Any, path: Path = (), floor: Mapping[str, float] | None = None) -> Iterator[Row]:
    """What stands in either, in the order of A and then of what B adds.

    Numbers are the same too where they differ by less than ``floor`` says for the last key of their path.
    """
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        yield from _entries(a, b, path, floor or {})
    elif _is_list(a) and _is_list(b):
        yield from _entries(dict(enumerate(a)), dict(enumerate(b)), path, floor or {})
    else:
        yield Row(path, "same" if _is_same(a, b, (floor or {}).get(_key(path), 0.0)) else "changed", a, b)


def _entries(
    a: Mapping[Any, Any], b: Mapping[Any, Any], path: Path, floor: Mapping[str, float]
) -> Iterator[Row]:
    for key in [*a, *(key for key in b if key not in a)]:
        here = (*path, key)
        if key not in b:
            yield Row(here, "removed", a[key], None)
        elif key not in a:
            yield Row(here, "added", None, b[key])
        else:
            yield from rows(a[key], b[key], here, floor)


def _key(path: Path) -> str:
    return str(path[-1]) if path else ""


def _is_same(a: Any, b: Any, floor: float) -> bool:
    if _is_number(a) and _is_number(b):
        return math.isclose(a, b, rel_tol=SAME, abs_tol=floor)
    return bool(a == b) and isinstance(a, bool) == isinstance(b, bool)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)

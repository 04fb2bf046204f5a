"""The sentences of a result: its status, its bounds, what limits it and at what price."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from orthospec.result import Result
from orthospec.result.model import DesignRecord, LimitRecord, SearchRecord
from orthospec.show.labels import Labels
from orthospec.show.numbers import NOTHING, UNKNOWN, Numbers, percent

SIDES = {"at_least": "at least", "at_most": "at most"}
_NODES = {"meets": "meet", "violates": "violate", "unreachable": "out of reach"}
_NO_CHANGE = 1e-9
"""Prices of λ below this are rounding."""


def status(result: Result) -> tuple[str, str]:
    """In which manner, and with which words, the status is told."""
    factor = result.attainment.factor if result.attainment else None
    with_factor = "" if factor is None else f" (λ = {factor:.6g})"
    evaluated = ("good", "every bound holds") if holds(result) else ("bad", "not every bound holds")
    found = result.search is not None and result.search.subproblems > 0
    so_far = "the best design found so far" if found else "the design that the search starts from"
    return {
        "attained": ("good", f"Attained: every bound holds and every goal is met{with_factor}."),
        "compromise": ("warn", f"Best compromise: every bound holds, not every goal is met{with_factor}."),
        "infeasible": ("bad", "No design was found in which every bound holds."),
        "evaluated": (evaluated[0], f"Evaluated: {evaluated[1]} in the prescribed cuboid."),
        "unfinished": ("warn", f"Stopped before the end; what follows is {so_far}."),
        "failed": ("bad", "A plugin failed; what follows is what could still be found."),
    }[result.status]


def searched(search: SearchRecord) -> str:
    """What was searched where no design was found."""
    designs = f"{search.designs} design{'' if search.designs == 1 else 's'}"
    solves = f"{search.starts} local solve{'' if search.starts == 1 else 's'}"
    if search.least_violation is None:
        return f"Searched: {designs} on a coarse grid, {solves}. What follows is the start."
    worst = percent(search.least_violation)
    return (
        f"Searched: {designs} on a coarse grid, {solves}. The best point found misses its bounds by {worst}; "
        "it is what follows."
    )


def holds(one: DesignRecord) -> bool:
    """Whether everything asked holds in the prescribed cuboid, or each measure's in its own."""
    workspace = one.workspace
    if workspace.joint is not None:
        return workspace.prescribed is not None and workspace.prescribed.holds
    bounded = [record for record in workspace.measures.values() if record.scale is not None]
    return all(record.prescribed is not None and record.prescribed.holds for record in bounded)


def bounds(numbers: Numbers, given: Mapping[str, float | None], unit: str) -> str:
    """``at least 0.5 and at most 2``."""
    return " and ".join(
        f"{words} {numbers.value(given[side], unit)}"
        for side, words in SIDES.items()
        if given.get(side) is not None
    )


def limiting(limit: LimitRecord, known: Labels, numbers: Numbers) -> str:
    """What binds, with the value of its bound where that is known."""
    side = SIDES.get(limit.side or "", "")
    if limit.kind == "goal":
        aim = known.goals.get(limit.name)
        return f"goal {limit.name}" + (f": {aim.words}" if aim else "")
    if limit.kind == "joint":
        return f"reach: {limit.name.removesuffix(f'.{limit.side}')} {side}"
    end, unit = None, UNKNOWN
    if limit.kind == "variable" and limit.name in known.ranges:
        variable, unit = known.ranges[limit.name], known.variables.get(limit.name, UNKNOWN)
        end = variable.min if limit.side == "at_least" else variable.max
    elif limit.name in known.measures:
        asked = known.measures[limit.name]
        end, unit = asked.bounds.get(limit.side or ""), asked.unit
    kind = "variable" if limit.kind == "variable" else "measure"
    return f"{kind} {limit.name}: {side} {'' if end is None else numbers.value(end, unit)}"


def price(limit: LimitRecord) -> str:
    """What one per cent is worth, in λ."""
    said = []
    if limit.gain is not None:
        said.append(
            "1 % looser: no gain" if limit.gain < _NO_CHANGE else f"1 % looser: λ falls by {limit.gain:.3g}"
        )
    if limit.cost is not None:
        said.append(
            "1 % tighter: no cost" if limit.cost < _NO_CHANGE else f"1 % tighter: λ rises by {limit.cost:.3g}"
        )
    return "; ".join(said)


def nodes(counts: Mapping[str, int]) -> str:
    """``391114 meet, 620432 violate, 1236545 out of reach``."""
    return ", ".join(f"{count} {_NODES.get(state, state)}" for state, count in counts.items() if count)


def flat(fields: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested fields under dotted names."""
    for name, value in fields.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def field_value(numbers: Numbers, value: Any, unit: str) -> str:
    """One field of the machine."""
    several = value if isinstance(value, list) else [value]
    if several and all(isinstance(one, int | float) and not isinstance(one, bool) for one in several):
        return numbers.several(several, unit)
    return ", ".join(map(str, several)) or NOTHING

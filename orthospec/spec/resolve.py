"""From keys to values: variables, workspace, poses and sweep in SI, with what is wrong about them noted."""

from __future__ import annotations

import keyword
from collections.abc import Mapping, Sequence
from typing import Any

from orthospec.quantities.expressions import GOAL_CALLS, WORDS
from orthospec.quantities.fields import is_quantity
from orthospec.quantities.units import kind
from orthospec.spec.design import Region, Sweep, Variable, Workspace
from orthospec.spec.document import Path
from orthospec.spec.draft import Draft
from orthospec.spec.model import RegionKeys, VariableKeys
from orthospec.spec.wording import did_you_mean

RESERVED = WORDS | GOAL_CALLS | {"scale"}
_ROUNDING = 1e-9
_LENGTH_AXES = frozenset({"x", "y", "z"})


def variables(draft: Draft) -> dict[str, Variable]:
    """The design variables that are well given."""
    for name in sorted(draft.names):
        _check_name(draft, name)
    resolved = {name: _variable(draft, name, keys) for name, keys in draft.keys.variables.items()}
    return {name: variable for name, variable in resolved.items() if variable is not None}


def _check_name(draft: Draft, name: str) -> None:
    path = ("variables", name)
    indices = draft.machine.index_units if draft.machine else {}
    if not name.isidentifier() or keyword.iskeyword(name):
        draft.wrong(path, f"'{name}' cannot be a variable's name: letters, digits and _ only", at_key=True)
    elif name in RESERVED:
        draft.wrong(
            path, f"'{name}' has a meaning in expressions; give the variable another name", at_key=True
        )
    elif name in indices:
        draft.wrong(path, f"'{name}' is an index of the machine; give the variable another name", at_key=True)


def _variable(draft: Draft, name: str, keys: VariableKeys) -> Variable | None:
    path = ("variables", name)
    given = {key: getattr(keys, key) for key in ("min", "max", "start")}
    if keys.choices is not None:
        if keys.min is not None or keys.max is not None:
            draft.wrong(path, "either 'choices', or 'min' and 'max' were expected, both given", at_key=True)
            return None
        return _catalogue(draft, path, keys.choices, keys.start)
    for key in ("min", "max"):
        if given[key] is None:
            draft.wrong(path, f"'{key}' is missing", at_key=True)
    values = {
        key: draft.amount((*path, key), value, None) for key, value in given.items() if value is not None
    }
    if not _is_of_one_kind(draft, path, given) or values.get("min") is None or values.get("max") is None:
        return None
    return _in_order(draft, path, values)


def _catalogue(draft: Draft, path: Path, choices: Sequence[Any], start: Any) -> Variable | None:
    values = [draft.amount((*path, "choices", i), one, None) for i, one in enumerate(choices)]
    given = {f"choice {i + 1}": one for i, one in enumerate(choices)}
    begin = None if start is None else draft.amount((*path, "start"), start, None)
    if not _is_of_one_kind(draft, path, {**given, "start": start}) or None in values:
        return None
    known = sorted(value for value in values if value is not None)
    for i, value in enumerate(values):
        if value in values[:i]:
            draft.wrong((*path, "choices", i), f"{value:g} stands in the catalogue twice")
    if begin is not None and begin not in known:
        draft.wrong((*path, "start"), f"start {begin:g} is not one of the choices")
    middle = known[(len(known) - 1) // 2]
    return Variable(known[0], known[-1], middle if begin is None else begin, tuple(known))


def _is_of_one_kind(draft: Draft, path: Path, given: Mapping[str, Any]) -> bool:
    kinds: dict[str, str] = {}
    for key, value in given.items():
        if isinstance(value, str) and is_quantity(value):
            kinds[key] = kind(value.split()[-1])
    if len(set(kinds.values())) > 1:
        said = ", ".join(f"{key} is {name}" for key, name in kinds.items())
        draft.wrong(path, f"one kind of quantity was expected, but {said}", at_key=True)
        return False
    return True


def _in_order(draft: Draft, path: Path, values: Mapping[str, float | None]) -> Variable | None:
    least, greatest, start = values["min"], values["max"], values.get("start")
    assert least is not None
    assert greatest is not None
    if least >= greatest:
        draft.wrong((*path, "min"), f"min {least:g} is not below max {greatest:g}")
        return None
    if start is not None and not least <= start <= greatest:
        draft.wrong((*path, "start"), f"start {start:g} is not within {least:g} ... {greatest:g}")
    return Variable(least, greatest, (least + greatest) / 2 if start is None else start)


def tolerances(draft: Draft) -> dict[str, float]:
    """How far numbers of the machine may be off, by field, where they may be off at all."""
    path, machine = ("manipulator", "tolerance"), draft.machine
    given = draft.keys.manipulator.tolerance or {}
    if machine is None:
        return {}
    if given and not machine.toleranced:
        draft.wrong(path, f"{draft.keys.manipulator.use} has no field that takes a tolerance", at_key=True)
        return {}
    found = {}
    for name, amount in given.items():
        if name not in machine.toleranced:
            what = (
                f"'{name}' takes no tolerance" if name in machine.model_fields else f"unknown field '{name}'"
            )
            draft.wrong((*path, name), what + did_you_mean(name, machine.toleranced), at_key=True)
            continue
        value = draft.amount((*path, name), amount, machine.toleranced[name])
        if value is not None and value < 0:
            draft.wrong((*path, name), f"0 or more was expected, {value:g} given")
        elif value:
            found[name] = value
    return found


def workspace(draft: Draft) -> Workspace | None:
    """The prescribed cuboid; None after a mistake."""
    keys = draft.keys.workspace
    path = ("workspace", "size")
    if not draft.is_known("workspace"):
        return None
    axes = _axis_units(draft)
    if axes is not None and len(keys.size) > len(axes):
        draft.wrong(path, f"the machine's poses have {len(axes)} coordinates, {len(keys.size)} sizes given")
        return None
    size = _per_axis(draft, path, keys.size)
    for i, edge in enumerate(size or ()):
        if edge <= 0:
            draft.wrong((*path, i), f"more than 0 was expected, {edge:g} given")
    region = None if keys.region is None or size is None else _region(draft, keys.region, size)
    return None if size is None else Workspace(size, keys.divisions, region, keys.together)


def _region(draft: Draft, keys: RegionKeys, size: Sequence[float]) -> Region | None:
    corners = []
    for side, given in (("min", keys.min), ("max", keys.max)):
        path = ("workspace", "region", side)
        if len(given) != len(size):
            draft.wrong(path, f"{len(size)} values were expected, as many as in size, {len(given)} given")
            return None
        corners.append(_per_axis(draft, path, given))
    low, high = corners
    if low is None or high is None:
        return None
    for i, (least, greatest, edge) in enumerate(zip(low, high, size, strict=True)):
        at = ("workspace", "region", "max", i)
        if least >= greatest:
            draft.wrong(at, f"the region's max {greatest:g} is not above its min {least:g}")
        elif greatest - least < edge * (1 - _ROUNDING):
            draft.wrong(at, f"the region is {greatest - least:g} wide here, less than the cuboid's {edge:g}")
    return Region(low, high)


def poses(draft: Draft) -> dict[str, tuple[float, ...]]:
    """The named poses that are well given."""
    resolved = {}
    axes = _axis_units(draft)
    for name, given in draft.keys.poses.items():
        if axes is not None and len(given) != len(axes):
            draft.wrong(("poses", name), f"{len(axes)} values were expected, {len(given)} given")
            continue
        pose = _per_axis(draft, ("poses", name), given)
        if pose is not None:
            resolved[name] = pose
    return resolved


def sweep(draft: Draft) -> Sweep | None:
    """The sweep along one variable, where one is asked for."""
    keys = draft.keys.sweep
    if keys is None:
        return None
    if keys.variable not in draft.names:
        hint = did_you_mean(keys.variable, sorted(draft.names))
        draft.wrong(("sweep", "variable"), f"unknown variable '{keys.variable}'{hint}")
    start = draft.amount(("sweep", "from"), keys.from_, None)
    stop = draft.amount(("sweep", "to"), keys.to, None)
    if start is None or stop is None:
        return None
    if start == stop:
        draft.wrong(("sweep", "to"), "a value other than 'from' was expected")
    return Sweep(keys.variable, start, stop, keys.points)


def _axis_units(draft: Draft) -> tuple[str, ...] | None:
    if draft.machine is None:
        return None
    return tuple("m" if axis in _LENGTH_AXES else "rad" for axis in draft.machine.axes)


def _per_axis(draft: Draft, path: Path, given: Sequence[Any]) -> tuple[float, ...] | None:
    units: Sequence[str | None] = _axis_units(draft) or [None] * len(given)
    values = [draft.amount((*path, i), one, units[i]) for i, one in enumerate(given)]
    resolved = tuple(value for value in values if value is not None)
    return resolved if len(resolved) == len(values) else None

"""``manipulator.from``: the machine of a result, taken into a spec as if its keys stood there.

The result's keys are fixed. Those that the spec gives beside ``from`` add what the solved machine leaves
open, at any depth, and change nothing that it has decided. Where neither gives joint limits, the range of the
joints over the solved cuboid becomes them.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, ValidationError

from orthospec import registry
from orthospec.arrays import np
from orthospec.described import names_by_key
from orthospec.errors import Mistake, PluginFault, SpecError, UsageError
from orthospec.spec.blueprint import Blueprint, Refused
from orthospec.spec.document import Document
from orthospec.spec.document import Path as Keys
from orthospec.spec.strict_yaml import LARGEST_RESULT, parse
from orthospec.spec.wording import known_keys

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses
    from orthospec.manipulators import Manipulator

SECTION: Keys = ("manipulator",)
FROM: Keys = (*SECTION, "from")
_FILE = "result.yaml"
_SOLVED = frozenset({"attained", "compromise", "evaluated"})
_LIMITS = "joint_limits"
_SAME = 1e-9
"""Joints count as unmoved within this, relative: limits and ranges are measured no better."""


@dataclass(frozen=True)
class Solved:
    """Where a spec's machine comes from."""

    path: str
    """The result file as the spec writes it, relative to the spec's own."""
    sha256: str
    """Hash of the result file's bytes."""
    machine: Manipulator
    """As it was solved, without what the spec adds."""
    cuboids: tuple[_Ends, ...]
    """The prescribed cuboids that it was solved for."""

    def moved_by(self, machine: Manipulator) -> bool:
        """Whether any joint of ``machine`` stands elsewhere than the solved one's at a cuboid's corner."""
        if not self.cuboids:
            return False
        poses = np.concatenate([_corners(cuboid, len(machine.axes)) for cuboid in self.cuboids])
        before, after = (one.inverse_kinematics(poses)[0] for one in (self.machine, machine))
        nearness = _SAME * float(np.nanmax(np.abs(before), initial=0.0))
        return not np.allclose(before, after, rtol=0, atol=nearness, equal_nan=True)


class _Record(BaseModel):
    """The part of a result file that a spec takes; the rest is passed over."""

    model_config = ConfigDict(frozen=True, strict=True, defer_build=True)


class _Ends(_Record):
    min: list[float]
    max: list[float]


class _Part(_Record):
    prescribed: _Ends | None = None


class _Workspace(_Part):
    measures: dict[str, _Part] = {}


class _Result(_Record):
    status: str
    manipulator: dict[str, Any]
    joints: _Ends
    workspace: _Workspace = _Workspace()


def take(document: Document) -> Solved | None:
    """Put the machine that ``from`` names in its place; None, and mistakes noted, where that cannot be."""
    keys = document.data.get("manipulator") if isinstance(document.data, dict) else None
    if not isinstance(keys, dict) or keys.get("use") is not None or not isinstance(keys.get("from"), str):
        return None
    written = keys["from"]
    try:
        content = _bytes(document, written)
        result = _result(content, written)
        machine = _machine(result, written, document.place(FROM))
    except UsageError as error:
        document.mistakes.append(document.mistake(FROM, str(error)))
        return None
    given = {key: value for key, value in keys.items() if key not in ("use", "from")}
    merged = _added(document, SECTION, written, machine, result.manipulator, given)
    if _LIMITS not in given and _may_have_limits(machine):
        merged[_LIMITS] = result.joints.model_dump()
    document.data["manipulator"] = merged
    workspace = result.workspace
    cuboids = [part.prescribed for part in (workspace, *workspace.measures.values()) if part.prescribed]
    return Solved(written, hashlib.sha256(content).hexdigest(), machine, tuple(cuboids))


def _bytes(document: Document, written: str) -> bytes:
    folder = Path() if document.file == "-" else Path(document.file).parent
    path = folder / written
    try:
        return (path / _FILE if path.is_dir() else path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "cannot be read"
        raise UsageError(f"'{written}': {reason.lower()}") from None


def _result(content: bytes, written: str) -> _Result:
    try:
        document = parse(content.decode("utf-8-sig"), "", LARGEST_RESULT)
    except UnicodeDecodeError:
        raise UsageError(f"'{written}' is not a result: not UTF-8 text") from None
    except SpecError as error:
        raise UsageError(f"'{written}' cannot be read: {_first(error.mistakes[0])}") from None
    if document.mistakes:
        raise UsageError(f"'{written}' cannot be read: {_first(document.mistakes[0])}")
    data = document.data
    if not isinstance(data, dict) or "status" not in data:
        is_spec = isinstance(data, dict) and "workspace" in data
        kind = "a spec; 'orthospec run' makes a result of it" if is_spec else "not a result"
        raise UsageError(f"'{written}' is {kind}; a result's {_FILE} was expected")
    if data.get("orthospec") != 1:
        raise UsageError(f"'{written}' is a result of format {data.get('orthospec')}; format 1 is read here")
    if data["status"] not in _SOLVED:
        raise UsageError(f"'{written}' has no solved machine: its status is {data['status']}")
    if data.get("joints") is None:
        raise UsageError(f"'{written}' has no solved machine: its cuboid leaves the reach")
    try:
        return _Result.model_validate(data)
    except ValidationError as error:
        where = ".".join(map(str, error.errors()[0]["loc"]))
        raise UsageError(f"'{written}' is not a whole result: '{where}' is missing or wrong") from None


def _first(mistake: Mistake) -> str:
    return f"line {mistake.line}: {mistake.message}" if mistake.line else mistake.message


def _machine(result: _Result, written: str, place: str) -> Manipulator:
    keys = dict(result.manipulator)
    use = str(keys.pop("use", None))
    try:
        made_of = registry.find_manipulator(use)
        return Blueprint(use, made_of, keys, SECTION, place).build({})
    except UsageError as error:
        raise UsageError(f"the machine of '{written}': {error}") from None
    except Refused as error:
        raise UsageError(f"the machine of '{written}' is not one of {use} as installed: {error}") from None
    except PluginFault as fault:
        raise PluginFault(fault.plugin, fault.what, place) from fault


def _added(
    document: Document,
    path: Keys,
    written: str,
    solved: BaseModel,
    content: Mapping[str, Any],
    given: Mapping[str, Any],
) -> dict[str, Any]:
    """The solved keys and those given beside them; a mistake for each that the solved machine has decided."""
    merged = dict(content)
    names = names_by_key(type(solved))
    for key, value in given.items():
        name, inner = names.get(key), content.get(key)
        here = None if name is None else getattr(solved, name)
        if name is None or _is_open(solved, name):
            merged[key] = value
        elif isinstance(here, BaseModel) and isinstance(inner, Mapping) and isinstance(value, Mapping):
            merged[key] = _added(document, (*path, key), written, here, inner, value)
        else:
            at = (*path, key)
            message = (
                f"'{'.'.join(map(str, at[1:]))}' is solved in {written} and cannot be changed here;"
                " keys beside 'from' only add"
            )
            document.mistakes.append(document.mistake(at, message, at_key=True))
    return merged


def _is_open(solved: BaseModel, name: str) -> bool:
    """Whether a field is at its default: the solved machine has not decided it."""
    default = type(solved).model_fields[name].get_default(call_default_factory=True)
    return bool(getattr(solved, name) == default)


def _may_have_limits(machine: Manipulator) -> bool:
    """Whether the class has joint limits with both ends, and the solved machine left them open."""
    ends = known_keys(type(machine), (_LIMITS,))
    return {"min", "max"} <= set(ends) and _is_open(machine, _LIMITS)


def _corners(cuboid: _Ends, coordinates: int) -> Poses:
    """Its corners (n, coordinates); further pose coordinates are 0."""
    ends: Iterator[tuple[float, ...]] = itertools.product(*zip(cuboid.min, cuboid.max, strict=True))
    corners: Array = np.array(list(ends), dtype=float)
    return np.pad(corners, ((0, 0), (0, coordinates - corners.shape[1])))

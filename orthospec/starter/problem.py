"""A first problem for a machine: from the examples of its keys to a cuboid that it can have.

The first required length that the machine has is the design variable. How large a cuboid is asked for comes
from the largest one of the example itself, so that there is something to find.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from orthospec import registry
from orthospec.errors import OrthospecError, UsageError
from orthospec.quantities.fields import is_quantity, resolve
from orthospec.quantities.units import parse_unit
from orthospec.show.keys import Key, keys_of
from orthospec.spec import load_spec
from orthospec.spec.writing import dump

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.workspace.evaluate import Evaluation

MEASURE = "condition_number"
BOUNDS = (3.0, 5.0, 10.0)
"""Condition numbers to be had over the cuboid; the first that leaves a cuboid worth the name is taken."""
PART = 0.8
"""Of the example's largest cuboid: what shorter legs can do as well."""
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)


@dataclass(frozen=True)
class Problem:
    """What a starting spec says, as it is written."""

    machine: str
    keys: Mapping[str, Any]
    """The machine's own, with the variable in its place."""
    others: tuple[Key, ...]
    """Its keys that are left out."""
    variable: str
    least: str
    start: str
    greatest: str
    size: tuple[str, ...]
    far: str
    """No pose of the cuboid has a greater coordinate."""
    endless: bool
    """Whether the reach has no end without a region."""
    at_most: float
    coordinates: int
    """Of a pose."""


def first_problem(machine: str) -> Problem:
    """The problem; `UsageError` where the machine's keys have no examples, or these give no cuboid."""
    made_of = registry.find_manipulator(machine)
    examples, keys = _examples(machine, made_of), keys_of(made_of).keys
    varied = next((key for key in keys if key.required and _is_length(key, examples[key.path[0]])), None)
    lengths = len([*takewhile(lambda axis: axis in "xyz", made_of.axes)])
    if varied is None or lengths < 2:
        what = "no length among its required keys" if varied is None else "no cuboid among its axes"
        raise UsageError(f"{machine} has {what}: write its spec by hand, see `orthospec explain {machine}`")
    (name,) = varied.path
    example = examples[name]
    first = example[0] if isinstance(example, list) else example
    length, unit = _length(machine, name, first), str(first).split()[-1] if is_quantity(str(first)) else "m"
    found, endless = _tried(machine, examples, length, lengths)
    most, edge = _cuboid(machine, found, length / 2)
    variable = _name(name, made_of, several=isinstance(example, list))
    in_place = [variable] * len(example) if isinstance(example, list) else variable
    return Problem(
        machine=machine,
        keys={**examples, name: in_place},
        others=tuple(key for key in keys if key.path[0] not in examples),
        variable=variable,
        least=_written(length / 2, unit),
        start=_written(length, unit),
        greatest=_written(length * 2, unit),
        size=(_written(_rounded(PART * edge, unit), unit),) * min(lengths, 3),
        far=_written(length, unit),
        endless=endless,
        at_most=most,
        coordinates=len(made_of.axes),
    )


def _examples(machine: str, made_of: type[Manipulator]) -> dict[str, Any]:
    """An example of each required key, and of others that have one; by the names in a spec."""
    schema = made_of.model_json_schema()
    given = {name: one["examples"][0] for name, one in schema["properties"].items() if one.get("examples")}
    known = json.loads(json.dumps(given))
    missing = [name for name in schema.get("required", ()) if name not in known]
    if missing:
        raise UsageError(
            f"{machine} gives no example of {', '.join(missing)}, so that no spec can be made for it; write"
            f" one by hand (`orthospec explain {machine}`), or let its author add Field(examples=[...])"
        )
    return dict(known)


def _length(machine: str, key: str, example: Any) -> float:
    try:
        length = resolve(example, "m", {})
    except ValueError as error:
        raise UsageError(f"{machine}: the example of its key {key}: {error}") from None
    if length > 0:
        return length
    raise UsageError(f"{machine}: the example of its key {key} is {example}, not above 0")


def _is_length(key: Key, example: Any) -> bool:
    """Whether a key is one length, or several that are equal in the example."""
    values = example if isinstance(example, list) else [example]
    return key.units == ("m",) and key.part is None and all(value == values[0] for value in values)


def _tried(machine: str, examples: Mapping[str, Any], length: float, axes: int) -> tuple[Evaluation, bool]:
    """The example on a coarse grid over its reach, or over a region where that has no end."""
    content = {
        "orthospec": 1,
        "manipulator": {"use": machine, **examples},
        "workspace": {"size": [length / 2] * min(axes, 3), "divisions": 10},
        "measures": {"trial": {"use": MEASURE, "levels": {"at_most": list(BOUNDS)}}},
    }
    try:
        return _evaluated(machine, content), False
    except UsageError:
        box = {"min": [-length] * min(axes, 3), "max": [length] * min(axes, 3)}
        content["workspace"] = {**content["workspace"], "region": box}  # type: ignore[dict-item]
        return _evaluated(machine, content), True


def _evaluated(machine: str, content: Mapping[str, Any]) -> Evaluation:
    from orthospec.optimise import evaluate_spec

    with TemporaryDirectory() as folder:
        path = Path(folder) / f"examples of {machine}"
        path.write_text(dump(content), encoding="utf-8")
        try:
            finding = evaluate_spec(load_spec(path)).finding
        except OrthospecError as error:
            said = str(error).replace(str(path), path.name)
            raise UsageError(f"{machine}: its keys' examples make no machine to start from: {said}") from None
    if finding.errors:
        said = "; ".join(f"{one.name} {one.message}" for one in finding.errors)
        raise UsageError(f"{machine}: its keys' examples make no machine to start from: {said}")
    return finding.evaluation


def _cuboid(machine: str, found: Evaluation, edge: float) -> tuple[float, float]:
    """A bound on the condition number, and the edge [m] of the largest cuboid in which it holds."""
    scales = [largest.scale for _, largest in found.measures["trial"].levels]
    for most, scale in zip(BOUNDS, scales, strict=True):
        if scale * edge >= 0.1 * edge or (most == BOUNDS[-1] and scale > 0):
            return most, scale * edge
    raise UsageError(
        f"{machine}: with its keys' examples there is no cuboid in which {MEASURE} is at most {BOUNDS[-1]:g}"
    )


def _name(key: str, made_of: type[Manipulator], *, several: bool) -> str:
    """A variable's name, that of one of several where it stands for all: none of the machine's indices."""
    name = key.removesuffix("s") if several else key
    return f"{name}_" if name in made_of.index_units else name


def _written(length: float, unit: str) -> str:
    """A length as a quantity."""
    known = parse_unit(unit)
    return f"{length * float(known.denominator / known.numerator):.6g} {unit}"


def _rounded(length: float, unit: str) -> float:
    """The next smaller round number in this unit [m]."""
    known = parse_unit(unit)
    number = length * float(known.denominator / known.numerator)
    power = 10.0 ** math.floor(math.log10(number))
    return max(one for one in _ROUND if one * power <= number * (1 + 1e-9)) * power * length / number

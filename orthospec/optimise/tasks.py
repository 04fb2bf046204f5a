"""What can be done independently of anything else, and by anyone: here, in another process, elsewhere.

A task is a function of a module, from a design space and plain frozen data to plain frozen data. Nothing
else decides what comes out, so that its result is the same wherever it was made, and can be kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from orthospec.optimise.space import DesignSpace
from orthospec.workspace.field import Progress

Given = TypeVar("Given")
Made = TypeVar("Made")


def _always(_: object) -> bool:
    return True


@dataclass(frozen=True)
class Task(Generic[Given, Made]):
    """One kind of independent work."""

    name: str
    """In the user's words, for progress: what is being done."""
    work: Callable[[DesignSpace, Given, Progress | None], Made]
    """A function that other processes find by its module and name; it tells how far it is if it is heard."""
    depends: Callable[[Mapping[str, Any]], Any]
    """Of a spec's canonical content, the part that decides what is made."""
    makes: tuple[type, ...] = ()
    """The frozen dataclasses in what is made."""
    lasting: Callable[[Made], bool] = _always
    """Whether what was made may be kept: not what tells of places in this very file."""
    keeps_parts: bool = False
    """Whether it is not kept as a whole, but the work keeps parts of it."""
    divides: bool = False
    """Whether the work shares out parts of itself where it is done in this process: a single one is then."""


class Stopped(KeyboardInterrupt):
    """Ctrl-C in the middle of a task that has something to show for it already."""

    def __init__(self, made: object) -> None:
        super().__init__()
        self.made = made


def problem_of(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a solve depends on: not the grid, levels, poses, a sweep, or where the search starts."""
    ranges = {
        name: _without(one, "start") if one["min"] < one["max"] else one
        for name, one in content["variables"].items()
    }
    measures = _measures_alone(content)
    goals, machine = content["goals"], content["manipulator"]
    workspace = _without(content["workspace"], "divisions")
    return {
        "variables": ranges,
        "workspace": workspace,
        "measures": measures,
        "goals": goals,
        "machine": machine,
    }


def machine_and_measures(content: Mapping[str, Any]) -> dict[str, Any]:
    """What measuring a design depends on: not goals, a sweep, or the variables' ranges."""
    workspace = _without(content["workspace"], "divisions")
    parts = {part: content[part] for part in ("manipulator", "measures", "poses")}
    return {"variables": list(content["variables"]), "workspace": workspace, **parts}


def machine_and_bounds(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a proof depends on: not poses to be told, nor levels."""
    parts = _without(machine_and_measures(content), "poses")
    return {**parts, "measures": _measures_alone(content), "tolerances": content.get("tolerances", {})}


def _measures_alone(content: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _without(one, "levels") for name, one in content["measures"].items()}


def _without(content: Mapping[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in content.items() if key != name}

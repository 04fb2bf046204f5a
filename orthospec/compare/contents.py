"""What is compared of a spec and of a result, under the keys that their readers know."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from orthospec.result.model import (
    DesignRecord,
    LargestRecord,
    LimitRecord,
    MeasureRecord,
    ParetoRecord,
    PrescribedRecord,
    Result,
)

if TYPE_CHECKING:
    from orthospec.result.model import AttainmentRecord
    from orthospec.spec import Spec

ORDERED = ("variables", "measures", "goals")
"""Sections of a spec in which the order of the entries can decide between equal designs."""


def of_spec(spec: Spec) -> dict[str, Any]:
    """A spec's meaning (`Spec.canonical`: SI, no title, notes or comments) under the keys of spec files."""
    content = {name: part for name, part in spec.canonical().items() if part is not None}
    content.pop("orthospec")
    content["variables"] = {name: _variable(one) for name, one in content["variables"].items()}
    content["measures"] = {name: _measure(one) for name, one in content["measures"].items()}
    content["workspace"] = {key: part for key, part in content["workspace"].items() if part is not None}
    if spec.sweep is not None:
        sweep = content["sweep"]
        content["sweep"] = {
            "variable": sweep["variable"],
            "from": sweep["start"],
            "to": sweep["stop"],
            "points": sweep["points"],
        }
    if spec.pareto is not None:
        content["pareto"] = {"points": spec.pareto}
    content["proof"] = False if spec.proof is None else spec.proof.model_dump()
    return content


def _variable(content: Mapping[str, Any]) -> dict[str, Any]:
    """Of a catalogue the choices; its ends are among them."""
    return {key: content[key] for key in content if "choices" not in content or key in ("choices", "start")}


def _measure(content: Mapping[str, Any]) -> dict[str, Any]:
    """Levels by side, as specs have them."""
    levels: dict[str, list[Any]] = {}
    for level in content["levels"]:
        for side, bound in level.items():
            levels.setdefault(side, []).append(bound)
    others = {key: part for key, part in content.items() if key != "levels"}
    return {**others, "levels": levels} if levels else others


def of_result(result: Result) -> dict[str, Any]:
    """What a result found, in SI.

    Goals, λ, design, machine, indices, the cuboids' scales, the measures' extremes, prices and verdicts; of a
    Pareto set the goals and variables, of a sweep the variables and extremes.
    """
    return {
        "status": result.status,
        **_given(attainment=_attainment(result.attainment)),
        **_given(variables=result.variables, manipulator=result.manipulator, indices=result.indices),
        **_given(workspace=_workspace(result)),
        **_given(limits=_limits(result.limits)),
        **_given(pareto=[_alternative(one) for one in result.pareto]),
        **_given(sweep=[_swept(one) for one in result.sweep]),
        **_given(provenance={k: v for k, v in result.provenance.items() if k in ("orthospec", "plugins")}),
    }


def _given(**entries: Any) -> dict[str, Any]:
    return {name: value for name, value in entries.items() if value is not None and value not in ({}, [])}


def _attainment(attainment: AttainmentRecord | None) -> dict[str, Any] | None:
    return None if attainment is None else attainment.model_dump()


def _workspace(one: DesignRecord) -> dict[str, Any]:
    workspace = one.workspace
    joint = None if workspace.joint is None else _largest(workspace.joint)
    measures = {name: _measured(record) for name, record in workspace.measures.items()}
    return _given(prescribed=_prescribed(workspace.prescribed), joint=joint, measures=measures)


def _prescribed(place: PrescribedRecord | None) -> dict[str, Any] | None:
    return None if place is None else {"holds": place.holds, **_verdict(place)}


def _verdict(record: PrescribedRecord | LargestRecord | MeasureRecord) -> dict[str, Any]:
    return {} if record.proof is None else {"proof": {"verdict": record.proof.verdict}}


def _largest(record: LargestRecord) -> dict[str, Any]:
    return {"scale": record.scale, **_verdict(record)}


def _measured(record: MeasureRecord) -> dict[str, Any]:
    levels = [
        {**_given(at_least=level.at_least, at_most=level.at_most), **_largest(level)}
        for level in record.levels
    ]
    # A measure without directions has one value a pose.
    poses = {name: at[0] if at and len(at) == 1 else at for name, at in record.poses.items()}
    return {
        **_given(scale=record.scale),
        **_verdict(record),
        **_extremes(record),
        **_given(levels=levels, poses=poses, prescribed=_prescribed(record.prescribed)),
    }


def _extremes(record: MeasureRecord) -> dict[str, Any]:
    ends = {"lowest": record.lowest, "highest": record.highest}
    return {name: None if end is None else {"value": end.value} for name, end in ends.items()}


def _limits(limits: list[LimitRecord]) -> dict[str, Any]:
    """By kind, name and side; in the file they stand by their gains."""
    return {_called(one): {"gain": one.gain, "cost": one.cost} for one in limits}


def _called(limit: LimitRecord) -> str:
    """``bound.transmission.at_most``; a joint limit's name ends with its side."""
    side = "" if limit.side is None else f".{limit.side}"
    return f"{limit.kind}.{limit.name.removesuffix(side)}{side}"


def _alternative(one: ParetoRecord) -> dict[str, Any]:
    goals = (
        {} if one.attainment is None else {name: goal.value for name, goal in one.attainment.goals.items()}
    )
    return _given(goals=goals, variables=one.variables)


def _swept(one: DesignRecord) -> dict[str, Any]:
    measures = {name: _extremes(record) for name, record in one.workspace.measures.items()}
    return _given(variables=one.variables, measures=measures)

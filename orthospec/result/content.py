"""From what was found to the plain content of ``result.yaml``.

The same content for the same spec and versions: no time, host or absolute path comes in. A number that is
not finite becomes null.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from importlib.metadata import version
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.result.records import (
        Attainment,
        Branch,
        Card,
        Finding,
        Limit,
        Note,
        PluginError,
        Search,
        Taken,
    )
    from orthospec.spec import Spec
    from orthospec.workspace.evaluate import Evaluation, Largest, Measured, Prescribed, Value
    from orthospec.workspace.guarantee import Bracket, Proof

ITSELF = "orthospec"


def compose(spec: Spec, finding: Finding) -> dict[str, Any]:
    """The content of the result file, keys in the contract's order; those without content are left out."""
    return {
        "orthospec": 1,
        **_given(title=spec.title),
        "status": finding.status,
        **_given(attainment=_attainment(finding.attainment)),
        **_design(spec, finding),
        **({"limits": _limits(finding.limits)} if finding.search is not None else {}),
        **_given(
            search=_search(spec, finding.search),
            pareto=[_pareto(spec, point) for point in finding.pareto],
            sweep=[_design(spec, point) for point in finding.sweep],
            errors=[_told(spec, error.name, error) for error in finding.errors],
            notes=[_told(spec, note.about, note) for note in finding.notes],
        ),
        "provenance": _provenance(spec),
    }


def _given(**entries: Any) -> dict[str, Any]:
    """The entries that say something."""
    return {name: value for name, value in entries.items() if value is not None and value not in ({}, [])}


def _number(value: float) -> float | None:
    """A plain float; no minus zero, since it would be another text for the same number."""
    return float(value) + 0.0 if math.isfinite(value) else None


def _known(value: float | None) -> float | None:
    return None if value is None else _number(value)


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [_number(value) for value in values]


def _by_name(values: Mapping[str, float]) -> dict[str, float | None]:
    return {name: _number(value) for name, value in values.items()}


def _attainment(attainment: Attainment | None) -> dict[str, Any] | None:
    if attainment is None or not attainment.goals:
        return None
    goals = {
        name: {
            "value": _number(goal.value),
            "goal": _number(goal.goal),
            "weight": _number(goal.weight),
            "attained": goal.attained,
        }
        for name, goal in attainment.goals.items()
    }
    factor = attainment.factor
    return {"factor": None if factor is None else _number(factor), "goals": goals}


def _design(spec: Spec, finding: Finding) -> dict[str, Any]:
    """What is said of each design, of the one found and of those along a sweep."""
    evaluation = finding.evaluation
    return {
        **_given(variables=_by_name(finding.design.values)),
        "manipulator": {"use": spec.manipulator.use, **_fields(finding.design.manipulator)},
        **_given(indices=_by_name(evaluation.indices), joints=_joints(evaluation)),
        "workspace": _workspace(evaluation),
    }


def _pareto(spec: Spec, point: Finding) -> dict[str, Any]:
    return {
        **({"knee": True} if point.is_knee else {}),
        **_given(attainment=_attainment(point.attainment)),
        **_design(spec, point),
        "limits": _limits(point.limits),
    }


def _fields(manipulator: Manipulator) -> dict[str, Any]:
    """The machine's fields as resolved; what was not given and has no value says nothing."""
    return _given(**manipulator.model_dump(mode="json", by_alias=True, exclude_none=True))


def _joints(evaluation: Evaluation) -> dict[str, Any] | None:
    if evaluation.joints is None:
        return None
    return {"min": _numbers(evaluation.joints[:, 0]), "max": _numbers(evaluation.joints[:, 1])}


def _workspace(evaluation: Evaluation) -> dict[str, Any]:
    return _given(
        prescribed=_prescribed(evaluation.prescribed),
        joint=None if evaluation.joint is None else _largest(evaluation.joint),
        measures={name: _measured(record) for name, record in evaluation.measures.items()},
    )


def _prescribed(prescribed: Prescribed | None) -> dict[str, Any] | None:
    if prescribed is None:
        return None
    low, high = _numbers(prescribed.cuboid.low), _numbers(prescribed.cuboid.high)
    scale = {} if prescribed.scale == 1 else {"scale": _number(prescribed.scale)}
    return {
        "min": low,
        "max": high,
        **scale,
        "holds": prescribed.holds,
        **_given(proof=_proof(prescribed.proof)),
    }


def _largest(largest: Largest) -> dict[str, Any]:
    cuboid = largest.cuboid
    return {
        "scale": _number(largest.scale),
        "grid_scale": _number(largest.grid_scale),
        "ties": largest.ties,
        "min": None if cuboid is None else _numbers(cuboid.low),
        "max": None if cuboid is None else _numbers(cuboid.high),
        "nodes": dict(largest.nodes),
        **_given(proved=_bracket(largest.proved), proof=_proof(largest.proof)),
    }


def _bracket(bracket: Bracket | None) -> dict[str, Any] | None:
    return None if bracket is None else {"least": _known(bracket.least), "most": _known(bracket.most)}


def _proof(proof: Proof | None) -> dict[str, Any] | None:
    if proof is None:
        return None
    return {
        "verdict": proof.verdict,
        "slack": _number(proof.slack),
        "boxes": proof.boxes,
        "excess": _known(proof.excess),
        "at": None if proof.at is None else _numbers(proof.at),
        **_given(machine={name: _numbers(values) for name, values in (proof.machine or {}).items()}),
        **_given(nominal=proof.nominal, condition=proof.condition, why=proof.why),
    }


def _measured(record: Measured) -> dict[str, Any]:
    levels = [{**_by_name(level.bounds), **_largest(largest)} for level, largest in record.levels]
    poses = {name: None if at is None else _numbers(at) for name, at in record.poses.items()}
    return {
        **({} if record.largest is None else _largest(record.largest)),
        "lowest": _value(record.lowest),
        "highest": _value(record.highest),
        **_given(levels=levels, poses=poses, prescribed=_prescribed(record.prescribed)),
    }


def _value(value: Value | None) -> dict[str, Any] | None:
    return None if value is None else {"value": _number(value.value), "at": _numbers(value.at)}


def _limits(limits: Iterable[Limit]) -> list[dict[str, Any]]:
    """What binds, in the order in which it was found: the largest gain first."""
    return [
        {
            "kind": limit.kind,
            "name": limit.name,
            "side": limit.side,
            "at": [_numbers(pose) for pose in limit.at],
            "gain": _known(limit.gain),
            "cost": _known(limit.cost),
        }
        for limit in limits
    ]


def _search(spec: Spec, search: Search | None) -> dict[str, Any] | None:
    if search is None:
        return None
    violation = search.least_violation
    return {
        "designs": search.designs,
        "refined": search.refined,
        "distinct": search.distinct,
        "starts": search.starts,
        "subproblems": search.subproblems,
        **_given(
            steps=[_step(step) for step in search.steps],
            least_violation=None if violation is None else _number(violation),
            conflicts=list(search.conflicts),
            card=None if search.card is None else _card(spec, search.card),
            combinations=search.combinations if search.branches else None,
            branches=[_branch(branch) for branch in search.branches],
            pareto=None if search.front is None else asdict(search.front),
        ),
    }


def _step(step: Taken) -> dict[str, Any]:
    return {
        "subproblems": step.subproblems,
        "factor": _number(step.factor),
        "violation": _number(step.violation),
    }


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "choices": _by_name(branch.choices),
        "found": branch.found,
        "factor": _known(branch.factor),
        **_given(cost=_known(branch.cost), least_violation=_known(branch.least_violation)),
    }


def _card(spec: Spec, card: Card) -> dict[str, Any]:
    return {
        "conflict": [
            {
                "kind": one.kind,
                "name": one.name,
                "side": one.side,
                "place": _portable(spec, one.place),
                "value": _known(one.value),
                **({"needed": _known(one.needed), "by": _known(one.by)} if one.sought else {}),
            }
            for one in card.culprits
        ],
        "irreducible": card.irreducible,
        "together": _known(card.together),
        "scale": _known(card.scale),
    }


def _told(spec: Spec, name: str, one: PluginError | Note) -> dict[str, Any]:
    return {"name": name, **_given(place=_portable(spec, one.place)), "message": one.message}


def _portable(spec: Spec, place: str | None) -> str | None:
    """The place without the folder that the spec lies in."""
    file = spec.document.file
    if place is None or not place.startswith(file):
        return place
    return PurePath(file).name + place.removeprefix(file)


def _provenance(spec: Spec) -> dict[str, Any]:
    others = {one.distribution: one.version for one in spec.plugins if one.distribution != ITSELF}
    solved = spec.solved
    source = None if solved is None else {"path": solved.path, "sha256": solved.sha256}
    return {
        "orthospec": version(ITSELF),
        "spec_sha256": spec.sha256(),
        **_given(**{"from": source}, plugins=others),
    }

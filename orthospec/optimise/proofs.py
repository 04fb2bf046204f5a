"""Proofs for a result: of each cuboid that it tells, each a task of its own."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from orthospec.errors import PluginFault
from orthospec.measures import Level
from orthospec.optimise.objective import scale_is_asked
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.optimise.tasks import Task, machine_and_bounds
from orthospec.optimise.workers import Workers, in_order
from orthospec.spec import Design, ProofKeys
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Evaluation, Largest, Prescribed, enlarged
from orthospec.workspace.guarantee import Bracket, Proof, bracket, proof_within
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.workspace.field import Progress


ENLARGED = 3
"""How often a largest cuboid gives way to one that its proof has met."""

Bounds: TypeAlias = tuple[tuple[str, float], ...]
"""Bounds by their sides."""


@dataclass(frozen=True)
class ToProve:
    """A cuboid, and what is to hold everywhere in it beside the reach."""

    values: tuple[float, ...]
    """Of the variables, in the spec's order."""
    measures: tuple[str, ...]
    level: Bounds | None
    """Bounds in the place of the one measure's own."""
    cuboid: Cuboid
    scale: float | None
    """The scale of a largest cuboid, which is to be enclosed."""
    slack: float
    boxes: int


@dataclass(frozen=True)
class Proved:
    """The verdict over a cuboid, and the ends of its scale where they were asked for."""

    proof: Proof
    bracket: Bracket | None


def prove_cuboid(space: DesignSpace, one: ToProve, progress: Progress | None = None) -> Proved:  # noqa: ARG001
    """Prove what is asked of one cuboid."""
    design = space.spec.design(dict(zip(space.spec.variables, one.values, strict=True)))
    demands = {demand.name: demand for demand in design.demands if demand.name in one.measures}
    if one.level is not None:
        (demand,) = demands.values()
        demands = {demand.name: demand.at(Level(dict(one.level)))}
    machine = Machine(design.manipulator, demands)
    proof = proof_within(machine, one.cuboid, one.slack, one.boxes, space.spec.tolerances)
    if one.scale is None:
        return Proved(proof, None)
    setting = space.setting
    ends = bracket(machine, setting.size, one.cuboid, one.scale, setting.region, one.boxes)
    return Proved(proof, ends)


PROVE = Task("proving", prove_cuboid, machine_and_bounds, (Proved, Proof, Bracket, Cuboid))


def proved(
    workers: Workers,
    space: DesignSpace,
    points: Sequence[tuple[Design, Evaluation]],
    keys: ProofKeys,
    progress: Progress | None = None,
    of: tuple[type[Any], ...] = (Prescribed, Largest),
) -> list[Evaluation]:
    """The evaluations of designs, with a proof beside each cuboid ``of`` these kinds.

    Where the search for a scale's upper end meets a larger cuboid, that is told and proved instead.
    """
    designs, found = [design for design, _ in points], [evaluation for _, evaluation in points]
    for left in reversed(range(ENLARGED + 1)):
        found = _proved(workers, space, list(zip(designs, found, strict=True)), keys, progress, of)
        grown = [_enlarged(space, *point) for point in zip(designs, found, strict=True)] if left else found
        if all(map(operator.is_, grown, found)):
            break
        found, of = grown, (Prescribed, Largest)
    return found


def _larger_in(evaluation: Evaluation) -> dict[str, Cuboid]:
    """Cuboids that proofs have met, larger than the largest that are told, by measure ("": joint)."""
    told = {"": evaluation.joint}
    if evaluation.joint is None:
        told = {name: record.largest for name, record in evaluation.measures.items()}
    ends = {name: one.proved for name, one in told.items() if one is not None}
    return {name: one.larger for name, one in ends.items() if one is not None and one.larger is not None}


def _enlarged(space: DesignSpace, design: Design, evaluation: Evaluation) -> Evaluation:
    """The evaluation with what these lead to; as it is where there are none, or a plugin fails on the way."""
    larger = _larger_in(evaluation)
    if not larger:
        return evaluation
    machine = machine_of(design)
    known = {name: demand for name, demand in machine.demands.items() if name in evaluation.measures}
    machine = replace(machine, demands=known)
    setting = replace(space.setting, grows=scale_is_asked(design.goals))
    try:
        return enlarged(machine, setting, evaluation, larger, space.forms)
    except PluginFault:
        return evaluation


def _proved(
    workers: Workers,
    space: DesignSpace,
    points: Sequence[tuple[Design, Evaluation]],
    keys: ProofKeys,
    progress: Progress | None,
    of: tuple[type[Any], ...],
) -> list[Evaluation]:
    """The evaluations with a proof beside each cuboid of these kinds that has none."""
    wanted: dict[ToProve, None] = {}

    def ask(design: Design, one: Any, *how: Any) -> Any:
        item = _item(design, keys, one, *how) if isinstance(one, of) else None
        if item is not None:
            wanted[item] = None
        return one

    for design, evaluation in points:
        _each(evaluation, design, ask)
    known: dict[ToProve | None, Proved] = dict(
        zip(wanted, in_order(workers, PROVE, space, list(wanted), progress), strict=True)
    )

    def tell(design: Design, one: Any, *how: Any) -> Any:
        found = known.get(_item(design, keys, one, *how)) if isinstance(one, of) else None
        if found is None:
            return one
        if isinstance(one, Largest):
            return replace(one, proof=found.proof, proved=found.bracket)
        return replace(one, proof=found.proof, holds=one.holds and not found.proof.refutes_design)

    return [_each(evaluation, design, tell) for design, evaluation in points]


def refuting_poses(evaluation: Evaluation) -> tuple[tuple[float, ...], ...]:
    """The poses that refute the prescribed cuboids of the machine as it is designed."""
    places = [evaluation.prescribed, *(record.prescribed for record in evaluation.measures.values())]
    proofs = [place.proof for place in places if place is not None and place.proof is not None]
    return tuple(proof.at for proof in proofs if proof.refutes_design and proof.at is not None)


def _each(evaluation: Evaluation, design: Design, visit: Callable[..., Any]) -> Evaluation:
    """The evaluation with ``visit(design, cuboid, measures, level, ends)`` in the place of each cuboid."""
    bounded = tuple(demand.name for demand in design.demands if demand.bounds)
    apart = evaluation.joint is None

    def seen(one: Any, names: tuple[str, ...], level: Bounds | None = None, ends: bool = False) -> Any:
        return None if one is None else visit(design, one, names, level, ends)

    measures = {
        name: replace(
            record,
            prescribed=seen(record.prescribed, (name,)),
            largest=seen(record.largest, (name,), ends=apart or bounded == (name,)),
            levels=tuple(
                (level, seen(one, (name,), tuple(level.bounds.items()))) for level, one in record.levels
            ),
        )
        for name, record in evaluation.measures.items()
    }
    prescribed, joint = seen(evaluation.prescribed, bounded), seen(evaluation.joint, bounded, ends=True)
    return replace(evaluation, prescribed=prescribed, joint=joint, measures=measures)


def _item(
    design: Design,
    keys: ProofKeys,
    one: Any,
    names: tuple[str, ...],
    level: Bounds | None,
    ends: bool,
) -> ToProve | None:
    """What is to be proved of a cuboid; None of one that has no size, or a proof."""
    scale = one.scale if isinstance(one, Largest) else None
    if one.cuboid is None or scale == 0 or one.proof is not None:
        return None
    values = tuple(design.values.values())
    return ToProve(values, names, level, one.cuboid, scale if ends else None, keys.slack, keys.boxes)

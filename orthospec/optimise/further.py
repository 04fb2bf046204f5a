"""Further designs of a run, each told as the one that was found: a Pareto set, and a sweep."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.errors import PluginFault
from orthospec.optimise.appraise import FRONT, SWEEP, asked, asked_of_found, coarser_notes, error_of
from orthospec.optimise.limits import find_limits
from orthospec.optimise.meet import soft_goals
from orthospec.optimise.pareto import find_front
from orthospec.optimise.proofs import proved
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.status import attainment_of, status_of
from orthospec.optimise.workers import Workers, in_order
from orthospec.result import Finding, FrontSearch, Note, PluginError, Status
from orthospec.spec import Design, Spec
from orthospec.workspace.evaluate import Prescribed

if TYPE_CHECKING:
    from orthospec.workspace.field import Progress


def front_of(
    spec: Spec, workers: Workers, progress: Progress | None
) -> tuple[tuple[Finding, ...], FrontSearch]:
    """The Pareto set, each point as a finding; prices are parts of the goals' ranges over the set."""
    front = find_front(spec, workers, progress)
    ends = [(point.space, point.met.attained.end) for point in front.points]
    designs = [space.design(end.design) for space, end in ends]
    asks = [
        asked_of_found(space, design, spec.workspace.divisions, end.cuboids(space))
        for design, (space, end) in zip(designs, ends, strict=True)
    ]
    soft = set(soft_goals(spec))
    measured = in_order(workers, FRONT, DesignSpace(spec), asks, progress)
    told = [
        (point, spec.design(design.values), replace(known, notes=coarser_notes(space, one)))
        for point, (space, _), one, design, known in zip(
            front.points, ends, asks, designs, measured, strict=True
        )
        if known.error is None and known.evaluation is not None
    ]
    evaluations = [known.evaluation for _, _, known in told if known.evaluation is not None]
    if spec.proof is not None:
        pairs = [(design, one) for (_, design, _), one in zip(told, evaluations, strict=True)]
        evaluations = proved(workers, DesignSpace(spec), pairs, spec.proof, progress, of=(Prescribed,))
    found = []
    for (point, design, known), evaluation in zip(told, evaluations, strict=True):
        limits = find_limits(point.space, point.met.attained, workers, progress)
        kept = tuple(one for one in limits if one.kind != "goal" or one.name not in soft)
        attainment = attainment_of(design, evaluation)
        status = status_of(point.met.attained, evaluation, attainment, known.faults)
        found.append(
            Finding(
                status,
                design,
                evaluation,
                attainment,
                kept,
                errors=known.errors,
                notes=known.notes,
                is_knee=point.is_knee,
            )
        )
    return tuple(found), front.search


class Swept(NamedTuple):
    """A sweep: the points that can be measured, and what went otherwise at any of them."""

    points: tuple[Finding, ...] = ()
    errors: tuple[PluginError, ...] = ()
    notes: tuple[Note, ...] = ()


def sweep_of(space: DesignSpace, design: Design, workers: Workers, progress: Progress | None) -> Swept:
    """The design evaluated along one variable, the others as they are.

    A point without a machine, or whose reach cannot be found, must not lose the rest.
    """
    spec, sweep = space.spec, space.spec.sweep
    if sweep is None:
        return Swept()
    line = [
        {**design.values, sweep.variable: float(value)}
        for value in np.linspace(sweep.start, sweep.stop, sweep.points)
    ]
    here = asked(design, spec.workspace.divisions)
    points = [replace(here, values=tuple(values.values())) for values in line]
    found: list[Finding] = []
    errors: list[PluginError] = []
    notes: list[Note] = []
    for values, point in zip(line, in_order(workers, SWEEP, space, points, progress), strict=True):
        at = f"at {sweep.variable} = {values[sweep.variable]:g}"
        failed = [*point.errors]
        if isinstance(point.error, PluginFault):
            failed.append(error_of(point.error))
        elif point.error is not None:
            notes.append(Note("sweep", spec.place(("sweep",)), f"{at}: {point.error}"))
        errors += [replace(error, message=f"{at}: {error.message}") for error in failed]
        if point.evaluation is not None:
            status: Status = "failed" if point.faults else "evaluated"
            found.append(Finding(status, spec.design(values), point.evaluation))
    return Swept(tuple(found), tuple(errors), tuple(notes))

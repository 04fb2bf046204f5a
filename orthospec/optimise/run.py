"""The main job: from a spec to a finding, whatever happens on the way.

A spec with variables is searched and its best design evaluated; one without is evaluated. A measure that
fails is named and left out, and the rest is still told.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from orthospec.errors import PluginFault
from orthospec.optimise.appraise import Appraisal, appraised, asked, asked_of_found, coarser_notes, error_of
from orthospec.optimise.attain import REFIT, Attained, Refuted
from orthospec.optimise.branch import beside_choices, catalogues, hunt_branches
from orthospec.optimise.card import find_card
from orthospec.optimise.explore import COARSE
from orthospec.optimise.further import Swept, front_of, sweep_of
from orthospec.optimise.limits import find_conflicts, find_limits
from orthospec.optimise.proofs import proved, refuting_poses
from orthospec.optimise.slabs import Slabs
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.status import attainment_of, status_of
from orthospec.optimise.tasks import Stopped, Task, machine_and_measures
from orthospec.optimise.workers import Here, Workers, in_order
from orthospec.result import (
    Card,
    Finding,
    FrontSearch,
    Limit,
    Note,
    Search,
    Status,
)
from orthospec.spec import Design, ProofKeys, Spec
from orthospec.workspace.evaluate import Evaluation, Largest, Prescribed
from orthospec.workspace.field import fields

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.workspace.cuboid import Cuboid
    from orthospec.workspace.field import Progress

REFITS = 5
"""How often a design that a proof refutes is solved on."""

T = TypeVar("T")


@dataclass
class Outcome:
    """A finding, and the log of how it came about."""

    finding: Finding
    log: dict[str, Any] = field(default_factory=dict)
    interrupted: bool = False


class _Clock:
    """Wall times of the stages, for the log."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def time(self, stage: str, work: Callable[[], T]) -> T:
        start = time.perf_counter()
        try:
            return work()
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


def evaluate_spec(
    spec: Spec,
    values: Mapping[str, float] | None = None,
    *,
    progress: Progress | None = None,
    workers: Workers | None = None,
) -> Outcome:
    """Evaluate one design: at these values of the variables, else at their start.

    Raises UnbuildableDesign where there is no machine at the values.
    """
    clock, space, doing = _Clock(), DesignSpace(spec), workers or Here()
    design = spec.design(spec.default_values() if values is None else values)
    one = asked(design, spec.workspace.divisions)
    evaluation, known = clock.time("evaluate", lambda: appraised(doing, space, one, progress))
    sweep = clock.time("sweep", lambda: sweep_of(space, design, doing, progress))
    status: Status = "failed" if known.faults else "evaluated"
    attainment = attainment_of(design, evaluation)
    errors = (*known.errors, *sweep.errors)
    notes = (*_notes_of(spec), *sweep.notes)
    finding = Finding(status, design, evaluation, attainment, sweep=sweep.points, errors=errors, notes=notes)
    return Outcome(finding, {"seconds": clock.seconds})


def solve(spec: Spec, *, progress: Progress | None = None, workers: Workers | None = None) -> Outcome:
    """Find the design that attains the spec's goals, or the best compromise; say what limits it.

    ``workers`` do what is independent: this process if none are given.
    """
    doing = workers or Here()
    if not spec.variables:
        outcome = evaluate_spec(spec, progress=progress, workers=doing)
        if spec.proof is None:
            return outcome
        return with_proof(spec, outcome, spec.proof, progress=progress, workers=doing)
    clock = _Clock()
    try:
        branches = clock.time("optimise", lambda: hunt_branches(spec, doing, progress))
    except PluginFault as fault:
        outcome = evaluate_spec(spec, progress=progress, workers=doing)
        unique = tuple(dict.fromkeys([error_of(fault), *outcome.finding.errors]))
        return Outcome(replace(outcome.finding, status="failed", errors=unique), outcome.log)
    (space, found), stopped = branches.best, branches.interrupted
    best = found.best
    if best is not None and not stopped:
        try:
            best = beside_choices(space, best, doing, progress)
        except KeyboardInterrupt:
            stopped = True
    ending = _measured(space, best, doing, clock, progress, stopped)
    best, design, evaluation, known, stopped = ending
    attainment = attainment_of(design, evaluation)
    status = "unfinished" if stopped else status_of(best, evaluation, attainment, known.faults)
    infeasible = status == "infeasible"
    limits: tuple[Limit, ...] = ()
    card: Card | None = None
    front: tuple[Finding, ...] = ()
    front_search: FrontSearch | None = None
    sweep = Swept()
    try:
        limits = clock.time("limits", lambda: _limits(space, best, status, doing, progress))
        if best is not None and not best.feasible and status == "infeasible":
            card = clock.time("card", lambda: find_card(space, best.end, limits, doing, progress))
        if spec.pareto is not None and status in ("attained", "compromise"):
            front, front_search = clock.time("pareto", lambda: front_of(spec, doing, progress))
        if not stopped:
            sweep = clock.time("sweep", lambda: sweep_of(space, design, doing, progress))
    except KeyboardInterrupt as stop:
        stopped, status = True, "unfinished"
        card = stop.made if isinstance(stop, Stopped) and isinstance(stop.made, Card) else card
    search = Search(
        *branches.searched,
        best.subproblems if best is not None else 0,
        None if best is None or best.feasible else float(best.violation),
        _conflicts(best, limits) if infeasible else (),
        card,
        branches.combinations,
        branches.records(),
        front_search if catalogues(spec) else None,
        best.taken if best is not None else (),
    )
    errors = [*known.errors, *sweep.errors, *(error for point in front for error in point.errors)]
    notes = [
        *_notes_of(spec),
        *_notes_on(spec, best),
        *known.notes,
        *sweep.notes,
        *(note for point in front for note in point.notes),
    ]
    finding = Finding(
        status,
        design,
        evaluation,
        attainment,
        limits,
        search,
        sweep.points,
        tuple(dict.fromkeys(errors)),
        tuple(dict.fromkeys(notes)),
        front,
    )
    return Outcome(finding, {"seconds": clock.seconds, "solves": branches.history()}, stopped)


def _notes_of(spec: Spec) -> list[Note]:
    """What is odd about the spec itself."""
    return [Note("variables", odd.place, odd.message) for odd in spec.oddities()]


def _notes_on(spec: Spec, best: Attained | None) -> list[Note]:
    """That the solve which was kept did not come to its end."""
    if best is None or not best.exhausted:
        return []
    said = (
        f"given up after {best.subproblems} subproblems, on the way: designs near it may be better, and"
        " prices are not known; start from it, or give more starts"
    )
    return [Note("optimise", spec.place(("optimise",)), said)]


class _Ending(NamedTuple):
    """The end of a search, measured."""

    best: Attained | None
    design: Design
    evaluation: Evaluation
    known: Appraisal
    stopped: bool


def _measured(
    space: DesignSpace,
    best: Attained | None,
    workers: Workers,
    clock: _Clock,
    progress: Progress | None,
    stopped: bool,
) -> _Ending:
    """The best design, or the spec's own, measured and proved.

    Where the proof finds a pose at which it does not hold, the search goes on from there with that pose.
    """
    spec, poses = space.spec, tuple[tuple[float, ...], ...]()
    prove = partial(proved, workers, space, keys=spec.proof, progress=progress) if spec.proof else None
    for left in reversed(range(REFITS + 1)):
        design = space.design(best.end.design) if best else spec.design(spec.default_values())
        prescribed = best.end.cuboids(space) if best else None
        if stopped:
            return _Ending(best, design, *_quickly(space, design, prescribed), stopped=True)
        one = asked_of_found(space, design, spec.workspace.divisions, prescribed)
        try:
            evaluation, known = clock.time("evaluate", partial(appraised, workers, space, one, progress))
            known = replace(known, notes=coarser_notes(space, one))
        except KeyboardInterrupt:
            return _Ending(best, design, *_quickly(space, design, prescribed), stopped=True)
        if prove is None:
            break
        try:
            prescribed_alone = partial(prove, [(design, evaluation)], of=(Prescribed,))
            (evaluation,) = clock.time("proof", prescribed_alone)
            found = refuting_poses(evaluation)
            if not (left and found and best and best.feasible):
                the_others = partial(prove, [(design, evaluation)], of=(Largest,))
                (evaluation,) = clock.time("proof", the_others)
                break
            poses = (*poses, *found)
            again = [Refuted(best, poses)]
            (best,) = clock.time("optimise", partial(in_order, workers, REFIT, space, again, progress))
        except KeyboardInterrupt:
            return _Ending(best, design, evaluation, known, stopped=True)
    return _Ending(best, design, evaluation, known, stopped=False)


def _quickly(
    space: DesignSpace, design: Design, prescribed: Mapping[str, Cuboid] | None
) -> tuple[Evaluation, Appraisal]:
    """A design measured on a coarse grid, here, where a run is stopped."""
    divisions = min(space.spec.workspace.divisions, COARSE)
    return appraised(Here(), space, asked_of_found(space, design, divisions, prescribed))


def with_proof(
    spec: Spec,
    outcome: Outcome,
    keys: ProofKeys,
    *,
    progress: Progress | None = None,
    workers: Workers | None = None,
) -> Outcome:
    """An outcome with a proof beside each cuboid of its design; Ctrl-C leaves it out."""
    clock, finding = _Clock(), outcome.finding
    point = [(finding.design, finding.evaluation)]
    work = partial(proved, workers or Here(), DesignSpace(spec), point, keys, progress)
    try:
        (evaluation,) = clock.time("proof", work)
    except KeyboardInterrupt:
        return replace(outcome, finding=replace(finding, status="unfinished"), interrupted=True)
    outcome.log.setdefault("seconds", {}).update(clock.seconds)
    attainment = attainment_of(finding.design, evaluation)
    return replace(outcome, finding=replace(finding, evaluation=evaluation, attainment=attainment))


def fields_of(
    spec: Spec, design: Design, *, progress: Progress | None = None, workers: Workers | None = None
) -> dict[str, Array]:
    """The measures' values on the spec's grid at a design, with the nodes' coordinates by axis."""
    one = tuple(design.values.values())
    (found,) = in_order(workers or Here(), FIELDS, DesignSpace(spec), [one], progress)
    return found


def _fields(
    space: DesignSpace, values: tuple[float, ...], progress: Progress | None = None
) -> dict[str, Array]:
    design = space.spec.design(dict(zip(space.spec.variables, values, strict=True)))
    slabs = Slabs(space, values)
    grid = slabs.grid(design.manipulator)
    return fields(design.manipulator, design.demands, grid, progress, slabs)


FIELDS = Task("grid", _fields, machine_and_measures, keeps_parts=True, divides=True)


def _limits(
    space: DesignSpace,
    best: Attained | None,
    status: Status,
    workers: Workers,
    progress: Progress | None,
) -> tuple[Limit, ...]:
    if best is None or status not in ("attained", "compromise", "infeasible"):
        return ()
    if status == "infeasible":
        return find_conflicts(space, best)
    return find_limits(space, best, workers, progress)


def _conflicts(best: Attained | None, limits: tuple[Limit, ...]) -> tuple[str, ...]:
    """Each thing that conflicts, named as the spec names it."""
    if best is None:
        return ("at none of these designs does the machine reach the poses of any cuboid to start from",)
    words = {"at_least": "least", "at_most": "greatest"}
    found = []
    for limit in limits:
        side = words.get(limit.side or "", "")
        found.append(
            {
                "bound": f"measure {limit.name}: {limit.side}",
                "joint": f"reach: {limit.name}" + (f", {limit.side}" if side else ""),
                "variable": f"variable {limit.name}: its {side} value",
                "goal": f"goal {limit.name}: a hard bound",
            }[limit.kind]
        )
    return tuple(found)

"""The main job: from a spec to a finding, whatever happens on the way.

A spec with variables is searched and its best design evaluated; one without is evaluated. A measure that
fails is named and left out, and the rest is still told.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from orthospec.errors import OrthospecError, PluginFault
from orthospec.optimise.attain import Attained, hunt
from orthospec.optimise.card import find_card
from orthospec.optimise.explore import COARSE
from orthospec.optimise.limits import find_conflicts, find_limits
from orthospec.optimise.objective import goal_values
from orthospec.optimise.space import DesignSpace, machine_of, setting_of
from orthospec.optimise.workers import Here, Workers
from orthospec.result import Attainment, Card, Finding, GoalOutcome, Limit, PluginError, Search, Status
from orthospec.spec import Design, Goal, Spec
from orthospec.workspace.evaluate import Evaluation, Setting, evaluate
from orthospec.workspace.field import fields
from orthospec.workspace.grid import make_grid

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.workspace.cuboid import Cuboid
    from orthospec.workspace.field import Progress

ATTAINED = 1e-9
"""A goal counts as attained within this, relative."""

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
    spec: Spec, values: Mapping[str, float] | None = None, *, progress: Progress | None = None
) -> Outcome:
    """Evaluate one design: at these values of the variables, else at their start.

    Raises UnbuildableDesign where there is no machine at the values.
    """
    clock = _Clock()
    design = spec.design(spec.default_values() if values is None else values)
    evaluation, faults = clock.time("evaluate", lambda: _evaluate(design, setting_of(spec), None, progress))
    sweep, left_out = clock.time("sweep", lambda: _sweep(spec, design, progress))
    status: Status = "failed" if faults else "evaluated"
    attainment = _attainment(design, evaluation)
    errors = (*faults, *_failed_nodes(evaluation), *left_out)
    finding = Finding(status, design, evaluation, attainment, sweep=sweep, errors=errors)
    return Outcome(finding, {"seconds": clock.seconds})


def solve(spec: Spec, *, progress: Progress | None = None, workers: Workers | None = None) -> Outcome:
    """Find the design that attains the spec's goals, or the best compromise; say what limits it."""
    if not spec.variables:
        return evaluate_spec(spec, progress=progress)
    clock, space, doing = _Clock(), DesignSpace(spec), workers or Here()
    try:
        found = clock.time("optimise", lambda: hunt(space, doing, progress))
    except PluginFault as fault:
        outcome = evaluate_spec(spec, progress=progress)
        errors = (_error(fault), *outcome.finding.errors)
        unique = tuple(dict.fromkeys(errors))
        return Outcome(replace(outcome.finding, status="failed", errors=unique), outcome.log)
    best, stopped = found.best, found.interrupted
    design = space.design(best.end.design) if best is not None else spec.design(spec.default_values())
    prescribed = best.end.cuboids(space) if best is not None else None
    try:
        setting = setting_of(spec) if not stopped else _quick(spec)
        evaluation, faults = clock.time("evaluate", lambda: _evaluate(design, setting, prescribed, progress))
    except KeyboardInterrupt:
        stopped = True
        evaluation, faults = _evaluate(design, _quick(spec), prescribed, None)
    attainment = _attainment(design, evaluation)
    status = "unfinished" if stopped else _status(best, evaluation, attainment, faults)
    limits: tuple[Limit, ...] = ()
    card: Card | None = None
    sweep: tuple[Finding, ...] = ()
    left_out: tuple[PluginError, ...] = ()
    try:
        limits = clock.time("limits", lambda: _limits(space, best, status, progress))
        if best is not None and not best.feasible and status == "infeasible":
            card = clock.time("card", lambda: _card(space, best, limits, progress))
        if not stopped:
            sweep, left_out = clock.time("sweep", lambda: _sweep(spec, design, progress))
    except KeyboardInterrupt:
        stopped, status = True, "unfinished"
    search = Search(
        found.designs,
        len(found.solved),
        best.subproblems if best is not None else 0,
        None if best is None or best.feasible else float(best.violation),
        _conflicts(best, limits) if status == "infeasible" else (),
        card,
    )
    errors = (*faults, *_failed_nodes(evaluation), *left_out)
    finding = Finding(status, design, evaluation, attainment, limits, search, sweep, errors)
    return Outcome(finding, {"seconds": clock.seconds, "solves": found.history(space)}, stopped)


def fields_of(spec: Spec, design: Design) -> dict[str, Array]:
    """The measures' values on the spec's grid at a design, with the nodes' coordinates by axis."""
    setting = setting_of(spec)
    grid = make_grid(design.manipulator, setting.size, setting.divisions, setting.region)
    return fields(design.manipulator, design.demands, grid)


def _quick(spec: Spec) -> Setting:
    """The spec's workspace on a coarse grid: someone who pressed Ctrl-C does not want to wait."""
    setting = setting_of(spec)
    return replace(setting, divisions=min(setting.divisions, COARSE))


def _status(
    best: Attained | None,
    evaluation: Evaluation,
    attainment: Attainment | None,
    faults: tuple[PluginError, ...],
) -> Status:
    if faults:
        return "failed"
    if best is None or not best.feasible or not evaluation.holds:
        return "infeasible"
    goals = attainment.goals.values() if attainment is not None else ()
    return "attained" if all(goal.attained for goal in goals) else "compromise"


def _evaluate(
    design: Design,
    setting: Setting,
    prescribed: Mapping[str, Cuboid] | None,
    progress: Progress | None,
) -> tuple[Evaluation, tuple[PluginError, ...]]:
    """Evaluate a design; a measure that fails is left out and named."""
    faults: list[PluginError] = []
    machine = machine_of(design)
    while True:
        try:
            evaluation = evaluate(machine, setting, prescribed, progress)
        except PluginFault as fault:
            kept = {name: d for name, d in machine.demands.items() if d.place != fault.place}
            if len(kept) == len(machine.demands):
                raise
            faults.append(_error(fault))
            machine = replace(machine, demands=kept)
            continue
        return evaluation, tuple(faults)


def _failed_nodes(evaluation: Evaluation) -> tuple[PluginError, ...]:
    """Nodes where a measure gave NaN: told with the first pose of each measure, but no failure of the run."""
    return tuple(
        PluginError(failure.measure, failure.place, f"gave NaN at the reachable pose {list(failure.pose)}")
        for failure in evaluation.failures
    )


def _error(fault: PluginFault) -> PluginError:
    return PluginError(fault.plugin, fault.place, fault.what)


def _attainment(design: Design, evaluation: Evaluation) -> Attainment | None:
    """λ and each goal's value; a goal that names a measure left out has no value and is not attained."""
    if not design.goals:
        return None
    values = goal_values(design, evaluation)
    goals = {goal.name: _outcome(goal, values[goal.name]) for goal in design.goals}
    gaps = [_gap(goal, values[goal.name]) / goal.weight for goal in design.goals if goal.weight > 0]
    return Attainment(float(max(gaps)) if gaps and np.isfinite(gaps).all() else None, goals)


def _gap(goal: Goal, value: float) -> float:
    """How far a goal is missed; negative where it is over-attained."""
    gap = value - goal.goal
    return {"minimise": gap, "maximise": -gap, "match": abs(gap)}[goal.sense]


def _outcome(goal: Goal, value: float) -> GoalOutcome:
    attained = _gap(goal, value) <= ATTAINED * (abs(goal.goal) or 1.0)
    return GoalOutcome(value, goal.goal, goal.weight, bool(attained))


def _limits(
    space: DesignSpace, best: Attained | None, status: Status, progress: Progress | None
) -> tuple[Limit, ...]:
    if best is None or status not in ("attained", "compromise", "infeasible"):
        return ()
    if progress is not None:
        progress("what limits it", 0, 0)
    find = find_conflicts if status == "infeasible" else find_limits
    return find(space, best)


def _card(space: DesignSpace, best: Attained, limits: tuple[Limit, ...], progress: Progress | None) -> Card:
    if progress is not None:
        progress("what would have to give way", 0, 0)
    return find_card(space, best.end, limits)


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


def _sweep(
    spec: Spec, design: Design, progress: Progress | None
) -> tuple[tuple[Finding, ...], tuple[PluginError, ...]]:
    """The design evaluated along one variable, the others as they are; and the points that cannot be.

    A point without a machine, or whose reach cannot be found, must not lose the rest.
    """
    if spec.sweep is None:
        return (), ()
    found, left_out = [], []
    variable = spec.sweep.variable
    values = np.linspace(spec.sweep.start, spec.sweep.stop, spec.sweep.points)
    for k, value in enumerate(map(float, values)):
        if progress is not None:
            progress("sweep", k, len(values))
        try:
            here = spec.design({**design.values, variable: value})
            evaluation, faults = _evaluate(here, setting_of(spec), None, None)
        except OrthospecError as error:
            left_out.append(
                PluginError("sweep", spec.place(("sweep",)), f"at {variable} = {value:g}: {error}")
            )
            continue
        errors = (*faults, *_failed_nodes(evaluation))
        found.append(Finding("failed" if faults else "evaluated", here, evaluation, errors=errors))
    return tuple(found), tuple(left_out)

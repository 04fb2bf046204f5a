"""What became of a design's bounds and goals."""

from __future__ import annotations

import numpy as np

from orthospec.optimise.attain import Attained
from orthospec.optimise.objective import goal_values
from orthospec.result import Attainment, GoalOutcome, PluginError, Status
from orthospec.spec import Design, Goal
from orthospec.workspace.evaluate import Evaluation

ATTAINED = 1e-9
"""A goal counts as attained within this, relative."""


def status_of(
    best: Attained | None,
    evaluation: Evaluation,
    attainment: Attainment | None,
    faults: tuple[PluginError, ...],
) -> Status:
    """How a search ended."""
    if faults:
        return "failed"
    if best is None or not best.feasible or not evaluation.holds:
        return "infeasible"
    goals = attainment.goals.values() if attainment is not None else ()
    return "attained" if all(goal.attained for goal in goals) else "compromise"


def attainment_of(design: Design, evaluation: Evaluation) -> Attainment | None:
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

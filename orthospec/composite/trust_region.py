"""Convex-composite minimisation: a trust region over convex subproblems.

    minimise  factor(x)    subject to    convex sets of smooth functions of x

Merit is factor + penalty·violation, with the violation the worst over everything that must hold (for a
cuboid: over all of its poses, not the critical points alone) and infinite where x cannot be evaluated. Each
subproblem keeps the convex parts and an elastic slack, so it is always feasible. A vertex optimum is reached
at first order; smooth trade-offs need curvature: a second-order correction where the actual reduction
disappoints, and the positive part of the Lagrangian's Hessian (Fletcher, *Practical Methods of Optimization*,
1987, ch. 14; Conn, Gould and Toint, *Trust-Region Methods*, 2000, ch. 15).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Protocol

import numpy as np

from orthospec.composite.curvature import binding_gradients, bound_gradients, convex_part, directions
from orthospec.composite.differences import hessian, jacobian
from orthospec.composite.subproblem import Rows, Step, solve

if TYPE_CHECKING:
    from orthospec.arrays import Array

FEASIBLE = 1e-9
"""A violation up to this (relative) counts as none."""
SETTLED = 5e-10
"""The loop ends when a subproblem predicts less gain than this."""
ACCEPTABLE = 1e-4
"""The part of the predicted gain that a step must bring to be accepted."""
SHARP = 1e-8
"""Steps shorter than this sharpen x no more."""
SHARPENINGS = 2
"""Most steps that only sharpen x."""
RADIUS = (0.2, 1.0, 1e-10)
"""First, greatest and least trust radius, in scaled variables."""
SHRINK = (0.1, 0.4)
"""Least and greatest part of a step's length to which the radius shrinks after it."""
PENALTY = (10.0, 1e6)
"""Least and greatest penalty; factors are scaled to be of order 1."""
NEARER = 0.5
"""The part of the way to feasibility that can be gone which a step must go, or the penalty rises."""
STUCK = 0.01
"""Where no step is nearer by this part of the violation, for a length of 1, feasibility is sought alone."""
DAMPING = 1e-9
"""A trace of curvature, so that a flat optimum has one answer."""


@dataclass(frozen=True)
class Assessment:
    """What a point is worth; x may come back with its dependent variables (extremes) made exact."""

    x: Array
    factor: float
    violation: float


class Problem(Protocol):
    """Scaled variables x in [lower, upper]; over ``scale`` of a variable the functions change."""

    lower: Array
    upper: Array
    scale: Array
    has_factor: bool
    """Whether there is a factor to minimise; without one any feasible point is a solution."""

    def assess(self, x: Array) -> Assessment:
        """Judge x truly; new critical points join the problem. Violation inf where it cannot be evaluated."""

    def rows(self, x: Array) -> Rows:
        """The shape of the subproblem at x."""

    def smooth(self, points: Array, rows: Rows) -> Array:
        """w at each point (k, n) -> (k, t); NaN rows where a point cannot be evaluated."""

    def drift(self, x: Array, rows: Rows, step: Step) -> Array:
        """Curvature (n, n) that is not in w, since the rows themselves move with x; multipliers of a step."""


class Ending(Enum):
    """How the loop ended; each text says what to do about it."""

    SOLVED = "solved"
    INFEASIBLE = "no nearby point meets all bounds: loosen one that conflicts, or widen a variable"
    STALLED = "the start, or a subproblem, cannot be evaluated: try another start"
    EXHAUSTED = "the limit of subproblems is reached: raise it, or try another start"


@dataclass(frozen=True)
class Iterate:
    """One accepted or refused step, for the log."""

    subproblems: int
    factor: float
    violation: float
    radius: float
    penalty: float
    accepted: bool


@dataclass(frozen=True)
class Solution:
    """Where the loop ended, with the last subproblem's rows and multipliers."""

    x: Array
    factor: float
    violation: float
    ending: Ending
    subproblems: int
    history: tuple[Iterate, ...]
    rows: Rows | None
    step: Step | None


@dataclass
class _State:
    """What one pass of the loop hands to the next."""

    here: Assessment
    radius: float = RADIUS[0]
    penalty: float = PENALTY[0]
    weight: float = 1.0
    """1 while the factor counts, 0 while only feasibility is sought."""
    subproblems: int = 0
    rows: Rows | None = None
    step: Step | None = None
    curvature: Array | None = None
    sharpened: int = 0
    feasible: Assessment | None = None
    """The best point so far at which everything holds."""
    history: list[Iterate] = field(default_factory=list)

    @property
    def settled(self) -> float:
        """The gain in merit that is none: relative to the factor while it counts, else to feasibility."""
        return SETTLED * max(1.0, abs(self.here.factor)) if self.weight else 0.1 * FEASIBLE

    def merit(self, assessment: Assessment) -> float:
        """Weight·factor + penalty·violation."""
        if not np.isfinite(assessment.violation):
            return np.inf
        return self.weight * assessment.factor + self.penalty * max(assessment.violation, 0.0)

    def move(self, to: Assessment) -> None:
        """Go to a point."""
        self.here = to
        if to.violation <= FEASIBLE and (self.feasible is None or to.factor < self.feasible.factor):
            self.feasible = to

    def record(self, accepted: bool) -> None:
        """Note the step just judged."""
        here = self.here
        self.history.append(
            Iterate(self.subproblems, here.factor, here.violation, self.radius, self.penalty, accepted)
        )


@dataclass(frozen=True)
class _Model:
    """The problem linearised at a point, with the curvature of its Lagrangian."""

    problem: Problem
    x: Array
    rows: Rows
    w: Array
    slopes: Array
    curvature: Array

    def smooth(self, points: Array) -> Array:
        return self.problem.smooth(points, self.rows)

    def solve(self, state: _State, w: Array) -> Step | None:
        """The subproblem with w in the place of the values at x."""
        state.subproblems += 1
        box = self._box(state)
        return solve(self.rows, w, self.slopes, self.curvature, *box, state.penalty, state.weight)

    def least_slack(self, state: _State) -> float:
        """The least slack of any step, whatever the factor; 0 where the solver found no step."""
        state.subproblems += 1
        bare = DAMPING * np.eye(len(self.x))
        step = solve(self.rows, self.w, self.slopes, bare, *self._box(state), 1.0, 0.0)
        return 0.0 if step is None else max(step.slack, 0.0)

    def merit(self, state: _State, step: Step) -> float:
        """The merit that the model foretells for a step."""
        factor = state.weight * step.factor if state.weight else 0.0
        bend = 0.5 * float(step.delta @ self.curvature @ step.delta)
        return factor + state.penalty * max(step.slack, 0.0) + bend

    def _box(self, state: _State) -> tuple[Array, Array]:
        """Least and greatest step."""
        lower = np.maximum(self.problem.lower - self.x, -state.radius)
        return lower, np.minimum(self.problem.upper - self.x, state.radius)

    def at(self, step: Step) -> Array:
        """Where a step leads."""
        return np.clip(self.x + step.delta, self.problem.lower, self.problem.upper)

    def bend(self, step: Step, x: Array) -> Array:
        """A convex stand-in for the Lagrangian's Hessian at x, with a step's multipliers; 0 at a vertex."""
        problem = self.problem
        held = bound_gradients(step, x, problem.lower, problem.upper)
        along, across = directions(np.vstack([binding_gradients(self.rows, self.slopes, step), held]))
        if not along.shape[1] and step.slack <= FEASIBLE:
            return np.zeros((len(x), len(x)))
        seen = hessian(self.smooth, step.multipliers, x, problem.scale, problem.lower, problem.upper)
        return convex_part(seen + problem.drift(x, self.rows, step), along, across)


def minimise(
    problem: Problem,
    start: Array,
    *,
    most: int = 200,
    radius: float = RADIUS[0],
    on_iterate: Callable[[Assessment, Iterate], None] | None = None,
) -> Solution:
    """Minimise the factor from ``start``; no step is begun after ``most`` subproblems.

    ``on_iterate`` is called after each step with the current point: a caller stopped by Ctrl-C has it.
    """
    state = _State(problem.assess(np.asarray(start, dtype=float)), radius=radius)
    state.weight = float(problem.has_factor)
    state.move(state.here)
    ending = None if np.isfinite(state.here.violation) else Ending.STALLED
    while ending is None:
        told = len(state.history)
        ending = _pass(problem, state) if state.subproblems < most else Ending.EXHAUSTED
        if on_iterate and len(state.history) > told:
            on_iterate(state.here, state.history[-1])
    if state.here.violation > FEASIBLE and state.feasible is not None:
        # Better a feasible point that was left for a better merit than a worse one that is not feasible.
        ending = ending if ending is Ending.EXHAUSTED else Ending.STALLED
        state.here = state.feasible
    here = state.here
    return Solution(
        here.x,
        here.factor,
        here.violation,
        ending,
        state.subproblems,
        tuple(state.history),
        state.rows,
        state.step,
    )


def _pass(problem: Problem, state: _State) -> Ending | None:
    """One step of the loop; an Ending when it is the last."""
    model = _linearised(problem, state)
    if model is None:
        return Ending.STALLED
    step = model.solve(state, model.w)
    if step is None:
        return _shrink(state, state.radius)
    if state.weight and step.slack > FEASIBLE:
        step = _steered(model, state, step)
        if step is None:
            return _settle(problem, state)
    state.rows, state.step = model.rows, step
    predicted = state.merit(state.here) - model.merit(state, step)
    if predicted < -state.settled:
        again = problem.assess(model.x)
        if again.violation > state.here.violation + SETTLED:
            # Points that a trial elsewhere brought to light are worse here than what was known of here.
            state.here, state.feasible = again, None
            return None
    if predicted <= state.settled:
        return None if _sharpen(model, state, step) else _settle(problem, state)
    return _judge(model, state, *_try(model, state, step, predicted), predicted)


def _steered(model: _Model, state: _State, step: Step) -> Step | None:
    """A step with slack, or one of a larger penalty where that may come much nearer to feasibility.

    How near the model lets any step come is asked first, for where that is hardly nearer no penalty is large
    enough: None then (Byrd, Nocedal and Waltz, *Steering exact penalty methods for nonlinear programming*,
    Optimization Methods and Software 23, 2008).
    """
    violation, least = state.here.violation, 0.0
    if violation > FEASIBLE:
        least = model.least_slack(state)
        if violation - least <= max(SETTLED, STUCK * violation * min(state.radius, 1.0)):
            return None
    if violation - step.slack < NEARER * (violation - least) and state.penalty < PENALTY[1]:
        state.penalty = min(10 * state.penalty, PENALTY[1])
        return model.solve(state, model.w) or step
    return step


def _linearised(problem: Problem, state: _State) -> _Model | None:
    """The model at the current point; None where a derivative cannot be had."""
    x = state.here.x
    rows = problem.rows(x)
    w, slopes = jacobian(
        lambda points: problem.smooth(points, rows), x, problem.scale, problem.lower, problem.upper
    )
    if not np.isfinite(slopes).all():
        return None
    curvature = DAMPING * np.eye(len(x)) + (0.0 if state.curvature is None else state.curvature)
    return _Model(problem, x, rows, w, slopes, curvature)


def _try(model: _Model, state: _State, step: Step, predicted: float) -> tuple[Assessment, Step]:
    """The trial point of a step; where it disappoints, its second-order correction if that is better."""
    trial = model.problem.assess(model.at(step))
    gain = state.merit(state.here) - state.merit(trial)
    if gain >= 0.75 * predicted or not np.isfinite(trial.violation):
        return trial, step
    moved = model.smooth(trial.x[None])[0]
    corrected = (
        model.solve(state, moved - model.slopes @ (trial.x - model.x)) if np.isfinite(moved).all() else None
    )
    if corrected is None:
        return trial, step
    second = model.problem.assess(model.at(corrected))
    return (second, corrected) if state.merit(second) < state.merit(trial) else (trial, step)


def _sharpen(model: _Model, state: _State, step: Step) -> bool:
    """Take a step that promises nothing, unless it does harm; whether another one may pay.

    Where the merit is flat its rounding tells nothing of x, but Newton's step still does.
    """
    last = model.problem.assess(model.at(step))
    harm = last.factor - state.here.factor
    if last.violation > max(state.here.violation, 0.1 * FEASIBLE) or harm > state.settled:
        state.record(accepted=False)
        return False
    state.move(last)
    state.record(accepted=True)
    state.curvature = model.bend(step, last.x)
    state.sharpened += 1
    return state.sharpened < SHARPENINGS and float(np.max(np.abs(step.delta))) > SHARP


def _judge(model: _Model, state: _State, trial: Assessment, step: Step, predicted: float) -> Ending | None:
    """Accept or refuse a trial point; adapt radius, penalty and curvature."""
    ratio = (state.merit(state.here) - state.merit(trial)) / predicted
    length = float(np.max(np.abs(step.delta)))
    if ratio > ACCEPTABLE:
        state.move(trial)
        state.curvature = model.bend(step, trial.x)
    state.record(accepted=ratio > ACCEPTABLE)
    if ratio > 0.75 and length > 0.9 * state.radius:
        state.radius = min(2.5 * state.radius, RADIUS[1])
    elif ratio < 0.25 and _shrink(state, min(length, state.radius), ratio):
        return _settle(model.problem, state)
    if not state.weight and state.here.violation <= FEASIBLE:
        return _settle(model.problem, state)
    _lower_penalty(state, step)
    return None


def _shrink(state: _State, length: float, ratio: float = 0.0) -> Ending | None:
    """To where a parabola through the merit and its slope here has its least."""
    state.radius = min(max(0.5 / (1 - ratio), SHRINK[0]), SHRINK[1]) * length
    return Ending.STALLED if state.radius < RADIUS[2] else None


def _lower_penalty(state: _State, step: Step) -> None:
    """Lower it towards the pressure: too large stalls.

    Without slack it is large enough, however much pressure there is: where bounds leave no room against each
    other, their multipliers have no limit and take what the penalty allows.
    """
    if state.weight and step.slack <= FEASIBLE:
        state.penalty = max(min(state.penalty, 10 * step.pressure), PENALTY[0])


def _settle(problem: Problem, state: _State) -> Ending | None:
    """Nothing more to gain: done; or seek feasibility alone; or, feasible again, return to the factor."""
    feasible = state.here.violation <= FEASIBLE
    if feasible and (state.weight or not problem.has_factor):
        return Ending.SOLVED
    if not feasible and not state.weight:
        return Ending.INFEASIBLE
    state.weight, state.penalty = (1.0, PENALTY[1]) if feasible else (0.0, 1.0)
    state.radius, state.curvature = RADIUS[0], None
    return None

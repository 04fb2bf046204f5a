"""Whether a spec's machine and measures can be built: at the start, or somewhere in the variables' box."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel

from orthospec.errors import RAISED, PluginFault
from orthospec.quantities import Expression, ExpressionError
from orthospec.quantities.fields import is_quantity, read
from orthospec.spec.blueprint import Blueprint, Refused, booleans_as_numbers
from orthospec.spec.design import Variable
from orthospec.spec.draft import Draft
from orthospec.spec.model import ManipulatorKeys, MeasureKeys
from orthospec.spec.plans import DemandPlan, GoalPlan
from orthospec.spec.wording import ABOUT_VALUES, Problem, did_you_mean, known_keys

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator

Built = TypeVar("Built", bound=BaseModel)
_CORNERS, _INSIDE = 64, 16
_GOLDEN = 0.6180339887498949
_SERVED_BY = {
    "compliance": "compliance",
    "joint_inertia": "joint_inertia",
    "actuator_forces": "actuator_limits",
    "actuator_speeds": "actuator_limits",
}
"""The optional method of a machine that serves a measure's need."""


def build(draft: Draft, blueprint: Blueprint[Built], variables: Mapping[str, Variable]) -> Built | None:
    """One instance at the first trial point that the class accepts; mistakes where it accepts none."""
    refused = None
    for values in _points(draft, variables):
        try:
            built = blueprint.build(values)
        except Refused as refusal:
            refused = refused or refusal
            continue
        for path in booleans_as_numbers(blueprint.keys, built.model_dump(by_alias=True)):
            draft.wrong((*blueprint.path, *path), "a number was expected, true or false given")
        return built
    for problem in refused.problems if refused else ():
        _report(draft, blueprint, problem, variables)
    return None


def check_machine(
    draft: Draft, machine: Manipulator, demands: Sequence[DemandPlan], goals: Sequence[GoalPlan]
) -> None:
    """Name what measures and goals need and the machine does not offer, or the spec does not give."""
    for plan in demands:
        for need in sorted(plan.blueprint.made_of.needs):
            _check_need(draft, machine, plan, need)
    for goal in goals:
        for index in sorted(goal.expression.names & machine.index_units.keys()):
            if missing := _missing(draft, machine, index):
                message = f"{index} is not known: give {', '.join(missing)}"
                draft.wrong(("goals", goal.name, goal.sense), message)


def check_goals(draft: Draft, goals: Sequence[GoalPlan], variables: Mapping[str, Variable]) -> None:
    """A mistake for a goal over variables that has no value, or no weight, at any design tried."""
    for plan in goals if draft.names == variables.keys() else ():
        alone, why = plan.depends_on_only(variables.keys()), None
        weighed = plan.goal if plan.weight is None else plan.weight
        for values in _points(draft, variables):
            try:
                if isinstance(weighed, Expression):
                    plan.at(values)
                if alone:
                    plan.expression.value(values)
            except ExpressionError as error:
                why = why or str(error)
            else:
                break
        else:
            draft.wrong(("goals", plan.name), f"{why}, and so at every other design tried", at_key=True)


def check_tolerances(draft: Draft, machine: Manipulator, tolerances: Mapping[str, float]) -> None:
    """A mistake where a number could be off by all that it is: no such machine can be built."""
    for name, tolerance in tolerances.items():
        value = getattr(machine, name)
        least = min(map(abs, value if isinstance(value, tuple) else (value,)))
        if tolerance >= least:
            message = f"less than the field's own {least:g} was expected, {tolerance:g} given"
            draft.wrong(("manipulator", "tolerance", name), message)


def _check_need(draft: Draft, machine: Manipulator, plan: DemandPlan, need: str) -> None:
    what = need.replace("_", " ")
    if not _offers(machine, need):
        message = f"{plan.blueprint.use} needs the machine's {what}, and {_use(draft)} offers none"
    elif need in _SERVED_BY and (missing := _missing(draft, machine, need)):
        message = f"{plan.blueprint.use} needs the machine's {what}: give {', '.join(missing)}"
    else:
        return
    draft.wrong(plan.blueprint.path, message, at_key=True)


def _offers(machine: Manipulator, need: str) -> bool:
    """Whether the machine's class defines the optional method that serves a need."""
    from orthospec.manipulators import Manipulator

    if need == "sliding_joints":
        return set(machine.joint_units) == {"m"}
    method = _SERVED_BY.get(need)
    return method is None or getattr(type(machine), method) is not getattr(Manipulator, method)


def _use(draft: Draft) -> str:
    return draft.keys.manipulator.use or ""


def _missing(draft: Draft, machine: Manipulator, what: str) -> tuple[str, ...]:
    try:
        return machine.missing(what)
    except RAISED as error:
        raise PluginFault(_use(draft), f"missing({what!r}): {error}") from error


def _points(draft: Draft, variables: Mapping[str, Variable]) -> Iterator[dict[str, float]]:
    """The start, corners of the box, and points spread inside it."""
    unknown = dict.fromkeys(draft.names - set(variables), 1.0)
    yield unknown | {name: variable.start for name, variable in variables.items()}
    if not variables:
        return
    corners = itertools.product(*((variable.min, variable.max) for variable in variables.values()))
    for corner in itertools.islice(corners, _CORNERS):
        yield unknown | dict(zip(variables, corner, strict=True))
    for i in range(1, _INSIDE + 1):
        yield unknown | {
            name: variable.min + (variable.max - variable.min) * (i * _GOLDEN ** (k + 1) % 1)
            for k, (name, variable) in enumerate(variables.items())
        }


def _report(
    draft: Draft, blueprint: Blueprint[Any], problem: Problem, variables: Mapping[str, Variable]
) -> None:
    """A mistake, unless it may come from a variable that is itself wrong."""
    names = _names_below(blueprint.keys, problem)
    if names - set(variables) and not names - draft.names:
        return
    message = problem.message
    if problem.kind == "extra_forbidden" and len(problem.path) == 1:
        message = _unknown_key(blueprint, problem.path[0])
    elif names and not names - set(variables) and problem.kind in ABOUT_VALUES:
        message += ", and so at every other design tried"
    draft.wrong((*blueprint.path, *problem.path), message, at_key=problem.at_key)


def _unknown_key(blueprint: Blueprint[Any], key: object) -> str:
    """A key that is neither the plugin's nor one of those that the spec has beside them."""
    of_machine = blueprint.path[0] == "manipulator"
    beside = known_keys(ManipulatorKeys if of_machine else MeasureKeys, ())
    return f"unknown key '{key}'{did_you_mean(key, [*known_keys(blueprint.made_of, ()), *beside])}"


def _names_below(keys: Any, problem: Problem) -> frozenset[str]:
    """The names in the expressions that a problem may come from."""
    for step in problem.path:
        try:
            keys = keys[step]
        except (KeyError, IndexError, TypeError):
            return frozenset()
    if problem.kind in ("missing", "extra_forbidden"):
        return frozenset()
    return frozenset(_names(keys))


def _names(keys: Any) -> Iterator[str]:
    if isinstance(keys, Mapping):
        keys = list(keys.values())
    if isinstance(keys, list):
        for inner in keys:
            yield from _names(inner)
    elif isinstance(keys, str) and not is_quantity(keys):
        try:
            reading = read(keys, None)
        except ExpressionError:
            return
        yield from reading.names if isinstance(reading, Expression) else ()

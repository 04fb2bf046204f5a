"""The measures, bounds and goals of a spec checked against the classes that `use` names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast, get_args

from orthospec.quantities import Expression
from orthospec.quantities.expressions import GOAL_CALLS, Extreme
from orthospec.quantities.fields import is_quantity
from orthospec.quantities.units import UnitError, si_unit
from orthospec.spec.blueprint import Blueprint
from orthospec.spec.design import Sense
from orthospec.spec.document import Path
from orthospec.spec.draft import Draft
from orthospec.spec.model import GoalKeys, MeasureKeys, VariableKeys
from orthospec.spec.plans import DemandPlan, GoalPlan, Reading
from orthospec.spec.wording import did_you_mean

if TYPE_CHECKING:
    from orthospec.measures import Measure

SIDES = ("at_least", "at_most")


def demands(draft: Draft, in_goals: frozenset[str]) -> list[DemandPlan]:
    """The measures whose class is known; ``in_goals`` are those that a goal names."""
    plans = []
    for name, keys in draft.keys.measures.items():
        _check_name(draft, name)
        _check_is_asked(draft, name, keys, in_goals)
        made_of = draft.measures.get(name)
        if made_of is not None:
            plans.append(_demand(draft, name, keys, made_of))
    return plans


def _check_name(draft: Draft, name: str) -> None:
    """A measure's field stands under its name, beside the nodes' coordinates and the ends of two values."""
    axes = draft.machine.axes if draft.machine is not None else ()
    if name in {"end", *axes, *(f"axis_{axis}" for axis in axes)}:
        message = f"'{name}' is a coordinate of the measures' fields; give the measure another name"
        draft.wrong(("measures", name), message, at_key=True)


def _check_is_asked(draft: Draft, name: str, keys: MeasureKeys, in_goals: frozenset[str]) -> None:
    levels = keys.levels and (keys.levels.at_least or keys.levels.at_most)
    if keys.at_least is None and keys.at_most is None and not levels and name not in in_goals:
        message = (
            f"'{name}' asks for nothing: give it 'at_least', 'at_most' or 'levels', or name it in a goal"
        )
        draft.wrong(("measures", name), message, at_key=True)


def _demand(draft: Draft, name: str, keys: MeasureKeys, made_of: type[Measure]) -> DemandPlan:
    path = ("measures", name)
    bounds = _bounds(draft, path, made_of, {side: getattr(keys, side) for side in SIDES})
    levels: list[Mapping[str, Reading]] = []
    for side in SIDES:
        given = getattr(keys.levels, side) if keys.levels else None
        at = (*path, "levels", side)
        if given is None or not _has_side(draft, at, made_of, side):
            continue
        readings = [draft.reading((*at, i), one, made_of.unit) for i, one in enumerate(given)]
        levels.extend({side: reading} for reading in readings if reading is not None)
    own = keys.model_extra or {}
    blueprint = Blueprint(keys.use, made_of, own, path, draft.document.place(path))
    return DemandPlan(name, blueprint, bounds, tuple(levels))


def _bounds(draft: Draft, path: Path, made_of: type[Measure], given: Mapping[str, Any]) -> dict[str, Reading]:
    bounds: dict[str, Reading] = {}
    for side, value in given.items():
        at = (*path, side)
        if value is not None and _has_side(draft, at, made_of, side):
            reading = draft.reading(at, value, made_of.unit)
            if reading is not None:
                bounds[side] = reading
    least, most = bounds.get("at_least"), bounds.get("at_most")
    why = never_met(draft.keys.measures[str(path[1])].use, made_of, most) if isinstance(most, float) else ""
    if why:
        draft.wrong((*path, "at_most"), why)
    if isinstance(least, float) and isinstance(most, float) and least > most:
        draft.wrong((*path, "at_least"), f"at_least {least:g} is above at_most {most:g}: nothing meets both")
    return bounds


def never_met(use: str, made_of: type[Measure], most: float) -> str:
    """Why no machine meets an upper bound on a measure; nothing where one may."""
    if most > made_of.least or most == made_of.least != 0:
        return ""
    return f"{use} is never below {made_of.least:g}: no machine meets at_most {most:g}"


def _has_side(draft: Draft, path: Path, made_of: type[Measure], side: str) -> bool:
    if side in made_of.sides:
        return True
    known = " and ".join(sorted(made_of.sides))
    use = draft.keys.measures[str(path[1])].use
    draft.wrong(path, f"{use} has no '{side}'; it knows {known}", at_key=True)
    return False


def goals(draft: Draft) -> list[GoalPlan]:
    """The goals that are well given."""
    plans = [_goal(draft, name, keys) for name, keys in draft.keys.goals.items()]
    return [plan for plan in plans if plan is not None]


def pareto(draft: Draft, plans: Sequence[GoalPlan]) -> int | None:
    """How many points of a Pareto set are asked for; a mistake where there can be none."""
    keys = draft.keys.pareto
    if keys is None:
        return None
    soft = [plan for plan in plans if plan.is_soft]
    several = len(soft) in (2, 3) or len(plans) < len(draft.keys.goals)
    if not several:
        message = f"a Pareto set is of 2 or 3 goals with weights above 0, {len(soft)} given"
        draft.wrong(("pareto",), message, at_key=True)
    for plan in soft:
        if plan.sense == "match":
            message = "in a Pareto set a goal to match is a hard bound: leave its weight out"
            draft.wrong(("goals", plan.name, "weight"), message)
    if not draft.names:
        draft.wrong(("pareto",), "a Pareto set needs design variables, and the spec has none", at_key=True)
    return keys.points


def measures_in_goals(draft: Draft) -> frozenset[str]:
    """The measures that goals name, also in goals with other mistakes."""
    found: set[str] = set()
    for keys in draft.keys.goals.values():
        for sense in get_args(Sense):
            text = getattr(keys, sense)
            try:
                found |= {extreme.measure for extreme in Expression(text or "0", GOAL_CALLS).extremes}
            except ValueError:
                continue
    return frozenset(found)


def _goal(draft: Draft, name: str, keys: GoalKeys) -> GoalPlan | None:
    path = ("goals", name)
    senses = [sense for sense in get_args(Sense) if getattr(keys, sense) is not None]
    if len(senses) != 1:
        given = " and ".join(senses) or "none of them"
        draft.wrong(path, f"one of minimise, maximise and match was expected, {given} given", at_key=True)
        return None
    sense = cast(Sense, senses[0])
    expression = _aim(draft, (*path, sense), getattr(keys, sense))
    unit = None if expression is None else _unit(draft, expression)
    goal = draft.reading((*path, "goal"), keys.goal, unit)
    weight = _weight(draft, path, keys, goal, unit)
    if expression is None or goal is None:
        return None
    return GoalPlan(name, sense, expression, goal, weight, draft.document.place(path))


def _aim(draft: Draft, path: Path, text: str) -> Expression | None:
    """The goal's expression; None after a mistake."""
    if is_quantity(text):
        draft.wrong(
            path, f"an expression was expected, the quantity '{text}' given; its value stands in 'goal'"
        )
        return None
    try:
        expression = Expression(text, GOAL_CALLS)
    except ValueError as error:
        draft.wrong(path, str(error))
        return None
    if not expression.names and not expression.extremes:
        draft.wrong(
            path, f"'{text}' is a constant: an expression over variables, indices or measures was expected"
        )
        return None
    for name in sorted(expression.names & set(draft.measures) - draft.names):
        draft.wrong(path, f"'{name}' is a measure; write worst({name}), lowest({name}) or highest({name})")
        return None
    known = [_knows_measure(draft, path, extreme) for extreme in sorted(expression.extremes)]
    if draft.machine is not None:
        known.append(draft.knows(path, expression, {*draft.names, *draft.machine.index_units, "scale"}))
    if "scale" in expression.names and not draft.keys.workspace.together:
        draft.wrong(path, "'scale' is that of the joint cuboid, and with 'together: false' there is none")
        return None
    return expression if all(known) else None


def _knows_measure(draft: Draft, path: Path, extreme: Extreme) -> bool:
    name = extreme.measure
    if name not in draft.measures:
        draft.wrong(path, f"unknown measure '{name}' in {extreme.kind}(){did_you_mean(name, draft.measures)}")
        return False
    keys = draft.keys.measures.get(name)
    if extreme.kind == "worst" and keys is not None and (keys.at_least is None) == (keys.at_most is None):
        has = "no bound" if keys.at_least is None else "both bounds"
        draft.wrong(path, f"worst({name}) needs one bound, and {name} has {has}; write lowest() or highest()")
        return False
    return True


def _unit(draft: Draft, expression: Expression) -> str | None:
    """The unit of a goal on one bare name: index, variable, measure, scale; None where none is followed."""
    if expression.text == "scale":
        return "1"
    if draft.machine is not None and expression.text in draft.machine.index_units:
        return draft.machine.index_units[expression.text]
    if expression.text in draft.keys.variables:
        return _unit_of_variable(draft.keys.variables[expression.text])
    for kind, name in expression.extremes:
        made_of = draft.measures.get(name)
        if made_of is not None and expression.text == f"{kind}({name})":
            return made_of.unit
    return None


def _unit_of_variable(keys: VariableKeys) -> str | None:
    """The SI unit of what its values are written in; None where they are plain numbers, or mistaken."""
    for given in (keys.min, keys.max, keys.start, *(keys.choices or ())):
        if isinstance(given, str) and is_quantity(given):
            try:
                return si_unit(given.split()[-1])
            except UnitError:
                return None
    return None


def _weight(
    draft: Draft, path: Path, keys: GoalKeys, goal: Reading | None, unit: str | None
) -> Reading | None:
    at = (*path, "weight")
    if keys.weight is None:
        return 0.0 if keys.match is not None else 1.0
    if keys.weight == "relative":
        if goal == 0:
            draft.wrong(at, "'relative' has no meaning at goal 0; give the weight as a number")
        return None
    if isinstance(keys.weight, str) and keys.weight.isidentifier() and keys.weight not in draft.names:
        known = [*sorted(draft.names), "relative"]
        draft.wrong(at, f"unknown name '{keys.weight}'{did_you_mean(keys.weight, known)}")
        return None
    weight = draft.reading(at, keys.weight, unit)
    if isinstance(weight, float) and weight < 0:
        draft.wrong(at, f"0 or more was expected, {weight:g} given; minimise and maximise tell the sense")
    return weight

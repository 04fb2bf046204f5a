"""What is asked of a design, parsed once: measures with bounds and goals, resolved anew for each design."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from orthospec.quantities import Expression, ExpressionError
from orthospec.spec.blueprint import Blueprint, Refused
from orthospec.spec.design import Goal, Sense

if TYPE_CHECKING:
    from orthospec.measures import Demand, Measure

Reading: TypeAlias = float | Expression
"""A constant in SI, or an expression over the variables."""


def value_at(reading: Reading, values: Mapping[str, float]) -> float:
    """The reading's value at these values of the variables."""
    return reading.value(values) if isinstance(reading, Expression) else reading


@dataclass(frozen=True)
class DemandPlan:
    """One measure of the spec, under the user's name."""

    name: str
    blueprint: Blueprint[Measure]
    bounds: Mapping[str, Reading]
    levels: tuple[Mapping[str, Reading], ...]

    @cached_property
    def _measure(self) -> Measure | None:
        """The measure itself, where its fields do not depend on the variables."""
        try:
            return self.blueprint.build({})
        except Refused:
            return None

    def at(self, values: Mapping[str, float]) -> Demand:
        """The demand on a design at these values; raises `Refused` or `ExpressionError`."""
        from orthospec.measures import Demand, Level

        return Demand(
            name=self.name,
            measure=self._measure or self.blueprint.build(values),
            bounds={side: value_at(bound, values) for side, bound in self.bounds.items()},
            levels=tuple(
                Level({side: value_at(bound, values) for side, bound in level.items()})
                for level in self.levels
            ),
            place=self.blueprint.place,
        )


@dataclass(frozen=True)
class GoalPlan:
    """One goal of the spec; weight None stands for relative, |goal|."""

    name: str
    sense: Sense
    expression: Expression
    goal: Reading
    weight: Reading | None
    place: str

    @property
    def is_soft(self) -> bool:
        """Whether the goal may be missed, at a price."""
        return self.weight is None or isinstance(self.weight, Expression) or self.weight > 0

    def depends_on_only(self, variables: Set[str]) -> bool:
        """Whether the goal is about these variables alone: with them fixed it has one value."""
        read = [one for one in (self.expression, self.goal) if isinstance(one, Expression)]
        return not self.expression.extremes and all(one.names <= variables for one in read)

    def aimed(self, easier: float, weight: float) -> GoalPlan:
        """The same goal, by so much easier, with another weight."""
        by = -easier if self.sense == "maximise" else easier
        moved = (
            self.goal + by if isinstance(self.goal, float) else Expression(f"({self.goal.text}) + ({by!r})")
        )
        return replace(self, goal=moved, weight=weight)

    def at(self, values: Mapping[str, float]) -> Goal:
        """The goal at these values of the variables; raises `ExpressionError`."""
        goal = value_at(self.goal, values)
        weight = abs(goal) if self.weight is None else value_at(self.weight, values)
        if weight < 0 or (weight == 0 and not isinstance(self.weight, float)):
            raise ExpressionError(f"the weight of goal {self.name} is {weight:g} here")
        return Goal(self.name, self.sense, self.expression, goal, weight, self.place)

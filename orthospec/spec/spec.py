"""`Spec`: a checked spec, and `Spec.design`, the machine and what is asked of it at given variables."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from orthospec import registry
from orthospec.errors import Mistake, UnbuildableDesign, UsageError
from orthospec.quantities import Expression, ExpressionError
from orthospec.quantities.fields import read
from orthospec.spec.blueprint import Blueprint, Refused
from orthospec.spec.design import Design, Sweep, Variable, Workspace
from orthospec.spec.document import Document, Path
from orthospec.spec.model import OptimiseKeys, ProofKeys
from orthospec.spec.plans import DemandPlan, GoalPlan, Reading
from orthospec.spec.solved import Solved

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator

UNUSED = "variable '{}' changes nothing: no key of the machine, measure or goal names it"
_NAME = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True)
class Spec:
    """What a spec file says, in SI, with its classes found and its expressions parsed."""

    title: str | None
    variables: Mapping[str, Variable]
    manipulator: Blueprint[Manipulator]
    tolerances: Mapping[str, float]
    """How far each number of a field of the machine may be off when it is built, by field."""
    workspace: Workspace
    measures: tuple[DemandPlan, ...]
    goals: tuple[GoalPlan, ...]
    poses: Mapping[str, tuple[float, ...]]
    sweep: Sweep | None
    optimise: OptimiseKeys
    pareto: int | None
    """How many points of a Pareto set to look for; None: none is asked for."""
    proof: ProofKeys | None
    """How the bounds are proved; None: not at all."""
    source: str
    """The text as run, with what ``--set`` changed and the keys of a solved machine in their place."""
    solved: Solved | None
    """Where the machine comes from, if not from the spec itself."""
    document: Document

    def design(self, values: Mapping[str, float]) -> Design:
        """The problem at these values of the variables; `UnbuildableDesign` where there is no machine."""
        values = self._all_of(values)
        try:
            return Design(
                values=values,
                manipulator=self.manipulator.build(values),
                demands=tuple(plan.at(values) for plan in self.measures),
                goals=tuple(plan.at(values) for plan in self.goals),
            )
        except (Refused, ExpressionError) as error:
            raise UnbuildableDesign(values, str(error)) from None

    def default_values(self) -> dict[str, float]:
        """Each variable's start, or else the middle of its range."""
        return {name: variable.start for name, variable in self.variables.items()}

    def chosen(self, values: Mapping[str, float]) -> Spec:
        """The same problem with these variables fixed: one branch of its catalogues."""
        fixed = {name: Variable(value, value, value) for name, value in values.items()}
        return replace(self, variables={**self.variables, **fixed})

    def aimed(self, aims: Mapping[str, tuple[float, float]]) -> Spec:
        """The same problem with other aims: of the soft goals those that are named, by so much easier.

        Each has a weight of its own; soft goals that are not named are left out.
        """
        goals = [
            plan.aimed(*aims[plan.name]) if plan.is_soft else plan
            for plan in self.goals
            if plan.name in aims or not plan.is_soft
        ]
        return replace(self, goals=tuple(goals))

    def place(self, path: Path) -> str:
        """``FILE:LINE:COLUMN`` of a key or list item: ``place(("measures", "transmission"))``."""
        return self.document.place(path)

    @property
    def plugins(self) -> tuple[registry.Installed, ...]:
        """The plugins in use, with distribution and version, each once."""
        used = {registry.distribution_of(registry.MANIPULATORS, self.manipulator.use)}
        used |= {registry.distribution_of(registry.MEASURES, plan.blueprint.use) for plan in self.measures}
        return tuple(sorted(used))

    def oddities(self) -> list[Mistake]:
        """What its author may have meant otherwise, though it can be run: variables that nothing names."""
        content = self.canonical()
        texts = _texts([content[part] for part in ("manipulator", "measures", "goals")])
        named = {name for text in texts for name in _NAME.findall(text)}
        return [
            self.document.mistake(("variables", name), UNUSED.format(name), at_key=True)
            for name in self.variables
            if name not in named
        ]

    def canonical(self) -> dict[str, Any]:
        """The content that decides the result: no title, notes or comments; SI units, one spelling."""
        return {
            "orthospec": 1,
            "variables": {name: _variable_content(variable) for name, variable in self.variables.items()},
            "manipulator": {"use": self.manipulator.use, **_folded(self.manipulator.keys)},
            "workspace": asdict(self.workspace),
            "measures": {plan.name: _demand_content(plan) for plan in self.measures},
            "goals": {plan.name: _goal_content(plan) for plan in self.goals},
            "poses": {name: list(pose) for name, pose in self.poses.items()},
            "sweep": None if self.sweep is None else asdict(self.sweep),
            "optimise": self.optimise.model_dump(),
            **({"tolerances": dict(self.tolerances)} if self.tolerances else {}),
            **({} if self.pareto is None else {"pareto": self.pareto}),
            **({} if self.proof == ProofKeys() else {"proof": self.proof and self.proof.model_dump()}),
        }

    def sha256(self) -> str:
        """Hash of the canonical content; the order of variables, measures and goals counts."""
        text = json.dumps(self.canonical(), separators=(",", ":"), ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()

    def _all_of(self, values: Mapping[str, float]) -> dict[str, float]:
        if values.keys() != self.variables.keys():
            wanted, given = ", ".join(self.variables) or "none", ", ".join(values) or "none"
            raise UsageError(f"a value for each variable was expected ({wanted}), given are {given}")
        return {name: float(values[name]) for name in self.variables}


def _texts(content: Any) -> Iterator[str]:
    """All values that are texts, at whatever depth."""
    if isinstance(content, Mapping | list):
        for inner in content.values() if isinstance(content, Mapping) else content:
            yield from _texts(inner)
    elif isinstance(content, str):
        yield content


def _variable_content(variable: Variable) -> dict[str, Any]:
    content = asdict(variable)
    return {name: content[name] for name in content if name != "choices" or variable.choices}


def _demand_content(plan: DemandPlan) -> dict[str, Any]:
    bounds = {side: _written(bound) for side, bound in plan.bounds.items()}
    levels = [{side: _written(bound) for side, bound in level.items()} for level in plan.levels]
    return {"use": plan.blueprint.use, **bounds, "levels": levels, **_folded(plan.blueprint.keys)}


def _goal_content(plan: GoalPlan) -> dict[str, Any]:
    weight = "relative" if plan.weight is None else _written(plan.weight)
    return {plan.sense: plan.expression.text, "goal": _written(plan.goal), "weight": weight}


def _written(reading: Reading) -> float | str:
    return reading.text if isinstance(reading, Expression) else reading


def _folded(keys: Any) -> Any:
    """A plugin's keys in one spelling: sorted, numbers as floats, quantities in SI, expressions tidy."""
    if isinstance(keys, Mapping):
        return {name: _folded(keys[name]) for name in sorted(keys)}
    if isinstance(keys, list):
        return [_folded(inner) for inner in keys]
    if isinstance(keys, bool) or not isinstance(keys, int | float | str):
        return keys
    try:
        return _written(read(keys, None))
    except ValueError:
        return keys

"""What a run would do, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from math import prod
from typing import TYPE_CHECKING, Any

from orthospec.show import words
from orthospec.show.labels import Labels, labels
from orthospec.show.numbers import UNKNOWN, Numbers, percent
from orthospec.show.page import Page
from orthospec.spec import Spec, Variable

if TYPE_CHECKING:
    from orthospec.optimise.plan import Plan, Searching
    from orthospec.workspace.grid import Grid

_Row = tuple[str, str]


def plan_content(spec: Spec, plan: Plan) -> dict[str, Any]:
    """The plan as plain content."""
    searching = plan.searching
    search = None
    if searching is not None:
        search = {**asdict(searching), "coarse": _grid_content(searching.coarse)}
    return {
        "title": spec.title,
        "variables": {name: asdict(one) for name, one in spec.variables.items()},
        "search": search,
        "grid": {
            **_grid_content(plan.grid),
            "bytes": plan.memory,
            "seconds": plan.timed.of(plan.grid),
            "timed": asdict(plan.timed),
        },
        "goals": [goal.name for goal in spec.goals],
        "measures": {measure.name: {"levels": len(measure.levels)} for measure in spec.measures},
        "poses": list(spec.poses),
        "sweep": None if spec.sweep is None else asdict(spec.sweep),
        "pareto": plan.front or None,
        "proof": None if spec.proof is None else {**spec.proof.model_dump(), "cuboids": plan.proofs},
        "plugins": [one._asdict() for one in plan.plugins],
        "kept": {"steps": plan.steps, "known": plan.kept},
    }


def _grid_content(grid: Grid) -> dict[str, Any]:
    return {"step": list(grid.step), "shape": list(grid.shape), "nodes": grid.nodes}


def show_plan(spec: Spec, plan: Plan, *, width: int, colour: bool) -> str:
    """The plan in words."""
    page = Page(width=width, colour=colour)
    known, numbers = labels(spec, plan.design.values), Numbers(max(spec.workspace.size) < 1.0)
    page.heading(spec.title or spec.manipulator.use)
    page.sentence("Nothing was run. This is what a run would do.")
    if plan.searching is not None:
        page.heading("Design variables")
        page.rows([_variable(name, one, known, numbers) for name, one in spec.variables.items()])
        page.heading("Search")
        page.rows(list(_search(spec, plan.searching)))
    page.heading("Grid of the design" if plan.searching is None else "Grid of the design found")
    page.rows(list(_grid(spec, plan, known, numbers)))
    page.heading("Measured and proved")
    page.rows(list(_told(spec, plan, known, numbers)))
    page.heading("Plugins")
    page.rows(list(_plugins(plan)))
    page.heading("Kept from earlier runs")
    page.sentence(_kept(plan))
    return str(page)


def _variable(name: str, one: Variable, known: Labels, numbers: Numbers) -> tuple[str, str]:
    unit = known.variables.get(name, UNKNOWN)
    if one.choices:
        return name, f"one of {len(one.choices)}: {numbers.several(one.choices, unit)}"
    return name, f"{numbers.interval(one.min, one.max, unit)}, from {numbers.value(one.start, unit)}"


def _search(spec: Spec, searching: Searching) -> Iterator[_Row]:
    goals = ", ".join(goal.name for goal in spec.goals)
    yield "goals", goals or "none: a design in which every bound holds"
    each = ""
    if searching.combinations > 1:
        each = ", for each combination"
        every = f"{searching.combinations} combinations of choices"
        screened = f"the best {searching.branches} of {every}, screened on the coarse grid"
        all_searched = searching.branches == searching.combinations
        yield "catalogues", f"{every}, all searched" if all_searched else screened
    designs = words.counted(searching.starts, "design")
    yield "starts", f"{designs} on a coarse grid of {_nodes(searching.coarse)} nodes{each}"
    solved = f"up to {words.counted(searching.solved, 'place')}" if searching.solved > 1 else "1 place"
    yield "then", f"{searching.refined} of them refined, {solved} solved to the end{each}"


def _grid(spec: Spec, plan: Plan, known: Labels, numbers: Numbers) -> Iterator[_Row]:
    grid, timed = plan.grid, plan.timed
    at_start = " at the start" if plan.searching is not None else ""
    over = "the region" if spec.workspace.region else f"the machine's reach{at_start}"
    yield "nodes", f"{_nodes(grid)}, over {over}"
    yield "step", numbers.edges([0.0] * len(grid.step), grid.step, known.axes)
    yield "memory", f"about {max(1, round(plan.memory / 1e6))} MB for its nodes"
    yield "time", f"{_seconds(timed.of(grid))}, by {timed.poses} of its poses measured here"


def _told(spec: Spec, plan: Plan, known: Labels, numbers: Numbers) -> Iterator[_Row]:
    measures = [words.asked(name, one, numbers) for name, one in known.measures.items()]
    yield from _list("measures", measures or ["none: the reach alone"])
    levels = [
        f"{demand.name}: {words.bounds(numbers, level.bounds, known.measures[demand.name].unit)}"
        for demand in plan.design.demands
        for level in demand.levels
    ]
    yield from _list("levels", levels)
    if spec.poses:
        yield "poses", ", ".join(spec.poses)
    if spec.proof is None:
        yield "proof", "none"
    else:
        slack = percent(spec.proof.slack)
        yield (
            "proof",
            f"within {slack}, over up to {plan.proofs} cuboids, by up to {spec.proof.boxes} boxes each time",
        )
    if plan.searching is not None:
        yield "limits", "each thing that binds, with its price by solving again to either side"
    sweep = spec.sweep
    if sweep is not None:
        unit = known.variables.get(sweep.variable, UNKNOWN)
        ends = numbers.interval(sweep.start, sweep.stop, unit)
        yield "sweep", f"{sweep.points} designs, {sweep.variable} = {ends}, {_grids(plan, sweep.points)}"
    if plan.front:
        yield "pareto", f"up to {plan.front} designs, {_grids(plan, plan.front)}; and what finds them"


def _grids(plan: Plan, designs: int) -> str:
    return f"each on a grid of its own: {_seconds(designs * plan.timed.of(plan.grid))}"


def _list(head: str, lines: list[str]) -> Iterator[_Row]:
    for number, line in enumerate(lines):
        yield "" if number else head, line


def _plugins(plan: Plan) -> Iterator[_Row]:
    by: dict[str, list[str]] = {}
    for one in plan.plugins:
        by.setdefault(f"{one.distribution} {one.version}", []).append(one.name)
    for owner, names in by.items():
        yield owner, ", ".join(names)


def _kept(plan: Plan) -> str:
    if not plan.steps:
        return "Not known before the combinations are screened."
    if plan.searching is None:
        return (
            "The design was measured before." if plan.kept else "Nothing: the design was not measured before."
        )
    if not plan.kept:
        return "Nothing: none of the starts was measured before."
    return f"{plan.kept} of the {plan.steps} starts were measured before; what followed may be kept too."


def _nodes(grid: Grid) -> str:
    return f"{' x '.join(map(str, grid.shape))} = {prod(grid.shape)}"


def _seconds(seconds: float) -> str:
    """As much of a time as can be told."""
    if seconds < 1:
        return "less than 1 s"
    for size, unit in ((3600, "h"), (60, "min"), (1, "s")):
        if seconds >= 2 * size or size == 1:
            return f"about {seconds / size:.0f} {unit}"
    raise AssertionError

"""The text of a starting spec: each key of the format with a comment, those left out behind a #."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from orthospec import registry
from orthospec.starter.problem import MEASURE, Problem, first_problem

WIDTH = 79
COMMENT = 36
"""Where comments begin that stand behind a key."""


def starting_spec(machine: str, schema: str | None) -> str:
    """A spec for a machine, with its JSON schema named for editors where there is one.

    Raises `UsageError` where nothing can be said of the machine.
    """
    problem = first_problem(machine)
    lines = [] if schema is None else [f"# yaml-language-server: $schema={schema}"]
    for part in (_head, _variables, _manipulator, _workspace, _measures, _goals, _further):
        lines += part(problem)
    return "\n".join(lines) + "\n"


def _head(problem: Problem) -> Iterator[str]:
    yield from _note(
        "A number is in SI units: m, kg, s, N, rad. '310 mm' is a quantity: number, blank, unit. Any other"
        " text in a number's place is an expression over the variables, like leg / 2. A key right behind a #"
        " is left out: take the # away to use it."
    )
    yield from _key(0, "orthospec: 1", "version of this format")
    yield from _key(0, f"title: First {problem.machine}", "one line to tell it by")
    yield from _key(0, "#notes: anything", "never interpreted")


def _variables(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note(
        "What may vary. Without variables the one design is measured. start is where to begin; the middle if"
        " left out. A catalogue has choices instead of min and max."
    )
    yield "variables:"
    ends = f"min: {problem.least}, max: {problem.greatest}, start: {problem.start}"
    yield from _key(2, f"{problem.variable}: {{{ends}}}")
    yield from _key(2, f"#other: {{choices: [{problem.least}, {problem.start}, {problem.greatest}]}}")


def _manipulator(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note(
        f"The machine. `orthospec explain {problem.machine}` tells its keys and those of its parts. With"
        " from: result.yaml in place of use the machine of a result is taken."
    )
    yield "manipulator:"
    yield from _key(2, f"use: {problem.machine}", f"or {_listed(registry.MANIPULATORS, but=problem.machine)}")
    told = _meanings(problem)
    for name, value in problem.keys.items():
        yield from _key(2, f"{name}: {_flow(value)}", told[name])
    for key in problem.others:
        yield from _note(f"{key.path[0]}: {key.meaning}", indent=2, hang=2)


def _workspace(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note("The prescribed cuboid. The optimiser places it: where it ends is part of the result.")
    yield "workspace:"
    yield from _key(2, f"size: {_flow(problem.size)}", "edges along the pose's first axes [m]")
    yield from _key(2, "divisions: 20", "steps of the grid along each edge")
    low, high = ([f"{sign}{problem.far}"] * len(problem.size) for sign in ("-", ""))
    box = f"region: {{min: {_flow(low)}, max: {_flow(high)}}}"
    if problem.endless:
        yield from _key(2, box, "where to look; needed, since the reach of this machine has no end")
    else:
        yield from _key(2, f"#{box}", "where to look; the machine's whole reach if left out")
    yield from _key(2, "#together: true", "one cuboid for all measures; or one each")


def _measures(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note("What must hold at every pose of the cuboid, under names of your own.")
    yield from _note(f"Installed: {_listed(registry.MEASURES, but=MEASURE)}, {MEASURE}.")
    yield from _note("`orthospec explain NAME` tells formula, unit and keys of one.")
    yield "measures:"
    yield "  isotropy:"
    yield from _key(4, f"use: {MEASURE}", "1: alike in all directions")
    yield from _key(4, f"at_most: {problem.at_most:g}", "or at_least, in the measure's unit")
    levels = [round(problem.at_most * part, 3) for part in (0.8, 0.9)]
    yield from _key(4, f"#levels: {{at_most: {_flow(levels)}}}", "told with a cuboid each; bind nothing")
    yield from _key(2, "#speed: {use: velocity_transmission, at_least: 0.1}")


def _goals(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note(
        "What is aimed at, under names of your own: minimise, maximise or match an expression over the"
        " variables, the machine's indices, lowest(measure), highest(measure), worst(measure) and scale."
        " goal: the value aimed at. weight: how much it gives way, 1 if left out; relative is the goal's own"
        " magnitude; 0 makes it a hard bound."
    )
    yield "goals:"
    yield from _key(2, f"short: {{minimise: {problem.variable}, goal: {problem.least}, weight: relative}}")
    even = f"#even: {{minimise: worst(isotropy), goal: {0.8 * problem.at_most:g}, weight: relative}}"
    yield from _key(2, even)


def _further(problem: Problem) -> Iterator[str]:
    yield ""
    yield from _note("What else may be told, and how it is searched and proved.")
    home = _flow([0] * problem.coordinates)
    yield from _key(0, f"#poses: {{home: {home}}}", "where measures are told too [m, rad]")
    ends = f"from: {problem.least}, to: {problem.greatest}, points: 5"
    yield from _key(0, f"#sweep: {{variable: {problem.variable}, {ends}}}", "designs along one variable")
    yield from _key(0, "#pareto: {points: 5}", "a Pareto set of two or three goals")
    yield from _key(0, "#optimise: {starts: 8, seed: 0}", "how many starts, and which")
    proof = "slack: part of a bound that a proof leaves; boxes: the most that it takes; false: no proof"
    if problem.endless:
        few = "; few here: where the reach has no end a larger cuboid is hard to exclude"
        yield from _key(0, "proof: {slack: 1e-3, boxes: 5000}", proof + few)
    else:
        yield from _key(0, "#proof: {slack: 1e-3, boxes: 50000}", proof)


def _listed(group: str, but: str) -> str:
    return ", ".join(name for name in registry.names(group) if name != but) or "others, where installed"


def _meanings(problem: Problem) -> dict[str, str]:
    from orthospec.show.keys import keys_of

    keys = keys_of(registry.find_manipulator(problem.machine)).keys
    return {key.path[0]: key.meaning.rstrip(".") for key in keys}


def _key(indent: int, text: str, comment: str = "") -> Iterator[str]:
    """A key with its comment behind it, or above where there is no room."""
    line = " " * indent + text
    if not comment:
        yield line
    elif len(line) < COMMENT - 1 and COMMENT + 2 + len(comment) <= WIDTH:
        yield f"{line:<{COMMENT}}# {comment}"
    else:
        yield from _note(comment, indent=indent)
        yield line


def _note(text: str, *, indent: int = 0, hang: int = 0) -> list[str]:
    """A comment on lines of its own."""
    lead = " " * indent + "# "
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=lead,
        subsequent_indent=lead + " " * hang,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _flow(value: Any) -> str:
    """A value in flow style; the texts in it are quantities and names."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_flow, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name}: {_flow(inner)}" for name, inner in value.items()) + "}"
    return str(value).lower() if isinstance(value, bool) else str(value)

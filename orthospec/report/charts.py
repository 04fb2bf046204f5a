"""Charts of a result's numbers: goals, prices, Pareto set, sweep, and how the search came to its end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orthospec.report import style
from orthospec.report.drawing import Drawing, Table
from orthospec.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, RULE, SERIES, WIDTH
from orthospec.report.subject import Subject
from orthospec.show import words
from orthospec.show.numbers import UNKNOWN, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from orthospec.result.model import DesignRecord, ParetoRecord

MARKS = ("o", "s", "^", "D", "v")


def goals(subject: Subject) -> Drawing | None:
    """How far each goal is met: its value over what is aimed at."""
    attainment = subject.result.attainment
    told = [
        (n, g) for n, g in (attainment.goals if attainment else {}).items() if g.value is not None and g.goal
    ]
    if not told:
        return None
    from matplotlib.figure import Figure

    parts = [g.value / g.goal if g.value is not None else 1.0 for _, g in told]
    figure = Figure(figsize=(WIDTH, 0.75 + 0.34 * len(told)), layout="constrained")
    axes = figure.add_subplot()
    for row, ((_, goal), part) in enumerate(zip(told, parts, strict=True)):
        axes.barh(row, part - 1.0, left=1.0, height=0.5, color=GREEN if goal.attained else ORANGE)
        axes.plot([part], [row], MARKS[0], color=GREEN if goal.attained else ORANGE, markersize=5)
        aim = subject.known.goals.get(told[row][0])
        label = subject.numbers.value(goal.value, aim.unit if aim else UNKNOWN)
        axes.annotate(
            f"{label} ({'met' if goal.attained else 'missed'})", (max(part, 1.0), row), (8, 0),
            textcoords="offset points", va="center", fontsize=8,
        )  # fmt: skip
    axes.axvline(1.0, color=INK, linewidth=1.0)
    axes.set_yticks(range(len(told)), [name for name, _ in told])
    axes.set_ylim(len(told) - 0.4, -0.6)
    span = max(max(parts) - 1.0, 1.0 - min(parts), 0.02)
    axes.set_xlim(min(1.0, *parts) - 0.1 * span, max(1.0, *parts) + 0.75 * span)
    axes.xaxis.set_major_formatter(lambda x, _: f"{100 * x:.4g} %")
    axes.set_xlabel("value, in per cent of what is aimed at")
    rows = [
        (name, goal.value, goal.goal, goal.weight, "yes" if goal.attained else "no") for name, goal in told
    ]
    said = "; ".join(
        f"{name} at {percent_of(part)} of its aim, {'met' if goal.attained else 'missed'}"
        for (name, goal), part in zip(told, parts, strict=True)
    )
    return Drawing(
        "goals", "The goals: the line is what is aimed at.", f"Bars of the goals: {said}.", figure,
        Table(("goal", "value", "aimed at", "weight", "met"), rows),
    )  # fmt: skip


def percent_of(part: float) -> str:
    """``103.5 %``."""
    return f"{100 * part:.4g} %"


def prices(subject: Subject) -> Drawing | None:
    """What one per cent of each limit is worth."""
    every = words.together(subject.result.limits)
    limits = [one for one in every if one.gain is not None or one.cost is not None]
    if not limits:
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 0.9 + 0.34 * len(limits)), layout="constrained")
    axes = figure.add_subplot()
    for row, one in enumerate(limits):
        axes.barh(row, -(one.gain or 0.0), height=0.5, color=GREEN)
        axes.barh(row, one.cost or 0.0, height=0.5, color=RED, hatch="////", edgecolor=RULE, linewidth=0)
    axes.axvline(0.0, color=INK, linewidth=1.0)
    labels = [words.limiting(one, subject.known, subject.numbers) for one in limits]
    axes.set_yticks(range(len(limits)), labels)
    axes.set_ylim(len(limits) - 0.4, -0.6)
    axes.margins(x=0.08)
    axes.set_xlabel("change of λ: 1 % looser (falls), 1 % tighter (rises, hatched)")
    rows = [(label, one.gain, one.cost) for label, one in zip(labels, limits, strict=True)]
    said = "; ".join(f"{label}: {words.price(one)}" for label, one in zip(labels, limits, strict=True))
    return Drawing(
        "prices", "What one per cent of each limit is worth.", f"Bars of prices. {said}.", figure,
        Table(("limit", "gain at 1 % looser", "cost at 1 % tighter"), rows),
    )  # fmt: skip


def front(subject: Subject) -> Drawing | None:
    """The Pareto set: each goal against the first."""
    designs = subject.result.pareto
    names = _soft(designs[0]) if designs else []
    if len(names) < 2:
        return None
    from matplotlib.figure import Figure

    units = {n: subject.known.goals[n].unit if n in subject.known.goals else UNKNOWN for n in names}
    columns = {n: subject.told(units[n], [_goal_value(one, n) for one in designs]) for n in names}
    figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
    hints = {}
    for k, axes in enumerate(style.panels(figure, 1, len(names) - 1)):
        x, y = columns[names[0]], columns[names[k + 1]]
        axes.plot(x[0], y[0], "-", color=RULE, linewidth=1.2, zorder=1)
        for number, one in enumerate(designs):
            mark = f"point-{k}-{number + 1}"
            axes.plot(
                x[0][number], y[0][number], MARKS[3] if one.knee else MARKS[0],
                color=ORANGE if one.knee else BLUE, markersize=8 if one.knee else 5.5, gid=mark, zorder=2,
            )  # fmt: skip
            hints[mark] = _design_in_words(subject, number + 1, one)
        _name_ends(axes, x[0], y[0], designs)
        axes.set_xlabel(_with_unit(names[0], x[1]))
        axes.set_ylabel(_with_unit(names[k + 1], y[1]))
        axes.margins(0.08)
    variables = list(designs[0].variables)
    rows = [
        [k, *(_goal_value(one, n) for n in names), *one.variables.values(), "yes" if one.knee else ""]
        for k, one in enumerate(designs, start=1)
    ]
    ends = f"from {hints['point-0-1']} to {hints[f'point-0-{len(designs)}']}"
    return Drawing(
        "pareto", "The Pareto set: no design of it is better in one goal without being worse in another.",
        f"Points of {len(designs)} designs, {ends}.", figure,
        Table(("design", *names, *variables, "knee"), rows), hints,
    )  # fmt: skip


def _soft(one: ParetoRecord) -> list[str]:
    return [name for name, goal in (one.attainment.goals if one.attainment else {}).items() if goal.weight]


def _goal_value(one: ParetoRecord, name: str) -> float:
    value = one.attainment.goals[name].value if one.attainment else None
    return float("nan") if value is None else value


def _design_in_words(subject: Subject, number: int, one: ParetoRecord) -> str:
    goals = {n: subject.known.goals[n].unit if n in subject.known.goals else UNKNOWN for n in _soft(one)}
    said = [f"{n} {subject.numbers.value(_goal_value(one, n), unit)}" for n, unit in goals.items()]
    units = {n: subject.known.variables.get(n, UNKNOWN) for n in one.variables}
    said += [f"{n} = {subject.numbers.value(value, units[n])}" for n, value in one.variables.items()]
    return f"design {number}{' (knee)' if one.knee else ''}: {', '.join(said)}"


def _name_ends(axes: Axes, x: np.ndarray, y: np.ndarray, designs: list[ParetoRecord]) -> None:
    named = {0: "1", len(designs) - 1: str(len(designs))}
    named.update({k: f"{k + 1}, knee" for k, one in enumerate(designs) if one.knee})
    for k, text in named.items():
        axes.annotate(text, (x[k], y[k]), (6, 6), textcoords="offset points", fontsize=8, color=INK)


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def sweep(subject: Subject) -> Drawing | None:
    """The measures, and the scale of the largest cuboid, along one variable."""
    points = subject.result.sweep
    names = [n for n in points[0].variables if len({p.variables[n] for p in points}) > 1] if points else []
    if len(names) != 1:
        return None
    from matplotlib.figure import Figure

    (name,) = names
    x, unit = subject.told(subject.known.variables.get(name, UNKNOWN), [p.variables[name] for p in points])
    measures = list(points[0].workspace.measures)
    with_scale = points[0].workspace.joint is not None
    figure = Figure(figsize=(WIDTH, 1.7 * (len(measures) + with_scale)), layout="constrained")
    every = style.panels(figure, len(measures) + with_scale, 1)
    rows: list[list[float | str | None]] = [[p.variables[name]] for p in points]
    head = [name]
    if with_scale:
        scales = [p.workspace.joint.scale if p.workspace.joint else np.nan for p in points]
        every[0].plot(x, scales, marker=MARKS[0], color=BLUE, markersize=3.5)
        every[0].axhline(1.0, color=MUTED, linewidth=0.8, linestyle="--")
        every[0].set_ylabel("scale")
        head.append("scale")
        for row, scale in zip(rows, scales, strict=True):
            row.append(scale)
    for axes, measure in zip(every[with_scale:], measures, strict=True):
        asked = subject.known.measures.get(measure)
        ends = np.array([_ends(p, measure) for p in points])
        told, shown = subject.told(asked.unit if asked else UNKNOWN, ends)
        for k, (end, mark) in enumerate((("lowest", MARKS[4]), ("highest", MARKS[2]))):
            axes.plot(x, told[:, k], marker=mark, color=SERIES[k], markersize=3.5, label=end)
            head.append(f"{measure} {end} [{asked.unit if asked else UNKNOWN}]")
        for bound in (asked.bounds if asked else {}).values():
            axes.axhline(
                float(subject.told(asked.unit if asked else UNKNOWN, [bound])[0][0]), color=RED, linewidth=0.9
            )
        axes.set_ylabel(_with_unit(measure, shown))
        axes.legend(loc="best")
        for row, (low, high) in zip(rows, ends, strict=True):
            row += [float(low), float(high)]
    every[-1].set_xlabel(_with_unit(name, unit))
    return Drawing(
        "sweep", f"Along {name}: extremes over the prescribed cuboid; red lines are bounds.",
        f"Curves of {', '.join(measures) or 'the scale'} along {name}, {x[0]:.6g} to {x[-1]:.6g} {unit}.",
        figure, Table(head, rows),
    )  # fmt: skip


def _ends(point: DesignRecord, measure: str) -> tuple[float, float]:
    record = point.workspace.measures[measure]
    low, high = (end.value if end is not None else None for end in (record.lowest, record.highest))
    return np.nan if low is None else low, np.nan if high is None else high


def convergence(subject: Subject) -> Drawing | None:
    """λ and the worst violation after each subproblem, from each start that was solved to the end."""
    solves = [
        one for one in subject.solution.log.get("solves", []) if one.get("to_the_end") and one["iterates"]
    ]
    if not solves:
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    rows: list[tuple[float | str | None, ...]] = []
    for number, solve in enumerate(solves):
        steps = [one["subproblems"] for one in solve["iterates"]]
        factors = [np.nan if one["factor"] is None else one["factor"] for one in solve["iterates"]]
        missed = [max(one["violation"] or 0.0, 1e-12) for one in solve["iterates"]]
        mark = {"marker": MARKS[number % 5], "color": SERIES[number % 5], "markersize": 4, "linewidth": 1.0}
        left.plot(steps, factors, **mark)
        right.semilogy(steps, missed, **mark)
        rows += [(number + 1, *row) for row in zip(steps, factors, missed, strict=True)]
    left.set_ylabel("λ")
    right.set_ylabel("worst violation, relative")
    right.set_ylim(bottom=3e-13)
    for axes in (left, right):
        axes.set_xlabel("subproblems")
        axes.xaxis.get_major_locator().set_params(integer=True)
    last = solves[0]["iterates"][-1]
    return Drawing(
        "convergence",
        "How the search came to its end; violations below 1e-12 are rounding and drawn there.",
        f"λ and violation over the subproblems of {words.counted(len(solves), 'solve')}; the first one ends"
        f" after {last['subproblems']}, missing its bounds by {percent(max(last['violation'] or 0.0, 0.0))}.",
        figure,
        Table(("solve", "subproblems", "λ", "violation"), rows),
    )

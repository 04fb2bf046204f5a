"""Tables for papers: LaTeX with the rules of booktabs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from orthospec.show import tables, words

if TYPE_CHECKING:
    from orthospec.show.reading import Reading

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "λ": r"$\lambda$",
    "μ": r"$\mu$",
    "±": r"$\pm$",
    "−": r"$-$",
    "²": r"\textsuperscript{2}",
    **{one: rf"\{one}" for one in "&%$#_{}"},
}
_POWER = re.compile(r"\^(-?\d+)")


def escaped(text: str) -> str:
    """Text that LaTeX sets as it is; ``m^2`` with a raised 2."""
    parts = _POWER.split(text)
    return "".join(
        rf"\textsuperscript{{{part}}}" if k % 2 else "".join(_SPECIAL.get(one, one) for one in part)
        for k, part in enumerate(parts)
    )


def latex(reading: Reading) -> str:
    """Goals, variables, limits and the Pareto set, those that there are; needs ``\\usepackage{booktabs}``."""
    every = list(_tables(reading))
    needs = "% Needs \\usepackage{booktabs}.\n"
    return needs + "".join(f"\n{_table(caption, label, *one)}" for caption, label, one in every)


def _tables(reading: Reading) -> Iterator[tuple[str, str, tables.Table]]:
    goals, variables = tables.goals(reading), tables.variables(reading)
    if goals:
        rows = [[one.name, one.value, one.goal, one.weight, one.verdict] for one in goals]
        head = ["goal", "value", "aimed at", "weight", ""]
        yield "Goals.", "goals", tables.Table(head, rows)
    if variables:
        yield "Design variables.", "variables", tables.Table(["variable", "value", "range"], variables)
    rows = [
        [words.limiting(one, reading.known, reading.numbers), _price(one.gain), _price(one.cost)]
        for one in words.together(reading.result.limits)
    ]
    if rows:
        head = ["limit", "gain of λ, 1 % looser", "cost of λ, 1 % tighter"]
        yield "What limits the design.", "limits", tables.Table(head, rows)
    if reading.result.pareto:
        front = tables.pareto(reading)
        yield "Pareto set.", "pareto", tables.Table(["design", *front.head[1:]], front.rows)


def _price(price: float | None) -> str:
    return "" if price is None else f"{price:.3g}"


def _table(caption: str, label: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    columns = "l" + "r" * (len(head) - 1)
    lines = [" & ".join(map(escaped, row)) + r" \\" for row in (head, *rows)]
    return "\n".join(
        [
            r"\begin{table}",
            r"  \centering",
            rf"  \caption{{{escaped(caption)}}}",
            rf"  \label{{tab:{label}}}",
            rf"  \begin{{tabular}}{{{columns}}}",
            r"    \toprule",
            f"    {lines[0]}",
            r"    \midrule",
            *(f"    {line}" for line in lines[1:]),
            r"    \bottomrule",
            r"  \end{tabular}",
            r"\end{table}",
            "",
        ]
    )

"""Tables as LaTeX sets them, with the rules of booktabs."""

from __future__ import annotations

from collections.abc import Sequence

from orthospec.report.tables import Rows

_SIGNS = {
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    **{sign: f"${sign}$" for sign in "<>"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "λ": r"$\lambda$",
    "σ": r"$\sigma$",
    "κ": r"$\kappa$",
    "μ": r"$\mu$",
    "ρ": r"$\rho$",
    "±": r"$\pm$",
    "×": r"$\times$",
    "−": r"$-$",
}


def latex(tables: Sequence[Rows]) -> str:
    """All tables, each a `table` environment with caption and label."""
    return "% Needs \\usepackage{booktabs}.\n" + "\n".join(_table(one) for one in tables)


def _table(rows: Rows) -> str:
    columns = "".join("r" if k in rows.right else "l" for k in range(len(rows.head)))
    lines = [
        r"\begin{table}",
        r"  \centering",
        rf"  \caption{{{_escaped(rows.caption)}}}",
        rf"  \label{{tab:{rows.name}}}",
        rf"  \begin{{tabular}}{{{columns}}}",
        r"    \toprule",
    ]
    if any(rows.head):
        lines += [_row(rows.head), r"    \midrule"]
    lines += [_row(row) for row in rows.rows]
    lines += [r"    \bottomrule", r"  \end{tabular}", r"\end{table}", ""]
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return f"    {' & '.join(map(_escaped, cells))} \\\\"


def _escaped(text: str) -> str:
    return "".join(_SIGNS.get(sign, sign) for sign in text)

"""What a subproblem costs as problems grow: its set-up and Clarabel's solve, and what comes before.

python benchmarks/subproblems.py

Medians and quartiles over all subproblems that the solver meets on its way through each of ``problems.py``,
and beside them what cvxpy takes to compile one constraint of the kind, which is done once for a form.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import cvxpy  # noqa: F401  # no one's imports are timed
from problems import SpecProblem, problems
from timing import quartiles

from orthospec.composite import trust_region
from orthospec.workspace import forms

MEASURED = {
    "set-up and solve [ms]": (trust_region, "solve"),
    "rows and derivatives": (trust_region, "_linearised"),
    "cvxpy, one form": (forms, "compile_form"),
}


@contextmanager
def clocked(module: Any, name: str) -> Iterator[list[float]]:
    """Milliseconds of each call of a function of a module."""
    taken: list[float] = []
    function: Callable[..., Any] = getattr(module, name)

    def timed(*args: Any, **keys: Any) -> Any:
        start = time.perf_counter()
        try:
            return function(*args, **keys)
        finally:
            taken.append(1e3 * (time.perf_counter() - start))

    with patch.object(module, name, timed):
        yield taken


def cell(taken: list[float]) -> str:
    if not taken:
        return f"{'':>24}"
    low, middle, high = quartiles(taken)
    return f"{middle:8.2f}{f'{low:.2f} ... {high:.2f}':>16}"


def main() -> None:
    print(f"{'':49}" + "".join(map("{:>24}".format, MEASURED)))
    print(f"{'problem':30}{'variables':>10}{'times':>9}" + len(MEASURED) * f"{'median':>8}{'quartiles':>16}")
    for name, problem in problems().items():
        if not isinstance(problem, SpecProblem):
            continue
        with ExitStack() as stack:
            taken = [stack.enter_context(clocked(*function)) for function in MEASURED.values()]
            problem.solve()
        row = "".join(map(cell, taken))
        print(f"{name:30}{problem.variables:>10}{len(taken[0]):>9}{row}", flush=True)


if __name__ == "__main__":
    main()

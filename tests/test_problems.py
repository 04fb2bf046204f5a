"""Problems with known optima: each is solved to a millionth of λ from one start."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


def load(name: str) -> ModuleType:
    """A script of ``benchmarks/``, which find each other by name."""
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


load("optima")
problems = load("problems")
PROBLEMS = problems.problems()


MANY = 40
"""Subproblems."""
HARDEST = {"legs and drives": 45}
"""This one takes 39 or 41, as the processor rounds."""


def test_there_are_enough_of_each_kind():
    assert len(PROBLEMS) >= 20
    assert len(problems.sections()) >= 4
    assert len(problems.drives()) >= 4
    assert set(problems.RANDOM) <= set(PROBLEMS)


@pytest.mark.parametrize("name", [name for name in PROBLEMS if name != "twenty factors"])
def test_the_known_optimum_is_found(name):
    problem = PROBLEMS[name]
    one_start = ("optimise.starts=1",) if isinstance(problem, problems.SpecProblem) else ()
    found = problem.solve(*one_start)
    assert found.error < problems.ACCURACY
    assert found.subproblems <= HARDEST.get(name, MANY)


def test_many_variables_are_no_other_matter():
    found = problems.factors_of_a_diameter(8).solve("optimise.starts=1")
    assert found.error < problems.ACCURACY
    assert found.subproblems <= MANY


def test_a_far_start_gets_there():
    problem = PROBLEMS["lightest legs"]
    found = problem.solve_from([0.9, 0.1])
    assert found.error < problems.ACCURACY

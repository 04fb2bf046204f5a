"""`Solution`: a result, the spec that it answers and the machine that it found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orthospec.errors import UnbuildableDesign
from orthospec.result import compose, log_of, read_result, spec_of
from orthospec.result.model import Result

if TYPE_CHECKING:
    from orthospec.optimise import Outcome
    from orthospec.spec import Design, Spec


@dataclass(frozen=True)
class Solution:
    """What a run found; all that reports, scenes and files for other programs are made from."""

    content: Mapping[str, Any]
    """As in ``result.yaml``, SI."""
    spec: Spec | None
    """As it was run; None where it is not at hand, or a plugin of it is not installed."""
    log: Mapping[str, Any] = field(default_factory=dict)
    """How the search went, and how long it took; empty where that is not known."""

    @cached_property
    def result(self) -> Result:
        """The content as named records."""
        return Result.model_validate(self.content)

    @cached_property
    def design(self) -> Design | None:
        """The machine found and what was demanded of it; None without a spec, or where it has no machine."""
        if self.spec is None:
            return None
        try:
            return self.spec.design(self.result.variables)
        except UnbuildableDesign:
            return None


def read_solution(path: Path) -> Solution:
    """The solution in a result folder, or beside a ``result.yaml``.

    Raises `UsageError` for what is no result, `SpecError` with all places for a result with mistakes in it.
    """
    return Solution(read_result(path), spec_of(path), log_of(path))


def solution_of(spec: Spec, outcome: Outcome) -> Solution:
    """The solution that a run or an evaluation came to."""
    return Solution(compose(spec, outcome.finding), spec, outcome.log)

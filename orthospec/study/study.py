"""`Study`: a result in hand, with its machine, fields, pages and files; and the functions that give one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from orthospec.errors import UsageError
from orthospec.optimise import evaluate_spec, solve, with_proof
from orthospec.preview import preview
from orthospec.report import Panel, drawings, report, summary
from orthospec.result import PREVIEW, REPORT, write_result
from orthospec.show import show
from orthospec.solution import Solution, read_solution, solution_of
from orthospec.spec import ProofKeys

if TYPE_CHECKING:
    import xarray

    from orthospec.arrays import Array
    from orthospec.manipulators import Manipulator
    from orthospec.optimise import Outcome, Workers
    from orthospec.spec import Spec
    from orthospec.workspace.field import Progress


@dataclass(frozen=True)
class Study(Solution):
    """A result and all that can be had from it; in a notebook it shows itself.

    ``result`` has its records by name, ``content`` the same as plain data, ``design`` the machine and what
    was demanded of it. All numbers are SI.
    """

    outcome: Outcome | None = field(default=None, repr=False, compare=False)
    """What the run handed over; None of a result that was read."""

    @property
    def status(self) -> str:
        """attained, compromise, infeasible, evaluated, unfinished or failed."""
        return self.result.status

    @property
    def variables(self) -> Mapping[str, float]:
        """The design found."""
        return self.result.variables

    @property
    def manipulator(self) -> Manipulator:
        """The machine found; `UsageError` where its spec or plugin is not at hand."""
        if self.design is None:
            raise UsageError(
                "the machine of this result is not known: its spec or a plugin of it is not at hand"
            )
        return self.design.manipulator

    def fields(self, *, workers: Workers | None = None, progress: Progress | None = None) -> xarray.Dataset:
        """Each measure at the nodes of the spec's grid, NaN out of reach; units and bounds are attributes.

        Dimensions are the machine's axes, and ``end`` (least, greatest) of a measure with two values. Needs
        the extra ``exchange``. Raises `UsageError` where the machine is not known.
        """
        from orthospec.exchange.dataset import dataset

        return dataset(self, workers, progress)

    def drawings(self) -> Mapping[str, Panel]:
        """The report's figures by name, each a matplotlib figure with its title and its numbers."""
        return {panel.name: panel for panel in drawings(self)}

    def report(self) -> str:
        """The report, a whole page of HTML."""
        return report(self)

    def preview(self, other: Solution | None = None) -> str:
        """The scene in space, a whole page of HTML, with another result in it where one is given."""
        return preview(self, other)

    def save(
        self,
        folder: Path | str,
        fields: Mapping[str, Array] | None = None,
        *,
        told: Callable[[str], None] = warnings.warn,
    ) -> Path:
        """Write the result folder, whole or not at all; the folder.

        A page that cannot be made is left out, which is ``told``, and costs nothing else. Ctrl-C leaves out
        the pages that are not made yet, and the outcome is then an interrupted one.
        Raises `UsageError` where there is something else in it, or without a spec.
        """
        if self.spec is None:
            raise UsageError("a result without its spec cannot be written as a folder")
        pages = {}
        try:
            for name, make in {REPORT: self.report, PREVIEW: self.preview}.items():
                try:
                    pages[name] = make()
                except Exception as error:
                    told(f"{name} is left out: {type(error).__name__}: {error}")
        except KeyboardInterrupt:
            told(f"stopped at {name}: this page, and any after it, is left out")
            self._interrupted()
        try:
            write_result(Path(folder), self.spec, self.content, self.log, fields, pages)
        except KeyboardInterrupt:
            self._interrupted()
        return Path(folder)

    def _interrupted(self) -> None:
        if self.outcome is not None:
            self.outcome.interrupted = True

    def export(self, *files: Path | str) -> list[Path]:
        """Write files for other programs, by their names: see `orthospec.exchange.KINDS`; those written."""
        from orthospec.exchange import export

        return export(self, [Path(file) for file in files])

    def __str__(self) -> str:
        """As the terminal shows it."""
        return show(dict(self.content), spec=self.spec, width=80, colour=False)

    def _repr_html_(self) -> str:
        """As a notebook shows it."""
        return summary(self)


def run(spec: Spec, *, workers: Workers | None = None, progress: Progress | None = None) -> Study:
    """Find the best design of a spec; without variables, measure and prove its one.

    ``progress(what, done, all)`` is told how far it is. Ctrl-C ends it with the best so far, status
    unfinished. Raises `UsageError` for what cannot be run, `PluginFault` where a plugin fails at the start.
    """
    return _study(spec, solve(spec, workers=workers, progress=progress))


def evaluate(
    spec: Spec,
    at: Mapping[str, float] | None = None,
    *,
    prove: bool = False,
    workers: Workers | None = None,
    progress: Progress | None = None,
) -> Study:
    """Measure one design, at these values of the variables (SI), the others at their start.

    ``prove`` proves it as a run does.

    Raises `UnbuildableDesign` where there is no such machine.
    """
    unknown = set(at or {}) - set(spec.variables)
    if unknown:
        known = ", ".join(spec.variables) or "none"
        raise UsageError(f"{', '.join(sorted(unknown))}: no variable of the spec; these are {known}")
    outcome = evaluate_spec(spec, {**spec.default_values(), **(at or {})}, workers=workers, progress=progress)
    if prove:
        keys = spec.proof or ProofKeys()
        outcome = with_proof(spec, outcome, keys, workers=workers, progress=progress)
    return _study(spec, outcome)


def open_study(path: Path | str) -> Study:
    """A result folder, or a ``result.yaml``, read back.

    Raises `UsageError` for what is no result, `SpecError` with all places for a result with mistakes in it.
    """
    read = read_solution(Path(path))
    return Study(read.content, read.spec, read.log)


def _study(spec: Spec, outcome: Outcome) -> Study:
    made = solution_of(spec, outcome)
    return Study(made.content, spec, made.log, outcome)

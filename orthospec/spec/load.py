"""Read and check a spec file: all its mistakes at once, or a `Spec`."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from orthospec import registry
from orthospec.errors import Mistake, PluginFault, SpecError, UsageError
from orthospec.spec import asked, later, resolve, solved, trials
from orthospec.spec.blueprint import Blueprint
from orthospec.spec.document import Document
from orthospec.spec.document import Path as Keys
from orthospec.spec.draft import Draft
from orthospec.spec.overrides import override
from orthospec.spec.solved import Solved
from orthospec.spec.spec import Spec
from orthospec.spec.strict_yaml import parse
from orthospec.spec.writing import dump

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator

Found = TypeVar("Found")


def load_spec(path: Path, overrides: Sequence[str] = (), *, at: Path | None = None) -> Spec:
    """The checked spec in a file (``-``: standard input), with each KEY=VALUE of ``overrides`` set in it.

    A copy is read as if it stood ``at`` another place: its mistakes are told there, its paths start there.
    Raises `SpecError` with all mistakes, `UsageError` where there is no file, and `PluginFault` where a
    plugin cannot be loaded.
    """
    text = _text(path)
    document = parse(text, str(at or path), empty="the file is empty; a spec starts with 'orthospec: 1'")
    override(document, overrides)
    taken = solved.take(document)
    return _checked(document, dump(document.data) if overrides or taken else text, taken)


def _text(path: Path) -> str:
    try:
        content = sys.stdin.buffer.read() if str(path) == "-" else path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: {(error.strerror or 'cannot be read').lower()}") from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line, column = before.count(b"\n") + 1, len(before) - before.rfind(b"\n")
        raise SpecError(
            [Mistake(str(path), line, column, "not UTF-8 text; save the file as UTF-8")]
        ) from None


def _checked(document: Document, source: str, taken: Solved | None) -> Spec:
    draft = Draft(document)
    _find_classes(draft)
    later.check(draft)
    variables = resolve.variables(draft)
    workspace, poses, sweep = resolve.workspace(draft), resolve.poses(draft), resolve.sweep(draft)
    goals, tolerances = asked.goals(draft), resolve.tolerances(draft)
    pareto = asked.pareto(draft, goals)
    demands = asked.demands(draft, asked.measures_in_goals(draft))
    machine = _machine(draft)
    built = trials.build(draft, machine, variables) if machine else None
    for plan in demands:
        trials.build(draft, plan.blueprint, variables)
    trials.check_goals(draft, goals, variables)
    if built is not None:
        trials.check_machine(draft, built, demands, goals)
        trials.check_tolerances(draft, built, tolerances)
        _check_added(draft, built, taken)
    if draft.mistakes or machine is None or workspace is None:
        raise SpecError(draft.mistakes)
    return Spec(
        title=draft.keys.title,
        variables=variables,
        manipulator=machine,
        tolerances=tolerances,
        workspace=workspace,
        measures=tuple(demands),
        goals=tuple(goals),
        poses=poses,
        sweep=sweep,
        optimise=draft.keys.optimise,
        pareto=pareto,
        proof=draft.keys.proof or None,
        source=source,
        solved=taken,
        document=document,
    )


def _check_added(draft: Draft, built: Manipulator, taken: Solved | None) -> None:
    if taken is not None and taken.moved_by(built):
        message = f"the keys beside it move the joints of the machine solved in {taken.path}; they only add"
        draft.wrong(solved.FROM, message, at_key=True)


def _find_classes(draft: Draft) -> None:
    keys = draft.keys.manipulator
    if draft.is_known("manipulator"):
        if (keys.use is None) == (keys.from_ is None):
            given = "none" if keys.use is None else "both"
            draft.wrong(("manipulator",), f"one of 'use' and 'from' was expected, {given} given", at_key=True)
        if keys.use is not None:
            at = ("manipulator", "use")
            draft.machine = _find(draft, at, registry.MANIPULATORS, keys.use, registry.find_manipulator)
    for name, measure in draft.keys.measures.items():
        place = ("measures", name, "use")
        draft.measures[name] = _find(draft, place, registry.MEASURES, measure.use, registry.find_measure)


def _find(draft: Draft, path: Keys, group: str, name: str, find: Callable[[str], Found]) -> Found | None:
    try:
        return find(name)
    except UsageError as error:
        draft.wrong(path, str(error))
        # The rest is checked against what was probably meant, so that its mistakes are told at once too.
        installed = registry.names(group)
        meant = [] if name in installed else difflib.get_close_matches(name, installed, n=1)
        return _find(draft, path, group, meant[0], find) if meant else None
    except PluginFault as fault:
        raise PluginFault(fault.plugin, fault.what, draft.document.place(path)) from fault


def _machine(draft: Draft) -> Blueprint[Manipulator] | None:
    keys, path = draft.keys.manipulator, ("manipulator",)
    if draft.machine is None or keys.use is None or keys.from_ is not None:
        return None
    return Blueprint(keys.use, draft.machine, keys.model_extra or {}, path, draft.document.place(path))

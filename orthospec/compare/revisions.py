"""The specs and results that differ between a git revision and the working tree."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from orthospec.compare.sides import Comparison, compare, read_side
from orthospec.errors import OrthospecError, UsageError

_OURS = (":(top)*.yaml", ":(top)*.yml")
_OURS_ALONE = re.compile(r"^orthospec[ \t]*:", re.MULTILINE)
"""The key that specs and results have."""


@dataclass(frozen=True)
class Changed:
    """One file: what differs in it, or in words why that is not known."""

    path: str
    comparison: Comparison | None
    said: str = ""


def changed_since(revision: str) -> list[Changed]:
    """Each spec and result that differs in the working tree from what it was at a revision, by path.

    Raises `UsageError` outside a git repository, and for a revision that there is not.
    """
    commit = _commit(revision)
    listed = _git("diff", "--name-status", "--no-renames", "-z", commit, "--", *_OURS).split("\0")
    new = _git("ls-files", "--full-name", "--others", "--exclude-standard", "-z", "--", *_OURS).split("\0")
    top = Path(_git("rev-parse", "--show-toplevel").strip())
    pairs = [*zip(listed[::2], listed[1::2], strict=False), *(("A", path) for path in new if path)]
    found = [_changed(commit, revision, state, path, top) for state, path in pairs]
    return sorted((one for one in found if one is not None), key=lambda one: one.path)


def _commit(revision: str) -> str:
    """The hash that a revision's name stands for: a name is no option."""
    try:
        named = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    except UsageError:
        named = ""
    if not named.strip():
        _git("rev-parse", "--show-toplevel")  # Outside a repository git says so.
        raise UsageError(f"git: '{revision}' is no revision of this repository")
    return named.strip()


def _changed(commit: str, revision: str, state: str, path: str, top: Path) -> Changed | None:
    here = top / path
    if state == "A":
        return Changed(path, None, "new") if _is_ours(here.read_text("utf-8", "replace")) else None
    before = _git("show", f"{commit}:{path}")
    if not _is_ours(before):
        return None
    if state == "D":
        return Changed(path, None, "removed")
    with _copied(before) as copy:
        try:
            a = read_side(copy, stands_for=here, name=f"{path} ({revision})")
            return Changed(path, compare(a, read_side(here, name=path)))
        except OrthospecError as error:
            return Changed(path, None, str(error).replace(f"{top}{os.sep}", ""))


@contextmanager
def _copied(text: str) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "before.yaml"
        copy.write_text(text, encoding="utf-8")
        yield copy


def _is_ours(text: str) -> bool:
    return _OURS_ALONE.search(text) is not None


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], capture_output=True, check=True)
    except FileNotFoundError:
        raise UsageError("git is not installed, and a revision is asked for") from None
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode("utf-8", "replace").strip().splitlines()
        raise UsageError(f"git: {said[0] if said else 'failed'}") from None
    return done.stdout.decode("utf-8", "replace")

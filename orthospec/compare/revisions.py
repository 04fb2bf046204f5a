"""The specs and results that differ between a git revision and the working tree."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from orthospec.compare.sides import Comparison, compare, read_side
from orthospec.errors import OrthospecError, UsageError

_OURS = (":(top)*.yaml", ":(top)*.yml")
_FIRST = "orthospec:"
"""With this key a spec or a result begins."""


@dataclass(frozen=True)
class Changed:
    """One file: what differs in it, or in words why that is not known."""

    path: str
    comparison: Comparison | None
    said: str = ""


def changed_since(revision: str) -> list[Changed]:
    """Each spec and result that differs in the working tree from what it was at a revision, in git's order.

    Raises `UsageError` outside a git repository, and for a revision that there is not.
    """
    listed = _git("diff", "--name-status", "--no-renames", "-z", revision, "--", *_OURS).split("\0")
    top = Path(_git("rev-parse", "--show-toplevel").strip())
    pairs = zip(listed[::2], listed[1::2], strict=False)
    return [one for state, path in pairs if (one := _changed(revision, state, path, top)) is not None]


def _changed(revision: str, state: str, path: str, top: Path) -> Changed | None:
    here = top / path
    if state == "A":
        return Changed(path, None, "new") if _is_ours(here.read_text("utf-8", "replace")) else None
    before = _git("show", f"{revision}:{path}")
    if not _is_ours(before):
        return None
    if state == "D":
        return Changed(path, None, "removed")
    with _copied(before) as copy:
        try:
            a = read_side(copy, stands_for=here, name=f"{path} ({revision})")
            return Changed(path, compare(a, read_side(here, name=path)))
        except OrthospecError as error:
            return Changed(path, None, str(error))


@contextmanager
def _copied(text: str) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "before.yaml"
        copy.write_text(text, encoding="utf-8")
        yield copy


def _is_ours(text: str) -> bool:
    lines = (line for line in text.splitlines() if line.strip() and not line.startswith(("#", "---")))
    return next(lines, "").startswith(_FIRST)


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], capture_output=True, check=True)
    except FileNotFoundError:
        raise UsageError("git is not installed, and a revision is asked for") from None
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode("utf-8", "replace").strip().splitlines()
        raise UsageError(f"git: {said[0] if said else 'failed'}") from None
    return done.stdout.decode("utf-8", "replace")

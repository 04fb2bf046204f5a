"""How git calls an external diff command, gitattributes(5) and git(1): one file in two versions."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

_WHOLE = (7, 9)
"""``path old-file old-hex old-mode new-file new-hex new-mode``; then a renamed file's new path, how alike."""
_COUNTER = "GIT_DIFF_PATH_COUNTER"
"""Git sets it for external diff commands."""
_NOTHING = "/dev/null"
_SHORT = 7


@dataclass(frozen=True)
class GitCall:
    """One file in two versions; None where it is not there, both where git is in the middle of a merge."""

    path: Path
    """Where it stands in the working tree, the current folder being the top."""
    old: Path | None = None
    new: Path | None = None
    old_name: str = ""
    new_name: str = ""
    new_path: Path | None = None
    """Of a renamed file."""


def git_call(arguments: Sequence[str], environment: Mapping[str, str]) -> GitCall | None:
    """What git asks for; None where these are not its arguments."""
    if len(arguments) == 1 and _COUNTER in environment:
        return GitCall(Path(arguments[0]))
    if len(arguments) not in _WHOLE:
        return None
    path, old, old_hex, _, new, new_hex, _ = arguments[:7]
    moved = Path(arguments[7]) if len(arguments) > 7 else None
    return GitCall(
        Path(path),
        None if old == _NOTHING else Path(old),
        None if new == _NOTHING else Path(new),
        f"{path} ({_version(old_hex)})",
        f"{moved or path} ({_version(new_hex)})",
        moved,
    )


def _version(hexadecimal: str) -> str:
    """A blob's short name; git gives zeros, or no number, for what it has not hashed."""
    known = hexadecimal.strip("0.")
    return hexadecimal[:_SHORT] if known else "in the working tree"


def line_by_line(call: GitCall) -> str:
    """The two versions by their lines, where they have no meaning to compare."""
    before, after = (_lines(path) for path in (call.old, call.new))
    lines = difflib.unified_diff(before, after, call.old_name, call.new_name, lineterm="")
    return "\n".join(lines)


def _lines(path: Path | None) -> list[str]:
    return [] if path is None else path.read_text(encoding="utf-8", errors="replace").splitlines()

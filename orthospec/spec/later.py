"""What format 1 has a place for and this version does not serve yet."""

from __future__ import annotations

from orthospec.spec.draft import Draft

NOT_YET = "not available in this version"


def check(draft: Draft) -> None:
    """A mistake for each part of the spec that is well formed and not served."""
    keys = draft.keys
    given = {
        ("workspace", "orientation"): keys.workspace.orientation,
    }
    for path, value in given.items():
        if value is not None:
            draft.wrong(path, f"'{path[-1]}' is {NOT_YET}", at_key=True)

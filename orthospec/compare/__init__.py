"""Two specs, or two results, side by side by what they mean: from files to rows."""

from orthospec.compare.git import GitCall, git_call, line_by_line
from orthospec.compare.revisions import Changed, changed_since
from orthospec.compare.rows import Row, State, rows
from orthospec.compare.sides import Comparison, Side, compare, read_side

__all__ = [
    "Changed",
    "Comparison",
    "GitCall",
    "Row",
    "Side",
    "State",
    "changed_since",
    "compare",
    "git_call",
    "line_by_line",
    "read_side",
    "rows",
]

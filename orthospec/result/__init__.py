"""What a run found: frozen records, their plain content, and the folder that keeps it."""

from orthospec.result.content import compose
from orthospec.result.files import (
    PREVIEW,
    REPORT,
    RESULT,
    check_destination,
    log_of,
    read_result,
    spec_of,
    write_page,
    write_result,
)
from orthospec.result.model import Result
from orthospec.result.records import (
    FURTHEST,
    Attainment,
    Branch,
    Card,
    Culprit,
    Finding,
    FrontSearch,
    GoalOutcome,
    Limit,
    Note,
    PluginError,
    Search,
    Status,
    Taken,
)

__all__ = [
    "FURTHEST",
    "PREVIEW",
    "REPORT",
    "RESULT",
    "Attainment",
    "Branch",
    "Card",
    "Culprit",
    "Finding",
    "FrontSearch",
    "GoalOutcome",
    "Limit",
    "Note",
    "PluginError",
    "Result",
    "Search",
    "Status",
    "Taken",
    "check_destination",
    "compose",
    "log_of",
    "read_result",
    "spec_of",
    "write_page",
    "write_result",
]

"""What a run found: frozen records, their plain content, and the folder that keeps it."""

from orthospec.result.records import (
    Attainment,
    Finding,
    GoalOutcome,
    Limit,
    PluginError,
    Search,
    Status,
)

__all__ = ["Attainment", "Finding", "GoalOutcome", "Limit", "PluginError", "Search", "Status"]

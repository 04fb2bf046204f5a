"""Text for the terminal: a result as a person reads it, what is known of the plugins, and progress."""

from orthospec.show.diff import diff_content, show_diff
from orthospec.show.plan import plan_content, show_plan
from orthospec.show.plugins import explain, installed, show_installed
from orthospec.show.progress import ProgressLine
from orthospec.show.result import show
from orthospec.show.what_if import show_what_if, what_if_content

__all__ = [
    "ProgressLine",
    "diff_content",
    "explain",
    "installed",
    "plan_content",
    "show",
    "show_diff",
    "show_installed",
    "show_plan",
    "show_what_if",
    "what_if_content",
]

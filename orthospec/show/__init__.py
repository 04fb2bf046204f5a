"""Text for the terminal: a result as a person reads it, what is known of the plugins, and progress."""

from orthospec.show.diff import diff_content, show_diff
from orthospec.show.markdown import comment, compared
from orthospec.show.plan import plan_content, show_plan
from orthospec.show.plugins import explain, explained, installed, show_installed
from orthospec.show.progress import ProgressLine, Silence
from orthospec.show.result import show
from orthospec.show.what_if import show_what_if, what_if_content

__all__ = [
    "ProgressLine",
    "Silence",
    "comment",
    "compared",
    "diff_content",
    "explain",
    "explained",
    "installed",
    "plan_content",
    "show",
    "show_diff",
    "show_installed",
    "show_plan",
    "show_what_if",
    "what_if_content",
]

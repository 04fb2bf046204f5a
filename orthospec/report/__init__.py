"""A solution as one page for people, and its figures and tables for papers."""

from orthospec.report.page import report, summary
from orthospec.report.panel import Panel
from orthospec.report.writing import drawings, write_figures

__all__ = ["Panel", "drawings", "report", "summary", "write_figures"]

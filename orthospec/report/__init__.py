"""A result as one page for people: figures, tables and the sentences that the terminal tells too."""

from orthospec.report.drawing import Drawing
from orthospec.report.drawings import drawings
from orthospec.report.files import write_figures
from orthospec.report.page import report

__all__ = ["Drawing", "drawings", "report", "write_figures"]

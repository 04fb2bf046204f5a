"""Everything in a few lines of Python: what the commands do, as functions, and a result to look into."""

from orthospec.study.study import Study, evaluate, open_study, run

__all__ = ["Study", "evaluate", "open_study", "run"]

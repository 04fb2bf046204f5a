"""The commands, in the order of the work. No arithmetic here; what is heavy is imported where it is used.

Results go to standard output, progress and messages to standard error; `orthospec.guard` has the exit codes.
"""

from orthospec.cli import specs, results, plugins  # isort: skip  # the order of --help
from orthospec.cli.command import app, main

__all__ = ["app", "main", "plugins", "results", "specs"]

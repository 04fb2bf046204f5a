"""What can go wrong, said once: each error keeps its data, composes its own sentence and has an exit code.

0 done, 1 a fault of orthospec itself, 2 wrong use or a wrong spec, 3 no design found that meets the hard
bounds, 4 stopped before the end, 5 a plugin failed. Code 3 is a result's status, not an error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

RAISED = (Exception, SystemExit)
"""What the code of others may raise: SystemExit too, which would end the program without a word."""


class OrthospecError(Exception):
    """Base of all that orthospec raises on purpose; its text is for the user.

    What an error is made from stands in ``args``, so that it crosses from one process to another unharmed.
    """

    exit_code = 1


@dataclass(frozen=True, order=True)
class Mistake:
    """One mistake in a file, at its place (line and column count from 1; 0 where there is no place)."""

    file: str
    line: int
    column: int
    message: str

    @property
    def place(self) -> str:
        """``FILE:LINE:COLUMN``, or where it is not of a line what it is of."""
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file

    def __str__(self) -> str:
        """``FILE:LINE:COLUMN: message``, as editors and compilers write it."""
        return f"{self.place}: {self.message}"


class SpecError(OrthospecError):
    """A spec (or a result file) that cannot be used: all its mistakes at once."""

    exit_code = 2

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        self.mistakes = tuple(sorted(mistakes))
        super().__init__(self.mistakes)

    def __str__(self) -> str:
        """One mistake a line."""
        return "\n".join(str(mistake) for mistake in self.mistakes)


class UsageError(OrthospecError):
    """A command or a function asked for something that cannot be."""

    exit_code = 2


class GridTooLarge(UsageError):
    """A grid has more nodes than can be held; ``shape`` is how many along each axis."""

    def __init__(self, shape: Sequence[int], most: int) -> None:
        self.shape = tuple(shape)
        self.most = most
        super().__init__(self.shape, most)

    @property
    def nodes(self) -> int:
        """How many there would be."""
        return math.prod(self.shape)

    def __str__(self) -> str:
        """How many there would be, and what to do about it."""
        shape = " x ".join(map(str, self.shape))
        return (
            f"the grid would have {self.nodes:.2g} nodes ({shape}), more than {self.most:.0e}: lower"
            " workspace.divisions or give a smaller workspace.region"
        )


class UnbuildableDesign(OrthospecError):
    """A manipulator's or measure's own validator refuses these values of the variables.

    Not a fault: a region of the design space without a machine.
    """

    exit_code = 2

    def __init__(self, values: dict[str, float], reason: str) -> None:
        self.values = dict(values)
        self.reason = reason
        super().__init__(self.values, reason)

    def __str__(self) -> str:
        """Where there is no machine, and why."""
        at = ", ".join(f"{name} = {value:.10g}" for name, value in self.values.items())
        return f"no machine can be built at {at or 'these values'}: {self.reason}"


class PluginFault(OrthospecError):
    """A measure or manipulator raised, or gave back what its contract does not allow."""

    exit_code = 5

    def __init__(self, plugin: str, what: str, place: str | None = None) -> None:
        self.plugin = plugin
        self.what = what
        self.place = place
        super().__init__(plugin, what, place)

    def __str__(self) -> str:
        """Which plugin, and what it did."""
        return f"{self.place + ': ' if self.place else ''}plugin {self.plugin}: {self.what}"


class WorkersLost(OrthospecError):
    """Those who were to do a task are gone; what they completed is kept."""

    exit_code = 4

    def __init__(self, task: str, why: str) -> None:
        self.task = task
        self.why = why
        super().__init__(task, why)

    def __str__(self) -> str:
        """What was being done, and what may be the reason."""
        return f"stopped at '{self.task}': {self.why}"


class NoEnclosure(OrthospecError):
    """Code that cannot be carried over whole boxes of poses, so that nothing is proved of it."""

    exit_code = 5

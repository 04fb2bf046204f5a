"""What can be done independently of anything else, and by anyone: here, in another process, elsewhere.

A task is a function of a module, from a design space and plain frozen data to plain frozen data. Nothing
else goes in or comes out, so that its result is the same wherever it was made, and can be kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from orthospec.optimise.space import DesignSpace

Given = TypeVar("Given")
Made = TypeVar("Made")


@dataclass(frozen=True)
class Task(Generic[Given, Made]):
    """One kind of independent work."""

    name: str
    """In the user's words, for progress: what is being done."""
    work: Callable[[DesignSpace, Given], Made]
    """A function that other processes find by its module and name."""


class Stopped(KeyboardInterrupt):
    """Ctrl-C in the middle of a task that has something to show for it already."""

    def __init__(self, made: object) -> None:
        super().__init__()
        self.made = made

"""Progress on standard error: one line redrawn on a terminal, else a plain line now and then."""

from __future__ import annotations

import io
import shutil
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self, TextIO

REDRAW, PLAIN = 0.1, 5.0
"""Least seconds between two lines, on a terminal and elsewhere."""
ASSURED = 3.0
"""Seconds that a step has to have taken before it is told how long it will take."""


class ProgressLine:
    """Called with what is being done, how much of it is done, and of how much (0: not known)."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        """Draws on ``stream``."""
        self._stream = stream
        self._redraws = stream.isatty()
        self._clock = clock
        self._start = clock()
        self._last = self._start
        self._drawn = False
        self._step, self._since, self._first = "", self._start, 0

    def __enter__(self) -> Self:
        """For ``with``: the line is wiped at the end, whatever happens."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wipe the line."""
        if self._drawn and self._redraws:
            self._stream.write("\r\033[K")
            self._stream.flush()

    def __call__(self, what: str, done: int, total: int) -> None:
        """Draw, unless the last line is too young."""
        now = self._clock()
        if what != self._step:
            self._step, self._since, self._first = what, now, done
        if now - self._last < (REDRAW if self._redraws else PLAIN):
            return
        self._last, self._drawn = now, True
        part = f" {100 * done // total} %" if total else ""
        text = f"{what}{part}, {_elapsed(now - self._start)}{self._left(done, total, now)}"
        if self._redraws:
            room = shutil.get_terminal_size().columns - 1
            self._stream.write(f"\r\033[K{text[:room]}")
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()

    def _left(self, done: int, total: int, now: float) -> str:
        """How long this step takes yet, if it goes on as it went."""
        taken = now - self._since
        if not self._first < done < total or taken < ASSURED:
            return ""
        return f", this step some {_elapsed(taken * (total - done) / (done - self._first))} more"


class Silence(ProgressLine):
    """Tells nothing."""

    def __init__(self) -> None:
        """It needs no stream."""
        super().__init__(io.StringIO())

    def __call__(self, what: str, done: int, total: int) -> None:
        """Say nothing."""


def _elapsed(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"

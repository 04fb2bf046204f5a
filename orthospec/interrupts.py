"""Ctrl-C made to wait for what may not be cut in half, and a request to end taken for it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def end_as_by_ctrl_c() -> None:
    """Let SIGTERM, by which batch systems and ``timeout`` ask for the end, do what Ctrl-C does."""

    def asked(*_: object) -> None:
        if callable(signal.getsignal(signal.SIGINT)):
            signal.raise_signal(signal.SIGINT)
        else:  # Ctrl-C is ignored, as in what a shell has in the background.
            raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, asked)


@contextmanager
def ctrl_c_waiting() -> Iterator[None]:
    """Let Ctrl-C come at the end; processes begun meanwhile never hear it, not even while they import."""
    with _noted(), _masked():
        yield


@contextmanager
def _masked() -> Iterator[None]:
    """What this thread, and the processes that it begins, do not hear; another thread may hear it yet."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _noted() -> Iterator[None]:
    """Whichever thread hears it, the main one acts on it, at the end."""
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is None:
        yield
        return
    heard: list[int] = []
    handler = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if heard:
            signal.raise_signal(signal.SIGINT)

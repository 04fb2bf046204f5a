"""Ctrl-C made to wait: it comes once, at the end, whichever thread hears it."""

from __future__ import annotations

import signal
import threading
import time

import pytest

from orthospec.interrupts import ctrl_c_waiting

pytestmark = pytest.mark.usefixtures("hears_ctrl_c")


def test_it_comes_at_the_end_of_the_outermost() -> None:
    done = []

    def nested() -> None:
        with ctrl_c_waiting():
            with ctrl_c_waiting():
                signal.raise_signal(signal.SIGINT)
                done.append("inner")
            done.append("outer")

    with pytest.raises(KeyboardInterrupt):
        nested()
    assert done == ["inner", "outer"]


def test_it_waits_too_where_another_thread_hears_it() -> None:
    done, end = [], threading.Event()
    other = threading.Thread(target=end.wait)
    other.start()

    def work() -> None:
        with ctrl_c_waiting():
            signal.pthread_kill(other.ident or 0, signal.SIGINT)
            time.sleep(0.05)  # for the other thread to hear it
            done.append("all")

    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        end.set()
        other.join()
    assert done == ["all"]


def test_where_it_is_ignored_it_stays_so() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with ctrl_c_waiting():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN

"""Rivals that take turns, their medians and quartiles, and what a process took."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

Rivals = Mapping[str, Callable[[], Any]]

READ = 1 << 27
"""Bytes that are read to tell the bandwidth, more than caches hold."""


def taken(rivals: Rivals, rounds: int) -> dict[str, list[float]]:
    """Seconds of each in every round; they take turns, so that a busy spell meets all of them."""
    seconds: dict[str, list[float]] = {name: [] for name in rivals}
    for _ in range(rounds):
        for name, rival in rivals.items():
            start = time.perf_counter()
            rival()
            seconds[name].append(time.perf_counter() - start)
    return seconds


def quartiles(seconds: list[float]) -> tuple[float, float, float]:
    """Lower quartile, median and upper quartile; of one round three times the same."""
    if len(seconds) == 1:
        return seconds[0], seconds[0], seconds[0]
    low, middle, high = statistics.quantiles(seconds, n=4, method="inclusive")
    return low, middle, high


def compare(title: str, rivals: Rivals, each: int, rounds: int, read: int | None = None) -> None:
    """Print a row for each rival: its ratio is to the first one, and ``each`` says of how many things.

    ``read`` is how many bytes have to be read at least; a row then tells what reading takes from memory.
    """
    seconds = taken(rivals, rounds)
    first = statistics.median(next(iter(seconds.values())))
    print(f"\n{title:<52}{'ms':>10}{'quartiles':>20}{'ns each' if each > 1 else '':>9}{'ratio':>8}")
    for name, times in seconds.items():
        low, middle, high = quartiles(times)
        _print_row(name, middle, f"{1e3 * low:.4g} ... {1e3 * high:.4g}", each, middle / first)
    if read is not None:
        floor = read / bandwidth()
        _print_row(f"memory read once, {read / 2**20:.0f} MiB", floor, "", each, floor / first)


def _print_row(name: str, seconds: float, between: str, each: int, ratio: float) -> None:
    nanoseconds = f"{1e9 * seconds / each:.2f}" if each > 1 else ""
    print(f"  {name:<50}{1e3 * seconds:10.3f}{between:>20}{nanoseconds:>9}{ratio:8.2f}", flush=True)


def bandwidth() -> float:
    """Bytes a second that one thread reads from memory: NumPy's maximum of bytes, the best of nine."""
    if not _BANDWIDTH:
        block = np.ones(READ, dtype=np.uint8)  # zeros would all be one page
        _BANDWIDTH.append(READ / min(taken({"": block.max}, 9)[""]))
    return _BANDWIDTH[0]


_BANDWIDTH: list[float] = []

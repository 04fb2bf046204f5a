"""Who does the tasks: this process, other processes of this machine, or a cluster.

Whoever it is, an item's result is the same, and results are told by the number of their item: nothing that
follows depends on who was first.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import re
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Protocol

from orthospec.errors import UsageError, WorkersLost
from orthospec.interrupts import ctrl_c_waiting
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Given, Made, Task
from orthospec.optimise.versions import fingerprint
from orthospec.threads import one_blas_thread
from orthospec.workspace.field import Progress

ATTEMPTS = 3
"""How often tasks are begun whose worker dies: what kills every worker is the task itself."""
ADDRESS = re.compile(r"(tcp|tls)://[^\s/]+:\d{1,5}")
"""A scheduler's; Dask tries any other text for twice its patience."""
PATIENCE = 10
"""Seconds in which a scheduler must answer."""


class Workers(Protocol):
    """Whoever does tasks."""

    def each(
        self,
        task: Task[Given, Made],
        space: DesignSpace,
        items: Sequence[Given],
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, as they are completed.

        An error in a task is raised here. Ctrl-C while waiting is KeyboardInterrupt, or `Stopped`.
        """


class Here:
    """Does one task after the other in this process."""

    def each(
        self,
        task: Task[Given, Made],
        space: DesignSpace,
        items: Sequence[Given],
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, in order."""
        for number, item in enumerate(items):
            yield number, task.work(space, item, progress)


class Processes:
    """Does tasks in other processes of this machine, one BLAS thread each.

    They are begun afresh, not forked, when there is work, so that no state of this process reaches them.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: ProcessPoolExecutor | None = None
        self._lifeline: Connection | None = None

    def each(
        self,
        task: Task[Given, Made],
        space: DesignSpace,
        items: Sequence[Given],
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, as they are completed.

        Where a worker dies, new ones do what is left.
        """
        if task.divides and len(items) == 1:
            yield 0, task.work(space.helped_by(self), items[0], progress)
            return
        left = dict(enumerate(items))
        for _ in range(ATTEMPTS):
            try:
                for number, made in _completed(self._running(), task.work, space, left):
                    del left[number]
                    yield number, made
                return
            except BrokenProcessPool:
                self.close()
        why = f"the worker processes died {ATTEMPTS} times; if memory is short, try fewer --jobs"
        raise WorkersLost(task.name, why)

    def close(self) -> None:
        """End the processes, in the middle of their work if need be."""
        if self._pool is not None and self._lifeline is not None:
            self._lifeline.close()
            self._pool.shutdown(cancel_futures=True)
            self._pool = None

    def _running(self) -> ProcessPoolExecutor:
        if self._pool is None:
            one_blas_thread()
            context = multiprocessing.get_context("spawn")
            end, self._lifeline = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(self._count, context, _settle_in, (end,))
        return self._pool


def _settle_in(lifeline: Connection) -> None:
    """Live as long as the process that began this one, and leave Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_outlive_nothing, args=(lifeline,), daemon=True).start()


def _outlive_nothing(lifeline: Connection) -> None:
    """End with the other end of the line: it is closed on purpose, or by the death of its process."""
    lifeline.poll(None)
    os._exit(0)


class Cluster:
    """Does tasks on the workers of a Dask scheduler, which gives those of a worker that dies to others."""

    def __init__(self, url: str) -> None:
        if not ADDRESS.fullmatch(url):
            raise UsageError(f"--on {url}: the address of a scheduler was expected, like tcp://HOST:8786")
        try:
            from distributed import Client
        except ImportError:
            message = "--on needs Dask, which is not installed: pip install 'orthospec[dask]'"
            raise UsageError(message) from None
        # What goes wrong is raised; Dask's log would tell it again, by traces.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client: Any = Client(url, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise UsageError(f"--on {url}: no Dask scheduler answers there") from error

    def each(
        self,
        task: Task[Given, Made],
        space: DesignSpace,
        items: Sequence[Given],
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, as they are completed."""
        if task.divides and len(items) == 1:
            yield 0, task.work(space.helped_by(self), items[0], progress)
            return
        if progress is not None and not self._client.scheduler_info()["workers"]:
            progress("waiting for a worker of the cluster", 0, 0)
        from distributed import KilledWorker

        work = _Checked(task.work, fingerprint(space.spec))
        try:
            yield from _completed(self._client.get_executor(), work, space, dict(enumerate(items)))
        except KilledWorker:
            why = "one worker after another died of it; if memory is short, give them more"
            raise WorkersLost(task.name, why) from None
        except CancelledError:
            raise WorkersLost(task.name, "the scheduler no longer answers") from None

    def close(self) -> None:
        """Take back what is not done, and leave the scheduler and its workers to others."""
        self._client.close()


class _Checked:
    """Work that is refused where other versions are installed: they might make something else of it."""

    def __init__(self, work: Callable[[DesignSpace, Any, Progress | None], Any], versions: str) -> None:
        self._work, self._versions = work, versions

    def __call__(self, space: DesignSpace, item: Any, progress: Progress | None) -> Any:
        if fingerprint(space.spec) != self._versions:
            raise UsageError(
                "a worker of the cluster has other versions of orthospec or its plugins than this machine:"
                " install the same ones"
            )
        return self._work(space, item, progress)


def _completed(
    executor: Executor,
    work: Callable[[DesignSpace, Given, Progress | None], Made],
    space: DesignSpace,
    items: Mapping[int, Given],
) -> Iterator[tuple[int, Made]]:
    """Each item's number and result, as they are completed; of several errors that of the first item."""
    with ctrl_c_waiting():
        futures = {executor.submit(work, space, item, None): number for number, item in items.items()}
    try:
        for future in as_completed(list(futures)):
            if future.exception() is not None:
                earlier = [other for other, number in futures.items() if number < futures[future]]
                for other in [*sorted(wait(earlier).done, key=futures.__getitem__), future]:
                    other.result()
            # Forgotten here as well: all results of a large field together may not fit in memory.
            yield futures.pop(future), future.result()
    finally:
        for future in futures:
            future.cancel()


@contextmanager
def hired(jobs: int = 1, on: str | None = None) -> Iterator[Workers]:
    """The workers asked for; dismissed at the end, whatever happens."""
    if on is not None:
        workers: Processes | Cluster = Cluster(on)
    elif jobs > 1:
        workers = Processes(jobs)
    else:
        yield Here()
        return
    try:
        yield workers
    finally:
        workers.close()


def labelled(progress: Progress | None, label: str) -> Progress | None:
    """Progress that says what it is a part of."""
    if progress is None:
        return None
    return lambda what, done, total: progress(f"{label}: {what}", done, total)


def counted(
    workers: Workers,
    task: Task[Given, Made],
    space: DesignSpace,
    items: Sequence[Given],
    progress: Progress | None = None,
) -> Iterator[tuple[int, Made]]:
    """Each item's number and what was made of it, as they are completed; tells how many are."""
    if progress is None:
        yield from workers.each(task, space, items)
        return
    done = 0

    def within(what: str, part: int, whole: int) -> None:
        progress(f"{task.name}, {done + 1} of {len(items)}: {what}", part, whole)

    progress(task.name, 0, len(items))
    for number, made in workers.each(task, space, items, within if len(items) > 1 else progress):
        yield number, made
        done += 1
        progress(task.name, done, len(items))


def in_order(
    workers: Workers,
    task: Task[Given, Made],
    space: DesignSpace,
    items: Sequence[Given],
    progress: Progress | None = None,
) -> list[Made]:
    """What the task makes of each item, in the order of the items, whoever was first."""
    found = dict(counted(workers, task, space, items, progress))
    return [found[number] for number in range(len(items))]

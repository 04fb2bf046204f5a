"""Who does the tasks: this process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Given, Made, Task
from orthospec.workspace.field import Progress


class Workers(Protocol):
    """Whoever does tasks."""

    def each(
        self, task: Task[Given, Made], space: DesignSpace, items: Sequence[Given]
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, as they are completed.

        An error in a task is raised here. Ctrl-C while waiting is KeyboardInterrupt, or `Stopped`.
        """


class Here:
    """Does one task after the other in this process."""

    def each(
        self, task: Task[Given, Made], space: DesignSpace, items: Sequence[Given]
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it, in order."""
        for number, item in enumerate(items):
            yield number, task.work(space, item)


def in_order(
    workers: Workers,
    task: Task[Given, Made],
    space: DesignSpace,
    items: Sequence[Given],
    progress: Progress | None = None,
) -> list[Made]:
    """What the task makes of each item, in the order of the items, whoever was first."""
    found: dict[int, Made] = {}
    if progress is not None:
        progress(task.name, 0, len(items))
    for number, made in workers.each(task, space, items):
        found[number] = made
        if progress is not None:
            progress(task.name, len(found), len(items))
    return [found[number] for number in range(len(items))]

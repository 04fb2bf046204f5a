"""Results of tasks, kept in a folder under a name that tells all that they depend on.

The name is a hash of the task, of what it was given, of the part of the spec that decides it, and of the code
that made it. So a result is right whenever it is found: no option has to say whether to trust it, a changed
title finds everything, and a run that was killed goes on by being run again. Each file is written whole or
not at all, and with a hash of its own: one that is damaged counts as none.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from orthospec.errors import UsageError
from orthospec.optimise.plain import decode, encode
from orthospec.optimise.versions import fingerprint

if TYPE_CHECKING:
    from orthospec.optimise.space import DesignSpace
    from orthospec.optimise.tasks import Given, Made, Task
    from orthospec.optimise.workers import Workers
    from orthospec.workspace.field import Progress

Plain = TypeVar("Plain")

_BOUNDS = frozenset({"at_least", "at_most", "levels"})

MOST_BYTES = 1 << 30
"""Of all files; those unused for longest go first."""
OURS = re.compile(r"[0-9a-f]{64}\.(json|field)|\.orthospec-[0-9a-f]{16}")
"""Names of files that may be removed: the folder may be anyone's, by mistake."""


class Cache:
    """A folder of kept results; it may be shared, and holds nothing that could be run."""

    def __init__(self, folder: Path) -> None:
        """Raises UsageError where nothing can be kept in the folder."""
        self.folder = folder
        self.asked = 0
        """How many results were asked for so far."""
        self.known = 0
        """How many of them were kept from before."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UsageError(f"{folder}: results cannot be kept there: {reason}") from None

    def count(self, asked: int, left: int) -> None:
        """So many results were asked for, and so many of them are left to be made."""
        self.asked += asked
        self.known += asked - left

    def read(self, key: str) -> Any:
        """What is kept under a name, as JSON; None where nothing sound is."""
        path = self.path(key)
        try:
            digest, _, text = path.read_text(encoding="utf-8").partition("\n")
            if digest != sha256_of(text):
                return None
            content = json.loads(text)
        except (OSError, ValueError):
            return None
        with suppress(OSError):
            os.utime(path)
        return content

    def write(self, key: str, content: Any) -> None:
        """Keep content; a full disk only means that it is not kept."""
        text = json.dumps(content, ensure_ascii=False)
        with suppress(OSError), self.replacing(self.path(key)) as fresh:
            fresh.write_text(f"{sha256_of(text)}\n{text}", encoding="utf-8")

    def kept(self, key: str, kind: type[Plain], make: Callable[[], Plain]) -> Plain:
        """What is kept under a name, if it is sound and of a class; else what is made, which is kept then."""
        try:
            known = decode(self.read(key), [kind])
        except ValueError:
            known = None
        if isinstance(known, kind):
            return known
        made = make()
        self.write(key, encode(made))
        return made

    @contextmanager
    def replacing(self, path: Path) -> Iterator[Path]:
        """A path to write to, which then takes the place of ``path`` in one step."""
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = path.parent / f".orthospec-{secrets.token_hex(8)}"
        try:
            yield fresh
            os.replace(fresh, path)
        finally:
            fresh.unlink(missing_ok=True)

    def trim(self, most: int = MOST_BYTES, kind: str = "") -> None:
        """Remove what was unused for longest, until no more than so many bytes are left; no other's files.

        With a kind only files of that kind are counted, and removed.
        """
        found = []
        for path in self.folder.glob("[0-9a-f][0-9a-f]/*"):
            with suppress(OSError):
                if OURS.fullmatch(path.name) and path.name.endswith(kind):
                    found.append((path.stat().st_mtime, path.stat().st_size, path))
        total = sum(size for _, size, _ in found)
        for _, size, path in sorted(found):
            if total <= most:
                return
            with suppress(OSError):
                path.unlink()
            total -= size

    def path(self, key: str, kind: str = "json") -> Path:
        """Where what has this name stands, or would stand."""
        return self.folder / key[:2] / f"{key}.{kind}"


class Remembering:
    """Workers that do only what is not kept already, and keep each result as soon as it is there."""

    def __init__(self, workers: Workers, cache: Cache) -> None:
        self._workers, self._cache = workers, cache

    @property
    def asked(self) -> int:
        """How many results were asked for so far; the slabs of a large field count as well."""
        return self._cache.asked

    @property
    def known(self) -> int:
        """How many of them were kept from before."""
        return self._cache.known

    def each(
        self,
        task: Task[Given, Made],
        space: DesignSpace,
        items: Sequence[Given],
        progress: Progress | None = None,
    ) -> Iterator[tuple[int, Made]]:
        """Each item's number and what was made of it: first what is known, then the rest when it is done."""
        space = space.kept_in(self._cache)
        if task.keeps_parts:
            yield from self._workers.each(task, space, items, progress)
            return
        keys, left = _keys(task, space, items), []
        for number, key in enumerate(keys):
            try:
                made = decode(self._cache.read(key)["made"], task.makes)
            except (TypeError, KeyError, ValueError):
                left.append(number)
                continue
            yield number, made
        self._cache.count(len(items), len(left))
        for k, made in self._workers.each(task, space, [items[number] for number in left], progress):
            if task.lasting(made):
                self._cache.write(keys[left[k]], {"made": encode(made)})
            yield left[k], made


def _keys(task: Task[Given, Made], space: DesignSpace, items: Sequence[Given]) -> list[str]:
    """The name of each item's result."""
    content = task.depends(space.spec.canonical())
    where = f"{task.work.__module__}.{task.work.__qualname__}"
    common = [where, content, fingerprint(space.spec)]
    return [sha256_of(json.dumps([*common, encode(item)], ensure_ascii=False)) for item in items]


def kept_of(folder: Path | None, task: Task[Given, Made], space: DesignSpace, items: Sequence[Given]) -> int:
    """How many of the items' results seem to be kept in a folder, or the user's; nothing is made or read."""
    where = user_cache() if folder is None else folder
    return sum((where / key[:2] / f"{key}.json").exists() for key in _keys(task, space, items))


def own_keys(measure: Mapping[str, Any]) -> dict[str, Any]:
    """A measure's keys that decide its values and its forms: not its bounds."""
    return {key: value for key, value in measure.items() if key not in _BOUNDS}


def sha256_of(text: str) -> str:
    """In hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


@contextmanager
def remembering(workers: Workers, folder: Path | None = None) -> Iterator[Remembering]:
    """Workers that keep results in a folder.

    Without one it is the user's cache folder, or where that cannot be written one for this run alone.
    """
    with tempfile.TemporaryDirectory() as passing:
        cache = Cache(folder) if folder is not None else _users_or(Path(passing))
        try:
            yield Remembering(workers, cache)
        finally:
            cache.trim()


def cache_there(folder: Path) -> Cache | None:
    """A cache in another's folder; None where this machine has none such, or none to write in."""
    if not folder.is_dir():
        return None
    try:
        return Cache(folder)
    except UsageError:
        return None


def _users_or(other: Path) -> Cache:
    try:
        return Cache(user_cache())
    except UsageError:
        return Cache(other)


def user_cache() -> Path:
    """Where the user's system keeps what can be made again."""
    from platformdirs import user_cache_path

    return user_cache_path("orthospec", appauthor=False)

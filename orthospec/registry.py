"""Names to classes: manipulators and measures by entry point, loaded when first asked for.

The built-ins come through the same door as anyone else's: a distribution that declares, in the group
``orthospec.measures`` or ``orthospec.manipulators``, a name and the class it stands for.
"""

from __future__ import annotations

import difflib
import inspect
import sys
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import EntryPoint, distributions
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from orthospec.errors import RAISED, PluginFault, UsageError

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Measure

MANIPULATORS = "orthospec.manipulators"
MEASURES = "orthospec.measures"

_Base = TypeVar("_Base")


class Installed(NamedTuple):
    """One name as one distribution declares it, loadable or not."""

    group: str
    name: str
    distribution: str
    version: str
    target: str


def installed() -> tuple[Installed, ...]:
    """All that the installed distributions declare, sorted; a name with two owners comes twice."""
    return _declared(tuple(sys.path))


def find_manipulator(name: str) -> type[Manipulator]:
    """The manipulator class of this name; `UsageError` for an unknown one, `PluginFault` for a broken one."""
    from orthospec.manipulators import Manipulator

    return _find(MANIPULATORS, name, Manipulator)  # type: ignore[type-abstract]


def find_measure(name: str) -> type[Measure]:
    """The measure class of this name; `UsageError` for an unknown one, `PluginFault` for a broken one."""
    from orthospec.measures import Measure

    return _find(MEASURES, name, Measure)  # type: ignore[type-abstract]


def names(group: str) -> tuple[str, ...]:
    """The names installed in a group, sorted, each once."""
    return tuple(sorted({entry.name for entry in installed() if entry.group == group}))


def distribution_of(group: str, name: str) -> Installed:
    """Which distribution provides a name, and in which version."""
    owners = [entry for entry in installed() if entry.group == group and entry.name == name]
    if not owners:
        raise UsageError(_unknown(group, name))
    if len(owners) > 1:
        both = " and ".join(owner.distribution for owner in owners)
        raise UsageError(f"{_kind(group)} '{name}' is provided by {both}; uninstall all but one of them")
    return owners[0]


def _find(group: str, name: str, base: type[_Base]) -> type[_Base]:
    owner = distribution_of(group, name)
    try:
        found = EntryPoint(name, owner.target, group).load()
    except RAISED as error:
        raise PluginFault(
            name, f"{owner.target} of {owner.distribution} cannot be loaded: {_words(error)}"
        ) from error
    if not (isinstance(found, type) and issubclass(found, base)):
        raise PluginFault(name, f"{owner.target} of {owner.distribution} is not a {base.__name__} class")
    if inspect.isabstract(found):
        lacks = ", ".join(sorted(getattr(found, "__abstractmethods__", ())))
        raise PluginFault(name, f"{owner.target} of {owner.distribution} does not define {lacks}")
    undeclared = [one for one in base.__annotations__ if one[0] != "_" and not hasattr(found, one)]
    if undeclared:
        lacks = ", ".join(undeclared)
        raise PluginFault(name, f"{owner.target} of {owner.distribution} does not declare {lacks}")
    return found


def _unknown(group: str, name: str) -> str:
    known = names(group)
    close = difflib.get_close_matches(name, known, n=1)
    meant = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown {_kind(group)} '{name}'; {meant}installed: {', '.join(known) or 'none'}"


def _kind(group: str) -> str:
    return group.removeprefix("orthospec.").removesuffix("s")


def _words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


@lru_cache(maxsize=1)
def _declared(path: tuple[str, ...]) -> tuple[Installed, ...]:
    return tuple(sorted(set(_scan(path))))


def _scan(path: tuple[str, ...]) -> Iterator[Installed]:
    """The first distribution of a name on the path counts, as it does for import."""
    seen: set[str] = set()
    for distribution in distributions(path=list(path)):
        entries = [entry for entry in distribution.entry_points if entry.group in (MANIPULATORS, MEASURES)]
        if not entries:
            continue
        about = distribution.metadata  # read anew at each call
        owner, version = about["Name"], about["Version"]
        key = owner.lower().replace("-", "_").replace(".", "_")
        if key in seen:
            continue
        seen.add(key)
        for entry in entries:
            yield Installed(entry.group, entry.name, owner, version, entry.value)

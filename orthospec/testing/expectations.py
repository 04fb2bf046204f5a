"""What is expected of any plugin, and how it is said where it is not met."""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from orthospec.errors import RAISED, OrthospecError, PluginFault
from orthospec.quantities.units import UnitError, parse_unit
from orthospec.show.keys import keys_of

if TYPE_CHECKING:
    from pydantic import BaseModel

    from orthospec.arrays import Array, Flags, Poses


Given = TypeVar("Given")


class Nonconformity(AssertionError):
    """A promise that a plugin does not keep."""


def expect(holds: Any, who: object, said: str, way_out: str) -> None:
    """Raise `Nonconformity` where something does not hold."""
    if not holds:
        raise Nonconformity(f"{type(who).__name__}: {said}: {way_out}")


def asked(who: object, said: str, work: Callable[[], Given], way_out: str) -> Given:
    """What a plugin gives for ``work``; raises `Nonconformity` where it raises anything but on purpose."""
    try:
        return work()
    except OrthospecError:
        raise
    except RAISED as error:
        told = f"{said} raised {type(error).__name__}: {error}"
        raise Nonconformity(f"{type(who).__name__}: {told}: {way_out}") from error


@contextmanager
def faults_told(who: object) -> Iterator[None]:
    """Whatever a plugin raises meanwhile, and its faults that a run would tell, as `Nonconformity`."""
    try:
        yield
    except PluginFault as fault:
        raise Nonconformity(
            f"{fault.plugin}: {fault.what}: a run tells this as the plugin's fault"
        ) from fault
    except (OrthospecError, Nonconformity):
        raise
    except RAISED as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        at_line = f"{Path(last.filename).name}:{last.lineno}"
        told = f"raised {type(error).__name__}: {error} ({at_line})"
        raise Nonconformity(f"{type(who).__name__}: {told}: raise nothing") from error


def where(poses: Poses, wrong: Flags) -> str:
    """Where something is wrong first."""
    return at(poses[int(np.argmax(wrong))])


def at(pose: Array) -> str:
    """A pose, in words."""
    return f"at ({', '.join(f'{x:.6g}' for x in pose)})"


def documented(made: type[BaseModel]) -> None:
    """The class and each of its fields say what they are."""
    said = "has no docstring of its own" if not made.__dict__.get("__doc__") else ""
    expect(not said, made, said, "it is what 'orthospec explain' tells of it")
    for key in keys_of(made).every():
        expect(
            key.meaning,
            made,
            f"field {'.'.join(key.path)} has no description",
            "put a string below the field, with its unit",
        )


def survives(one: BaseModel) -> None:
    """Frozen, and the same from its own keys and from another process."""
    made = type(one)
    expect(one.model_config.get("frozen"), one, "is not frozen", "leave model_config as it is inherited")
    keys = one.model_dump(mode="json", by_alias=True, exclude_none=True)
    again = made.model_validate(keys).model_dump(mode="json", by_alias=True, exclude_none=True)
    expect(again == keys, one, "is not itself again from its keys", "let fields be plain numbers, in SI")
    try:
        copied = pickle.loads(pickle.dumps(one))
    except Exception as error:
        raise Nonconformity(
            f"{made.__name__}: cannot be pickled ({error}): --jobs sends it to others"
        ) from None
    same = copied.model_dump(mode="json", by_alias=True, exclude_none=True) == keys
    expect(same, one, "is another one after pickling", "let its fields be all that it is made of")


def is_unit(who: object, unit: str, what: str) -> None:
    """The unit is one that specs know."""
    try:
        parse_unit(unit)
    except UnitError as error:
        raise Nonconformity(f"{type(who).__name__}: {what} '{unit}': {error}") from None

"""The promises of a machine's toleranced fields: it serves arrays in them, and intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import NoEnclosure, OrthospecError
from orthospec.intervals import Boxes
from orthospec.manipulators import Manipulator
from orthospec.quantities.units import parse_unit
from orthospec.show.keys import keys_of
from orthospec.testing.expectations import at, expect, is_unit, where
from orthospec.testing.fields import apart, fields_of
from orthospec.testing.sampling import INSIDE, PARTS, SINGLES, within
from orthospec.workspace.tolerances import Family

if TYPE_CHECKING:
    from collections.abc import Mapping

    from orthospec.arrays import Poses
    from orthospec.workspace.cuboid import Cuboid

OFF = 1e-3
"""How far fields are off, relative."""


def check_toleranced(machine: Manipulator, box: Cuboid, poses: Poses) -> None:
    """Try what is promised of `toleranced` and `varied` at poses of a box, well within the reach."""
    if machine.toleranced:
        _declared(machine)
        _Toleranced(machine, box, poses[:SINGLES]).check()


def _declared(machine: Manipulator) -> None:
    """They are fields, of numbers, with their own units."""
    keys = {key.path: key for key in keys_of(type(machine)).keys}
    for name, unit in machine.toleranced.items():
        is_unit(machine, unit, f"toleranced '{name}'")
        expect(
            name in type(machine).model_fields and (name,) in keys,
            machine,
            f"toleranced names '{name}', which is no field",
            "name fields as a spec writes them",
        )
        value, own = getattr(machine, name), keys[name,].units
        expect(
            all(isinstance(number, float) for number in (value if isinstance(value, tuple) else (value,))),
            machine,
            f"toleranced names '{name}', which is {value!r}",
            "a toleranced field is a number, or a tuple of numbers",
        )
        expect(
            {parse_unit(other).dimension for other in own} == {parse_unit(unit).dimension},
            machine,
            f"toleranced has '{name}' in {unit}, the field itself is in {' or '.join(own) or 'no unit'}",
            "give the field's own unit",
        )


class _Toleranced:
    """A machine at poses with numbers of its own for each."""

    def __init__(self, machine: Manipulator, box: Cuboid, poses: Poses) -> None:
        self.machine = machine
        self.family = Family(machine, dict.fromkeys(machine.toleranced, OFF))
        self.named = " and ".join(f"'{name}'" for name in machine.toleranced)
        numbers = [np.atleast_1d(np.array(getattr(machine, name))) for name in machine.toleranced]
        sizes = np.concatenate([np.full(len(some), np.abs(some).max() or 1.0) for some in numbers])
        parts = np.random.default_rng(6).uniform(0, OFF, (len(poses), len(sizes)))
        self.points = np.concatenate([poses, np.concatenate(numbers) + parts * sizes], axis=1)
        idle = np.zeros(poses.shape[1] - len(box.low))
        self.spans = np.concatenate([box.size, idle, sizes])

    def check(self) -> None:
        """Try both."""
        self.arrays()
        self.intervals()

    def arrays(self) -> None:
        """With arrays in its fields it gives what a machine of each pose's numbers gives."""
        for name, field in fields_of(self.machine).items():
            try:
                together = field(*self.family.at(self.points))
            except OrthospecError as error:
                said = f"{name} fails with arrays (n,) in {self.named}: {error}"
                expect(False, self.machine, said, "compute with whole arrays, or leave toleranced out")
            for k, point in enumerate(self.points):
                own = self.family.named(point)
                one = _with_numbers(self.machine, own)
                if one is None:
                    continue
                pose = self.points[k : k + 1, : len(self.machine.axes)].copy()
                if found := apart(field(one, pose)[0], together, k):
                    said = (
                        f"{name} gives {found[1]} with arrays in {self.named}, and {found[0]} with the"
                        f" numbers of this pose alone, {_told(own)}, {at(pose[0])}"
                    )
                    way_out = "each pose has its own number of the array; keep nothing of the machine before"
                    expect(False, self.machine, said, way_out)

    def intervals(self) -> None:
        """With intervals in its fields the margins of all machines within them lie within its enclosure."""
        for part in PARTS:
            half = part / 2 * self.spans
            several = Boxes(self.points - half, self.points + half)
            try:
                machine, boxes = self.family.over(several)
                enclosed = machine.reach_enclosure(boxes)
            except NoEnclosure:
                continue  # Allowed: then nothing is proved of these.
            for k in range(INSIDE):
                points = within(several, k)
                one, poses = self.family.at(points)
                for name, margin in one.reach(poses).items():
                    wrong = (margin < enclosed[name].lo) | (margin > enclosed[name].hi)
                    own = self.family.named(points[int(np.argmax(wrong))])
                    expect(
                        not wrong.any(),
                        self.machine,
                        f"reach '{name}' leaves its enclosure {where(poses, wrong)} with {_told(own)}, where"
                        f" intervals stand in {self.named}",
                        "give nothing that is not certain for every number of them",
                    )


def _with_numbers(machine: Manipulator, numbers: Mapping[str, tuple[float, ...]]) -> Manipulator | None:
    """The machine with other numbers; None where its validators refuse them."""
    keys = machine.model_dump(mode="json", by_alias=True, exclude_none=True)
    for name, given in numbers.items():
        keys[name] = given if isinstance(getattr(machine, name), tuple) else given[0]
    try:
        return type(machine).model_validate(keys)
    except ValueError:
        return None


def _told(numbers: Mapping[str, tuple[float, ...]]) -> str:
    return ", ".join(f"{name} {' '.join(f'{x:.6g}' for x in given)}" for name, given in numbers.items())

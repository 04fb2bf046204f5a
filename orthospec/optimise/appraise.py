"""Designs measured as a result tells them, each a task of its own: the one found, and those of a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import OrthospecError, PluginFault, WorkersLost
from orthospec.measures import Level
from orthospec.optimise.grid_parts import GridStates
from orthospec.optimise.objective import scale_is_asked
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.optimise.tasks import Task, machine_and_measures
from orthospec.optimise.workers import Workers, in_order
from orthospec.result import Note, PluginError
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Evaluation, Largest, Measured, Prescribed, Value, evaluate
from orthospec.workspace.grid import fitting_divisions

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.spec import Design
    from orthospec.workspace.field import Progress


@dataclass(frozen=True)
class Asked:
    """A design to measure."""

    values: tuple[float, ...]
    """Of the variables, in the spec's order."""
    divisions: float
    prescribed: tuple[tuple[str, Cuboid], ...] | None = None
    """Where the prescribed cuboids stand, by measure ("": the joint one); None: centred on the largest."""
    grows: bool = False
    """Whether a goal is about the scale: where nothing has placed it the prescribed cuboid is the largest."""


@dataclass(frozen=True)
class Appraisal:
    """What was measured of a design, or why nothing could be."""

    evaluation: Evaluation | None
    faults: tuple[PluginError, ...] = ()
    """Measures that failed and were left out."""
    error: OrthospecError | None = None
    notes: tuple[Note, ...] = ()
    """What was done otherwise than asked for."""
    of_machine: tuple[PluginError, ...] = ()
    """What the machine did not give though its cuboid is in reach."""

    @property
    def errors(self) -> tuple[PluginError, ...]:
        """All that went wrong with plugins; nodes where a measure gave NaN with the first pose of each."""
        failures = self.evaluation.failures if self.evaluation is not None else ()
        nodes = (
            PluginError(one.measure, one.place, f"gave NaN at the reachable pose {list(one.pose)}")
            for one in failures
        )
        return (*self.faults, *nodes, *self.of_machine)


def asked(design: Design, divisions: float, prescribed: Mapping[str, Cuboid] | None = None) -> Asked:
    """What to ask for of a design."""
    places = None if prescribed is None else tuple(prescribed.items())
    return Asked(tuple(design.values.values()), divisions, places, scale_is_asked(design.goals))


def asked_of_found(
    space: DesignSpace, design: Design, divisions: int, prescribed: Mapping[str, Cuboid] | None
) -> Asked:
    """The same of a design that a search has found: on a coarser grid where it would be too large.

    A search may lead to a machine far larger than any that the spec's author thought of.
    """
    size, region = space.setting.size, space.setting.region
    return asked(design, fitting_divisions(design.manipulator, size, divisions, region), prescribed)


def coarser_notes(space: DesignSpace, one: Asked) -> tuple[Note, ...]:
    """A note of the grid being coarser than the spec has it; none where it is not."""
    divisions = space.spec.workspace.divisions
    if one.divisions == divisions:
        return ()
    said = (
        f"the grid of the design found would be too large with {divisions}: it was measured with"
        f" {one.divisions:.3g}; give a smaller workspace.region for a finer one"
    )
    return (Note("workspace.divisions", space.spec.place(("workspace", "divisions")), said),)


def appraise(space: DesignSpace, one: Asked, progress: Progress | None = None) -> Appraisal:
    """Measure a design; a measure that fails is left out and named."""
    setting = replace(space.setting, divisions=one.divisions, grows=one.grows)
    prescribed = None if one.prescribed is None else dict(one.prescribed)
    states_of = GridStates(space, one.values)
    faults: list[PluginError] = []
    try:
        machine = machine_of(space.spec.design(dict(zip(space.spec.variables, one.values, strict=True))))
        while True:
            try:
                evaluation = evaluate(machine, setting, prescribed, progress, states_of, space.forms)
            except PluginFault as fault:
                others = {name: d for name, d in machine.demands.items() if d.place != fault.place}
                if len(others) == len(machine.demands):
                    raise
                faults.append(error_of(fault))
                machine = replace(machine, demands=others)
                continue
            told = _told_of(machine.manipulator, evaluation, space.spec.place(("manipulator",)))
            return Appraisal(evaluation, tuple(faults), of_machine=told)
    except WorkersLost:
        raise
    except PluginFault as fault:
        # What a measure of its own did was left out: this is the machine's.
        place = fault.place or space.spec.place(("manipulator",))
        return Appraisal(None, tuple(faults), PluginFault(fault.plugin, fault.what, place))
    except OrthospecError as error:
        return Appraisal(None, tuple(faults), error)


def _told_of(machine: Manipulator, evaluation: Evaluation, place: str) -> tuple[PluginError, ...]:
    """What the machine does not give where it stands: indices that are NaN, a drawing."""
    of_each = [record.prescribed for record in evaluation.measures.values()]
    standing = [one for one in (evaluation.prescribed, *of_each) if one is not None and one.reached]
    if evaluation.joints is None or not standing:
        return ()
    name = type(machine).__name__
    found = [
        PluginError(name, place, f"gave NaN for the index '{index}' of a cuboid in reach")
        for index, value in evaluation.indices.items()
        if np.isnan(value)
    ]
    try:
        machine.skeleton(
            standing[0].cuboid.poses(np.zeros((1, len(standing[0].cuboid.low))), len(machine.axes))
        )
    except PluginFault as fault:
        found.append(PluginError(name, place, fault.what))
    return tuple(found)


def error_of(fault: PluginFault) -> PluginError:
    """A plugin's fault as the result tells it."""
    return PluginError(fault.plugin, fault.place, fault.what)


def _lasting(found: Appraisal) -> bool:
    """Whether nothing went wrong: errors tell places in the spec, which move with its lines."""
    return found.error is None and not found.errors


_PARTS = (Appraisal, Evaluation, Measured, Largest, Prescribed, Value, Cuboid, Level)
APPRAISE = Task("measuring the design", appraise, machine_and_measures, _PARTS, _lasting, divides=True)
SWEEP = replace(APPRAISE, name="sweep")
FRONT = replace(APPRAISE, name="measuring the Pareto set")


def appraised(
    workers: Workers, space: DesignSpace, one: Asked, progress: Progress | None = None
) -> tuple[Evaluation, Appraisal]:
    """The evaluation of one design, and all else that is known of it; raises what kept it from being made."""
    (found,) = in_order(workers, APPRAISE, space, [one], progress)
    if found.error is not None:
        raise found.error
    assert found.evaluation is not None
    return found.evaluation, found

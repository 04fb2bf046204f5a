"""The convex forms of measures' sides: their insides asked for in whole blocks, their cones compiled once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.composite.template import Template, compile_form
from orthospec.errors import RAISED, OrthospecError, PluginFault
from orthospec.interrupts import ctrl_c_waiting
from orthospec.measures import ConvexForm, Demand
from orthospec.measures.demand import bounded_side
from orthospec.workspace.field import measured
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses


Keep = Callable[[str, str, ConvexForm, Callable[[], Template]], Template]
"""Gives a measure's form of a side, as it is known, or else as it is then compiled."""


class Forms:
    """Compiled templates by measure and side; ``keep`` may know them from before."""

    def __init__(self, keep: Keep | None = None) -> None:
        self._templates: dict[tuple[str, str], Template] = {}
        self._keep = keep

    def template(self, machine: Machine, name: str, side: str, pose: Poses) -> Template | None:
        """The compiled form of a side, or None where the measure has none; ``pose`` (1, d) is any.

        Raises PluginFault where the form raises, is not convex, or of another type or shape.
        """
        demand = machine.demands[name]
        if side not in demand.measure.sides:
            return None
        if (name, side) not in self._templates:
            # An import of cvxpy that Ctrl-C cuts in half could not be mended.
            with ctrl_c_waiting():
                form = form_of(machine, name, side, pose)
            if form is None:
                return None
            compiled = partial(_compiled, demand, form)
            made = self._keep(name, side, form, compiled) if self._keep is not None else compiled()
            self._templates[name, side] = made
        return self._templates[name, side]


def _compiled(demand: Demand, form: ConvexForm) -> Template:
    def holds(*stated: Any) -> list[Any]:
        try:
            return form.holds(*stated)
        except RAISED as error:
            raise _fault(demand, f"holds raised {type(error).__name__}: {error}") from error

    with ctrl_c_waiting():
        try:
            return compile_form(holds, form.inside.shape[1:])
        except OrthospecError:
            raise
        except ValueError as error:
            raise _fault(demand, str(error)) from error
        except RAISED as error:
            said = f"cvxpy takes no such constraints: {type(error).__name__}: {error}"
            raise _fault(demand, said) from error


def form_of(machine: Machine, name: str, side: str, poses: Poses) -> ConvexForm | None:
    """A measure's convex form at the poses, None where it has none.

    Raises PluginFault where it raises, or gives another type or shape.
    """
    demand, n = machine.demands[name], len(poses)
    try:
        form = demand.measure.form(machine.manipulator, poses, side)
    except OrthospecError:
        raise
    except RAISED as error:
        raise _fault(demand, f"raised {type(error).__name__}: {error}") from error
    if form is None:
        return None
    if not isinstance(form, ConvexForm):
        raise _fault(demand, f"gave {type(form).__name__}, not a ConvexForm or None")
    inside = form.inside
    if not isinstance(inside, np.ndarray) or inside.dtype.kind not in "fiu":
        raise _fault(demand, f"inside is {type(inside).__name__}, not an array of floats")
    if inside.shape[:1] != (n,):
        raise _fault(demand, f"inside has shape {inside.shape} for {n} poses, not (n, ...)")
    return form


def inside_of(machine: Machine, name: str, side: str, poses: Poses) -> Array:
    """What a measure's form linearises, at poses of a cuboid (n, ...).

    Raises PluginFault as `form_of`, where there is a form at some poses only, and where the inside is finite
    at none of those at which the value is: nothing can be linearised then.
    """
    form, demand = form_of(machine, name, side, poses), machine.demands[name]
    if form is None:
        raise _fault(demand, f"gave None for {len(poses)} poses, a form for others")
    known = np.isfinite(form.inside).reshape(len(poses), -1).all(axis=1)
    if not known.any():
        reachable = np.asarray(machine.manipulator.inverse_kinematics(poses)[1])
        within = poses[reachable]
        within.flags.writeable = False
        values = bounded_side(measured(demand, machine.manipulator, within), side)
        sound = np.isfinite(values) & (values > 0)
        if sound.any():
            at = ", ".join(f"{x:.6g}" for x in within[int(np.argmax(sound))])
            raise _fault(demand, f"inside is not finite at ({at}), where the value is, nor at other poses")
    return form.inside


def _fault(demand: Demand, what: str) -> PluginFault:
    title = f"{type(demand.measure).__name__} (measure {demand.name})"
    return PluginFault(title, f"its convex form: {what}", demand.place)

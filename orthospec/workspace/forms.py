"""The convex forms of measures' sides: their insides asked for in whole blocks, their cones compiled once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from orthospec.composite.template import Template, compile_form
from orthospec.errors import OrthospecError, PluginFault
from orthospec.interrupts import ctrl_c_waiting
from orthospec.measures import ConvexForm, Demand
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Poses


Keep = Callable[[str, str, tuple[int, ...], Callable[[], Template]], Template]
"""Gives a measure's form of a side for insides of a shape, as it is known, or else as it is then compiled."""


class Forms:
    """Compiled templates by measure and side; ``keep`` may know them from before."""

    def __init__(self, keep: Keep | None = None) -> None:
        self._templates: dict[tuple[str, str], Template] = {}
        self._keep = keep

    def template(self, machine: Machine, name: str, side: str, pose: Poses) -> Template | None:
        """The compiled form of a side, or None where the measure has none; ``pose`` (1, d) is any.

        Raises PluginFault where the form raises or is not convex.
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
            shape = form.inside.shape[1:]
            compiled = partial(_compiled, demand, form)
            made = self._keep(name, side, shape, compiled) if self._keep is not None else compiled()
            self._templates[name, side] = made
        return self._templates[name, side]


def _compiled(demand: Demand, form: ConvexForm) -> Template:
    with ctrl_c_waiting():
        try:
            return compile_form(form.holds, form.inside.shape[1:])
        except ValueError as error:
            raise _fault(demand, str(error)) from error


def form_of(machine: Machine, name: str, side: str, poses: Poses) -> ConvexForm | None:
    """A measure's convex form at the poses; raises PluginFault where it raises."""
    demand = machine.demands[name]
    try:
        return demand.measure.form(machine.manipulator, poses, side)
    except OrthospecError:
        raise
    except Exception as error:
        raise _fault(demand, f"raised {type(error).__name__}: {error}") from error


def _fault(demand: Demand, what: str) -> PluginFault:
    title = f"{type(demand.measure).__name__} (measure {demand.name})"
    return PluginFault(title, f"its convex form: {what}", demand.place)

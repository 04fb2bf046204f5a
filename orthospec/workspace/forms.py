"""The convex forms of measures' sides: their insides asked for in whole blocks, their cones compiled once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from orthospec.composite.template import Template, compile_form
from orthospec.errors import OrthospecError, PluginFault
from orthospec.measures import ConvexForm, Demand
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Poses


class Forms:
    """Compiled templates by measure and side."""

    def __init__(self) -> None:
        self._templates: dict[tuple[str, str], Template] = {}

    def template(self, machine: Machine, name: str, side: str, pose: Poses) -> Template | None:
        """The compiled form of a side, or None where the measure has none; ``pose`` (1, d) is any.

        Raises PluginFault where the form raises or is not convex.
        """
        demand = machine.demands[name]
        if side not in demand.measure.sides:
            return None
        if (name, side) not in self._templates:
            form = form_of(machine, name, side, pose)
            if form is None:
                return None
            try:
                self._templates[name, side] = compile_form(form.holds, form.inside.shape[1:])
            except ValueError as error:
                raise _fault(demand, str(error)) from error
        return self._templates[name, side]


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

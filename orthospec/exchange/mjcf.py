"""The machine as MuJoCo has it: bodies, joints, and equations that close the loops (MJCF).

Machines of prismatic legs only: of another one its skeleton tells where lines are, not which joints they
turn in. A parallelogram keeps the platform from turning, so that the platform's joints are three slides; a
leg's bar turns freely on its slider, and an equation ties its other end to the platform.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

import numpy as np

from orthospec.errors import UsageError
from orthospec.manipulators.prismatic import PrismaticManipulator
from orthospec.report.subject import Subject

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.solution import Solution

LIGHT = 1e-3
"""Of a body whose mass is not known [kg]: MuJoCo moves none without."""
STEP = 5e-4
"""Of time [s]."""
SOLREF = (2 * STEP, 0.5)
"""MuJoCo's time constant and damping ratio of the equations. Their stiffness is 1 / STEP² and their damping
1 / STEP with these, so that each step puts right what the last one left."""
SOLIMP = (0.9999, 0.9999, 0.001)
"""As hard as MuJoCo lets equations hold."""
DRIVE = 200.0
"""Natural frequency of a drive that moves the whole machine, critically damped [rad/s]: it is 2 / DRIVE late.
Stiffer drives than the masses allow would make the simulation unstable."""


def write(solution: Solution, name: str, file: Path) -> None:
    """The machine at rest with its tool in the middle of the cuboid; sliders are driven to positions."""
    design, place = solution.design, Subject(solution).place
    machine = design.manipulator if design is not None else None
    if not isinstance(machine, PrismaticManipulator) or place is None:
        raise UsageError(
            f"{name} is for machines with prismatic legs; machine.glb has the lines of any machine"
        )
    root = _document(machine, np.array(place.centre), str(solution.result.manipulator["use"]))
    Xml.indent(root)
    file.write_text(Xml.tostring(root, encoding="unicode") + "\n", encoding="utf-8")


def _document(machine: PrismaticManipulator, tool: Array, use: str) -> Xml.Element:
    geometry, masses = machine.geometry, machine.masses
    rho = machine.inverse_kinematics(tool[None])[0][0]
    bases, joints, axes = geometry.bases[:, :, 0], geometry.joints[:, :, 0], geometry.axes
    root = Xml.Element("mujoco", model=use)
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    option = Xml.SubElement(
        root, "option", timestep=_text([STEP]), gravity=_text(machine.gravity), solver="Newton"
    )
    Xml.SubElement(option, "flag", contact="disable")
    world = Xml.SubElement(root, "worldbody")
    equations = Xml.Element("equality")
    drives = Xml.Element("actuator")
    platform = _body(world, "platform", tool)
    for axis in np.eye(3):
        Xml.SubElement(
            platform, "joint", name="platform_" + "xyz"[int(axis.argmax())], type="slide", axis=_text(axis)
        )
    size = 0.03 * float(np.mean(geometry.lengths))
    _geom(platform, "sphere", str(size), masses.platform, rgba="0.2 0.22 0.25 1")
    Xml.SubElement(platform, "site", name="tool", size=_text([size / 4]))
    spacing = machine.legs.spacing if machine.legs is not None and machine.legs.kind == "PRPaR" else None
    offsets = [0.0] if spacing is None else [-spacing / 2, spacing / 2]
    for i in range(3):
        slider = _body(world, f"slider_{i + 1}", bases[i] + rho[i] * axes[i])
        joint = f"slide_{i + 1}"
        Xml.SubElement(slider, "joint", name=joint, type="slide", axis=_text(axes[i]), ref=_text([rho[i]]))
        _geom(slider, "box", _text([size, size, size]), masses.sliders, rgba="0.47 0.49 0.52 1")
        Xml.SubElement(drives, "position", name=f"drive_{i + 1}", joint=joint)
        way = (tool + joints[i]) - (bases[i] + rho[i] * axes[i])
        for k, beside in enumerate(offsets, start=1):
            start = beside * geometry.revolutes[i]
            bar = _body(slider, f"bar_{i + 1}_{k}", start)
            Xml.SubElement(bar, "joint", name=f"ball_{i + 1}_{k}", type="ball")
            mass = float(masses.legs[0, i]) / len(offsets)
            _geom(bar, "capsule", str(size / 3), mass, fromto=_text([0, 0, 0, *way]), rgba="0.34 0.5 0.7 1")
            Xml.SubElement(bar, "site", name=f"end_{i + 1}_{k}", pos=_text(way), size=_text([size / 4]))
            at = joints[i] + start
            Xml.SubElement(platform, "site", name=f"joint_{i + 1}_{k}", pos=_text(at), size=_text([size / 4]))
            Xml.SubElement(
                equations,
                "connect",
                site1=f"end_{i + 1}_{k}",
                site2=f"joint_{i + 1}_{k}",
                solref=_text(SOLREF),
                solimp=_text(SOLIMP),
            )
    mass = sum(float(geom.attrib["mass"]) for geom in world.iter("geom"))
    for drive in drives:
        drive.attrib.update(kp=_text([mass * DRIVE**2]), kv=_text([2 * mass * DRIVE]))
    root.extend([equations, drives])
    return root


def _body(parent: Xml.Element, name: str, at: Array) -> Xml.Element:
    return Xml.SubElement(parent, "body", name=name, pos=_text(at))


def _geom(body: Xml.Element, kind: str, size: str, mass: float, **more: str) -> None:
    told = {"type": kind, "size": size, "mass": _text([max(mass, LIGHT)]), **more}
    Xml.SubElement(body, "geom", told)


def _text(numbers: Array | tuple[float, ...] | list[float]) -> str:
    """Numbers that read back exactly."""
    return " ".join(repr(float(x) + 0.0) for x in numbers)

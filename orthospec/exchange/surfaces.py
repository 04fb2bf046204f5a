"""Cuboids, the workspace and the machine as surfaces, by trimesh: STL in millimetres, glTF in metres."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.errors import UsageError
from orthospec.preview.build import GROUND, STEEL
from orthospec.report.subject import Subject, cuboid_of
from orthospec.result.model import Ends
from orthospec.solution import sampled, workspace_surface

if TYPE_CHECKING:
    from orthospec.solution import Solution
    from orthospec.workspace.cuboid import Cuboid

MILLIMETRES = 1000.0
"""In a metre: STL has no unit, and programs that print and mill take it for millimetres."""
NODES = 81
"""Of the lattice under the workspace's surface, along its longest edge."""
SIDES = 24
"""Of a bar."""


def write(solution: Solution, name: str, file: Path) -> None:
    """The surface that the name says."""
    made = {
        "cuboid.stl": _prescribed,
        "largest.stl": _largest,
        "workspace.stl": _workspace,
        "machine.glb": _machine,
    }
    file.write_bytes(made[name](solution))


def _prescribed(solution: Solution) -> bytes:
    return _stl(_box(Subject(solution).place, "prescribed cuboid"))


def _largest(solution: Solution) -> bytes:
    joint = solution.result.workspace.joint
    if joint is None or joint.min is None or joint.max is None:
        raise UsageError("this result has no largest cuboid for all measures together")
    return _stl(_box(cuboid_of(Ends(min=list(joint.min), max=list(joint.max))), "largest cuboid"))


def _box(cuboid: Cuboid | None, what: str) -> Any:
    import trimesh

    if cuboid is None or len(cuboid.low) != 3:
        raise UsageError(f"this result has no {what} in space")
    return trimesh.creation.box(bounds=np.array([cuboid.low, cuboid.high]))


def _workspace(solution: Solution) -> bytes:
    import trimesh

    if solution.spec is None or solution.design is None:
        raise UsageError(
            "the workspace of this result is not known: its spec or a plugin of it is not at hand"
        )
    workspace = solution.spec.workspace
    alone = replace(solution.design, demands=())
    surface = workspace_surface(sampled(alone, workspace.region, np.array(workspace.size), NODES))
    if surface is None:
        raise UsageError("this result has no workspace in space")
    return _stl(trimesh.Trimesh(surface.vertices, surface.triangles, process=False))


def _stl(mesh: Any) -> bytes:
    """In whole micrometres: vertices that would be one in a program that reads them are one already."""
    import trimesh

    vertices = np.round(MILLIMETRES * np.asarray(mesh.vertices), 3).astype(np.float32)
    distinct, which = np.unique(vertices, axis=0, return_inverse=True)
    triangles = which.reshape(-1)[mesh.faces]
    a, b, c = triangles.T
    proper = (a != b) & (b != c) & (c != a)
    return bytes(trimesh.Trimesh(distinct, triangles[proper], process=False).export(file_type="stl"))


def _machine(solution: Solution) -> bytes:
    import trimesh

    place, design = Subject(solution).place, solution.design
    if place is None or design is None:
        raise UsageError("the machine of this result is not known: its spec or a plugin of it is not at hand")
    machine = design.manipulator
    drawn = machine.skeleton(place.poses(np.zeros((1, len(place.low))), len(machine.axes)))
    scene = trimesh.Scene()
    for name, ends, radius in zip(drawn.names, drawn.segments[0], drawn.radii, strict=True):
        if np.linalg.norm(ends[1] - ends[0]) < 1e-9 or not np.isfinite(ends).all():
            continue
        bar = trimesh.creation.cylinder(radius=float(radius), segment=ends, sections=SIDES)
        colour = GROUND if name.startswith(("slide", "rail", "base")) else STEEL
        bar.visual.face_colors = [*colour, 255]
        scene.add_geometry(bar, node_name=name, geom_name=name)
    return bytes(scene.export(file_type="glb"))

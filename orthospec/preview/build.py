"""From a solution to its scene."""

from __future__ import annotations

from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from orthospec.measures.demand import bounded_side
from orthospec.preview.scene import Ball, Bar, Colour, Group, Lines, Mesh, Scale, Scene, Tool
from orthospec.report.figures.slices import COLOURS as MAP
from orthospec.report.subject import Subject, bound_side, nested
from orthospec.report.views import edges
from orthospec.show import words
from orthospec.solution import workspace_surface
from orthospec.workspace.field import measured

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Demand
    from orthospec.spec import Design
    from orthospec.workspace.cuboid import Cuboid

STEPS = 12
"""Frames along each edge of the cuboid."""
FACE = 17
"""Nodes along each edge of a coloured face."""
STEEL, GROUND, CARRIAGE = (86, 128, 178), (120, 124, 132), (45, 50, 60)
SHELL, BOX, MARK = (150, 156, 168), (214, 106, 30), (205, 40, 40)
NESTED: tuple[Colour, ...] = ((30, 140, 90), (130, 80, 170), (20, 120, 180), (170, 120, 20))
OTHER: tuple[Colour, Colour] = ((196, 84, 140), (150, 40, 100))
"""Of the machine and the cuboid of a second solution."""
UNKNOWN = (0.55, 0.55, 0.58)
"""Where a measure has no value, as out of reach."""


def scene_of(subject: Subject) -> Scene:
    """All that a solution has to show in space; without a machine only its cuboids."""
    scene = Scene()
    place, design = subject.place, subject.design
    if place is not None and design is not None:
        _machine(scene, subject, design, place, "machine", STEEL, "the machine")
    if subject.lattice is not None:
        surface = workspace_surface(subject.lattice)
        if surface is not None:
            scene.things.append(Mesh("workspace", surface.vertices, surface.triangles, SHELL, 0.22))
            scene.groups.append(Group("workspace", "all that is in reach", SHELL))
    _cuboids(scene, subject)
    _critical(scene, subject)
    if place is not None and design is not None:
        for demand in design.demands:
            _colours(scene, subject, design, demand, place)
    return scene


def overlaid(first: Subject, second: Subject) -> Scene:
    """A solution's scene with the machine and the prescribed cuboid of a second one in it."""
    scene = scene_of(first)
    place, design = second.place, second.design
    if place is None:
        return scene
    if design is not None:
        _machine(scene, second, design, place, "other-machine", OTHER[0], "the other machine")
    scene.things.append(Lines("other-cuboid", _edges(place), OTHER[1]))
    scene.groups.append(Group("other-cuboid", "the other cuboid", OTHER[1]))
    return scene


def _machine(
    scene: Scene, subject: Subject, design: Design, place: Cuboid, path: str, colour: Colour, said: str
) -> None:
    """The machine at each place of a tour along the cuboid's edges, in one block."""
    tour = _tour(len(place.low))
    poses = place.poses(tour, len(design.manipulator.axes))
    skeleton = design.manipulator.skeleton(poses)
    frames = np.array(skeleton.segments, dtype=float)
    if not np.isfinite(frames).all():
        known = np.isfinite(frames).all(axis=(1, 2, 3))
        if not known[0]:
            return
        frames = frames[np.maximum.accumulate(np.where(known, np.arange(len(frames)), 0))]
    for k, (name, radius) in enumerate(zip(skeleton.names, skeleton.radii, strict=True)):
        ground = name.startswith(("slide", "rail", "base"))
        scene.bars.append(Bar(f"{path}/{k}-{name}", float(radius), GROUND if ground else colour))
    scene.frames.append(frames)
    ball = Ball(f"{path}/tool", np.zeros(3), 1.6 * float(np.median(skeleton.radii)), CARRIAGE)
    scene.tools.append(Tool(ball, in_space(design.manipulator, poses)))
    scene.groups.append(Group(path, said, colour))
    if not scene.poses:
        scene.poses += [subject.numbers.pose(list(pose), subject.known.axes) for pose in poses]


def in_space(machine: Manipulator, poses: Poses) -> Array:
    """Where the tool is at each pose (n, 3) [m]; a coordinate that the machine does not have is 0."""
    space = np.zeros((len(poses), 3))
    for k, axis in enumerate("xyz"):
        if axis in machine.axes:
            space[:, k] = poses[:, machine.axes.index(axis)]
    return space


def _tour(d: int) -> Array:
    """Places u (k, d) of the tool: the middle, then from corner to corner along edges, and back."""
    turns = [np.zeros(d)]
    for number in [*range(2**d), 0]:
        code = number ^ (number >> 1)
        turns.append(np.array([(code >> k & 1) - 0.5 for k in range(d)]))
    turns.append(np.zeros(d))
    parts = np.arange(STEPS) / STEPS
    legs = [a + parts[:, None] * (b - a) for a, b in pairwise(turns)]
    return np.concatenate([*legs, turns[-1][None]])


def _edges(cuboid: Cuboid) -> Array:
    low, high = (np.pad(np.array(end), (0, 3 - len(end))) for end in (cuboid.low, cuboid.high))
    return edges(low, high)


def _cuboids(scene: Scene, subject: Subject) -> None:
    for k, (label, cuboid, scale) in enumerate(nested(subject)):
        path, colour = ("cuboid", BOX) if k == 0 else (f"cuboid-{k}", NESTED[(k - 1) % len(NESTED)])
        scene.things.append(Lines(path, _edges(cuboid), colour))
        said = "the prescribed cuboid" if k == 0 else f"{label}, scale {scale:.6g}"
        scene.groups.append(Group(path, said, colour))


def _critical(scene: Scene, subject: Subject) -> None:
    """Where what limits the design is reached."""
    poses = {
        tuple(pose[:3])
        for limit in words.together(subject.result.limits)
        for pose in limit.at
        if len(pose) >= 2
    }
    place = subject.place
    if not poses or place is None:
        return
    radius = 0.025 * float(place.size.max())
    for k, pose in enumerate(sorted(poses)):
        centre = np.pad(np.array(pose), (0, 3 - len(pose)))
        scene.things.append(Ball(f"limits/{k}", centre, radius, MARK))
    scene.groups.append(Group("limits", "where the limits are reached", MARK))


def _colours(scene: Scene, subject: Subject, design: Design, demand: Demand, place: Cuboid) -> None:
    """The values of a measure as colours on the faces of the cuboid."""
    if len(place.low) not in (2, 3):
        return
    u, triangles = _faces(len(place.low))
    poses = place.poses(u, len(design.manipulator.axes))
    values = _values(design.manipulator, demand, poses, bound_side(demand.bounds))
    known = np.isfinite(values)
    if not known.any():
        return
    low, high = float(values[known].min()), float(values[known].max())
    from matplotlib import colormaps

    parts = np.where(known, (values - low) / ((high - low) or 1.0), 0.0)
    colours = np.where(known[:, None], colormaps[MAP](parts)[:, :3], UNKNOWN)
    path = f"measure-{len(scene.scales)}"
    unit = subject.known.measures[demand.name].unit
    told = [subject.numbers.value(end, unit) for end in (low, high)]
    scene.things.append(Mesh(path, in_space(design.manipulator, poses), triangles, colours=colours))
    scene.scales.append(Scale(path, demand.name, *told))


def _values(machine: Manipulator, demand: Demand, poses: Poses, side: str) -> Array:
    reachable = np.asarray(machine.inverse_kinematics(poses)[1])
    values = np.full(len(poses), np.nan)
    inside = poses[reachable]
    inside.flags.writeable = False
    if len(inside):
        values[reachable] = bounded_side(measured(demand, machine, inside), side)
    return values


def _faces(d: int) -> tuple[Array, Array]:
    """Nodes u (v, d) on the faces of a cuboid, or over a rectangle, and triangles between them (t, 3)."""
    line = np.linspace(-0.5, 0.5, FACE)
    square = np.array(list(product(line, repeat=2)))
    node = np.arange(FACE * FACE).reshape(FACE, FACE)
    a, b, c, e = node[:-1, :-1].ravel(), node[1:, :-1].ravel(), node[1:, 1:].ravel(), node[:-1, 1:].ravel()
    flat = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, e], axis=1)])
    if d == 2:
        return square, flat
    faces = [np.insert(square, axis, end, axis=1) for axis in range(3) for end in (-0.5, 0.5)]
    return np.concatenate(faces), np.concatenate([flat + k * len(square) for k in range(len(faces))])

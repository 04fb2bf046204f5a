"""From a solution to its scene."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import PluginFault
from orthospec.measures.demand import bounded_side
from orthospec.preview.scene import Ball, Bar, Colour, Group, Joint, Lines, Mesh, Scale, Scene, Tool
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
SHELL, BOX = (150, 156, 168), (214, 106, 30)
MARKS: tuple[Colour, ...] = ((205, 40, 40), (150, 60, 190), (20, 140, 140), (190, 130, 0), (60, 90, 200))
"""Of limits."""
DARK, BRIGHT = (0, 32, 77), (253, 220, 50)
"""Of the least and the greatest value, as the map of colours has them."""
NESTED: tuple[Colour, ...] = ((30, 140, 90), (130, 80, 170), (20, 120, 180), (170, 120, 20))
OTHER: tuple[Colour, Colour] = ((196, 84, 140), (150, 40, 100))
"""Of the machine and the cuboid of a second solution."""
JOINT = 1.3
"""Radius of a ball at a bar's end, in the bar's own."""
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
    _marks(scene, subject)
    _axes(scene, subject)
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
    """The machine at each place of a tour through the cuboid, in one block; where it cannot go it waits.

    One that gives no skeleton is not drawn, which the panel says.
    """
    poses = place.poses(_tour(len(place.low)), len(design.manipulator.axes))
    try:
        skeleton = design.manipulator.skeleton(poses)
    except PluginFault as fault:
        scene.notes.append(f"{said} is not drawn: {fault}")
        return
    known = np.asarray(np.isfinite(skeleton.segments).all(axis=(1, 2, 3)))
    if not known[0]:
        return
    held = np.maximum.accumulate(np.where(known, np.arange(len(poses)), 0))
    if scene.poses:  # All machines move at once, each along its own cuboid.
        held = held[np.linspace(0, len(held) - 1, len(scene.poses)).round().astype(int)]
    frames, poses = np.array(skeleton.segments, dtype=float)[held], poses[held]
    machine = len(scene.frames)
    for k, (name, radius) in enumerate(zip(skeleton.names, skeleton.radii, strict=True)):
        ground = name.startswith(("slide", "rail", "base"))
        bar = Bar(f"{path}/{name}", float(radius), GROUND if ground else colour, ground)
        scene.bars.append(bar)
        for end in (0, 1):
            ball = Ball(f"{path}/{name}-{'ab'[end]}", np.zeros(3), JOINT * bar.radius, bar.colour)
            scene.joints.append(Joint(ball, machine, k, end))
    scene.frames.append(frames)
    ball = Ball(f"{path}/tool", np.zeros(3), 2.4 * float(np.median(skeleton.radii)), CARRIAGE)
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
    """Places u (k, d) of the tool: from the middle, corner to corner, through each diagonal, and back."""
    corners = [*_corners(d, d), _corners(d, 0)[0]]
    # An edge leads from the end of one diagonal to the next one.
    starts = [corner * (-1) ** k for k, corner in enumerate(_corners(d, d - 1))]
    diagonals = [end for start in starts for end in (start, -start)]
    turns = [np.zeros(d), *corners, *diagonals[1:], np.zeros(d)]
    parts = np.arange(STEPS) / STEPS
    legs = [a + parts[:, None] * (b - a) for a, b in pairwise(turns)]
    return np.concatenate([*legs, turns[-1][None]])


def _corners(d: int, free: int) -> list[Array]:
    """Corners u (d,), each an edge from the one before it; only the first ``free`` coordinates change."""
    codes = [number ^ (number >> 1) for number in range(2**free)]
    return [np.array([(code >> k & 1) - 0.5 for k in range(d)]) for code in codes]


def _edges(cuboid: Cuboid) -> Array:
    low, high = (np.pad(np.array(end), (0, 3 - len(end))) for end in (cuboid.low, cuboid.high))
    return edges(low, high)


def _cuboids(scene: Scene, subject: Subject) -> None:
    for k, (label, cuboid, scale) in enumerate(nested(subject)):
        path, colour = ("cuboid", BOX) if k == 0 else (f"cuboid-{k}", NESTED[(k - 1) % len(NESTED)])
        scene.things.append(Lines(path, _edges(cuboid), colour))
        if k == 0 and len(cuboid.low) == 3:
            u, triangles = _faces(3)
            scene.things.append(Mesh(f"{path}/faces", cuboid.poses(u, 3), triangles, colour, 0.07))
        said = f"the prescribed cuboid{words.scaled(scale)}" if k == 0 else f"{label}, scale {scale:.6g}"
        scene.groups.append(Group(path, said, colour))


def _marks(scene: Scene, subject: Subject) -> None:
    """Where each limit is reached, and, hidden at first, where each measure is least and greatest."""
    place = subject.place
    if place is None:
        return
    radius = 0.022 * float(place.size.max())
    limits = [one for one in words.together(subject.result.limits) if one.at]
    for k, limit in enumerate(limits):
        colour = MARKS[k % len(MARKS)]
        for n, pose in enumerate(limit.at):
            # Limits that meet at one pose show as a ball in a ball.
            ball = Ball(f"limit-{k}/{n}", _centre(pose), radius * (1 + 0.25 * (len(limits) - k)), colour)
            scene.things.append(ball)
        scene.groups.append(
            Group(f"limit-{k}", words.limiting(limit, subject.known, subject.numbers), colour)
        )
    for name, record in subject.result.workspace.measures.items():
        unit = subject.known.measures[name].unit if name in subject.known.measures else "1"
        for end, extreme, colour in (("lowest", record.lowest, DARK), ("highest", record.highest, BRIGHT)):
            if extreme is not None and extreme.value is not None:
                path = f"{end}-{name}"
                scene.things.append(Ball(f"{path}/0", _centre(extreme.at), radius, colour))
                said = f"{name}: {end}, {subject.numbers.value(extreme.value, unit)}"
                scene.groups.append(Group(path, said, colour, shown=False))


def _centre(pose: Sequence[float]) -> Array:
    return np.pad(np.array(pose[:3], dtype=float), (0, 3 - min(len(pose), 3)))


def _axes(scene: Scene, subject: Subject) -> None:
    """The axes from the origin, of a round length."""
    if not scene.things:
        return
    low, high = scene.ends
    reach = float(np.max(high - low)) / 3
    length = 10.0 ** np.floor(np.log10(reach))
    length *= max(step for step in (1, 2, 5) if step * length <= reach)
    for k, colour in enumerate(((200, 60, 50), (50, 150, 70), (60, 100, 210))):
        line = np.array([[np.zeros(3), length * np.eye(3)[k]]])
        scene.things.append(Lines(f"axes/{'xyz'[k]}", line, colour))
    said = f"axes x (red), y (green), z (blue), {subject.numbers.value(float(length), 'm')} long"
    scene.groups.append(Group("axes", said, (120, 120, 120)))


def _colours(scene: Scene, subject: Subject, design: Design, demand: Demand, place: Cuboid) -> None:
    """The values of a measure as colours on the faces of the cuboid; the panel tells which one fails."""
    if len(place.low) not in (2, 3):
        return
    u, triangles = _faces(len(place.low))
    poses = place.poses(u, len(design.manipulator.axes))
    try:
        values = _values(design.manipulator, demand, poses, bound_side(demand.bounds))
    except PluginFault as fault:
        scene.notes.append(f"{demand.name} is not shown: {fault}")
        return
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

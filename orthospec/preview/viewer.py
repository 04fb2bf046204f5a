"""A scene in the words of meshcat's viewer: its own pieces, without its server.

meshcat names each thing by a UUID made of the machine's network address and the time; here they are numbered,
so that the same scene gives the same bytes and tells nothing of where it was made.
"""

from __future__ import annotations

import base64
import warnings
from collections.abc import Iterator
from itertools import count, product
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.preview.scene import Ball, Bar, Colour, Lines, Mesh, Scene

if TYPE_CHECKING:
    from orthospec.arrays import Array

ROOT = "scene"
SIDES = 20
"""Of a cylinder, which is round enough."""
EXTENT = 2.0
"""The longest edge of a scene as the viewer sees it, whatever its size in metres."""

WAYS = 2
"""Steps from the middle of a cube's face to its edge: directions go to the nodes between."""


def viewer_source() -> str:
    """The viewer's own program, with the notes of its licences."""
    folder = File(_meshcat().__file__).parent / "viewer" / "dist"
    notes = (folder / "main.min.js.LICENSE.txt").read_text(encoding="utf-8")
    program = (folder / "main.min.js").read_text(encoding="utf-8")
    return f"{notes}\n{program}"


def commands(scene: Scene) -> Iterator[str]:
    """What the viewer is told, each as base64 of its binary messages."""
    _meshcat()
    from meshcat import commands as told
    from meshcat.path import Path

    numbers = count(1)
    balls = [one.ball for one in scene.joints] + [one.ball for one in scene.tools]
    things: list[Mesh | Lines | Ball | Bar] = [*scene.things, *scene.bars, *balls]
    for thing in things:
        made = _object(thing)
        for element in (made.geometry, made.material, made):
            element.uuid = f"{next(numbers):08x}-0000-4000-8000-000000000000"
        path = Path((ROOT, *thing.path.split("/")))
        yield _packed(told.SetObject(made, path=path).lower())
        if isinstance(thing, Ball):
            yield _packed(told.SetTransform(_moved(thing.centre), path).lower())
    yield _packed(told.SetTransform(_fitted(scene), Path((ROOT,))).lower())


def outline(scene: Scene) -> Array:
    """The points farthest out in many directions (p, 3), in the viewer's units: what a view has to hold."""
    ways = np.array([way for way in product(range(-WAYS, WAYS + 1), repeat=3) if max(map(abs, way)) == WAYS])
    points = scene.points
    far = points[np.unique(np.argmax(points @ ways.T, axis=0))]
    matrix = _fitted(scene)
    return np.asarray(far @ matrix[:3, :3].T + matrix[:3, 3])


def _meshcat() -> Any:
    """The package, which imports a module of its server's that warns of its own age."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import meshcat
    return meshcat


def _packed(message: dict[str, Any]) -> str:
    import umsgpack

    return base64.b64encode(umsgpack.packb(message)).decode("ascii")


def _object(thing: Mesh | Lines | Ball | Bar) -> Any:
    from meshcat import geometry

    if isinstance(thing, Lines):
        points = thing.segments.reshape(-1, 3).T.astype(np.float32)
        lines = geometry.LineBasicMaterial(color=_number(thing.colour), linewidth=2)
        return geometry.LineSegments(geometry.PointsGeometry(points), lines)
    if isinstance(thing, Mesh):
        return geometry.Mesh(
            _triangles(thing), _material(thing.colour, thing.opacity, thing.colours is not None)
        )
    if isinstance(thing, Ball):
        return geometry.Mesh(geometry.Sphere(thing.radius), _material(thing.colour))
    if thing.square:
        return geometry.Mesh(geometry.Box([2 * thing.radius, 1.0, 2 * thing.radius]), _material(thing.colour))
    cylinder = geometry.Cylinder(1.0, radius=thing.radius)
    cylinder.radialSegments = SIDES
    return geometry.Mesh(cylinder, _material(thing.colour))


def _triangles(mesh: Mesh) -> Any:
    from meshcat import geometry

    vertices, triangles = mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)
    colours = None if mesh.colours is None else mesh.colours.astype(np.float32)
    return geometry.TriangularMeshGeometry(vertices, triangles, color=colours)


def _material(colour: Colour, opacity: float = 1.0, of_values: bool = False) -> Any:
    from meshcat import geometry

    if of_values:  # Light and shade would change what a colour means.
        # They stand behind the lines and faces that lie in the same plane.
        behind = {"polygonOffset": True, "polygonOffsetFactor": 1, "polygonOffsetUnits": 1}
        return geometry.MeshBasicMaterial(vertexColors=True, **behind)
    if opacity < 1.0:
        return geometry.MeshPhongMaterial(color=_number(colour), opacity=opacity, depthWrite=False)
    return geometry.MeshPhongMaterial(color=_number(colour), shininess=40)


def _number(colour: Colour) -> int:
    red, green, blue = colour
    return red << 16 | green << 8 | blue


def _moved(centre: Array) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = centre
    return matrix


def _fitted(scene: Scene) -> Array:
    """The scene about the viewer's origin, as large as it likes things."""
    low, high = scene.ends
    scale = EXTENT / (float(np.max(high - low)) or 1.0)
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = -scale * (low + high) / 2
    return matrix

"""A solution's machine, its fields on a lattice, and the surfaces drawn through them."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from orthospec.optimise import evaluate_spec
from orthospec.result import write_result
from orthospec.solution import (
    Solution,
    Surface,
    level_surface,
    read_solution,
    sampled,
    solution_of,
    workspace_surface,
)
from orthospec.spec import Spec
from orthospec.workspace.cuboid import Cuboid

EVALUATED = """
orthospec: 1
manipulator: {use: orthoglide, leg_lengths: [1, 1, 1]}
workspace: {size: [0.5, 0.5, 0.25], divisions: 4}
measures: {transmission: {use: velocity_transmission, at_most: 2}}
"""


def enclosed(surface: Surface) -> float:
    """The volume by the divergence theorem: positive where triangles are counter-clockwise from outside."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def edges_of(surface: Surface) -> Counter[tuple[int, int]]:
    pairs = surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return Counter(map(tuple, np.sort(pairs, axis=1).tolist()))


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(EVALUATED)


def test_lattice_is_even_and_spans_the_reach(spec: Spec) -> None:
    lattice = sampled(spec.design({}), None, np.array(spec.workspace.size), nodes=21)
    pitches = [axis[1] - axis[0] for axis in lattice.axes]
    assert np.allclose(pitches, pitches[0], rtol=0.1)
    faces = [np.take(lattice.reachable, end, axis) for axis in range(3) for end in (0, -1)]
    assert lattice.reachable.any()
    assert not any(face.any() for face in faces)
    assert np.array_equal(np.isfinite(lattice.values["transmission"]).all(axis=-1), lattice.reachable)


def test_lattice_of_a_region_ends_at_its_faces(spec: Spec) -> None:
    region = Cuboid((-0.2, -0.1, 0.0), (0.2, 0.1, 1e-3))
    lattice = sampled(spec.design({}), region, np.array(spec.workspace.size), nodes=9)
    assert lattice.box == region
    assert lattice.margin.shape == (9, 5, 3)


def test_workspace_surface_is_closed_and_stands_on_the_end_of_the_reach(spec: Spec) -> None:
    design = spec.design({})
    lattice = sampled(design, None, np.array(spec.workspace.size), nodes=41)
    surface = workspace_surface(lattice)
    assert surface is not None
    assert set(edges_of(surface).values()) == {2}
    pitch = lattice.axes[0][1] - lattice.axes[0][0]
    poses = lattice.box.poses(np.random.default_rng(1).uniform(-0.5, 0.5, (100_000, 3)), 3)
    share = design.manipulator.inverse_kinematics(poses)[1].mean()
    assert enclosed(surface) == pytest.approx(share * np.prod(lattice.box.size), rel=0.01)
    least = np.fmin.reduce(list(design.manipulator.reach(surface.vertices).values()), axis=0)
    assert np.median(np.abs(least)) < 0.1 * pitch


def test_workspace_surface_is_closed_by_the_faces_of_a_region_inside_the_reach(spec: Spec) -> None:
    region = Cuboid((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1))
    surface = workspace_surface(sampled(spec.design({}), region, np.ones(3), nodes=9))
    assert surface is not None
    assert set(edges_of(surface).values()) == {2}
    assert enclosed(surface) == pytest.approx(0.2**3, rel=1e-3)


def test_level_surface_of_a_distance_is_a_sphere() -> None:
    axes = [np.linspace(-1, 1, 41)] * 3
    x, y, z = np.meshgrid(*axes, indexing="ij")
    surface = level_surface(axes, -np.sqrt(x**2 + y**2 + z**2), -0.7)
    assert surface is not None
    assert np.allclose(np.linalg.norm(surface.vertices, axis=1), 0.7, atol=1e-3)
    assert enclosed(surface) == pytest.approx(4 / 3 * np.pi * 0.7**3, rel=5e-3)


def test_level_surface_leaves_out_what_is_not_known() -> None:
    axes = [np.linspace(-1, 1, 21)] * 3
    x = np.meshgrid(*axes, indexing="ij")[0]
    half = np.where(np.meshgrid(*axes, indexing="ij")[1] > 0, x, np.nan)
    surface = level_surface(axes, half, 0.05)
    assert surface is not None
    assert surface.vertices[:, 1].min() == pytest.approx(axes[1][half[0, :, 0] == half[0, :, 0]][0])
    flipped = level_surface(axes, half[:, ::-1], 0.05)
    assert flipped is not None
    assert flipped.vertices[:, 1].max() == pytest.approx(-surface.vertices[:, 1].min())
    assert level_surface(axes, half, 2.0) is None
    assert level_surface(axes, np.full_like(x, np.nan), 0.0) is None


def test_solution_is_the_same_from_a_run_and_from_its_folder(spec: Spec, tmp_path: Path) -> None:
    outcome = evaluate_spec(spec)
    made = solution_of(spec, outcome)
    folder = tmp_path / "result"
    write_result(folder, spec, made.content, outcome.log)
    read = read_solution(folder)
    assert read.content == made.content
    assert read.result == made.result
    assert read.design is not None
    assert made.design is not None
    assert read.design.manipulator == made.design.manipulator
    assert read.design.demands[0].bounds == {"at_most": 2}


def test_solution_without_its_spec_has_no_design(spec: Spec) -> None:
    content = solution_of(spec, evaluate_spec(spec)).content
    assert Solution(content, None).design is None

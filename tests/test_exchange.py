"""Files for other programs, read back by other programs."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
import xarray

from orthospec.errors import UsageError
from orthospec.exchange import KINDS, export
from orthospec.solution import Solution
from orthospec.spec import Spec
from orthospec.study import Study, evaluate

SPEC = """
orthospec: 1
title: An Orthoglide to hand on
variables: {leg: {min: 0.3, max: 0.5, start: 0.4}}
manipulator:
  use: orthoglide
  leg_lengths: [leg, leg, leg]
  legs: {kind: PRPaR, section: {round: {diameter: 20 mm}}, material: steel, spacing: 60 mm}
  actuators: {stiffness: 1e7, mass: 2 kg}
  platform: {mass: 1 kg}
  gravity: [0, 0, -9.81]
workspace: {size: [0.1, 0.1, 0.05], divisions: 2}
measures:
  transmission: {use: velocity_transmission, at_least: 0.4, at_most: 2.5}
  stiffness: {use: stiffness, at_least: 0.1 N/um}
sweep: {variable: leg, from: 0.35, to: 0.45, points: 3}
"""

BARE = """
orthospec: 1
manipulator: {use: orthoglide, leg_lengths: [0.4, 0.4, 0.4], gravity: [0, 0, -9.81]}
workspace: {size: [0.1, 0.1, 0.05], divisions: 2}
measures: {transmission: {use: velocity_transmission, at_least: 0.4, at_most: 2.5}}
"""

DELTA = """
orthospec: 1
manipulator:
  use: linear_delta
  leg_lengths: [0.4, 0.4, 0.4]
  base_radius: 0.2
  platform_radius: 0.05
  legs: {kind: PRPaR, section: {round: {diameter: 25 mm, wall: 2 mm}}, material: carbon, spacing: 80 mm}
  actuators: {mass: 2 kg}
  platform: {mass: 2 kg}
  gravity: [0, 0, -9.81]
workspace: {size: [0.2, 0.2, 0.1], divisions: 2, region: {min: [-0.3, -0.3, -0.1], max: [0.3, 0.3, 0.1]}}
measures: {transmission: {use: velocity_transmission, at_least: 0.3, at_most: 3}}
"""


@pytest.fixture(scope="module")
def study(spec_of: Callable[..., Spec]) -> Study:
    return evaluate(spec_of(SPEC))


def test_a_dataset_has_the_measures_with_units_bounds_and_coordinates(study: Study) -> None:
    data = study.fields()
    assert data["transmission"].dims == ("x", "y", "z", "end")
    assert data["stiffness"].attrs["units"] == "N/m"
    assert data["transmission"].attrs["bound_at_most"] == 2.5
    assert data.attrs["variable_leg"] == 0.4
    at = {"x": 0.05, "y": 0.0, "z": -0.025}
    found = data.sel(at, method="nearest")
    pose = np.array([[float(found[axis]) for axis in "xyz"]])
    (demand, other) = study.design.demands  # type: ignore[union-attr]
    np.testing.assert_allclose(found["transmission"], demand.measure.values(study.manipulator, pose)[0])
    np.testing.assert_allclose(found["stiffness"], other.measure.values(study.manipulator, pose)[0])
    assert np.isnan(data["stiffness"]).any()


@pytest.mark.filterwarnings("ignore")
def test_fields_are_read_back_from_netcdf_and_zarr(study: Study, tmp_path: Path) -> None:
    made = study.fields()
    study.export(tmp_path / "fields.nc", tmp_path / "fields.zarr")
    with xarray.open_dataset(tmp_path / "fields.nc", engine="scipy") as read:
        np.testing.assert_array_equal(read["transmission"], made["transmission"])
        assert read["x"].attrs["units"] == "m"
    read = xarray.open_zarr(tmp_path / "fields.zarr", consolidated=False)
    np.testing.assert_array_equal(read["stiffness"], made["stiffness"])


def test_image_data_have_the_grid_and_the_values(study: Study, tmp_path: Path) -> None:
    from xml.etree import ElementTree

    file = tmp_path / "fields.vti"
    study.export(file)
    head, _, rest = file.read_bytes().partition(b'<AppendedData encoding="raw">')
    root = ElementTree.fromstring(head + b"</VTKFile>")
    image = root.find("ImageData")
    assert image is not None
    made = study.fields()
    spacing = [float(made[axis][1] - made[axis][0]) for axis in "xyz"]
    np.testing.assert_allclose([float(x) for x in image.attrib["Spacing"].split()], spacing)
    extent = [int(x) for x in image.attrib["WholeExtent"].split()]
    assert extent[1::2] == [made.sizes[axis] - 1 for axis in "xyz"]
    arrays = {one.attrib["Name"]: int(one.attrib["offset"]) for one in root.iter("DataArray")}
    assert {"transmission_least", "transmission_greatest", "stiffness", "reach"} == set(arrays)
    data = rest[rest.index(b"_") + 1 :]
    start = arrays["stiffness"] + 8
    values = np.frombuffer(data[start : start + 8 * made["stiffness"].size])
    np.testing.assert_array_equal(values, made["stiffness"].values.ravel(order="F"))


def test_cuboid_and_workspace_are_watertight_in_millimetres(study: Study, tmp_path: Path) -> None:
    study.export(tmp_path / "cuboid.stl", tmp_path / "workspace.stl")
    box = trimesh.load_mesh(tmp_path / "cuboid.stl")
    assert box.is_watertight
    assert box.volume == pytest.approx(100 * 100 * 50)
    place = study.result.workspace.prescribed
    assert place is not None
    np.testing.assert_allclose(box.bounds, 1000 * np.array([place.min, place.max]), atol=1e-3)
    whole = trimesh.load_mesh(tmp_path / "workspace.stl")
    assert whole.is_watertight
    assert whole.volume > box.volume


def test_the_machine_in_gltf_has_its_bars(study: Study, tmp_path: Path) -> None:
    study.export(tmp_path / "machine.glb")
    scene = trimesh.load_scene(tmp_path / "machine.glb")
    drawn = study.manipulator.skeleton(np.zeros((1, 3)))
    assert set(scene.geometry) == set(drawn.names)
    bar = scene.geometry["bar_left_1"]
    assert max(bar.extents) == pytest.approx(0.4, rel=0.05)


def test_the_machine_in_mujoco_closes_its_loops_and_follows_its_sliders(study: Study, tmp_path: Path) -> None:
    """Driven to where the inverse kinematics sends the sliders, the tool gets to the pose."""
    study.export(tmp_path / "machine.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "machine.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    loops = np.abs(data.efc_pos[: data.ne])
    assert data.ne == 3 * 2 * 3
    assert loops.max() < 1e-12
    assert model.body_mass.sum() == pytest.approx(study.result.indices["total_mass"])
    place = study.result.workspace.prescribed
    assert place is not None
    tool = np.mean([place.min, place.max], axis=0)
    goal = tool + np.array([0.02, -0.015, 0.01])
    start, end = (study.manipulator.inverse_kinematics(pose[None])[0][0] for pose in (tool, goal))
    np.testing.assert_allclose(data.qpos[[model.joint(f"slide_{i}").qposadr[0] for i in (1, 2, 3)]], start)
    model.opt.gravity[:] = 0
    for step in range(4000):
        part = min(step / 2000, 1.0)
        data.ctrl[:] = (1 - part) * start + part * end
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.site("tool").xpos, goal, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "settings", "apart"),
    [
        pytest.param(SPEC, [], 5e-8, id="orthoglide"),
        pytest.param(BARE, [], 5e-8, id="no mass is known"),
        pytest.param(SPEC, ["manipulator.payload={mass: 50 kg}"], 5e-8, id="a heavy payload"),
        pytest.param(SPEC, ["manipulator.actuators.mass=50 kg"], 5e-8, id="heavy sliders"),
        pytest.param(DELTA, [], 2e-7, id="linear delta"),
    ],
)
def test_the_machine_in_mujoco_keeps_to_the_inverse_kinematics_along_a_path_under_gravity(
    spec_of: Callable[..., Spec], tmp_path: Path, text: str, settings: list[str], apart: float
) -> None:
    """Wherever its tool is on the way, its sliders stand where the inverse kinematics has them."""
    study = evaluate(spec_of(text, *settings))
    study.export(tmp_path / "machine.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "machine.xml"))
    data, seen = mujoco.MjData(model), mujoco.MjData(model)
    assert model.opt.gravity[2] == -9.81
    sliders = [model.joint(f"slide_{i}").qposadr[0] for i in (1, 2, 3)]
    place = study.result.workspace.prescribed
    assert place is not None
    low, high = np.array(place.min), np.array(place.max)
    seconds = 4.0
    part = np.linspace(0, 1, round(seconds / model.opt.timestep))
    turn = 2 * np.pi * part - np.sin(2 * np.pi * part)  # from rest to rest
    path = (low + high) / 2 + 0.45 * (high - low) * np.sin(np.outer(turn, [1, 2, 3]))
    rho = study.manipulator.inverse_kinematics(path)[0]
    tools, found = [], []
    for step, sent in enumerate(rho):
        data.ctrl[:] = sent
        mujoco.mj_step(model, data)
        if step % 20 == 19:
            seen.qpos[:] = data.qpos
            mujoco.mj_kinematics(model, seen)
            tools.append(seen.site("tool").xpos.copy())
            found.append(seen.qpos[sliders])
    wanted, reachable = study.manipulator.inverse_kinematics(np.array(tools))
    assert reachable.all()
    assert np.abs(wanted - found).max() < apart
    assert np.ptp(tools, axis=0) == pytest.approx(0.9 * (high - low), rel=0.05)
    np.testing.assert_allclose(tools[-1], path[-1], atol=5e-4)


def test_designs_are_a_table_whose_numbers_read_back(study: Study, tmp_path: Path) -> None:
    study.export(tmp_path / "designs.csv")
    rows = list(csv.DictReader((tmp_path / "designs.csv").read_text().splitlines()))
    assert [row["design"] for row in rows] == ["evaluated", "sweep 1", "sweep 2", "sweep 3"]
    assert [float(row["leg"]) for row in rows] == [0.4, *(one.variables["leg"] for one in study.result.sweep)]
    highest = study.result.workspace.measures["transmission"].highest
    assert highest is not None
    assert float(rows[0]["transmission highest"]) == highest.value
    assert float(rows[0]["total_mass [kg]"]) == study.result.indices["total_mass"]
    lowest = study.result.workspace.measures["stiffness"].lowest
    assert lowest is not None
    assert float(rows[0]["stiffness lowest [N/m]"]) == lowest.value


@pytest.mark.parametrize(
    "name", ["cuboid.stl", "machine.glb", "machine.xml", "designs.csv", "fields.vti", "fields.nc"]
)
def test_a_file_has_the_same_bytes_each_time(study: Study, tmp_path: Path, name: str) -> None:
    first, second = (study.export(tmp_path / folder / name)[0].read_bytes() for folder in ("a", "b"))
    assert first == second


def test_a_name_says_what_is_written_and_may_have_more_before_it(study: Study, tmp_path: Path) -> None:
    export(study, [tmp_path / "before-designs.csv", tmp_path / "deep" / "after_designs.csv"])
    assert (tmp_path / "before-designs.csv").read_bytes() == (
        tmp_path / "deep" / "after_designs.csv"
    ).read_bytes()
    with pytest.raises(UsageError, match=r"fields\.vti .*ParaView") as caught:
        export(study, [tmp_path / "mydesigns.xls"])
    assert all(name in str(caught.value) for name in KINDS)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["before-designs.csv", "deep"]


@pytest.mark.filterwarnings("ignore")
def test_a_zarr_store_is_replaced_whole_and_through_a_link(study: Study, tmp_path: Path) -> None:
    store, link = tmp_path / "fields.zarr", tmp_path / "linked-fields.zarr"
    store.mkdir()
    link.symlink_to(store)
    study.export(store)
    (store / "stiffness" / "stray").touch()
    study.export(link)
    assert link.is_symlink()
    assert not (store / "stiffness" / "stray").exists()
    xarray.testing.assert_equal(xarray.open_zarr(store, consolidated=False).load(), study.fields())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fields.zarr", "linked-fields.zarr"]


@pytest.mark.parametrize(
    ("name", "made", "told"),
    [
        ("fields.zarr", "notes.txt", "holds other files and no Zarr store"),
        ("fields.zarr", None, "there is a file of this name"),
        ("fields.nc", "zarr.json", "there is a folder of this name"),
        ("designs.csv", "notes.txt", "there is a folder of this name"),
    ],
)
def test_what_is_of_another_kind_is_never_replaced(
    study: Study, tmp_path: Path, name: str, made: str | None, told: str
) -> None:
    place = tmp_path / name
    if made is not None:
        place.mkdir()
    other = place if made is None else place / made
    other.write_text("kept")
    with pytest.raises(UsageError, match=rf"{name}: .*{told}.*; choose another name"):
        export(study, [tmp_path / "cuboid.stl", place])
    assert other.read_text() == "kept"
    assert list(tmp_path.iterdir()) == [place]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("broken", [OSError("no room"), KeyboardInterrupt()])
def test_a_zarr_store_is_put_back_where_the_new_one_cannot_take_its_place(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: BaseException
) -> None:
    store = tmp_path / "fields.zarr"
    study.export(store)
    (store / "old").touch()
    rename = Path.rename

    def breaking(self: Path, target: Path) -> Path:
        if self.name == "fields.zarr" and target == store:
            assert not store.exists()
            raise broken
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", breaking)
    with pytest.raises((UsageError, KeyboardInterrupt)):
        export(study, [store])
    assert (store / "old").exists()
    assert list(tmp_path.iterdir()) == [store]


def test_a_missing_library_is_told_with_what_to_install(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(UsageError, match=r"needs trimesh: pip install 'orthospec\[exchange\]'"):
        export(study, [tmp_path / "cuboid.stl"])


@pytest.mark.parametrize("name", ["fields.nc", "fields.vti", "workspace.stl", "machine.glb", "machine.xml"])
def test_what_is_not_known_is_said_and_nothing_is_left(study: Study, tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match=r"not known|prismatic legs"):
        export(Solution(study.content, None), [tmp_path / name])
    assert list(tmp_path.iterdir()) == []

"""Compliance at the tool by PyNite, a program for building frames: ``python stiffness_by_pynite.py``.

Every link is a beam of the frame; passive joints are its members' end releases. The foot's own frame has the
revolute axis as y and the bar's has the parallelogram's normal as z, so both joints of a universal joint
are plain bending releases: about y at the end of the foot or of the platform's arm, about z at the bar's.
Parts that are rigid in the model are members of s times a link's stiffness. What that adds is a series in
1/s: compliances at s, 2s and 4s remove its first two terms, and s can stay small enough for rounding.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import stored
from machines import Chain, Leg, chains, leg, poses, shear_modulus
from Pynite import FEModel3D

STIFFER = 3e2
"""s: stiffness of the rigid parts over that of the links."""
RAIL = 0.1
"""Length of the member that stands for slide and actuator [m]."""
LOADS = ("FX", "FY", "FZ", "MX", "MY", "MZ")
UPPER = np.triu_indices(3)
RIGID = {"A": 1.6e-4, "Iy": 1e-8, "Iz": 1e-8, "J": 1e-8}
STEEL = {"E": 2.1e11, "G": 8.1e10}


class Frame:
    """A frame under construction."""

    def __init__(self) -> None:
        self.model = FEModel3D()

    def node(self, name: str, at: np.ndarray) -> str:
        return self.model.add_node(name, *map(float, at))

    def member(
        self, ends: tuple[str, str], section: Mapping[str, float], material: Mapping[str, float],
        normal: np.ndarray, *releases: str,
    ) -> None:  # fmt: skip
        """A beam whose local z axis is ``normal``, up to its sign, with these moments released."""
        name = "-".join(ends)
        elastic = (material["E"], shear_modulus(material), 0.3, 0.0)
        self.model.add_material(name, *elastic)
        self.model.add_section(name, *(section[key] for key in ("A", "Iy", "Iz", "J")))
        self.model.add_member(name, *ends, name, name)
        beam = self.model.members[name]
        _, y, z = beam.T()[:3, :3]
        beam.rotation = float(np.degrees(np.arctan2(-(normal @ y), normal @ z)))
        self.model.def_releases(name, **dict.fromkeys(releases, True))


def compliance(machine: Mapping[str, Any], tool: np.ndarray) -> np.ndarray:
    """(6, 6) at the tool, order x y z rx ry rz."""
    one, two, four = (_with_rigid_parts_of(machine, tool, s * STIFFER) for s in (1, 2, 4))
    extrapolated = (8 * four - 6 * two + one) / 3
    return (extrapolated + extrapolated.T) / 2


def _with_rigid_parts_of(machine: Mapping[str, Any], tool: np.ndarray, stiffer: float) -> np.ndarray:
    frame = Frame()
    frame.node("tool", tool)
    rigid = {key: stiffer * value for key, value in RIGID.items()}
    for i, chain in enumerate(chains(machine)):
        _add_chain(frame, str(i), machine, chain, leg(chain, tool), rigid)
    for load in LOADS:
        frame.model.add_load_combo(load, {load: 1.0})
        frame.model.add_node_load("tool", load, 1.0, case=load)
    # PyNite's test of stability takes a residual of stiff parts for a loose machine.
    frame.model.analyze_linear(check_stability=False, sparse=False)
    node = frame.model.nodes["tool"]
    moved = (node.DX, node.DY, node.DZ, node.RX, node.RY, node.RZ)
    return np.array([[direction[load] for load in LOADS] for direction in moved])


def _add_chain(
    frame: Frame, i: str, machine: Mapping[str, Any], chain: Chain, at: Leg, rigid: Mapping[str, float]
) -> None:
    feet, inwards = machine["feet"], -chain.branch * chain.axis
    carriage = at.slider_end - feet["length"] * inwards
    ground = frame.node(f"ground{i}", carriage - RAIL * inwards)
    frame.model.def_support(ground, *[True] * 6)
    nodes = [frame.node(f"carriage{i}", carriage), frame.node(f"A{i}", at.slider_end)]
    across = np.cross(inwards, chain.revolute)
    drive = {**rigid, "A": machine["actuators"]["stiffness"] * RAIL / STEEL["E"]}
    frame.member((ground, nodes[0]), drive, STEEL, across)
    frame.member(
        (nodes[0], nodes[1]), _rectangle(**feet["section"]["rectangle"]), feet["material"], across, "Ryj"
    )
    frame.node(f"B{i}", at.platform_end)
    arm_across = np.cross(chain.arm, chain.revolute) / np.linalg.norm(chain.arm)
    frame.member(("tool", f"B{i}"), rigid, STEEL, arm_across, "Ryj")
    _add_bars(frame, i, machine["legs"], chain, at, rigid)


def _add_bars(
    frame: Frame, i: str, legs: Mapping[str, Any], chain: Chain, at: Leg, rigid: Mapping[str, float]
) -> None:
    bar = (legs["section"]["given"], legs["material"], at.normal, "Rzi", "Rzj")
    if legs["kind"] == "PUU":
        frame.member((f"A{i}", f"B{i}"), *bar)
        return
    for side, sign in (("+", 0.5), ("-", -0.5)):
        sideways = sign * legs["spacing"] * chain.revolute
        for end, middle in (("A", at.slider_end), ("B", at.platform_end)):
            frame.node(end + i + side, middle + sideways)
            frame.member((end + i, end + i + side), rigid, STEEL, at.normal)
        frame.member((f"A{i}{side}", f"B{i}{side}"), *bar)


def _rectangle(height: float, width: float) -> dict[str, float]:
    """Torsion by Saint-Venant's series (Timoshenko and Goodier, *Theory of Elasticity*, art. 109)."""
    long, short = max(height, width), min(height, width)
    n = np.arange(1, 200, 2)
    ends = np.sum(np.tanh(n * np.pi * long / (2 * short)) / n**5) * 192 * short / (np.pi**5 * long)
    return {
        "A": height * width,
        "Iy": width * height**3 / 12,
        "Iz": height * width**3 / 12,
        "J": long * short**3 / 3 * (1 - ends),
    }


def asked(case: str) -> dict[str, np.ndarray]:
    return {"poses": poses(case)}


def answers(machine: Mapping[str, Any], tool: np.ndarray) -> dict[str, np.ndarray]:
    """The blocks by name: their units and sizes differ."""
    C = compliance(machine, tool)
    return {"tt": C[:3, :3][UPPER], "tr": C[:3, 3:], "rr": C[3:, 3:][UPPER]}


if __name__ == "__main__":
    stored.run("stiffness", "PyNiteFEA", asked, answers, tolerance=1e-6)

"""Enclosures beside the values they enclose: escapes, which must be none, and widths over ranges.

python benchmarks/enclosures.py [BLOCKS]

A block tries 3,400,000 pairs of a box and a pose in it. Values in doubles are taken to be right to 1e-9 of
themselves, elastic ones to 10 units of rounding times the condition number of the compliance if that is more:
near singularities the enclosures tell more digits than the values. An escape by more is a fault, and so is a
value that cannot be computed where one is claimed.
"""

from __future__ import annotations

import itertools
import sys
import time
from typing import NamedTuple

import numpy as np

from orthospec.intervals import Boxes
from orthospec.manipulators import Manipulator
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Measure
from orthospec.measures.dynamic import (
    Acceleration,
    ActuatorForce,
    DynamicIsotropy,
    GieNorm,
    JointSpeed,
    ToolSpeed,
)
from orthospec.measures.elastic import Deflection, Rotation, RotationalStiffness, Stiffness
from orthospec.measures.kinematic import ConditionNumber, Manipulability, VelocityTransmission

RIGHT = 1e-9
BOXES, POINTS = 500, 20
SIZES = (1e-9, 1e-6, 1e-3, 0.01, 0.1)
WRENCH = (10.0, -20.0, 30.0, 1.0, 2.0, -3.0)
BAR = {
    "material": "aluminium",
    "section": {"round": {"diameter": 0.02, "wall": 0.002}},
}
PARTS = {
    "actuators": {"stiffness": 2e7, "mass": 1.7, "force": 500.0, "speed": 2.0, "friction": 10.0},
    "platform": {"mass": 0.8},
    "gravity": (0.0, 0.0, -9.81),
}
MEASURES: dict[str, Measure] = {
    "velocity_transmission": VelocityTransmission(),
    "condition_number": ConditionNumber(),
    "manipulability": Manipulability(),
    "deflection": Deflection(force=100),
    "deflection, wrench": Deflection(wrench=WRENCH),
    "rotation, torque": Rotation(torque=10),
    "rotation, force": Rotation(force=100),
    "stiffness": Stiffness(),
    "rotational_stiffness": RotationalStiffness(),
    "gie_norm": GieNorm(),
    "dynamic_isotropy": DynamicIsotropy(),
    "acceleration": Acceleration(),
    "acceleration, ellipsoid": Acceleration(ball="ellipsoid"),
    "joint_speed": JointSpeed(speed=1.5),
    "tool_speed": ToolSpeed(),
    "actuator_force": ActuatorForce(acceleration=10, speed=1),
}
CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


class Region(NamedTuple):
    """Where a machine's boxes are drawn from; the whole reach and a little beyond it."""

    machine: Manipulator
    low: float
    high: float
    middle: tuple[float, float, float]


def regions() -> dict[str, Region]:
    found = {}
    for kind in ("PUU", "PRPaR"):
        legs = {"kind": kind, **BAR, **({"spacing": 0.08} if kind == "PRPaR" else {})}
        orthoglide = Orthoglide(leg_lengths=(0.31, 0.31, 0.31), legs={**legs, "offset": 0.02}, **PARTS)
        found[f"orthoglide {kind}"] = Region(orthoglide, -0.22, 0.13, (0.0, 0.0, 0.0))
        delta = LinearDelta(
            leg_lengths=(0.4, 0.4, 0.4),
            base_radius=0.25,
            platform_radius=0.06,
            rail_tilt=0.2,
            legs=legs,
            **PARTS,
        )
        found[f"linear_delta {kind}"] = Region(delta, -0.2, 0.2, (0.0, 0.0, -0.2))
    return found


def boxes_in(region: Region, size: float, random: np.random.Generator) -> Boxes:
    edges = (region.high - region.low) * size * random.uniform(0.2, 1.0, (BOXES, 3))
    lo = np.array(region.middle) + random.uniform(region.low, region.high, (BOXES, 3))
    lo[: BOXES // 10] = np.array(region.middle) - edges[: BOXES // 10] * 0.5  # About a symmetric pose.
    return Boxes(lo, lo + edges)


def points_in(boxes: Boxes, random: np.random.Generator) -> np.ndarray:
    t = random.uniform(0, 1, (len(boxes), POINTS, 3))
    t[:, :8] = CORNERS
    points = boxes.lo[:, None] + t * (boxes.hi - boxes.lo)[:, None]
    return np.clip(points, boxes.lo[:, None], boxes.hi[:, None])


class Tally(NamedTuple):
    """What came of one measure's pairs."""

    pairs: int
    claimed: int
    escapes: int
    width: float
    """Of the enclosures over the sampled ranges, in the median."""
    seconds: float
    """A box."""


def tally(region: Region, measure: Measure, boxes: Boxes, points: np.ndarray) -> Tally:
    began = time.perf_counter()
    found = measure.enclosure(region.machine, boxes)
    seconds = (time.perf_counter() - began) / len(boxes)
    assert found is not None
    values = measure.values(region.machine, points.reshape(-1, 3))
    values = values.reshape(*points.shape[:2], *values.shape[1:])
    right = _rightness(region.machine, measure, points.reshape(-1, 3)).reshape(points.shape[:2])
    right = np.abs(values) * (right[:, :, None] if values.ndim == 3 else right)
    inside = (found.lo[:, None] - right <= values) & (values <= found.hi[:, None] + right)
    claimed = ~np.isnan(found.lo)[:, None]
    escapes = int((claimed & ~inside).sum())
    reached = np.ptp(values, axis=1)
    usable = np.isfinite(found.hi - found.lo) & np.isfinite(reached) & (reached > 0)
    width = float(np.median(((found.hi - found.lo) / reached)[usable])) if usable.any() else np.nan
    return Tally(inside.size, int(np.broadcast_to(claimed, inside.shape).sum()), escapes, width, seconds)


def _rightness(machine: Manipulator, measure: Measure, poses: np.ndarray) -> np.ndarray:
    """What the values at poses are taken to be right to (n,), relative."""
    right = np.full(len(poses), RIGHT)
    if "compliance" in measure.needs:
        compliance = machine.compliance(poses)
        finite = np.isfinite(compliance).all(axis=(1, 2))
        right[finite] += 10 * np.finfo(float).eps * np.linalg.cond(compliance[finite])
    return right


def main(blocks: int) -> int:
    print(f"{'machine':20}{'measure':26}{'pairs':>10}{'claimed':>10}{'escapes':>9}{'width':>8}{'us/box':>8}")
    escapes = pairs = 0
    for name, region in regions().items():
        for label, measure in MEASURES.items():
            random = np.random.default_rng(0)
            found = []
            with np.errstate(all="ignore"):
                for _, size in itertools.product(range(blocks), SIZES):
                    boxes = boxes_in(region, size, random)
                    found.append(tally(region, measure, boxes, points_in(boxes, random)))
            total = [sum(column) for column in zip(*(one[:3] for one in found), strict=True)]
            width, seconds = np.nanmedian([one.width for one in found]), min(one.seconds for one in found)
            print(
                f"{name:20}{label:26}{total[0]:10}{total[1]:10}{total[2]:9}{width:8.2f}{1e6 * seconds:8.0f}"
            )
            pairs, escapes = pairs + total[0], escapes + total[2]
    print(f"{pairs} pairs, {escapes} escapes")
    return int(escapes > 0)


if __name__ == "__main__":
    raise SystemExit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 1))

"""Every measure over every built-in machine: no value escapes its box's enclosure.

Against 30 digits, computed from the formulas in docs/method.md, on boxes down to single points, at the
isotropic pose, near the parallel singularity and near the edge of the reach; and against doubles, right to
1e-9, on many more boxes.
"""

from __future__ import annotations

import itertools
from functools import cache

import mpmath
import numpy as np
import pytest

from orthospec.intervals import Boxes
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
from orthospec.mechanics import prismatic

WRENCH = (10.0, -20.0, 30.0, 1.0, 2.0, -3.0)
LIMITS = {"stiffness": 2e7, "mass": 1.7, "force": 500.0, "speed": 2.0, "friction": 10.0}
PARTS = {
    "actuators": LIMITS,
    "platform": {"mass": 0.8},
    "gravity": (1.5, -2.0, -9.5),
    "feet": {
        "length": 0.08,
        "section": {"rectangle": {"height": 0.03, "width": 0.02}},
        "material": {"E": 2.1e11, "G": 8.1e10},
        "mass": 0.4,
    },
}
BAR = {
    "section": {"given": {"A": 1.6e-4, "Iy": 9.0e-9, "Iz": 5.0e-9, "J": 1.1e-8}},
    "material": {"E": 7.0e10, "nu": 0.33, "density": 2700.0},
}
PUU, PRPAR = {"kind": "PUU", **BAR}, {"kind": "PRPaR", "spacing": 0.08, **BAR}


@cache
def machine(name):
    if name == "orthoglide":
        return Orthoglide(leg_lengths=(0.31, 0.33, 0.36), legs={**PUU, "offset": 0.03}, **PARTS)
    if name == "orthoglide_equal":
        return Orthoglide(
            leg_lengths=(0.31,) * 3, legs=PRPAR, joint_limits={"min": 0.15, "max": 0.4}, **PARTS
        )
    if name == "orthoglide_branch":
        return Orthoglide(leg_lengths=(0.31, 0.33, 0.36), branch=(1, -1, 1), legs=PRPAR, **PARTS)
    if name == "orthoglide_drives":
        rigid = {"kind": "PRPaR", "spacing": 0.08, "section": {"compliance": np.zeros((6, 6)).tolist()}}
        return Orthoglide(leg_lengths=(0.31,) * 3, legs=rigid, **{**PARTS, "feet": "rigid"})
    if name in {"delta_vertical", "delta_star"}:
        tilt = 0.0 if name == "delta_vertical" else np.pi / 2
        keys = {"base_radius": 0.25, "platform_radius": 0.05, "rail_tilt": tilt}
        return LinearDelta(leg_lengths=(0.4,) * 3, legs=PRPAR, **keys, **PARTS)
    delta = {"leg_lengths": (0.4, 0.43, 0.38), "base_radius": 0.25, "platform_radius": 0.06}
    legs, tilt = (PUU, 0.25) if name == "delta" else (PRPAR, -0.2)
    return LinearDelta(**delta, rail_tilt=tilt, legs=legs, **PARTS)


REGIONS = {
    "orthoglide": ([-0.12] * 3, [0.07] * 3),
    "orthoglide_equal": ([-0.12] * 3, [0.07] * 3),
    "orthoglide_branch": ([-0.12, -0.07, -0.12], [0.07, 0.12, 0.07]),
    "delta": ([-0.08, -0.08, -0.25], [0.08, 0.08, -0.1]),
    "delta_prpar": ([-0.08, -0.08, -0.25], [0.08, 0.08, -0.1]),
}
FURTHER = {
    "orthoglide_drives": ([-0.12] * 3, [0.07] * 3),
    "delta_vertical": ([-0.08, -0.08, -0.3], [0.08, 0.08, -0.2]),
    "delta_star": ([-0.08, -0.08, -0.3], [0.08, 0.08, -0.2]),
}
ALL = {**REGIONS, **FURTHER}
MEASURES = {
    "transmission": VelocityTransmission(),
    "condition": ConditionNumber(),
    "manipulability": Manipulability(),
    "deflection": Deflection(force=100),
    "deflection of a wrench": Deflection(wrench=WRENCH),
    "rotation": Rotation(torque=10),
    "rotation by a force": Rotation(force=100),
    "rotation by a wrench": Rotation(wrench=WRENCH),
    "stiffness": Stiffness(),
    "rotational stiffness": RotationalStiffness(),
    "gie": GieNorm(),
    "isotropy": DynamicIsotropy(),
    "acceleration": Acceleration(),
    "ellipsoid": Acceleration(ball="ellipsoid"),
    "joint speed": JointSpeed(speed=1.5),
    "tool speed": ToolSpeed(),
    "actuator force": ActuatorForce(acceleration=10),
}


# The machines in 30 digits.


def vector(numbers):
    return mpmath.matrix([mpmath.mpf(float(x)) for x in numbers])


def matrix(numbers):
    return mpmath.matrix([[mpmath.mpf(float(x)) for x in row] for row in numbers])


def dot(a, b):
    return mpmath.fsum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return mpmath.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def length(a):
    return mpmath.sqrt(dot(a, a))


def singular_values(A):
    """Ascending, as roots of the eigenvalues of AᵀA; 30 digits leave 15."""
    return [mpmath.sqrt(max(e, 0)) for e in sorted(mpmath.eigsy(A.T * A, eigvals_only=True))]


def greatest(A):
    return max(mpmath.eigsy((A + A.T) / 2, eigvals_only=True))


def legs_of(machine, pose):
    """Each leg's s and s·e, from ρ = d·e + β sqrt(L² − |d − (d·e) e|²)."""
    found = []
    g = machine.geometry
    for i in range(3):
        e, d = vector(g.axes[i]), vector(pose) + vector(g.joints[i, :, 0]) - vector(g.bases[i, :, 0])
        across = d - dot(d, e) * e
        closing = mpmath.mpf(float(g.lengths[i, 0])) ** 2 - dot(across, across)
        along = float(g.branches[i]) * mpmath.sqrt(closing)
        found.append(((dot(d, e) + along) * e - d, along))
    return found


def compliance(machine, legs):
    """C = (Σ W D⁻¹ Wᵀ)⁻¹ with each D from beam theory."""
    g, springs, K = machine.geometry, machine.springs, mpmath.zeros(6)
    for i, (s, _) in enumerate(legs):
        u, a = s / mpmath.mpf(float(g.lengths[i, 0])), vector(g.revolutes[i])
        z = cross(a, u)
        cosine, sine = length(z), -dot(a, u)
        z = z / cosine
        t = cross(a, z)
        C, d = matrix(springs.bars[i]), springs.spacing
        twist = C[3, 3] * cosine**2 + C[4, 4] * sine**2
        if d is None:
            moments, D = [t], mpmath.diag([C[0, 0], twist])
        else:
            d = mpmath.mpf(d)
            h = C[2, 2] - C[2, 4] ** 2 / C[4, 4]
            sway = twist * h / (2 * h + d**2 * twist / 2)
            moments, D = [t, z], mpmath.diag([C[0, 0] / 2, sway, 2 * C[0, 0] / (d * cosine) ** 2])
        D[0, 0] += mpmath.mpf(springs.actuator) * dot(vector(g.axes[i]), u) ** 2
        none = mpmath.zeros(3, 1)
        at_foot = columns([(u, none), *((none, m) for m in moments)])
        D += at_foot.T * matrix(springs.feet[i]) * at_foot
        W = columns([(u, cross(vector(g.joints[i, :, 0]), u)), *((none, m) for m in moments)])
        K += W * D**-1 * W.T
    return K**-1


def columns(wrenches):
    return mpmath.matrix([[*force, *moment] for force, moment in wrenches]).T


def exact_values(machine, pose):
    """Each measure's value, or its two."""
    legs = legs_of(machine, pose)
    inverse = mpmath.matrix([[x / along for x in s] for s, along in legs])
    sigma = singular_values(inverse)
    found = {
        "transmission": (1 / sigma[2], 1 / sigma[0]),
        "condition": sigma[2] / sigma[0],
        "manipulability": 1 / abs(mpmath.det(inverse)),
    }
    rows = [length(inverse[i, :]) for i in range(3)]
    found["joint speed"] = mpmath.mpf(1.5) * max(rows)
    found["tool speed"] = mpmath.mpf(2) / max(rows)
    return {**found, **elastic_values(machine, legs), **dynamic_values(machine, inverse)}


def elastic_values(machine, legs):
    C = compliance(machine, legs)
    tt, rr, rt = C[:3, :3], C[3:, 3:], C[3:, :3]
    moved = C * vector(WRENCH)
    return {
        "deflection": 100 * greatest(tt),
        "deflection of a wrench": length(moved[:3]),
        "rotation": 10 * greatest(rr),
        "rotation by a force": 100 * mpmath.sqrt(greatest(rt * rt.T)),
        "rotation by a wrench": length(moved[3:]),
        "stiffness": 1 / greatest(tt),
        "rotational stiffness": 1 / greatest(rr),
    }


def dynamic_values(machine, inverse):
    g, masses = machine.geometry, machine.masses
    sliders, m = mpmath.mpf(masses.sliders), vector(masses.legs[0])
    G = mpmath.mpf(masses.platform) * mpmath.eye(3)
    gravity, J = vector(machine.gravity), inverse**-1
    rest = -(mpmath.mpf(masses.platform) + mpmath.fsum(m) / 2) * (J.T * gravity)
    for i in range(3):
        j, e = inverse[i, :].T, vector(g.axes[i])
        G += (sliders + m[i] / 3) * j * j.T + m[i] / 3 * mpmath.eye(3) + m[i] / 6 * (j * e.T + e * j.T)
        rest[i] -= (sliders + m[i] / 2) * dot(e, gravity)
    eigenvalues = sorted(mpmath.eigsy(G, eigvals_only=True))
    rows = J.T * G
    sizes = [length(rows[i, :]) for i in range(3)]
    left = [500 - 10 - abs(x) for x in rest]
    radius = min(t / size for t, size in zip(left, sizes, strict=True))
    scaled = mpmath.matrix([[x / left[i] for x in rows[i, :]] for i in range(3)])
    return {
        "gie": eigenvalues[2],
        "isotropy": eigenvalues[2] / eigenvalues[0],
        "acceleration": radius,
        "ellipsoid": 1 / singular_values(scaled)[2] if min(left) > 0 else radius,
        "actuator force": max(10 * size + 10 + abs(x) for size, x in zip(sizes, rest, strict=True)),
    }


def boxes_in(region, widths, count, seed=0):
    """Boxes of these widths within the region, as parts of it, ``count`` each."""
    low, high = map(np.array, region)
    random = np.random.default_rng(seed)
    corners, edges = [], []
    for width in widths:
        edges.append((high - low) * width * random.uniform(0.3, 1, (count, 3)))
        corners.append(random.uniform(low, high - edges[-1]))
    lo, hi = np.concatenate(corners), np.concatenate(corners) + np.concatenate(edges)
    return Boxes(lo, hi)


def points_of(boxes, count, seed=1):
    """Corners and other points of each box (n, count, 3)."""
    signs = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    t = np.random.default_rng(seed).uniform(0, 1, (len(boxes), count, 3))
    t[:, : min(count // 2, 8)] = signs[: min(count // 2, 8)]
    points = boxes.lo[:, None] + t * (boxes.hi - boxes.lo)[:, None]
    return np.clip(points, boxes.lo[:, None], boxes.hi[:, None])


def exactly_inside(found, value, i):
    """Whether the exact value, or each of two, lies in box i's enclosure; always where nothing is claimed."""
    values = value if isinstance(value, tuple) else (value,)
    ends = zip(np.atleast_1d(found.lo[i]), np.atleast_1d(found.hi[i]), values, strict=True)
    return all(np.isnan(lo) or mpmath.mpf(float(lo)) <= v <= mpmath.mpf(float(hi)) for lo, hi, v in ends)


def escapes(machine, boxes, points):
    enclosures = {name: measure.enclosure(machine, boxes) for name, measure in MEASURES.items()}
    found = []
    with mpmath.workdps(30):
        for i, row in enumerate(points):
            for pose in row:
                for name, value in exact_values(machine, pose).items():
                    if not exactly_inside(enclosures[name], value, i):
                        found.append((name, pose))
    return found, enclosures


@pytest.mark.parametrize("name", REGIONS)
def test_no_exact_value_escapes(name):
    boxes = boxes_in(REGIONS[name], [0.0, 1e-13, 1e-6, 0.02, 0.2], 2)
    found, enclosures = escapes(machine(name), boxes, points_of(boxes, 2))
    assert found == []
    for enclosure in enclosures.values():
        width = (enclosure.hi - enclosure.lo)[:4] / np.abs(enclosure.hi[:4])
        assert np.max(width) < 1e-7


def test_no_exact_value_escapes_at_the_isotropic_pose():
    around = np.array([[0.0, 0.0], [-1e-15, 1e-15], [-1e-8, 2e-8], [0.0, 1e-3], [-0.02, 0.02]])
    boxes = Boxes(np.repeat(around[:, :1], 3, axis=1), np.repeat(around[:, 1:], 3, axis=1))
    found, enclosures = escapes(machine("orthoglide_equal"), boxes, points_of(boxes, 3))
    assert found == []
    np.testing.assert_allclose(enclosures["transmission"].lo[:2], 1, rtol=0, atol=1e-13)
    np.testing.assert_allclose(enclosures["condition"].hi[:2], 1, rtol=0, atol=1e-12)


SINGULAR = 0.31 / np.sqrt(6)
EDGE = 0.31 / np.sqrt(2)


@pytest.mark.parametrize(
    ("low", "high", "claimed"),
    [
        ([SINGULAR - 1.02e-4] * 3, [SINGULAR - 1e-4] * 3, ["transmission", "condition", "actuator force"]),
        ([SINGULAR - 1.002e-7] * 3, [SINGULAR - 1e-7] * 3, ["transmission", "condition"]),
        ([SINGULAR - 0.01] * 3, [SINGULAR + 0.01] * 3, ["joint speed"]),
        ([-0.1, 0.999 * EDGE, 0.999 * EDGE], [-0.0999, 0.99901 * EDGE, 0.99901 * EDGE], [*MEASURES]),
        ([0, EDGE * (1 - 1.01e-8), EDGE * (1 - 1.01e-8)], [0, *[EDGE * (1 - 1e-8)] * 2], ["joint speed"]),
    ],
    ids=["singular", "very singular", "across", "edge", "at the edge"],
)
def test_no_exact_value_escapes_near_singularities_and_edges(low, high, claimed):
    boxes = Boxes(np.array([low]), np.array([high]))
    found, enclosures = escapes(machine("orthoglide_equal"), boxes, points_of(boxes, 3))
    assert found == []
    for name in claimed:
        assert np.isfinite([enclosures[name].lo, enclosures[name].hi]).all()


def test_what_lies_beyond_the_edge_is_not_claimed():
    boxes = Boxes(np.array([[0.0, 0.999 * EDGE, EDGE]]), np.array([[0.01, 1.001 * EDGE, EDGE]]))
    for measure in MEASURES.values():
        found = measure.enclosure(machine("orthoglide_equal"), boxes)
        assert not np.isfinite(found.lo).any() or not np.isfinite(found.hi).any()
    margins = machine("orthoglide_equal").reach_enclosure(boxes)
    assert margins["leg_1"].lo < 0 < margins["leg_1"].hi


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("measure", [*MEASURES, "moving"])
def test_no_value_of_many_boxes_escapes(name, measure):
    known = {**MEASURES, "moving": ActuatorForce(acceleration=10, speed=1)}[measure]
    boxes = boxes_in(ALL[name], [0.0, 1e-4, 0.01, 0.1, 0.4], 30)
    points = points_of(boxes, 6)
    found = known.enclosure(machine(name), boxes)
    values = known.values(machine(name), points.reshape(-1, 3))
    values = values.reshape(len(boxes), -1, *values.shape[1:])
    lo, hi = found.lo[:, None], found.hi[:, None]
    unclaimed = np.isnan(found.lo)
    rounding = 1e-9 * np.where(np.isfinite(values), np.abs(values), 0.0)
    assert ((lo <= values + rounding) & (values - rounding <= hi) | unclaimed[:, None]).all()
    assert not unclaimed[:90].any()


@pytest.mark.parametrize("name", ALL)
def test_no_margin_of_the_reach_escapes(name):
    boxes = boxes_in(([-0.35] * 3, [0.35] * 3), [0.0, 1e-4, 0.01, 0.1, 0.4], 100)
    points = points_of(boxes, 9)
    margins = machine(name).reach(points.reshape(-1, 3))
    for key, found in machine(name).reach_enclosure(boxes).items():
        values = margins[key].reshape(len(boxes), -1)
        unclaimed = np.isnan(found.lo)[:, None]
        inside = (found.lo[:, None] <= values + 1e-12) & (values - 1e-12 <= found.hi[:, None])
        assert (inside | unclaimed).all()
        assert (unclaimed | ~np.isnan(values)).all()
        assert not unclaimed.all()
        assert not (key.startswith("leg") and unclaimed.any())


def excess_width(name, known, half):
    """How much wider than the range over a lattice the enclosure of one box is, relative."""
    low, high = REGIONS[name]
    centre = np.array([low]) * 0.4 + np.array([high]) * 0.6
    boxes = Boxes(centre - half, centre + half)
    found = known.enclosure(machine(name), boxes)
    u = np.array(list(itertools.product(np.linspace(-half, half, 9), repeat=3)))
    values = known.values(machine(name), centre + u)
    return np.max((found.hi - found.lo)[0] - np.ptp(values, axis=0)) / np.max(np.abs(values))


@pytest.mark.parametrize("measure", ["transmission", "condition", "manipulability", "deflection", "gie"])
def test_enclosures_converge_quadratically(measure):
    """Of the ends that are bounded: so for upper ends, and lower ones where the extremes are simple."""
    known = MEASURES[measure]
    wide, narrow = (excess_width("orthoglide_branch", known, half) for half in (4e-3, 4e-4))
    assert narrow < wide / 20


class Wear(Measure):
    """A stranger's measure, written for arrays of numbers."""

    unit = "1"
    sides = frozenset({"at_most"})

    def values(self, manipulator, poses):
        inverse = manipulator.inverse_jacobian(poses)
        rates = np.sqrt(np.sum(inverse**2, axis=2))
        return np.where(rates[:, 0] > 1.1, rates.max(axis=1), np.log(rates).sum(axis=1) + 1.1)


def test_a_measure_in_plain_numpy_has_its_enclosure_for_nothing():
    boxes = boxes_in(REGIONS["orthoglide"], [1e-3, 0.1], 50)
    found = Wear().enclosure(machine("orthoglide"), boxes)
    values = Wear().values(machine("orthoglide"), points_of(boxes, 5).reshape(-1, 3)).reshape(-1, 5)
    assert ((found.lo[:, None] <= values) & (values <= found.hi[:, None])).all()


def test_one_block_of_boxes_closes_the_loops_once(monkeypatch):
    blocks, close = [], prismatic.close

    def counted(geometry, poses):
        blocks.append(poses)
        return close(geometry, poses)

    monkeypatch.setattr(prismatic, "close", counted)
    boxes = boxes_in(REGIONS["delta"], [0.01], 5)
    fresh = machine("delta").model_copy(update={"rail_tilt": 0.26})
    for measure in MEASURES.values():
        measure.enclosure(fresh, boxes)
    assert len(blocks) == 1

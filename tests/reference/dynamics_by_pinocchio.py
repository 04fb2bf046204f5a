"""Inertia, Jacobian and inverse dynamics by Pinocchio, made for robots: ``python dynamics_by_pinocchio.py``.

Pinocchio computes trees, so each loop is cut where a bar meets the platform: the tree has the three slides,
on each its first revolute joint, on that its bars, each on its own revolute joint, and beside them the
platform on three slides of its own. The bars' tips must move as the platform does, A(q) v = 0. With N the
motions that this leaves, one a slider (N = 1 there), M the tree's inertia and b its forces at the motion
asked for,

    D = Nᵀ M N,      J = the platform's rows of N,      actuator forces = Nᵀ b.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import stored
from machines import MACHINES, POSES, Chain, chains, leg, poses

WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
SPEED, ACCELERATION = 2.0, 20.0
UPPER = np.triu_indices(3)


class Tree(NamedTuple):
    """The machine with its loops cut; columns of v by what they belong to."""

    model: pin.Model
    sliders: list[int]
    platform: list[int]
    tips: list[int]


def tree(machine: Mapping[str, Any]) -> Tree:
    """At q = 0 sliders stand at their bases and every leg lies along ``_rest(chain)``."""
    model = pin.Model()
    model.gravity.linear = np.array(machine["gravity"])
    sliders, tips, across = [], [], _across(machine["legs"])
    for chain in chains(machine):
        slider = _slide(model, 0, chain.axis, chain.base, _slider_mass(machine))
        sliders.append(model.idx_vs[slider])
        rest = _rest(chain)
        hinge = _joint(model, slider, pin.JointModelRevoluteUnaligned(chain.revolute), np.zeros(3))
        for distance in across:
            axis = pin.JointModelRevoluteUnaligned(np.cross(rest, chain.revolute))
            bar = _joint(model, hinge, axis, distance * chain.revolute)
            model.appendBodyToJoint(bar, _rod(machine, chain, rest), pin.SE3.Identity())
            tips.append(_frame(model, bar, chain.length * rest))
    platform, mass = 0, machine["platform"]["mass"] + machine.get("payload", {"mass": 0.0})["mass"]
    for i in range(3):
        platform = _slide(model, platform, np.eye(3)[i], np.zeros(3), mass if i == 2 else 0.0)
    last = model.idx_vs[platform]
    return Tree(model, sliders, [last - 2, last - 1, last], tips)


def _rest(chain: Chain) -> np.ndarray:
    """A direction across the revolute axis: inwards along the slide."""
    return -chain.branch * chain.axis


def _across(legs: Mapping[str, Any]) -> list[float]:
    return [0.0] if legs["kind"] == "PUU" else [-legs["spacing"] / 2, legs["spacing"] / 2]


def _slider_mass(machine: Mapping[str, Any]) -> float:
    feet = machine["feet"]
    box = feet["section"]["rectangle"]
    mass = feet["length"] * box["height"] * box["width"] * feet["material"]["density"]
    return machine["actuators"]["mass"] + feet.get("mass", mass)


def _rod(machine: Mapping[str, Any], chain: Chain, along: np.ndarray) -> pin.Inertia:
    """A thin uniform rod from the joint to its tip."""
    legs = machine["legs"]
    mass = legs.get("mass", legs["section"]["given"]["A"] * chain.length * legs["material"]["density"])
    about_centre = mass * chain.length**2 / 12 * (np.eye(3) - np.outer(along, along))
    return pin.Inertia(mass, chain.length / 2 * along, about_centre)


def _joint(model: pin.Model, parent: int, kind: Any, at: np.ndarray) -> int:
    return model.addJoint(parent, kind, pin.SE3(np.eye(3), at), f"joint {model.njoints}")


def _slide(model: pin.Model, parent: int, axis: np.ndarray, at: np.ndarray, mass: float) -> int:
    joint = _joint(model, parent, pin.JointModelPrismaticUnaligned(axis), at)
    model.appendBodyToJoint(joint, pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))), pin.SE3.Identity())
    return joint


def _frame(model: pin.Model, joint: int, at: np.ndarray) -> int:
    placement = pin.SE3(np.eye(3), at)
    return model.addFrame(pin.Frame(f"tip {model.nframes}", joint, placement, pin.FrameType.OP_FRAME))


def configuration(machine: Mapping[str, Any], tool: np.ndarray) -> np.ndarray:
    """q in the order in which ``tree`` adds its joints."""
    q: list[float] = []
    for chain in chains(machine):
        at, rest = leg(chain, tool), _rest(chain)
        swing = np.arctan2(at.along @ np.cross(chain.revolute, rest), at.along @ rest)
        lean = np.arcsin(at.along @ chain.revolute)
        q += [at.rho, swing, *[lean] * len(_across(machine["legs"]))]
    return np.array([*q, *tool])


class Cut(NamedTuple):
    """The tree at one configuration and its motions that keep the loops closed."""

    tree: Tree
    data: pin.Data
    q: np.ndarray
    constraint: np.ndarray
    motions: np.ndarray


def cut(machine: Mapping[str, Any], tool: np.ndarray) -> Cut:
    parts = tree(machine)
    data, q = parts.model.createData(), configuration(machine, tool)
    pin.framesForwardKinematics(parts.model, data, q)
    for tip, end in zip(parts.tips, _ends(machine, tool), strict=True):
        assert np.allclose(data.oMf[tip].translation, end, rtol=0, atol=1e-14), "a loop is not closed"
    rows = []
    for tip in parts.tips:
        row = pin.computeFrameJacobian(parts.model, data, q, tip, WORLD)[:3]
        row[:, parts.platform] -= np.eye(3)
        rows.append(row)
    constraint = np.vstack(rows)
    motions = _completed(constraint, parts.sliders, np.eye(3))
    return Cut(parts, data, q, constraint, motions)


def _ends(machine: Mapping[str, Any], tool: np.ndarray) -> list[np.ndarray]:
    """Where the platform holds each bar."""
    across = _across(machine["legs"])
    return [tool + chain.arm + side * chain.revolute for chain in chains(machine) for side in across]


def _completed(
    constraint: np.ndarray, given: list[int], values: np.ndarray, drift: np.ndarray | float = 0.0
) -> np.ndarray:
    """The v with A v + drift = 0 whose entries ``given`` have these values; bars' rows may repeat."""
    rest = [i for i in range(constraint.shape[1]) if i not in given]
    right = -(constraint[:, given] @ values + drift)
    found, _, rank, _ = np.linalg.lstsq(constraint[:, rest], right, rcond=1e-10)
    assert rank == len(rest), "a motion is free"
    assert np.allclose(constraint[:, rest] @ found, right, rtol=0, atol=1e-11), "the bars' loops disagree"
    v = np.zeros((constraint.shape[1], *values.shape[1:]))
    v[given], v[rest] = values, found
    return v


def joint_inertia(at: Cut) -> np.ndarray:
    upper = np.triu(pin.crba(at.tree.model, at.data, at.q))
    mass = upper + np.triu(upper, 1).T
    return at.motions.T @ mass @ at.motions


def actuator_forces(at: Cut, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """What the actuators exert while the tool moves so, gravity included."""
    model, data, platform = at.tree.model, at.data, at.tree.platform
    v = _completed(at.constraint, platform, velocity)
    pin.forwardKinematics(model, data, at.q, v, np.zeros_like(v))
    drift = [pin.getFrameClassicalAcceleration(model, data, tip, WORLD).linear for tip in at.tree.tips]
    a = _completed(at.constraint, platform, acceleration, np.concatenate(drift))
    return at.motions.T @ pin.rnea(model, data, at.q, v, a)


def asked(case: str) -> dict[str, np.ndarray]:
    """Poses, and a random motion of the tool at each."""
    random = np.random.default_rng(100 + list(MACHINES).index(case))
    return {
        "poses": poses(case),
        "velocity": np.round(random.uniform(-SPEED, SPEED, (POSES, 3)), 3),
        "acceleration": np.round(random.uniform(-ACCELERATION, ACCELERATION, (POSES, 3)), 2),
    }


def answers(
    machine: Mapping[str, Any], tool: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> dict[str, np.ndarray]:
    at, still = cut(machine, tool), np.zeros(3)
    return {
        "jacobian": at.motions[at.tree.platform],
        "joint_inertia": joint_inertia(at)[UPPER],
        "rest_load": actuator_forces(at, still, still),
        "actuator_forces": actuator_forces(at, velocity, acceleration),
    }


if __name__ == "__main__":
    stored.run("dynamics", "pin", asked, answers, tolerance=1e-8)

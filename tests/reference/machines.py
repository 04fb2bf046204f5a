"""The machines that the reference programs are asked about, and their geometry.

Written from the machines' description alone: nothing of orthospec is imported. A chain has a slide along
``axis`` through ``base``; its leg joins the slider at A = base + rho axis to the platform at
B = tool + arm, and the first revolute joint of both universal joints (of the parallelogram: its short links)
lies along ``revolute``, fixed in the world. All in SI.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

POSES = 200

_STEEL = {"E": 2.1e11, "G": 8.1e10, "density": 7850.0}
_ALUMINIUM = {"E": 7.0e10, "nu": 0.33, "density": 2700.0}
_TUBE = {"A": 1.6e-4, "Iy": 9.0e-9, "Iz": 5.0e-9, "J": 1.1e-8}
_FOOT = {"length": 0.08, "section": {"rectangle": {"height": 0.03, "width": 0.02}}, "material": _STEEL}

_ORTHOGLIDE = {
    "use": "orthoglide",
    "leg_lengths": [0.31, 0.33, 0.36],
    "legs": {
        "kind": "PUU",
        "section": {"given": _TUBE},
        "material": _ALUMINIUM,
        "offset": 0.03,
        "mass": 0.35,
    },
    "feet": {**_FOOT, "mass": 0.4},
    "actuators": {"stiffness": 2e7, "mass": 1.7},
    "platform": {"mass": 0.8},
    "payload": {"mass": 0.5},
    "gravity": [1.5, -2.0, -9.5],
}
_DELTA = {
    "use": "linear_delta",
    "leg_lengths": [0.4, 0.4, 0.4],
    "base_radius": 0.25,
    "platform_radius": 0.06,
    "rail_tilt": 0.25,
    "legs": {"kind": "PUU", "section": {"given": _TUBE}, "material": _STEEL},
    "feet": _FOOT,
    "actuators": {"stiffness": 1.5e7, "mass": 1.2},
    "platform": {"mass": 0.6},
    "gravity": [0.0, 0.0, -9.81],
}

MACHINES: Mapping[str, dict[str, Any]] = {
    "orthoglide_puu": _ORTHOGLIDE,
    "orthoglide_prpar": {
        **_ORTHOGLIDE,
        "branch": [1, -1, 1],
        "legs": {**_ORTHOGLIDE["legs"], "kind": "PRPaR", "spacing": 0.08},
    },
    "linear_delta_puu": {**_DELTA, "leg_lengths": [0.4, 0.43, 0.38]},
    "linear_delta_prpar": {
        **_DELTA,
        "rail_tilt": -0.2,
        "legs": {**_DELTA["legs"], "kind": "PRPaR", "spacing": 0.07},
    },
}
"""Each as it stands in a spec's ``manipulator`` section."""

REGIONS = {
    "orthoglide_puu": ([-0.12, -0.12, -0.12], [0.07, 0.07, 0.07]),
    "orthoglide_prpar": ([-0.12, -0.07, -0.12], [0.07, 0.12, 0.07]),
    "linear_delta_puu": ([-0.08, -0.08, -0.25], [0.08, 0.08, -0.1]),
    "linear_delta_prpar": ([-0.08, -0.08, -0.25], [0.08, 0.08, -0.1]),
}


class Chain(NamedTuple):
    """One slide and its leg."""

    axis: np.ndarray
    base: np.ndarray
    arm: np.ndarray
    revolute: np.ndarray
    length: float
    branch: int


class Leg(NamedTuple):
    """A leg as it stands at one pose: its ends, and the axes of its frame."""

    slider_end: np.ndarray
    platform_end: np.ndarray
    rho: float
    along: np.ndarray
    """From the slider's end to the platform's."""
    normal: np.ndarray
    """Of the plane of the leg and the revolute axis: the parallelogram's plane."""


def chains(machine: Mapping[str, Any]) -> list[Chain]:
    return {"orthoglide": _orthoglide, "linear_delta": _linear_delta}[machine["use"]](machine)


def _orthoglide(machine: Mapping[str, Any]) -> list[Chain]:
    branches, offset = machine.get("branch", [1, 1, 1]), machine["legs"]["offset"]
    found = []
    for i in range(3):
        axis, end = np.eye(3)[i], branches[i] * offset * np.eye(3)[i]
        found.append(Chain(axis, end, end, np.eye(3)[i - 1], machine["leg_lengths"][i], branches[i]))
    return found


def _linear_delta(machine: Mapping[str, Any]) -> list[Chain]:
    tilt, found = machine["rail_tilt"], []
    for i in range(3):
        azimuth = np.deg2rad(120.0 * i)
        radial, up = np.array([np.cos(azimuth), np.sin(azimuth), 0.0]), np.array([0.0, 0.0, 1.0])
        axis = np.cos(tilt) * up + np.sin(tilt) * radial
        base, arm = machine["base_radius"] * radial, machine["platform_radius"] * radial
        found.append(Chain(axis, base, arm, np.cross(up, radial), machine["leg_lengths"][i], 1))
    return found


def leg(chain: Chain, tool: np.ndarray) -> Leg:
    """The leg with its slider on the side of ``branch``: a circle about B cut by the slide's line."""
    platform_end = tool + chain.arm
    foot_of_perpendicular = chain.axis @ (platform_end - chain.base)
    distance = np.linalg.norm(chain.base + foot_of_perpendicular * chain.axis - platform_end)
    rho = foot_of_perpendicular + chain.branch * np.sqrt(chain.length**2 - distance**2)
    slider_end = chain.base + rho * chain.axis
    along = (platform_end - slider_end) / chain.length
    normal = np.cross(along, chain.revolute)
    return Leg(slider_end, platform_end, float(rho), along, normal / np.linalg.norm(normal))


def poses(name: str) -> np.ndarray:
    """Random tool points, in whole hundredths of a millimetre so that they are short to write."""
    low, high = REGIONS[name]
    seed = sorted(MACHINES).index(name)
    return np.round(np.random.default_rng(seed).uniform(low, high, (POSES, 3)), 5)


def shear_modulus(material: Mapping[str, float]) -> float:
    return material["G"] if "G" in material else material["E"] / (2 * (1 + material["nu"]))

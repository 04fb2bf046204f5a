"""`Manipulator`: one design of one machine, as frozen numbers with batched mechanics.

A subclass declares its dimensions as pydantic fields (types from `orthospec.quantities`, SI) and computes for
whole blocks of poses. Built-in and foreign machines are registered alike, in the entry-point group
``orthospec.manipulators``.
"""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self, TypeVar, cast

from pydantic import ConfigDict, PrivateAttr

from orthospec.arrays import np
from orthospec.described import Described
from orthospec.errors import RAISED, OrthospecError, PluginFault
from orthospec.mechanics import inertia

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses
    from orthospec.intervals import Boxes, Interval


@dataclass(frozen=True)
class Skeleton:
    """The machine's lines at each pose: segments (n, s, 2, 3) [m], radii (s,) [m], names (s,)."""

    segments: Array
    radii: Array
    names: tuple[str, ...]


class ActuatorLimits(NamedTuple):
    """What each actuator can do, (m,) each; inf where no limit is given."""

    forces: Array
    """Greatest force or torque [N or N*m]."""
    speeds: Array
    """Greatest speed [m/s or rad/s]."""
    friction: Array
    """Coulomb friction, which takes its part of the force [N or N*m]."""


class _Memory(dict[str, tuple[object, Any]]):
    """Fields over the block in hand: no part of what a machine is, and not sent to other processes."""

    __hash__ = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Memory)

    def __reduce__(self) -> tuple[type[_Memory], tuple[()]]:
        return _Memory, ()


class Manipulator(Described, ABC):
    """One design: a frozen pydantic model of numbers whose fields are the spec's keys.

    Methods take poses (n, d) and must be computable, with NaN where they are not, a little outside the reach:
    difference quotients and trial steps go there.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    axes: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    """The columns of a pose, of x y z rx ry rz; the cuboid spans the first ``len(size)``."""
    joint_units: ClassVar[tuple[str, ...]] = ("m", "m", "m")
    index_units: ClassVar[Mapping[str, str]] = {}
    """Names and units of the indices, known before a machine is built."""
    toleranced: ClassVar[Mapping[str, str]] = {}
    """Fields that may be off by a tolerance, with their units: `varied` machines have arrays in them."""

    _memory: _Memory = PrivateAttr(default_factory=_Memory)

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Let each field over the poses remember the block in hand, and name the machine that fails.

        Several measures then cost one field.
        """
        super().__init_subclass__(**kwargs)
        for name in (*_FIELDS, "reach", "reach_enclosure", "indices", "skeleton"):
            if name in cls.__dict__:
                method = _faulting(name, cls.__dict__[name])
                setattr(cls, name, remembering(method) if name in _FIELDS else method)

    def varied(self, fields: Mapping[str, Any]) -> Self:
        """This machine with other values in some `toleranced` fields, which no validator sees.

        In the place of each number of such a field there may be an array (n,), or an interval, with a value
        of its own for each pose of the block that the machine is then asked about. Reach and fields serve
        these; indices and skeleton need not.
        """
        own = {name: getattr(self, name) for name in type(self).model_fields}
        return cast("Self", self.model_construct(**{**own, **fields}))

    def __copy__(self) -> Self:
        """What `model_copy` changes: the fields alone, for what was computed from them is not the copy's."""
        return self.varied({})

    def __deepcopy__(self, memo: dict[int, Any] | None = None) -> Self:
        """The same with fields of its own."""
        fields = {name: deepcopy(getattr(self, name), memo) for name in type(self).model_fields}
        return cast("Self", self.model_construct(**fields))

    @abstractmethod
    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """Joint coordinates (n, m) and whether each pose is reachable (n,)."""

    @abstractmethod
    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """Each condition of *reachable* as a smooth signed margin (n,), >= 0 inside.

        A key may end in ``.at_least`` or ``.at_most``, the side of the limit that it stands for. A margin
        relative to its limit (or to a length of the machine) makes one per cent of it mean something.
        """

    def reach_enclosure(self, boxes: Boxes) -> Mapping[str, Interval]:
        """Bounds on each margin of the reach at all poses of each box (n,).

        Unless a machine has better ones, these are its own margins, computed with intervals for numbers.
        Raises NoEnclosure where its code cannot be carried over intervals.
        """
        from orthospec.intervals import as_interval

        margins = self.reach(boxes.poses)  # type: ignore[arg-type]
        return {name: as_interval(margin) for name, margin in margins.items()}

    @abstractmethod
    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """J⁻¹ = ∂ρ/∂p, (n, m, m): joint rates for a unit rate of each pose coordinate."""

    def compliance(self, poses: Poses) -> Array:
        """C (n, 6, 6) at the tool [m/N, rad/N, rad/(N*m)], in the order x y z rx ry rz; optional.

        All entries are inf where the machine is loose, that is where its stiffness is singular.
        """
        raise NotImplementedError(f"{type(self).__name__} offers no compliance")

    def joint_inertia(self, poses: Poses) -> Matrices:
        """D (n, m, m), the inertia in joint space [kg, kg*m^2]; optional."""
        raise NotImplementedError(f"{type(self).__name__} offers no joint inertia")

    def rest_load(self, poses: Poses) -> Joints:
        """The actuator forces (n, m) that hold the machine still [N, N*m]: none without gravity."""
        return np.zeros((len(poses), len(self.joint_units)))

    def velocity_forces(self, poses: Poses) -> Array:
        """Q (n, m, d, d), symmetric: actuator i exerts ṗᵀ Q_i ṗ at a constant tool velocity ṗ.

        From differences of the inertia at the tool, to about 1e-9, where a machine gives no formula.
        """
        return inertia.velocity_forces(self, poses)

    def actuator_limits(self) -> ActuatorLimits:
        """What the actuators can do; no limits where a machine gives none."""
        m = len(self.joint_units)
        return ActuatorLimits(np.full(m, np.inf), np.full(m, np.inf), np.zeros(m))

    def missing(self, what: str) -> tuple[str, ...]:  # noqa: ARG002
        """The fields to give before ``what`` can be had; () when it can.

        ``what`` is "compliance", "joint_inertia", "actuator_forces", "actuator_speeds" or an index's name.
        """
        return ()

    @abstractmethod
    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """The global indices; joint_ranges (m, 2): least and greatest joint value over the cuboid."""

    @abstractmethod
    def skeleton(self, poses: Poses) -> Skeleton:
        """Segments to draw the machine at each pose."""


_FIELDS: Mapping[str, tuple[str, ...]] = {
    "inverse_kinematics": ("n", "m"),
    "inverse_jacobian": ("n", "m", "m"),
    "compliance": ("n", "6", "6"),
    "joint_inertia": ("n", "m", "m"),
    "rest_load": ("n", "m"),
    "velocity_forces": ("n", "m", "d", "d"),
}
"""The methods that compute a field over poses, with the shapes that they owe."""


def _faulting(name: str, method: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """The method, its exceptions and what it owes but does not give told as the plugin's fault."""

    @functools.wraps(method)
    def faulting(self: Any, argument: Any) -> Any:
        # What a class gives to another one that is made of it need not be all that this one owes.
        is_own = getattr(type(self), name) is faulting
        try:
            value = method(self, argument)
            lacks = _OWED[name](self, argument, value) if name in _OWED and is_own else ""
        except OrthospecError:
            raise
        except RAISED as error:
            raise PluginFault(
                type(self).__name__, f"{name} raised {type(error).__name__}: {error}"
            ) from error
        if lacks:
            raise PluginFault(type(self).__name__, f"{name} {lacks}")
        if name in _FIELDS:
            _check_shape(self, name, value, len(argument))
        return value

    return faulting


def _of_indices(machine: Any, _: Array, given: Any) -> str:
    """What is wrong with the indices that a machine gives; "" where nothing is."""
    if not isinstance(given, Mapping):
        return f"gave {type(given).__name__}, not a mapping of names to numbers"
    for name, value in given.items():
        if name not in machine.index_units:
            return f"gave '{name}', of which index_units knows no unit"
        if isinstance(value, bool) or not isinstance(value, Real):
            return f"gave {value!r} for '{name}', not a number"
    for name in machine.index_units:
        if name not in given and not machine.missing(name):
            return f"gave no '{name}', which index_units names"
    return ""


def _of_skeleton(_: Any, poses: Poses, given: Any) -> str:
    """What is wrong with a skeleton at these poses."""
    if not isinstance(given, Skeleton):
        return f"gave {type(given).__name__}, not a Skeleton"
    s, segments, radii = len(given.names), np.shape(given.segments), np.shape(given.radii)
    if segments == (len(poses), s, 2, 3) and radii == (s,):
        return ""
    return (
        f"gave segments {segments}, radii {radii} and {s} names for {len(poses)} poses,"
        " not (n, s, 2, 3), (s,) and s"
    )


def _of_reach_enclosure(machine: Any, boxes: Boxes, given: Any) -> str:
    """What is wrong with an enclosure of the reach: a margin that is left out would hold everywhere."""
    if not isinstance(given, Mapping):
        return f"gave {type(given).__name__}, not a mapping of margins to intervals"
    margins = machine.reach(boxes.lo[:1])
    for name in sorted(set(margins) ^ set(given)):
        return (
            f"gave no '{name}', which reach has" if name in margins else f"gave '{name}', which reach has not"
        )
    return ""


def _of_reach(_: Any, poses: Any, given: Any) -> str:
    """What is wrong with margins at these poses."""
    if not isinstance(given, Mapping) or not given:
        return f"gave {type(given).__name__}, not a mapping of names to margins (n,)"
    for name, margin in given.items():
        if hasattr(margin, "lo"):
            continue  # An interval's: over boxes, or of machines within tolerances.
        shape, kind = np.shape(margin), np.asarray(margin).dtype
        if not isinstance(margin, np.ndarray) or shape != (len(poses),) or kind.kind != "f":
            return f"gave shape {shape} of {kind} for '{name}', not floats ({len(poses)},)"
    return ""


_OWED: Mapping[str, Callable[[Any, Any, Any], str]] = {
    "reach": _of_reach,
    "indices": _of_indices,
    "skeleton": _of_skeleton,
    "reach_enclosure": _of_reach_enclosure,
}
"""What is wrong with what a method of a machine gives for its argument, in words; "" where nothing is."""


def _check_shape(machine: Any, name: str, value: Any, n: int) -> None:
    sizes = {"n": n, "m": len(machine.joint_units), "d": len(machine.axes), "6": 6}
    owed = tuple(sizes[axis] for axis in _FIELDS[name])
    array = value[0] if name == "inverse_kinematics" and isinstance(value, tuple) else value
    shape = getattr(array, "shape", None)
    if shape != owed:
        what = f"{name} gave shape {shape}" if shape is not None else f"{name} gave {type(array).__name__}"
        raise PluginFault(type(machine).__name__, f"{what}, not {owed}")
    if name == "inverse_kinematics" and not _has_flags(value, n):
        raise PluginFault(type(machine).__name__, f"{name} gave no flags beside the joints: bools ({n},)")


def _has_flags(value: Any, n: int) -> bool:
    """Whether it is told of each pose if it is reachable; nobody asks where the joints are intervals."""
    joints, flags = value if isinstance(value, tuple) and len(value) == 2 else (value, None)
    if hasattr(joints, "lo"):
        return True
    return isinstance(flags, np.ndarray) and flags.shape == (n,) and flags.dtype == bool


Computed = TypeVar("Computed")


def remembering(method: Callable[[Any, Poses], Computed]) -> Callable[[Any, Poses], Computed]:
    """The method, its last value kept for as long as the same read-only block is asked about.

    The next one who asks is given the same arrays, so that they are read-only too.
    """
    name = method.__name__

    @functools.wraps(method)
    def remembered(self: Any, poses: Poses) -> Computed:
        held = self._memory.get(name)
        if held is not None and held[0] is poses:
            return cast("Computed", held[1])
        value = method(self, poses)
        # An interval's numbers are its ends.
        if not getattr(poses, "lo", poses).flags.writeable:
            value = _read_only(value)
            self._memory[name] = (poses, value)
        return value

    return remembered


def _read_only(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, Mapping):
        return MappingProxyType({key: _read_only(part) for key, part in value.items()})
    elif isinstance(value, tuple):
        for part in value:
            _read_only(part)
    elif hasattr(value, "make_read_only"):  # Intervals.
        value.make_read_only()
    return value

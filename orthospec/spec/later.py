"""What format 1 has a place for and this version does not serve yet."""

from __future__ import annotations

from orthospec import registry
from orthospec.spec.draft import Draft

NOT_YET = "not available in this version"

_PLUGINS = {
    registry.MANIPULATORS: frozenset({"linear_delta"}),
    registry.MEASURES: frozenset(
        {
            "deflection",
            "rotation",
            "stiffness",
            "rotational_stiffness",
            "gie_norm",
            "dynamic_isotropy",
            "acceleration",
            "joint_speed",
            "actuator_force",
        }
    ),
}
_MACHINE_KEYS = frozenset({"legs", "feet", "actuators", "platform", "payload", "gravity"})


def is_for_later(group: str, name: str) -> bool:
    """Whether a plugin's name is kept for a built-in to come, and no one provides it now."""
    return name in _PLUGINS[group] and name not in registry.names(group)


def is_key_for_later(name: object) -> bool:
    """Whether a machine's key is kept for what comes."""
    return name in _MACHINE_KEYS


def check(draft: Draft) -> None:
    """A mistake for each part of the spec that is well formed and not served."""
    keys = draft.keys
    given = {
        ("manipulator", "tolerance"): keys.manipulator.tolerance,
        ("workspace", "orientation"): keys.workspace.orientation,
        ("pareto",): keys.pareto,
        ("proof",): keys.proof or None,
    }
    given |= {("variables", name, "choices"): one.choices for name, one in keys.variables.items()}
    for path, value in given.items():
        if value is not None:
            draft.wrong(path, f"'{path[-1]}' is {NOT_YET}", at_key=True)

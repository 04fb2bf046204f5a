"""Design optimisation of parallel manipulators from a spec file.

>>> spec = load_spec(Path("specs/orthoglide-200.yaml"))
>>> study = run(spec)
>>> study.variables
{'leg': 0.31058...}
>>> study.save("runs/orthoglide-200")

The names below are loaded when first used, so that importing this package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orthospec.errors import OrthospecError, PluginFault, SpecError, UnbuildableDesign, UsageError
    from orthospec.manipulators import Manipulator, Skeleton
    from orthospec.measures import ConvexForm, Measure
    from orthospec.optimise import Outcome, evaluate_spec, solve
    from orthospec.result import Finding, compose, read_result, write_result
    from orthospec.spec import Design, Spec, load_spec
    from orthospec.study import Study, evaluate, open_study, run

_HOMES = {
    "errors": ("OrthospecError", "PluginFault", "SpecError", "UnbuildableDesign", "UsageError"),
    "manipulators": ("Manipulator", "Skeleton"),
    "measures": ("ConvexForm", "Measure"),
    "spec": ("Design", "Spec", "load_spec"),
    "result": ("Finding", "compose", "read_result", "write_result"),
    "optimise": ("Outcome", "evaluate_spec", "solve"),
    "study": ("Study", "evaluate", "open_study", "run"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "ConvexForm",
    "Design",
    "Finding",
    "Manipulator",
    "Measure",
    "OrthospecError",
    "Outcome",
    "PluginFault",
    "Skeleton",
    "Spec",
    "SpecError",
    "Study",
    "UnbuildableDesign",
    "UsageError",
    "compose",
    "evaluate",
    "evaluate_spec",
    "load_spec",
    "open_study",
    "read_result",
    "run",
    "solve",
    "write_result",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("orthospec")
    if name in _HOME_OF:
        return getattr(import_module(f"orthospec.{_HOME_OF[name]}"), name)
    raise AttributeError(f"module 'orthospec' has no attribute '{name}'")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

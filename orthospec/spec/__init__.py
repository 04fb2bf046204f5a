"""The spec file: strict YAML, checked as a whole, resolved to SI, and built into designs."""

from orthospec.spec.design import Design, Goal, Region, Sweep, Variable, Workspace
from orthospec.spec.load import load_spec
from orthospec.spec.model import ProofKeys
from orthospec.spec.schema import schema
from orthospec.spec.spec import Spec

__all__ = [
    "Design",
    "Goal",
    "ProofKeys",
    "Region",
    "Spec",
    "Sweep",
    "Variable",
    "Workspace",
    "load_spec",
    "schema",
]

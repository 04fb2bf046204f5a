"""From a spec to the design that attains its goals: problem, starts, solve, what limits it."""

from orthospec.optimise.cache import remembering
from orthospec.optimise.run import Outcome, evaluate_spec, fields_of, solve, with_proof
from orthospec.optimise.workers import Workers, hired

__all__ = [
    "Outcome",
    "Workers",
    "evaluate_spec",
    "fields_of",
    "hired",
    "remembering",
    "solve",
    "with_proof",
]

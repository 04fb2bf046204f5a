"""From a spec to the design that attains its goals: problem, starts, solve, what limits it."""

from orthospec.optimise.run import Outcome, evaluate_spec, fields_of, solve

__all__ = ["Outcome", "evaluate_spec", "fields_of", "solve"]

"""A result with all that can be looked at in it: its machine, its measures as fields, its surfaces."""

from orthospec.solution.lattice import Lattice, sampled, sliced
from orthospec.solution.solution import Solution, read_solution, solution_of
from orthospec.solution.surfaces import Surface, level_surface, workspace_surface

__all__ = [
    "Lattice",
    "Solution",
    "Surface",
    "level_surface",
    "read_solution",
    "sampled",
    "sliced",
    "solution_of",
    "workspace_surface",
]

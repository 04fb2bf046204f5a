"""What is asked of a machine: the abstract `Measure` with its convex form, and the built-in measures."""

from orthospec.measures.base import ConvexForm, Measure, logarithm
from orthospec.measures.demand import Demand, Level

__all__ = ["ConvexForm", "Demand", "Level", "Measure", "logarithm"]

"""Convex-composite optimisation, knowing nothing of machines: templates, subproblems, the trust region."""

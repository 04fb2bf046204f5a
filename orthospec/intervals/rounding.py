"""The rounding errors that are allowed for, in one place.

u = 2⁻⁵³ is the unit roundoff of doubles: one operation is off by u relative to its result, and by `TINIEST`
where that is subnormal.
"""

ULP = 2.0**-52
"""2 u, at least one unit in the last place, relative."""
TINIEST = 5e-324
"""The least positive double."""
TINY = 1e-300
"""More than all that underflows in one operation on arrays."""
LIBRARY = 8.0
"""Error allowed for sin, cos, exp, log, arctan and pow [ulp]; libm and NumPy's own are below 4."""
SPARE = 1.0 + 2.0**-45
"""Factor over a handful of sums and products of terms that are all >= 0: some 120 u."""
FEW = 2.0**-48
"""Error of a handful of operations, relative to the sum of the sizes of their terms: 32 u."""

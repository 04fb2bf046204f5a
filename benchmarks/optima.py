"""The known optima of ``problems.py``: closed forms, or roots of the optimality conditions in 50 digits.

On the diagonal p = (q, q, q) of an Orthoglide with legs L, t = sqrt(L² − 2q²) and u = q/t, the singular
values of J⁻¹ are |1 − 2u| once and |1 + u| twice, those of the matrix of unit legs t/L times as much. A cube
of edge a reaches from q = −L r(v) to q = L r(u), r(u) = u / sqrt(1 + 2u²); where two corners bind, both bind
alike. That these corners are the worst poses is what the solver's search over the whole cuboid confirms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath as mp
from mpmath import mpf, sqrt

mp.mp.dps = 50

Number = Any
STEEL = mpf("210e9")


def r(u: Number) -> Number:
    """The place of a corner on the diagonal, in leg lengths."""
    return u / sqrt(1 + 2 * u * u)


def slope(q: Number) -> Number:
    """U of a place q on the diagonal, in leg lengths: the inverse of r."""
    return q / sqrt(1 - 2 * q * q)


def balanced(upper: Callable[[Number], Number], lower: Callable[[Number], Number], edge: Number) -> Number:
    """U of the upper corner of a cube (edge in leg lengths) where upper(u) = lower(v)."""
    return mp.findroot(lambda u: upper(u) - lower(slope(edge - r(u))), slope(edge * mpf("0.37")))


def shortest_legs(edge: Number) -> Number:
    """Factors within [1/2, 2]: u = 1/4 above and v = 1/2 below, hence L = a / (1/√6 + 1/√18)."""
    return edge / (1 / sqrt(6) + 1 / sqrt(18))


def best_condition(edge: Number, leg: Number) -> Number:
    """(1 + u)/(1 − 2u) = k above and (1 + 2v)/(1 − v) = k below."""
    return mp.findroot(lambda k: r((k - 1) / (2 * k + 1)) + r((k - 1) / (k + 2)) - edge / leg, 3)


def stroke_and_legs(edge: Number, leg_goal: Number, stroke_goal: Number) -> Number:
    """λ where L / l₀ = (a + L − sqrt(L² − a²/2)) / s₀, the cube around the origin."""
    leg = mp.findroot(
        lambda x: x / leg_goal - (edge + x - sqrt(x * x - edge**2 / 2)) / stroke_goal, edge * mpf("1.7")
    )
    return leg / leg_goal - 1


def quickest_slide(edge: Number, leg: Number) -> Number:
    """‖j_i‖ = (1 − (y² + z²)/L²)^(-1/2), greatest in the corners of the centred cube: y² + z² = a²/2."""
    return 1 / sqrt(1 - edge**2 / (2 * leg**2))


def legs_for_slides(edge: Number, most: Number) -> Number:
    """The same solved for L."""
    return edge / sqrt(2 * (1 - 1 / most**2))


def drives_and_legs(edge: Number, tool: Number, speed_goal: Number, leg_goal: Number) -> Number:
    """λ where the drives' speed tool·‖j‖ over its goal equals L over its own."""
    leg = mp.findroot(
        lambda x: tool * quickest_slide(edge, x) / speed_goal - x / leg_goal,
        (edge * 1, edge * 4),
        solver="anderson",
    )
    return leg / leg_goal - 1


def delta_legs(edge: Number, radius: Number, most: Number) -> Number:
    """Vertical slides at distance d = R − r, ‖j_i‖ = (1 − h²/L²)^(-1/2) with h the horizontal distance.

    The square of half edge e moves to x = −(√3 − 1) e d / (3d + 4e), where the farthest corners from slide 1
    and from slides 2 and 3 are alike far: h² = (d + e − x)² + e².
    """
    e, d = edge / 2, radius
    x = -(sqrt(3) - 1) * e * d / (3 * d + 4 * e)
    return sqrt((d + e - x) ** 2 + e**2) / sqrt(1 - 1 / most**2)


def least_pull(edge: Number, leg: Number) -> Number:
    """The least singular value of the unit legs over the cube, where (1 − 2u) r'(u) = (1 − v) r'(v)."""
    above = balanced(
        lambda u: (1 - 2 * u) / sqrt(1 + 2 * u * u), lambda v: (1 - v) / sqrt(1 + 2 * v * v), edge / leg
    )
    return (1 - 2 * above) / sqrt(1 + 2 * above**2)


def round_leg(edge: Number, leg: Number, stiffness: Number) -> Number:
    """Universal joints pass the force along a leg only: E A/L times the least pull squared."""
    return sqrt(4 * stiffness * leg / (mp.pi * STEEL)) / least_pull(edge, leg)


def product_of_many(costs: Sequence[Number], product: Number) -> Number:
    """The least Σ c_i x_i with Π x_i given: every c_i x_i is their geometric mean."""
    n = len(costs)
    return n * (product * mp.fprod(costs)) ** (mpf(1) / n)


def lightest_legs(edge: Number, stiffness: Number) -> Number:
    """L d² of round legs, whose length is free as well: stationary in L."""

    def volume(leg: Number) -> Number:
        return leg * round_leg(edge, leg, stiffness) ** 2

    return volume(mp.findroot(lambda leg: mp.diff(volume, leg), edge * mpf("1.85")))


def tube_wall(edge: Number, leg: Number, drive: Number, stiffness: Number, diameter: Number) -> Number:
    """Legs and drives in series: their compliance L/EA + c t²/L² over the pull squared is 1/k twice."""

    def area(u: Number, pull: Number) -> Number:
        around = 1 / (1 + 2 * u * u)
        return leg / STEEL / (pull**2 * around / stiffness - around / drive)

    u = balanced(lambda u: area(u, 1 - 2 * u), lambda v: area(v, 1 - v), edge / leg)
    return (diameter - sqrt(diameter**2 - 4 * area(u, 1 - 2 * u) / mp.pi)) / 2


def square_foot(edge: Number, leg: Number, foot: Number, stiffness: Number) -> Number:
    """Area h² of feet under rigid legs: stretch l/EA t²/L², bending 2 l³/3EI q²/L², A = h², I = h⁴/12.

    Of one area, 1/I_y + 1/I_z is least in a square.
    """

    def side(u: Number, pull: Number) -> Number:
        # pull² / (l/E h² + 8 l³ u²/E h⁴) = k is a quadratic in h²; t/L cancels.
        c, b, a = -8 * foot**3 * u * u, -foot, STEEL * pull**2 / stiffness
        return (-b + sqrt(b * b - 4 * a * c)) / (2 * a)

    u = balanced(lambda u: side(u, 1 - 2 * u), lambda v: side(v, 1 - v), edge / leg)
    return side(u, 1 - 2 * u)


def heaviest_slider(edge: Number, leg: Number, platform: Number, most: Number) -> Number:
    """G = m_p I + m_s J⁻ᵀJ⁻¹: m_p + m_s (1 + u)² above equals m_p + m_s (1 + 2v)² below."""
    u = balanced(lambda u: 1 + u, lambda v: 1 + 2 * v, edge / leg)
    return (most - platform) / (1 + u) ** 2


def slider_for_isotropy(edge: Number, leg: Number, platform: Number, most: Number) -> Number:
    """(m_p + m_s (1 + u)²)/(m_p + m_s (1 − 2u)²) = k above, with 1 + 2v and 1 − v below."""

    def mass(high: Number, low: Number) -> Number:
        return platform * (most - 1) / (high**2 - most * low**2)

    u = balanced(lambda u: mass(1 + u, 1 - 2 * u), lambda v: mass(1 + 2 * v, 1 - v), edge / leg)
    return mass(1 + u, 1 - 2 * u)


def thrust_of_platform(edge: Number, leg: Number, force: Number) -> Number:
    """A platform alone: force m_p a times the length of a column of J, the same above and below.

    With w = u/(1 − 2u) it is sqrt((1 + w)² + 2w²)/(1 + u).
    """

    def column(u: Number) -> Number:
        w = u / (1 - 2 * u)
        return sqrt((1 + w) ** 2 + 2 * w * w) / (1 + u)

    return force * column(balanced(column, lambda v: column(-v), edge / leg))


def thrust_of_itself(
    edge: Number, leg: Number, acceleration: Number, mass: Number, density: Number
) -> Number:
    """Sliders of m₀ + F/c alone: F = (m₀ + F/c) a ‖j‖."""
    pull = acceleration * quickest_slide(edge, leg)
    return pull * mass / (1 - pull / density)


def legs_and_drives(
    edge: Number, leg: Number, stiffness: Number, pull: Number, goals: tuple[Number, Number]
) -> Number:
    """λ of the diameter d and the thrust F = pull·‖j‖, which want the cube elsewhere: d(u)/d₀ = F(v)/F₀.

    The stiffness binds above and wants it low; the slides are quickest in the lower corners.
    """

    def diameter(q: Number) -> Number:
        u = slope(q)
        return sqrt(4 * stiffness * leg / (mp.pi * STEEL) * (1 + 2 * u * u)) / (1 - 2 * u)

    def thrust(q: Number) -> Number:
        return pull / sqrt(1 - 2 * (edge / leg - q) ** 2)

    q = mp.findroot(lambda q: diameter(q) / goals[0] - thrust(q) / goals[1], edge / leg * mpf("0.4"))
    return diameter(q) / goals[0] - 1


def plane(base: Number, third: Number, q: Number, z: Number) -> tuple[Number, Number, Number]:
    """Squared singular values of J⁻¹ at (q, q, z) on legs (base, base, third), that of (1, −1, 0) last.

    J⁻¹ maps the plane of (1, 1, 0) and z into itself: a 2 × 2 matrix gives the first two, the least first.
    """
    t, s = sqrt(base**2 - q * q - z * z), sqrt(third**2 - 2 * q * q)
    m = mp.matrix([[1 - q / t, -sqrt(2) * z / t], [-sqrt(2) * q / s, 1]])
    whole, product = sum(x * x for x in m), mp.det(m) ** 2
    root = sqrt(whole**2 - 4 * product)
    return (whole - root) / 2, (whole + root) / 2, (1 + q / t) ** 2


def flat_goals(weights: tuple[Number, Number], goal: Number) -> Number:
    """λ for 1 x 1 x 0.8 with factors in [1/2, 2]: a vertex, where three bounds hold in λ, q and z.

    σ_max = 2 in the upper corner (q, q, z); σ_min = 1/2 and, across the plane, σ_max = 2 in the lower one.
    """

    def conditions(factor: Number, q: Number, z: Number) -> list[Number]:
        legs = [goal + weight * factor for weight in weights]
        below = plane(*legs, q - 1, z - mpf("0.8"))
        return [plane(*legs, q, z)[0] - mpf("0.25"), below[1] - 4, below[2] - mpf("0.25")]

    start = {True: ("0.15", "0.41", "0.21"), False: ("0.55", "0.48", "0.11")}[weights[0] == weights[1]]
    return mp.findroot(conditions, [mpf(x) for x in start])[0]


def flat_sum(on_base: Number) -> Number:
    """Least on_base·base + third for the same: three bounds hold, and four gradients depend on each other.

    σ_max = 2 in the upper corner, both factors in the plane of the lower one.
    """

    def conditions(*at: Number) -> list[Number]:
        def bounds(base: Number, third: Number, q: Number, z: Number) -> list[Number]:
            above, below = plane(base, third, q, z), plane(base, third, q - 1, z - mpf("0.8"))
            return [above[0] - mpf("0.25"), below[0] - mpf("0.25"), below[1] - 4]

        ways = [tuple(int(i == j) for j in range(4)) for i in range(4)]
        slopes = [[mp.diff(lambda *p, k=k: bounds(*p)[k], at, way) for way in ways] for k in range(3)]
        return [*bounds(*at), mp.det(mp.matrix([[on_base, 1, 0, 0], *slopes]))]

    base, third, *_ = mp.findroot(conditions, [mpf(x) for x in ("1.46", "1.43", "0.4", "0.22")])
    return on_base * base + third


def pole_placement() -> Number:
    """λ of fgoalattain's example: K = (−4, k, −4, −4), its first two real poles alike far from −5 and −3."""

    def poles(k: Number) -> list[Number]:
        a, b = mp.matrix([["-0.5", 0, 0], [0, -2, 10], [0, 1, -2]]), mp.matrix([[1, 0], [-2, 2], [0, 1]])
        gain, c = mp.matrix([[-4, k], [-4, -4]]), mp.matrix([[1, 0, 0], [0, 0, 1]])
        return sorted(mp.re(pole) for pole in mp.eig(a + b * gain * c, left=False, right=False))

    k = mp.findroot(lambda k: poles(k)[0] / 5 - poles(k)[1] / 3, mpf("-0.25"))
    return poles(k)[0] / 5 + 1

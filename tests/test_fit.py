"""The fitting problem: what the optimiser differentiates equals fifty digits; points, slots and faults."""

from __future__ import annotations

from typing import ClassVar

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from orthospec.composite.differences import jacobian
from orthospec.composite.trust_region import Ending, minimise
from orthospec.errors import PluginFault, UnbuildableDesign
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import ConvexForm, Demand, Measure
from orthospec.measures.kinematic import VelocityTransmission
from orthospec.mechanics.prismatic import CLEARANCE
from orthospec.optimise.objective import GoalObjective
from orthospec.optimise.space import DesignSpace
from orthospec.workspace import objective
from orthospec.workspace.conditions import Condition, Extreme, Sample
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.fit import FitProblem, Group, Machine
from orthospec.workspace.layout import Limits, Point
from orthospec.workspace.polish import LargestScale

SPEC = """\
orthospec: 1
variables:
  base: {min: 1.0, max: 3.0}
  third: {min: 1.5, max: 2.5}
manipulator:
  use: orthoglide
  leg_lengths: [base, base, third]
  joint_limits: {min: base / 5, max: 1.2 * base + third / 2}
workspace: {size: [1, 1, 0.8], region: {min: [-2, -2, -2], max: [2, 2, 2]}}
measures:
  transmission: {use: velocity_transmission, at_least: 1 / (1 + base), at_most: 1 + third}
  condition: {use: condition_number, at_most: 3 * base}
  volume: {use: manipulability, at_least: 0.2}
goals:
  trade: {minimise: base * third + scale**2, goal: 2}
  travel: {minimise: stroke, goal: 1}
  ground: {minimise: sqrt(footprint), goal: 1}
  isotropy: {minimise: worst(condition), goal: 2}
  speed: {maximise: lowest(transmission), goal: 1}
  unruly: {maximise: highest(transmission), goal: 3, weight: 2}
  legs: {match: leg_length_total, goal: 5, weight: 1}
"""
BOXES = {"base": (1, 3), "third": (mpf("1.5"), mpf("2.5"))}
SIZE = (mpf(1), mpf(1), mpf("0.8"))


class Exact:
    """The rows of `FitProblem.smooth` for SPEC, in 50 digits, from their definitions."""

    def __init__(self, problem, rows, exact):
        self.problem, self.selection, self.exact = problem, rows.selection, exact
        self.known = {}

    def __call__(self, x):
        """All rows at x, a list of 50-digit numbers."""
        self.base, self.third = (
            low + z * (high - low) for z, (low, high) in zip(x[:2], BOXES.values(), strict=True)
        )
        self.lengths = (self.base, self.base, self.third)
        start = [mpf(float(c)) for c in self.problem.layout.start[0]]
        self.centre = [c + dx * s for c, dx, s in zip(start, x[2:5], SIZE, strict=True)]
        self.scale = x[5]
        self.values = self.extremes(x[6:])
        numbers = [row for part in self.selection.numbers for row in self.number(part)]
        forms = [row for part in self.selection.forms for row in self.form(part)]
        return [*numbers, *self.placement(), *self.goals(), *forms]

    def extremes(self, given):
        layout, found = self.problem.layout, {}
        for e, first, ratio, z in zip(layout.extremes, layout.reference, layout.is_ratio, given, strict=True):
            first = mpf(float(first))
            found[e] = first * mpmath.exp(z) if ratio else first + z * max(SIZE)
        return found

    def pose(self, slot):
        u = [mpf(float(c)) for c in self.selection.slots[0][slot]]
        return tuple(c + self.scale * s * t for c, s, t in zip(self.centre, SIZE, u, strict=True))

    def inverse_jacobian(self, pose):
        key = (self.lengths, pose)
        if key not in self.known:
            inverse = self.exact.inverse_jacobian(self.lengths, pose)
            self.known[key] = inverse, self.exact.stretch(inverse)
        return self.known[key]

    def number(self, part):
        for slot in part.at:
            pose = self.pose(int(slot))
            if isinstance(part.term, Condition):
                yield -self.margin(part.term, pose)
                continue
            sign = 1 if part.term.kind == "highest" else -1
            if isinstance(part.term.of, int):
                value, unit = self.exact.sliders(self.lengths, pose)[part.term.of], max(SIZE)
            else:
                value = mpmath.exp(mpmath.eigsy(self.inverse_jacobian(pose)[1], eigvals_only=True)[2])
                unit = mpf(
                    float(self.problem.layout.reference[self.problem.layout.extremes.index(part.term)])
                )
            yield int(part.sign) * sign * (value - self.values[part.term]) / unit

    def margin(self, condition, pose):
        rho = self.exact.sliders(self.lengths, pose)
        name, _, joint = condition.name.partition(".")
        if name == "joint_limits":
            least, most = self.base / 5, mpf("1.2") * self.base + self.third / 2
            return 1 - rho[int(joint)] / most if condition.side == "at_most" else rho[int(joint)] / least - 1
        legs = mpmath.matrix(3, 3)
        for i in range(3):
            for k in range(3):
                legs[i, k] = ((rho[i] if i == k else 0) - pose[k]) / self.lengths[i]
        if name == "singularity":
            return mpmath.det(legs)
        if name == "assembly":
            pairs = ((0, 1), (0, 2), (1, 2))
            return sum(legs[i, i] * legs[j, j] - legs[i, j] * legs[j, i] for i, j in pairs)
        i = int(name.removeprefix("leg_")) - 1
        return legs[i, i] ** 2 - mpf(CLEARANCE) ** 2

    def placement(self):
        halves = [self.scale * s / 2 for s in SIZE]
        yield from ((-2 - c + h) / s for c, h, s in zip(self.centre, halves, SIZE, strict=True))
        yield from ((c + h - 2) / s for c, h, s in zip(self.centre, halves, SIZE, strict=True))

    def goals(self):
        of = {(e.kind, e.of): value for e, value in self.values.items()}
        ranges = [(of["lowest", i], of["highest", i]) for i in range(3)]
        yield self.base * self.third + self.scale**2 - 2
        yield self.travel(ranges) - 1
        yield self.ground(ranges) - 1
        yield of["highest", "condition"] - 2
        yield 1 - of["lowest", "transmission"]
        yield 3 - of["highest", "transmission"]
        yield 2 * self.base + self.third - 5
        yield 5 - 2 * self.base - self.third
        # Rows in which one joint leads: the others' ranges are one per cent shorter.
        led = [[self.shorter(r) if k != leader else r for k, r in enumerate(ranges)] for leader in range(3)]
        yield from (min(self.travel(r), self.travel(ranges)) - 1 for r in led)
        yield from (min(self.ground(r), self.ground(ranges)) - 1 for r in led)

    def travel(self, ranges):
        return max(high - low for low, high in ranges)

    def ground(self, ranges):
        sides = [max(high, 0) - min(low, 0) for low, high in ranges[:2]]
        return mpmath.sqrt(sides[0] * sides[1])

    def shorter(self, ends):
        cut = (ends[1] - ends[0]) / 200
        return ends[0] + cut, ends[1] - cut

    def form(self, part):
        bounds = {
            ("transmission", "at_least"): 1 / (1 + self.base),
            ("transmission", "at_most"): 1 + self.third,
            ("condition", "at_most"): 3 * self.base,
            ("volume", "at_least"): mpf("0.2"),
        }
        for slot in part.at:
            yield from self.inverse_jacobian(self.pose(int(slot)))[1]
            bound = (
                bounds[part.term.name, part.term.side]
                if isinstance(part.term, Condition)
                else self.values[part.term]
            )
            yield from (bound, mpmath.log(bound))


@pytest.fixture(scope="module")
def space(spec_of):
    return DesignSpace(spec_of(SPEC))


def problem_of(space, z):
    """The problem at a design with its cuboid around the origin at half size, and a few points off it."""
    goals = GoalObjective(space, z)
    limits = Limits((np.zeros(2), np.ones(2)), Cuboid((-2.0,) * 3, (2.0,) * 3), (1e-3, 1e3))
    group = Group(("transmission", "condition", "volume"), (0.05, -0.1, 0.02))
    problem = FitProblem(space.machine, np.array([1.0, 1.0, 0.8]), [group], goals, limits, (z, 0.5))
    goals.settle(space.machine(z), problem.layout.unpack(problem.start))
    return problem


def slopes_of(exact_rows, x):
    """Fifty-digit values and Jacobian at x."""
    x, h = [mpf(float(part)) for part in x], mpf(10) ** -17
    slopes = []
    for k in range(len(x)):
        ends = [exact_rows([*x[:k], x[k] + step, *x[k + 1 :]]) for step in (h, -h)]
        slopes.append([float((up - down) / (2 * h)) for up, down in zip(*ends, strict=True)])
    return np.array([float(row) for row in exact_rows(x)]), np.array(slopes).T


@pytest.mark.parametrize("seed", range(4))
def test_what_is_differentiated_equals_fifty_digits(space, exact, seed, monkeypatch):
    """Insides of every form, margins, bounds, goals, placement; by design, centre, scale and extremes."""
    monkeypatch.setattr(objective, "NEAR", np.inf)
    random = np.random.default_rng(seed)
    ends = [(0.0, 1.0), (1.0, 0.0)]
    z = np.array(ends[seed]) if seed < 2 else random.uniform(0.1, 0.9, 2)
    problem = problem_of(space, z)
    x = problem.start.copy()
    x[2:] += random.uniform(-0.05, 0.05, len(x) - 2)
    problem.slots = [random.uniform(-0.5, 0.5, (4, 3))]
    rows = problem.rows(x)
    found = jacobian(
        lambda points: problem.smooth(points, rows), x, problem.scale, problem.lower, problem.upper
    )
    values, slopes = slopes_of(Exact(problem, rows, exact), x)
    np.testing.assert_allclose(found[0], values, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found[1], slopes, rtol=1e-7, atol=1e-7)
    kinds = {
        (part.term.kind, part.form is None, part.sign)
        for part in rows.selection.numbers + rows.selection.forms
    }
    assert {
        ("joint", True, 1.0),
        ("bound", False, 1.0),
        ("highest", False, 1.0),
        ("highest", True, -1.0),
    } <= kinds


class Plain(Measure):
    """A stranger's measure that gives only numbers: the distance from the origin, shifted."""

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    shift: float = 0.0

    def values(self, manipulator, poses):  # noqa: ARG002
        return np.linalg.norm(poses, axis=1) - self.shift


class Bent(Plain):
    """A measure whose form is not convex."""

    def form(self, manipulator, poses, side):  # noqa: ARG002
        return ConvexForm(poses[:, :1], lambda x, bound, slack: [x**2 >= bound - slack])


class Raising(Plain):
    """A measure whose form raises."""

    def form(self, manipulator, poses, side):  # noqa: ARG002
        raise KeyError("no such thing")


def polish_problem(measure, bounds, *, scale=0.3, centre=(0.0, 0.0, 0.0), region=None, relaxed=None):
    machine = Machine(
        Orthoglide(leg_lengths=(1.0, 1.0, 1.0)), {"m": Demand("m", measure, bounds, place="s.yaml:7:3")}
    )
    none = np.zeros(0)
    limits = Limits((none, none), region, scale=(1e-9, 1e3))
    group = Group(("m",), centre)
    return FitProblem(lambda _: machine, np.ones(3), [group], LargestScale(), limits, (none, scale), relaxed)


@pytest.mark.parametrize(
    ("measure", "bounds", "scale"),
    [
        (Plain(), {"at_most": 0.4}, 0.8 / np.sqrt(3)),
        (Plain(shift=0.4), {"at_most": 0.0}, 0.8 / np.sqrt(3)),
        (Plain(shift=0.5), {"at_most": -0.1}, 0.8 / np.sqrt(3)),
    ],
)
def test_a_measure_of_numbers_alone_is_fitted_whatever_the_sign_of_its_bound(measure, bounds, scale):
    problem = polish_problem(measure, bounds)
    found = minimise(problem, problem.start)
    assert -found.factor == pytest.approx(scale, abs=1e-7)


class Rigid(Measure):
    """A stiffness that is infinite for x < ``until``, and falls from there."""

    unit: ClassVar[str] = "N/m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    until: float

    def values(self, manipulator, poses):  # noqa: ARG002
        return np.where(poses[:, 0] < self.until, np.inf, 1.0 - poses[:, 0])


@pytest.mark.parametrize(("until", "scale"), [(9.0, 0.4), (0.0, 0.3)])
def test_a_stiffness_that_is_infinite_in_places_or_everywhere_is_fitted(until, scale):
    region = Cuboid((-0.1, -9.0, -9.0), (0.3, 9.0, 9.0))
    problem = polish_problem(Rigid(until=until), {"at_least": 0.8}, scale=0.2, region=region)
    found = minimise(problem, problem.start)
    assert -found.factor == pytest.approx(scale, abs=1e-7)


def test_relaxing_a_bound_is_the_same_as_moving_it():
    step = np.log(1.01)
    condition = Condition("bound", "m", "at_most")
    moved = polish_problem(VelocityTransmission(), {"at_most": 2.02})
    relaxed = polish_problem(VelocityTransmission(), {"at_most": 2.0}, relaxed={condition: step})
    first, second = (minimise(problem, problem.start) for problem in (moved, relaxed))
    assert second.factor == pytest.approx(first.factor, abs=1e-9)


class Matched:
    """Two soft rows |extreme − 2| <= factor, and a hard one that wants it no higher than 9."""

    extremes = (Extreme("highest", "m"),)
    on_factor, on_slack = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])

    def rows(self, machine, point):  # noqa: ARG002
        value = point.extremes[0]
        return np.array([value - 2, 2 - value, value - 9])


@pytest.mark.parametrize(("value", "wanted"), [(1.0, True), (1.9, True), (2.1, True), (3.0, False)])
def test_an_extreme_is_held_from_its_far_side_only_where_a_row_that_acts_wants_it_worse(value, wanted):
    point = Point(np.zeros(0), np.zeros((1, 3)), 1.0, np.array([value]))
    assert objective.wanted_worse(Matched(), None, point) == frozenset(Matched.extremes if wanted else ())


def test_a_region_without_room_in_an_axis_fixes_the_cuboid_there():
    """As bounds on its centre, not as two rows against each other whose multipliers have no limit."""
    machine = Machine(Orthoglide(leg_lengths=(1.0, 1.0, 1.0)), {})
    none = np.zeros(0)
    region = Cuboid((-0.5, -0.1, -0.3), (0.5, 0.1, 0.3))
    size = np.array([0.2, 0.2 * (1 + 1e-12), 0.2])
    limits = Limits((none, none), region)
    problem = FitProblem(
        lambda _: machine, size, [Group((), (0.0, 0.05, 0.9))], LargestScale(), limits, (none, 1.0)
    )
    np.testing.assert_allclose(problem.cuboids(problem.start)[0].centre, [0.0, 0.0, 0.2], atol=1e-15)
    assert problem.lower[1] == problem.upper[1]
    np.testing.assert_allclose(problem.lower[[0, 2]], [-2.0, -2.0])
    np.testing.assert_allclose(problem.upper[[0, 2]], [2.0, 0.0], atol=1e-12)
    assert len(limits.rows(size, problem.layout.unpack(problem.start))) == 0


def test_a_region_holds_the_cuboid():
    region = Cuboid((-0.1, -9.0, -9.0), (0.15, 9.0, 9.0))
    problem = polish_problem(Plain(), {"at_most": 9.0}, scale=0.1, region=region)
    found = minimise(problem, problem.start)
    assert -found.factor == pytest.approx(0.25, abs=1e-9)


def _with_form(form):
    """A measure with this form."""

    class Formed(Plain):
        def form(self, manipulator, poses, side):  # noqa: ARG002
            return form(poses)

    return Formed()


def _below(x, bound, slack):
    return [x[0] <= bound + slack]


@pytest.mark.parametrize(
    ("measure", "says"),
    [
        (Bent(), "not convex"),
        (Raising(), "no such thing"),
        (_with_form(lambda _: 5), "its convex form: gave int, not a ConvexForm or None"),
        (
            _with_form(lambda poses: ConvexForm(poses.tolist(), _below)),
            "inside is list, not an array of floats",
        ),
        (
            _with_form(lambda _: ConvexForm(np.ones((7, 1)), _below)),
            r"inside has shape \(7, 1\) for 1 poses, not \(n, ...\)",
        ),
        (
            _with_form(lambda poses: ConvexForm(poses, lambda x, bound, slack: [x.nothing <= bound + slack])),
            "holds raised AttributeError",
        ),
        (_with_form(lambda poses: ConvexForm(poses, lambda *_: 5)), "cvxpy takes no such constraints"),
    ],
)
def test_a_broken_form_is_the_plugins_fault_with_its_place(measure, says):
    problem = polish_problem(measure, {"at_most": 2.0})
    with pytest.raises(PluginFault, match=says) as fault:
        problem.rows(problem.start)
    assert fault.value.place == "s.yaml:7:3"
    assert type(measure).__name__ in fault.value.plugin


@pytest.mark.parametrize(
    ("form", "says"),
    [
        (
            lambda poses: ConvexForm(np.full((len(poses), 1), np.nan), _below),
            r"inside is not finite at \(.*\), where the value is",
        ),
        (
            lambda poses: ConvexForm(poses[:1], _below),
            r"inside has shape \(1, 3\) for \d+ poses, not \(n, ...\)",
        ),
        (
            lambda poses: ConvexForm(poses, _below) if len(poses) == 1 else None,
            r"gave None for \d+ poses, a form for others",
        ),
    ],
)
def test_a_form_that_is_broken_over_several_poses_is_the_plugins_fault(form, says):
    problem = polish_problem(_with_form(form), {"at_most": 2.0})
    rows = problem.rows(problem.start)
    with pytest.raises(PluginFault, match=says) as fault:
        problem.smooth(problem.start[None], rows)
    assert fault.value.place == "s.yaml:7:3"


def test_a_cuboid_out_of_reach_cannot_be_assessed():
    problem = polish_problem(VelocityTransmission(), {"at_most": 2.0})
    far = problem.start.copy()
    far[-1] = 5.0
    assert problem.assess(far).violation == np.inf
    assert problem.assess(problem.start).violation <= 0.0


def test_a_cuboid_slides_along_the_edge_of_the_reach():
    """No measure is known beyond the edge; how far out a step leads is, and turns the next one."""
    beside = (-0.585, 0.585, 0.585)
    problem = polish_problem(VelocityTransmission(), {"at_most": 1.2}, scale=0.09, centre=beside)
    found = minimise(problem, problem.start)
    assert found.ending is Ending.SOLVED
    assert found.subproblems <= 20
    assert found.factor < -0.2
    assert "joint" in {one.kind for one, poses in problem.critical(found.x, 1e-6).items() if poses}


def test_just_out_of_reach_is_told_by_how_much_and_no_measure_counts():
    machine = polish_problem(VelocityTransmission(), {"at_most": 9.0}).machine(np.zeros(0))
    conditions = [Condition("joint", "leg_1", None), Condition("bound", "m", "at_most")]
    poses = np.array([[0.0, 0.7, 0.7], [0.0, 0.71, 0.71], [0.0, 0.9, 0.9]])
    leg, bound = Sample(machine, poses).rows(conditions, [], {})
    np.testing.assert_allclose(leg, 2 * poses[:, 1] ** 2 - 1 + CLEARANCE**2, rtol=1e-12)
    assert np.isfinite(bound[0])
    assert bound[1] == -np.inf
    assert bound[2] == np.inf


def test_critical_poses_are_those_within_reach_of_the_bound():
    scale = 2 / np.sqrt(12)
    problem = polish_problem(Plain(), {"at_most": 0.5}, scale=scale)
    found = problem.critical(problem.start, 1e-9)
    corners = found[Condition("bound", "m", "at_most")]
    assert len(corners) == 8
    for pose in corners:
        np.testing.assert_allclose(np.abs(pose), np.full(3, scale / 2), atol=1e-9)


def test_an_unbuildable_design_is_a_place_without_a_machine_and_no_fault():
    machine = Machine(Orthoglide(leg_lengths=(1.0, 1.0, 1.0)), {})

    def build(z):
        if z[0] > 0.5:
            raise UnbuildableDesign({"z": float(z[0])}, "too long")
        return machine

    limits = Limits((np.zeros(1), np.ones(1)), scale=(1e-9, 1e3))
    group = Group((), (0.0, 0.0, 0.0))
    problem = FitProblem(build, np.ones(3), [group], LargestScale(), limits, (np.array([0.4]), 0.2))
    rows = problem.rows(problem.start)
    points = np.vstack([problem.start, problem.start])
    points[1, 0] = 0.9
    w = problem.smooth(points, rows)
    assert np.isfinite(w[0]).all()
    assert np.isnan(w[1]).all()
    assert problem.assess(points[1]).violation == np.inf

"""The kernels give the same bits for every instruction set that this processor has."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest

from orthospec.kernels import (
    Within,
    _kernels,
    chain_compliance,
    close_legs,
    cube_ends,
    cube_sizes,
    gram_eigenvalues,
    intervals,
    largest_cube,
    leg_margins,
    legs_compliance,
    positive_inverse,
    positive_solve,
    row_norms,
    symmetric_eigenvalues,
    symmetric_eigenvectors,
)

ALL = _kernels.instruction_sets()
RANDOM = np.random.default_rng(1)
SPECIAL = np.array([0.0, -0.0, 1.0, 1e-320, 1e-200, 1e200, 1e308, np.inf, -np.inf, np.nan])
MATRICES = np.concatenate(
    [
        RANDOM.standard_normal((500, 3, 3)),
        RANDOM.choice(SPECIAL, (500, 3, 3)),
        np.eye(3) + 1e-9 * RANDOM.standard_normal((100, 3, 3)),
    ]
)
OTHERS = [
    np.concatenate(
        [
            RANDOM.standard_normal((300, size, size)),
            RANDOM.choice(SPECIAL, (300, size, size)),
            np.where(
                RANDOM.random((300, size, size)) < 0.5, 0.0, RANDOM.choice([1.0, 2, -1], (300, size, size))
            ),
            np.eye(size) + 1e-9 * RANDOM.standard_normal((100, size, size)),
        ]
    )
    for size in (1, 2, 3, 4, 5, 6)
]
DEFINITE = [np.swapaxes(each[:300], 1, 2) @ each[:300] for each in OTHERS]
POSES = RANDOM.uniform(-1.5, 1.5, (1001, 3))
GEOMETRY = np.hstack([np.eye(3), RANDOM.uniform(-0.1, 0.1, (3, 3)), [[1.0, 1], [1.2, -1], [0.9, 1]]])
SCALES = RANDOM.uniform(0.5, 1.0, (3, 7))
ELASTIC = RANDOM.uniform(0.5, 1.0, (3, 21)) + 2.0 * np.isin(np.arange(21), [11, 14, 16, 17, 19])
FEET = np.full((3, 6, 6), 0.1) + np.eye(6)


def compliances() -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(2)
    halves = random.standard_normal((77, 3, 2, 2))
    return halves @ np.swapaxes(halves, 2, 3), random.standard_normal((77, 3, 2, 6))


FIELD = np.random.default_rng(4).choice([0.5, 1.5, np.nan], (22 * 33 * 129, 2), p=[0.97, 0.02, 0.01])
WITHIN = [Within(values, (22, 33, 129), 0.0, 1.0) for values in (FIELD, FIELD[:, 0], FIELD[:, 1].copy())]

QUANTITIES = [
    tuple(np.where(RANDOM.random(part) < 0.05, RANDOM.choice(SPECIAL, part), RANDOM.standard_normal(part))
          for part in ((70, 4, 4), (70, 4, 4), (70, 4, 4), (70, 4, 4, 3), (70, 4, 4)))
    for _ in range(2)
]  # fmt: skip

KERNELS: dict[str, Callable[[], Sequence[np.ndarray]]] = {
    "cube_sizes": lambda: [
        cube_sizes(np.random.default_rng(3).random(shape) < 0.97) for shape in ((40, 50, 61), (256, 257, 258))
    ],
    "largest_cube": lambda: [cube_ends(nodes, max(largest_cube(nodes) - 1, 1)) for nodes in WITHIN],
    "symmetric_eigenvalues": lambda: [symmetric_eigenvalues(MATRICES), symmetric_eigenvalues(MATRICES[::-3])],
    "gram_eigenvalues": lambda: [gram_eigenvalues(MATRICES), gram_eigenvalues(np.swapaxes(MATRICES, 1, 2))],
    "symmetric_eigenvalues of other sizes": lambda: [symmetric_eigenvalues(each) for each in OTHERS],
    "symmetric_eigenvectors": lambda: [one for each in OTHERS for one in symmetric_eigenvectors(each)],
    "gram_eigenvalues of other sizes": lambda: [gram_eigenvalues(each) for each in OTHERS],
    "positive_inverse": lambda: [one for each in DEFINITE + OTHERS for one in positive_inverse(each)],
    "positive_solve": lambda: [one for each in DEFINITE + OTHERS for one in positive_solve(each, each)],
    "row_norms": lambda: [row_norms(view) for each in OTHERS for view in (each, np.swapaxes(each, 1, 2))],
    "chain_compliance": lambda: chain_compliance(*compliances()),
    "legs_compliance": lambda: [
        one
        for legs in (ELASTIC, np.where(np.arange(21) == 20, 0.0, ELASTIC))
        for feet in (FEET, np.zeros((3, 6, 6)))
        for one in legs_compliance(legs, feet, close_legs(GEOMETRY, POSES)[1])
    ],
    "close_legs": lambda: close_legs(GEOMETRY, POSES),
    "intervals": lambda: [
        intervals.add_intervals(*QUANTITIES, (70, 4, 4), 3),
        intervals.multiply_intervals(*QUANTITIES, (70, 4, 4), 3),
        intervals.narrow_intervals(QUANTITIES[0], (70, 4, 4), 3),
        intervals.contract_intervals(QUANTITIES[0], b"\0\1\3", QUANTITIES[1], b"\0\3\2", (70, 4, 4), 3),
    ],
    "leg_margins": lambda: [leg_margins(SCALES, *close_legs(GEOMETRY, POSES)[1::2])],
}


def bits(array: np.ndarray) -> np.ndarray:
    """Those of the numbers; NaN has a sign and a load that mean nothing."""
    numbers = np.where(np.isnan(array), np.nan, array) if array.dtype == np.float64 else array
    return np.ascontiguousarray(numbers).view(f"u{numbers.itemsize}")


@pytest.fixture
def restored() -> Iterator[None]:
    yield
    _kernels.use(ALL[0])


@pytest.mark.usefixtures("restored")
@pytest.mark.parametrize("name", KERNELS)
def test_bits_are_those_of_the_base(name: str) -> None:
    _kernels.use("base")
    expected = [bits(one) for one in KERNELS[name]()]
    for choice in ALL:
        _kernels.use(choice)
        for found, wanted in zip(KERNELS[name](), expected, strict=True):
            np.testing.assert_array_equal(bits(found), wanted, err_msg=choice)


def test_base_is_always_at_hand_and_the_last_choice() -> None:
    assert ALL[-1] == "base"
    assert len(set(ALL)) == len(ALL)


def test_one_that_is_not_at_hand_is_refused() -> None:
    with pytest.raises(ValueError, match="sse9: this processor or build has no such kernels"):
        _kernels.use("sse9")

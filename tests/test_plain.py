"""Plain data goes into JSON and comes back the same, and only as what the reader names."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.optimise.plain import decode, encode


@dataclass(frozen=True)
class Pair:
    left: Any
    right: Any


LEAVES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
VALUES = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner).map(tuple)
        | st.dictionaries(st.text(), inner)
        | st.builds(Pair, inner, inner)
        | st.dictionaries(st.tuples(st.text(), st.integers()), inner, max_size=2)
    ),
    max_leaves=20,
)


def there_and_back(value: Any) -> Any:
    return decode(json.loads(json.dumps(encode(value))), [Pair])


@given(value=VALUES)
def test_what_comes_back_is_equal_and_of_the_same_types(value: Any) -> None:
    found = there_and_back(value)
    assert found == value
    assert repr(found) == repr(value)


@pytest.mark.parametrize("array", [np.array([[0.1, np.nan], [np.inf, -0.0]]), np.zeros((0, 3)), np.arange(4)])
def test_arrays_keep_their_shape_type_and_bits(array: np.ndarray) -> None:
    found = there_and_back(array)
    assert (found.dtype, found.shape) == (array.dtype, array.shape)
    assert found.tobytes() == array.tobytes()


def test_numbers_of_numpy_come_back_as_pythons() -> None:
    found = there_and_back((np.float64(0.1), np.bool_(True), np.int64(3), math.nan))
    assert [type(one) for one in found] == [float, bool, int, float]


@pytest.mark.parametrize("value", [object(), {1, 2}, [1], Pair, b"bytes"])
def test_what_is_no_plain_data_is_refused(value: object) -> None:
    with pytest.raises(TypeError, match="is no plain data"):
        encode((value,))


@pytest.mark.parametrize(
    "content",
    [{"is": "Popen", "args": "true"}, {"is": "Pair", "left": 1}, {"left": 1}, {"is": "array", "all": []}],
)
def test_other_content_makes_nothing(content: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="not plain data of these classes"):
        decode(content, [Pair])

"""`Interval`: an array of quantities of which only bounds are known, that NumPy's functions take.

Where its quantities depend on a box of poses it carries their mean-value forms as well (`linear`), and each
result is the narrower of both. A comparison of intervals may be `Undecided`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from orthospec.intervals import linear
from orthospec.intervals.linear import Linear
from orthospec.intervals.refusal import refuse
from orthospec.kernels.floats import numbers
from orthospec.kernels.intervals import narrow_intervals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array
    from orthospec.intervals.ends import Ends

STACK = "put the parts together with np.stack or np.concatenate, or fill np.zeros_like(poses, shape=...)"
PLAIN = "write it in NumPy's elementary functions, or give the measure or machine an enclosure of its own"


class _Dispatched(NDArrayOperatorsMixin):
    """What NumPy asks of a class of its own arrays."""

    shape: tuple[int, ...]

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """NumPy's elementwise functions."""
        from orthospec.intervals.ufuncs import call_ufunc

        return call_ufunc(ufunc, method, inputs, kwargs)

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """NumPy's other functions."""
        from orthospec.intervals.functions import call_function

        return call_function(func, args, kwargs)

    def __array__(self, dtype: Any = None, copy: Any = None) -> NDArray[Any]:
        """Refused: an interval is no number."""
        raise refuse("an array of numbers (np.array, np.asarray, or what np.empty made)", STACK)

    def __bool__(self) -> bool:
        """Refused: an interval is neither true nor false."""
        raise refuse("a choice by if, and or or", "np.where chooses between values")

    def __float__(self) -> float:
        """Refused: an interval is no number."""
        raise refuse("float()", PLAIN)

    def __index__(self) -> int:
        """Refused: an interval is no number."""
        raise refuse("an index", "np.where chooses between values")

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of entries."""
        return int(np.prod(self.shape))

    def __len__(self) -> int:
        """Length of the first axis."""
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        """Along the first axis."""
        return (self[i] for i in range(len(self)))

    def __getitem__(self, key: Any) -> Any:
        """A part."""
        raise NotImplementedError

    def __getattr__(self, name: str) -> Any:
        """The methods of NumPy's arrays that it has no twin of are refused."""
        if name.startswith("_") or not hasattr(np.ndarray, name):
            raise AttributeError(name)
        raise refuse(f".{name}", PLAIN)


class Interval(_Dispatched):
    """Every quantity lies between ``lo`` and ``hi``, arrays of one shape.

    Both are NaN where it may be undefined somewhere. ``form`` is its mean-value form, if it has one.
    """

    def __init__(self, lo: Array, hi: Array, form: Linear | None = None) -> None:
        self.lo = lo
        self.hi = hi
        self.form = form

    @property
    def shape(self) -> tuple[int, ...]:  # type: ignore[override]
        """Lengths of the axes."""
        return self.lo.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of its ends."""
        return np.dtype(float)

    @property
    def ends(self) -> Ends:
        """Both ends."""
        return self.lo, self.hi

    @property
    def coordinates(self) -> int:
        """Of the box that its form belongs to; 0 without one."""
        return 0 if self.form is None else self.form.g.shape[-1]

    def form_over(self, d: int) -> Linear:
        """Its mean-value form, or one that knows nothing of the d coordinates."""
        return linear.flat(self.ends, d) if self.form is None else self.form

    @property
    def is_exact(self) -> bool:
        """Whether it is made of numbers: its ends are one array."""
        return self.lo is self.hi

    def narrowed(self) -> Interval:
        """Its ends where its form gives narrower ones."""
        if self.form is None:
            return self
        return of_rows(narrow_intervals(known_of(self), self.shape, self.coordinates))

    def __repr__(self) -> str:
        """Both ends."""
        return f"Interval(lo={self.lo!r}, hi={self.hi!r})"

    def __getitem__(self, key: Any) -> Interval:
        """A part, a view where NumPy gives one."""
        if isinstance(key, _Dispatched) or (
            isinstance(key, tuple) and any(isinstance(part, _Dispatched) for part in key)
        ):
            raise refuse("an index", "np.where chooses between values")
        form = self.form
        if form is not None:
            form = Linear(form.c[key], form.g[_before_last(key)], form.r[key])
        return Interval(self.lo[key], self.hi[key], form)

    def __setitem__(self, key: Any, value: Any) -> None:
        """Put numbers or an interval in place of a part."""
        value = as_interval(value)
        if not self.lo.flags.writeable:
            raise refuse(
                "a view, or what others are given too, changed in place,",
                "write a = a + b in place of a += b",
            )
        self.lo[key], self.hi[key] = value.lo, value.hi
        if self.form is None and value.form is not None:
            self.form = _own(linear.flat(self.ends, value.coordinates))
        if self.form is not None:
            form = value.form_over(self.coordinates)
            self.form.c[key], self.form.g[_before_last(key)], self.form.r[key] = form

    def make_read_only(self) -> None:
        """What is made from another array without being a view of it must not be written to."""
        for part in (self.lo, self.hi, *(self.form or ())):
            part.flags.writeable = False

    @property
    def T(self) -> Interval:
        """With its axes reversed."""
        return self.transpose()

    def copy(self) -> Interval:
        """A copy."""
        form = self.form and _own(self.form)
        return Interval(self.lo.copy(), self.hi.copy(), form)

    def reshape(self, *shape: Any) -> Any:
        """With these lengths of its axes."""
        return np.reshape(self, shape[0] if len(shape) == 1 else shape)

    def transpose(self, *axes: Any) -> Interval:
        """With its axes in another order."""
        found: Any = np.transpose(self, (axes[0] if len(axes) == 1 else axes) or None)
        return cast("Interval", found)

    def swapaxes(self, a: int, b: int) -> Any:
        """With two axes exchanged."""
        return np.swapaxes(self, a, b)

    def squeeze(self, axis: Any = None) -> Any:
        """Without axes of length 1."""
        return np.squeeze(self, axis)

    def ravel(self) -> Any:
        """Along one axis."""
        return np.reshape(self, -1)

    def sum(self, axis: Any = None, **kwargs: Any) -> Any:
        """The sum along axes."""
        return np.sum(self, axis=axis, **kwargs)

    def mean(self, axis: Any = None, **kwargs: Any) -> Any:
        """The mean along axes."""
        return np.mean(self, axis=axis, **kwargs)

    def prod(self, axis: Any = None, **kwargs: Any) -> Any:
        """The product along one axis."""
        return np.prod(self, axis=axis, **kwargs)

    def max(self, axis: Any = None, **kwargs: Any) -> Any:
        """The greatest along axes."""
        return np.max(self, axis=axis, **kwargs)

    def min(self, axis: Any = None, **kwargs: Any) -> Any:
        """The least along axes."""
        return np.min(self, axis=axis, **kwargs)

    def dot(self, other: Any) -> Any:
        """The matrix product."""
        return np.dot(self, other)


class Undecided(_Dispatched):
    """Whether something holds, of each box: ``surely`` everywhere, ``possibly`` somewhere."""

    def __init__(self, surely: NDArray[np.bool_], possibly: NDArray[np.bool_]) -> None:
        self.surely = surely
        self.possibly = possibly

    @property
    def shape(self) -> tuple[int, ...]:  # type: ignore[override]
        """Lengths of the axes."""
        return self.surely.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of a truth."""
        return np.dtype(bool)

    def __getitem__(self, key: Any) -> Undecided:
        """A part."""
        return Undecided(np.asarray(self.surely[key]), np.asarray(self.possibly[key]))

    def __bool__(self) -> bool:
        """Only of one truth that is decided."""
        if self.size == 1 and bool(self.surely) == bool(self.possibly):
            return bool(self.surely)
        raise refuse("a choice by if, and or or", "np.where chooses between values")

    def any(self, axis: Any = None, **kwargs: Any) -> Undecided:
        """Whether it holds for any entry along axes."""
        surely, possibly = (part.any(axis=axis, **kwargs) for part in (self.surely, self.possibly))
        return Undecided(np.asarray(surely), np.asarray(possibly))

    def all(self, axis: Any = None, **kwargs: Any) -> Undecided:
        """Whether it holds for all entries along axes."""
        surely, possibly = (part.all(axis=axis, **kwargs) for part in (self.surely, self.possibly))
        return Undecided(np.asarray(surely), np.asarray(possibly))


def as_interval(x: Any) -> Interval:
    """Numbers as an interval of no width, its two ends one array."""
    if isinstance(x, Interval):
        return x
    number = np.asarray(x, dtype=float)
    return Interval(number, number)


def known_of(x: Interval) -> tuple[Array, ...]:
    """What is known of an interval, as the kernels take it."""
    if x.is_exact:
        return (numbers(x.lo),)
    return tuple(map(numbers, (x.lo, x.hi, *(x.form or ()))))


def of_rows(rows: Array) -> Interval:
    """The interval that a kernel has found."""
    lo, hi = rows[0, ...], rows[1, ...]
    if len(rows) == 2:
        return Interval(lo, hi)
    slopes = rows[4:].transpose((*range(1, rows.ndim), 0))
    return Interval(lo, hi, Linear(rows[2, ...], slopes, rows[3, ...]))


def _own(form: Linear) -> Linear:
    slopes = np.moveaxis(np.array(np.moveaxis(form.g, -1, 0), order="C"), 0, -1)
    return Linear(np.array(form.c, order="C"), slopes, np.array(form.r, order="C"))


def _before_last(key: Any) -> Any:
    """The same key for an array with one more axis at the end."""
    parts = key if isinstance(key, tuple) else (key,)
    return (*parts, slice(None)) if any(part is Ellipsis for part in parts) else key

"""Where code that asks for a number stands: in the file of the measure or machine, not of NumPy or here."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from orthospec.errors import NoEnclosure

_OURS = (str(Path(__file__).parent), str(Path(np.__file__).parent))


def refuse(what: str, instead: str) -> NoEnclosure:
    """The error to raise, with the file and line of the caller's caller that is neither NumPy nor this."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_OURS):
        frame = frame.f_back
    line = line_of(frame, frame.f_lineno)
    return NoEnclosure(f"{line}: {what} knows numbers only, not intervals: {instead}")


def check_plain(dtype: Any, out: Any = None) -> None:
    """Refuse what would round the numbers or put them elsewhere, when NumPy's function is asked for it."""
    if out is not None or not (dtype is None or np.dtype(dtype) == np.dtype(float)):
        raise refuse("a result of another type or in place", "leave out 'dtype' and 'out'")


def line_of(frame: FrameType, number: int) -> str:
    """A line of code by its module: results tell of it, and are the same wherever that is installed."""
    return f"{frame.f_globals.get('__name__', frame.f_code.co_name)}, line {number}"

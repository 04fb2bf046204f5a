"""Where code that asks for a number stands: in the file of the measure or machine, not of NumPy or here."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from orthospec.errors import NoEnclosure

_OURS = (str(Path(__file__).parent), str(Path(np.__file__).parent))


def refuse(what: str, instead: str) -> NoEnclosure:
    """The error to raise, with the file and line of the caller's caller that is neither NumPy nor this."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_OURS):
        frame = frame.f_back
    return NoEnclosure(f"{frame.f_code.co_filename}:{frame.f_lineno}", what, instead)

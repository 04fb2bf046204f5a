"""Interval arithmetic on whole arrays of boxes: what holds at every pose of a box, not at points of it.

An `Interval` takes part in NumPy's own functions, so that code written in them for arrays of numbers gives
enclosures when it is handed intervals:

>>> import numpy as np
>>> boxes = Boxes(np.array([[-1.0, 0.0]]), np.array([[1.0, 0.5]]))
>>> norm = np.linalg.norm(boxes.poses, axis=1)
>>> float(norm.lo[0]), bool(1.118 < norm.hi[0] < 1.119)
(0.0, True)
"""

from orthospec.intervals.boxes import Boxes
from orthospec.intervals.interval import Interval, Undecided, as_interval

__all__ = ["Boxes", "Interval", "Undecided", "as_interval"]

"""Array types named by shape, and numpy, loaded at its first use.

``orthospec check`` and shell completion never touch an array, yet they need the classes of the manipulators
and measures to know their fields. The modules on that path take ``np`` from here, so that importing them
does not import numpy (70 ms); elsewhere ``import numpy as np`` is as good.

The first axis of each array is the batch: n poses, n boxes. Units are SI.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[np.float64]
    Poses: TypeAlias = Annotated[NDArray[np.float64], "n d"]
    Joints: TypeAlias = Annotated[NDArray[np.float64], "n m"]
    Matrices: TypeAlias = Annotated[NDArray[np.float64], "n m m"]
    Flags: TypeAlias = Annotated[NDArray[np.bool_], "n"]
else:

    class _Numpy:
        """Not a lazy module in ``sys.modules``: pydantic touches all that stand there, for docstrings."""

        def __getattr__(self, name):
            import numpy

            value = getattr(numpy, name)
            setattr(self, name, value)
            return value

    np = _Numpy()

__all__ = ["np"]

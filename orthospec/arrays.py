"""Array types named by shape, and numpy, loaded at its first use.

``orthospec check`` and shell completion never touch an array, yet they need the classes of the manipulators
and measures to know their fields. The modules on that path take ``np`` from here, so that importing them
does not import numpy (70 ms); elsewhere ``import numpy as np`` is as good.

The first axis of each array is the batch: n poses, n boxes. Units are SI.
"""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[np.float64]
    Poses: TypeAlias = Annotated[NDArray[np.float64], "n d"]
    Joints: TypeAlias = Annotated[NDArray[np.float64], "n m"]
    Matrices: TypeAlias = Annotated[NDArray[np.float64], "n m m"]
    Flags: TypeAlias = Annotated[NDArray[np.bool_], "n"]
    Mask: TypeAlias = Annotated[NDArray[np.uint8], "i j k"]
else:

    def _at_first_use(name: str) -> ModuleType:
        """The module ``name``, executed when an attribute of it is first asked for."""
        if name in sys.modules:
            return sys.modules[name]
        found = importlib.util.find_spec(name)
        found.loader = importlib.util.LazyLoader(found.loader)
        module = importlib.util.module_from_spec(found)
        sys.modules[name] = module
        found.loader.exec_module(module)
        return module

    np = _at_first_use("numpy")

__all__ = ["np"]

import numpy as np
from numpy.typing import NDArray

def cube_sizes(mask: NDArray[np.uint8 | np.bool_], out: NDArray[np.uint8 | np.uint16], /) -> None: ...
def symmetric_eigenvalues_3(matrices: NDArray[np.float64], out: NDArray[np.float64], /) -> None: ...
def chain_compliance(
    compliances: NDArray[np.float64],
    wrenches: NDArray[np.float64],
    out: NDArray[np.float64],
    safe: NDArray[np.uint8 | np.bool_],
    /,
) -> None: ...

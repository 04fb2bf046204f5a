from typing import Any

import numpy as np
from numpy.typing import NDArray

def cube_sizes(mask: NDArray[np.uint8 | np.bool_], out: NDArray[np.uint8 | np.uint16], /) -> None: ...
def largest_cube(nodes: tuple[Any, ...], axes: int, /) -> int: ...
def cube_ends(nodes: tuple[Any, ...], axes: int, edge: int, out: NDArray[np.uint64], /) -> None: ...
def symmetric_eigenvalues(matrices: NDArray[np.float64], out: NDArray[np.float64], /) -> None: ...
def symmetric_eigenvectors(
    matrices: NDArray[np.float64],
    out: NDArray[np.float64],
    vectors: NDArray[np.float64],
    /,
) -> None: ...
def gram_eigenvalues(matrices: NDArray[np.float64], out: NDArray[np.float64], /) -> None: ...
def row_norms(matrices: NDArray[np.float64], out: NDArray[np.float64], /) -> None: ...
def positive_inverse(
    matrices: NDArray[np.float64],
    out: NDArray[np.float64],
    safe: NDArray[np.uint8 | np.bool_],
    /,
) -> None: ...
def positive_solve(
    matrices: NDArray[np.float64],
    right: NDArray[np.float64],
    out: NDArray[np.float64],
    safe: NDArray[np.uint8 | np.bool_],
    /,
) -> None: ...
def close_legs(
    geometry: NDArray[np.float64],
    poses: NDArray[np.float64],
    rho: NDArray[np.float64],
    s: NDArray[np.float64],
    along: NDArray[np.float64],
    closing: NDArray[np.float64],
    /,
) -> None: ...
def leg_margins(
    scales: NDArray[np.float64],
    s: NDArray[np.float64],
    closing: NDArray[np.float64],
    margins: NDArray[np.float64],
    /,
) -> None: ...
def add_intervals(x: tuple[Any, ...], y: tuple[Any, ...], out: NDArray[np.float64], /) -> None: ...
def multiply_intervals(x: tuple[Any, ...], y: tuple[Any, ...], out: NDArray[np.float64], /) -> None: ...
def narrow_intervals(x: tuple[Any, ...], out: NDArray[np.float64], /) -> None: ...
def contract_intervals(
    x: tuple[Any, ...], x_axes: bytes, y: tuple[Any, ...], y_axes: bytes, out: NDArray[np.float64], /
) -> None: ...
def instruction_sets() -> list[str]: ...
def use(name: str, /) -> None: ...
def chain_compliance(
    compliances: NDArray[np.float64],
    wrenches: NDArray[np.float64],
    out: NDArray[np.float64],
    safe: NDArray[np.uint8 | np.bool_],
    /,
) -> None: ...
def legs_compliance(
    legs: NDArray[np.float64],
    feet: NDArray[np.float64],
    s: NDArray[np.float64],
    out: NDArray[np.float64],
    safe: NDArray[np.uint8 | np.bool_],
    /,
) -> None: ...

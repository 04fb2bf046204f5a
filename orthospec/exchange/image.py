"""The measures on the spec's grid as VTK image data (.vti), for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import UsageError
from orthospec.exchange.dataset import ENDS
from orthospec.optimise import fields_of

if TYPE_CHECKING:
    from orthospec.solution import Solution


def write(solution: Solution, name: str, file: Path) -> None:
    """Point data at the nodes, one array a value; out of reach NaN, and 0 in the array ``reach``."""
    from pyevtk.hl import imageToVTK

    spec, design = solution.spec, solution.design
    if spec is None or design is None:
        raise UsageError("the fields of this result are not known: its spec or a plugin of it is not at hand")
    found = fields_of(spec, design)
    axes = design.manipulator.axes[: len(spec.workspace.size)]
    if not 2 <= len(axes) <= 3:
        raise UsageError(f"{name} is for cuboids of two or three axes; this one has {len(axes)}")
    lines = [found[f"axis_{axis}"] for axis in axes]
    lines += [np.zeros(1)] * (3 - len(lines))
    shape = tuple(map(len, lines))
    data = {}
    for demand in design.demands:
        values = found.get(demand.name)
        if values is None:
            continue
        parts = [values] if values.ndim == len(axes) else [values[..., k] for k in range(2)]
        names = [demand.name] if len(parts) == 1 else [f"{demand.name}_{end}" for end in ENDS]
        for label, part in zip(names, parts, strict=True):
            data[label] = np.asfortranarray(part.reshape(shape))
            data["reach"] = np.asfortranarray(np.isfinite(part).reshape(shape).astype(np.uint8))
    spacing = tuple(float(line[1] - line[0]) if len(line) > 1 else 1.0 for line in lines)
    origin = tuple(float(line[0]) for line in lines)
    imageToVTK(str(file.with_suffix("")), origin=origin, spacing=spacing, pointData=data)

"""The measures on the spec's grid as xarray has them, for NetCDF and Zarr."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orthospec.errors import UsageError
from orthospec.optimise import fields_of

if TYPE_CHECKING:
    import xarray

    from orthospec.optimise import Workers
    from orthospec.solution import Solution
    from orthospec.workspace.field import Progress

ENDS = ("least", "greatest")


def dataset(
    solution: Solution, workers: Workers | None = None, progress: Progress | None = None
) -> xarray.Dataset:
    """Each measure over the machine's axes, and ``end`` where it has two values; NaN out of reach.

    Units, bounds and what was asked are attributes, named as the CF conventions do where they have a name.
    """
    import xarray

    spec, design = solution.spec, solution.design
    if spec is None or design is None:
        raise UsageError("the fields of this result are not known: its spec or a plugin of it is not at hand")
    found = fields_of(spec, design, workers=workers, progress=progress)
    axes = design.manipulator.axes[: len(spec.workspace.size)]
    coordinates: dict[str, Any] = {
        axis: (
            axis,
            found[f"axis_{axis}"],
            {"units": "m" if axis in "xyz" else "rad", "long_name": f"tool {axis}"},
        )
        for axis in axes
    }
    measures = {}
    for demand in design.demands:
        if demand.name not in found:
            continue
        values = found[demand.name]
        dimensions = axes if values.ndim == len(axes) else (*axes, "end")
        if values.ndim > len(axes):
            coordinates["end"] = ("end", list(ENDS))
        own = demand.measure.model_dump(mode="json", by_alias=True, exclude_none=True)
        measures[demand.name] = (
            dimensions,
            values,
            {
                "units": demand.measure.unit,
                "long_name": (type(demand.measure).__doc__ or demand.name).splitlines()[0],
                **{f"bound_{side}": bound for side, bound in demand.bounds.items()},
                **{f"key_{key}": value for key, value in own.items() if isinstance(value, int | float | str)},
            },
        )
    told = {
        "title": spec.title or solution.result.manipulator["use"],
        "source": f"orthospec {solution.result.provenance.get('orthospec', '')}",
        "manipulator": solution.result.manipulator["use"],
        **{f"variable_{name}": value for name, value in solution.result.variables.items()},
    }
    return xarray.Dataset(measures, coordinates, told)


def write(solution: Solution, name: str, file: Path) -> None:
    """NetCDF by SciPy, or Zarr, the same bytes each time."""
    data = dataset(solution)
    if name.endswith(".nc"):
        if "end" in data.coords:
            data = data.assign_coords(end=("end", list(range(len(ENDS))), {"flag_meanings": " ".join(ENDS)}))
        data.to_netcdf(file, engine="scipy")
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own drafts: text has no fixed type in Zarr 3 yet
        data.to_zarr(file, mode="w", consolidated=False)

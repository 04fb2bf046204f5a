"""Which files there are, by their names, and how they are written: whole or not at all."""

from __future__ import annotations

import importlib
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from orthospec.errors import UsageError

if TYPE_CHECKING:
    from orthospec.solution import Solution


class Kind(NamedTuple):
    """What can be written under one name."""

    words: str
    module: str
    """Of this package, with a function ``write(solution, stem, file)``."""
    needs: tuple[str, ...] = ()
    """Modules of the extra ``exchange``."""
    folder: bool = False
    """A Zarr store is a folder; all else is one file."""


KINDS: Mapping[str, Kind] = {
    "fields.nc": Kind("each measure on the spec's grid, NetCDF", "dataset", ("xarray",)),
    "fields.zarr": Kind("the same as a Zarr folder", "dataset", ("xarray", "zarr"), folder=True),
    "fields.vti": Kind("the same as VTK image data, for ParaView", "image", ("pyevtk",)),
    "cuboid.stl": Kind("the prescribed cuboid [mm]", "surfaces", ("trimesh",)),
    "largest.stl": Kind("the largest cuboid [mm]", "surfaces", ("trimesh",)),
    "workspace.stl": Kind("the surface around all that is in reach [mm]", "surfaces", ("trimesh",)),
    "machine.glb": Kind(
        "the machine with its tool in the middle of the cuboid, glTF [m]", "surfaces", ("trimesh",)
    ),
    "machine.xml": Kind("the machine with its closed loops, MuJoCo MJCF [m, kg]", "mjcf"),
    "designs.csv": Kind("the design, a Pareto set, a sweep and combinations as a table [SI]", "table"),
}
"""By name: a file's own may have more before it, as in ``before-fields.nc``."""
STORE = ("zarr.json", ".zgroup")
"""By which a folder is a Zarr store: of version 3, of version 2."""


def export(solution: Solution, files: Sequence[Path]) -> list[Path]:
    """Write each file by what its name ends with; those written.

    Raises `UsageError` for another name, where something else stands in a file's place, where a library is
    missing, where the result has no such thing, and where a file cannot be written; what was written before
    stays, and nothing is left half-written.
    """
    chosen = [(_kind(file), file) for file in files]
    for name, file in chosen:
        _check_place(file, KINDS[name])
    for name, file in chosen:
        kind = KINDS[name]
        for module in kind.needs:
            _needed(module, file)
        write = importlib.import_module(f"orthospec.exchange.{kind.module}").write
        _whole(file, partial(write, solution, name))
    return list(files)


def _kind(file: Path) -> str:
    for name in KINDS:
        stem, suffix = name.split(".")
        own, _, own_suffix = file.name.rpartition(".")
        if own_suffix == suffix and (own == stem or own.endswith((f"-{stem}", f"_{stem}"))):
            return name
    told = "\n".join(f"  {name:15}{kind.words}" for name, kind in KINDS.items())
    raise UsageError(f"{file}: what to write there is told by its name, which ends with one of\n{told}")


def _needed(module: str, file: Path) -> None:
    try:
        importlib.import_module(module)
    except ImportError:
        raise UsageError(f"{file} needs {module}: pip install 'orthospec[exchange]'") from None


def _check_place(file: Path, kind: Kind) -> None:
    """Raise `UsageError` where a file would take the place of something that is not of its kind."""
    if not kind.folder:
        if file.is_dir():
            raise UsageError(f"{file}: there is a folder of this name, not a file; choose another name")
    elif file.is_dir():
        if any(file.iterdir()) and not any((file / mark).is_file() for mark in STORE):
            raise UsageError(f"{file}: this folder holds other files and no Zarr store; choose another name")
    elif file.exists():
        raise UsageError(f"{file}: there is a file of this name, not a Zarr store; choose another name")


def _whole(file: Path, write: Callable[[Path], None]) -> None:
    """Written beside and then renamed; a link stays, and what it points to is replaced."""
    target = file.resolve()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{file.name}.", dir=target.parent) as scratch:
            fresh = Path(scratch) / file.name
            write(fresh)
            if fresh.is_dir():
                _put_in_place(fresh, target, Path(scratch) / "old")
            else:
                os.replace(fresh, target)
    except OSError as error:
        raise UsageError(f"{file}: cannot be written: {(error.strerror or str(error)).lower()}") from error


def _put_in_place(fresh: Path, target: Path, old: Path) -> None:
    """A folder that is there is moved aside first, and put back where the new one cannot take its place."""
    try:
        if target.exists():
            target.rename(old)
        fresh.rename(target)
    except BaseException:
        if old.exists() and not target.exists():
            old.rename(target)
        raise

"""The result folder, written whole or not at all, and the result file read back."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from orthospec.errors import OrthospecError, SpecError, UsageError
from orthospec.interrupts import ctrl_c_waiting
from orthospec.result.model import Result
from orthospec.spec.document import Document
from orthospec.spec.load import load_spec
from orthospec.spec.strict_yaml import LARGEST_RESULT, parse
from orthospec.spec.wording import problems
from orthospec.spec.writing import dump

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.spec import Spec

RESULT, SPEC, LOG, FIELDS = "result.yaml", "spec.yaml", "run.log.json", "fields.npz"
REPORT, PREVIEW = "report.html", "preview.html"
_OURS = frozenset({RESULT, SPEC, LOG, FIELDS, REPORT, PREVIEW})
_FIRST_LINE = b"orthospec: 1\n"


def check_destination(folder: Path) -> None:
    """Raise `UsageError` where a result may not be written; asked before the work, not only after it."""
    if folder.is_dir():
        if any(folder.iterdir()) and not _is_result(folder):
            raise UsageError(f"{folder}: this folder holds other files and no result; choose another one")
    elif folder.exists():
        raise UsageError(f"{folder}: there is a file of this name; choose another folder")


def write_result(
    folder: Path,
    spec: Spec,
    content: Mapping[str, Any],
    log: Mapping[str, Any],
    fields: Mapping[str, Array] | None = None,
    pages: Mapping[str, str] | None = None,
) -> None:
    """Write a result folder; one that is there already is replaced, other files in it are kept.

    ``pages`` are texts for people, by the names of their files.
    A fault on the way leaves the old folder as it was; Ctrl-C comes when the folder is written.
    """
    check_destination(folder)
    target = folder.resolve()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with (
            ctrl_c_waiting(),
            tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as scratch,
        ):
            fresh = Path(scratch) / "new"
            fresh.mkdir()
            _fill(fresh, spec, content, log, fields)
            for name, page in (pages or {}).items():
                _write(fresh / name, page)
            _put_in_place(fresh, target, Path(scratch) / "old")
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written: {(error.strerror or str(error)).lower()}") from error


def write_page(file: Path, text: str) -> None:
    """Write one page by a rename. Raises `UsageError` where that cannot be."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        fresh = file.with_name(f".{file.name}.new")
        _write(fresh, text)
        fresh.replace(file)
    except OSError as error:
        raise UsageError(f"{file}: cannot be written: {(error.strerror or str(error)).lower()}") from error


def _fill(
    folder: Path,
    spec: Spec,
    content: Mapping[str, Any],
    log: Mapping[str, Any],
    fields: Mapping[str, Array] | None,
) -> None:
    _write(folder / RESULT, dump(content))
    _write(folder / SPEC, spec.source)
    _write(folder / LOG, json.dumps(log, indent=2, ensure_ascii=False) + "\n")
    if fields:
        _write_fields(folder / FIELDS, fields)


def _write_fields(path: Path, fields: Mapping[str, Array]) -> None:
    """As ``np.savez_compressed`` does, which takes names for its own arguments; the same bytes each day."""
    import numpy as np

    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, values in fields.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, values, allow_pickle=False)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _put_in_place(fresh: Path, target: Path, old: Path) -> None:
    """One rename, or two where a result is replaced: what was there is put back unless both are done."""
    if not target.exists():
        fresh.rename(target)
        return
    for other in target.iterdir():
        if other.name not in _OURS:
            _copy(other, fresh / other.name)
    try:
        target.rename(old)
        fresh.rename(target)
    except BaseException:
        if not target.exists():
            os.rename(old, target)
        raise


def _copy(source: Path, target: Path) -> None:
    if source.is_dir() and not source.is_symlink():
        shutil.copytree(source, target, symlinks=True)
    else:
        shutil.copy2(source, target, follow_symlinks=False)


def _is_result(folder: Path) -> bool:
    try:
        with (folder / RESULT).open("rb") as file:
            return file.read(len(_FIRST_LINE)) == _FIRST_LINE
    except OSError:
        return False


def read_result(path: Path) -> dict[str, Any]:
    """The content of a result: a folder, or a ``result.yaml``.

    Raises `UsageError` for what is no result, `SpecError` with all places for a result with mistakes in it.
    """
    file = path / RESULT if path.is_dir() else path
    empty = f"the file is empty; a result is a folder with {RESULT} in it"
    document = parse(_text(path, file), str(file), LARGEST_RESULT, empty)
    content = document.data
    if not isinstance(content, dict) or "status" not in content:
        raise UsageError(f"{path}: {_other_kind(content)}")
    mistakes = [*document.mistakes, *_mistakes(document)]
    if mistakes:
        raise SpecError(mistakes)
    return content


def spec_of(path: Path) -> Spec | None:
    """The spec beside a result as it was run; None where it is not there or its plugins are not installed."""
    try:
        return load_spec((path if path.is_dir() else path.parent) / SPEC)
    except OrthospecError:
        return None


def log_of(path: Path) -> dict[str, Any]:
    """The log beside a result; empty where there is none that can be read."""
    try:
        text = ((path if path.is_dir() else path.parent) / LOG).read_text(encoding="utf-8")
        content = json.loads(text)
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _text(path: Path, file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        lacking = f"no {RESULT} in this folder" if path.is_dir() else "no such file or folder"
        raise UsageError(f"{path}: {lacking}") from None
    except UnicodeDecodeError:
        raise UsageError(f"{path}: not a result: not UTF-8 text") from None
    except OSError as error:
        raise UsageError(f"{path}: {(error.strerror or 'cannot be read').lower()}") from None


def _other_kind(content: object) -> str:
    if isinstance(content, dict) and "orthospec" in content:
        return "this is a spec, not a result; 'orthospec run' makes a result folder of it"
    return f"not a result; a result is a folder with {RESULT} in it"


def _mistakes(document: Document) -> list[Any]:
    try:
        Result.model_validate(document.data)
    except ValidationError as error:
        found = problems(error, document.data, Result)
        return [document.mistake(one.path, one.message, at_key=one.at_key) for one in found]
    return []

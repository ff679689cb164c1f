"""Files that are whole or not there: written beside their place, then moved into it."""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from impactfem.system.errors import ImpactfemError

_ROOT = Path(__file__).parents[3]
_PART = re.compile(r"\..+\.([1-9]\d{0,8})\.part")


def in_source_tree(name: str) -> Path:
    """A file or folder that comes with the source tree, and with no installed package.

    Args:
        name: Its path from the root of the tree, as "geometry/frame.toml".

    Raises:
        ImpactfemError: The program runs without its source tree.
    """
    path = _ROOT / name
    if not path.exists():
        raise ImpactfemError(f"{path} is not there: this needs a clone of the source tree")
    return path


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; move it there when the block ends without an error.

    A kill or a full disk leaves the old file, or none, never half of one.

    Raises:
        ImpactfemError: The file cannot be written; says why.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")  # as in _PART
    try:
        try:
            yield temporary
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ImpactfemError(f"cannot write {path}: {error.strerror or error}") from error


def remove_parts(folder: Path) -> None:
    """Remove the temporary files below a folder that `atomic` left there when it was killed.

    Those of processes that still live are kept; this process must not be writing there.

    Raises:
        OSError: One cannot be removed.
    """
    for path in folder.rglob(".*.part"):
        match = _PART.fullmatch(path.name)
        if match is not None and path.is_file() and not _at_work(int(match[1])):
            path.unlink(missing_ok=True)


def _at_work(process: int) -> bool:
    """Whether another process of this number lives; in a container that of a run before is ours."""
    if process == os.getpid():
        return False
    try:
        os.kill(process, 0)  # asks only
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def write_netcdf(path: Path, dataset: xr.Dataset) -> None:
    """Write a dataset as compressed NetCDF 4, in one piece.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    encoding = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind == "f" and variable.size > 1000
    }
    # Made in memory first: HDF5 aborts the process when its own writing hits a full disk.
    whole = io.BytesIO()
    dataset.to_netcdf(whole, engine="h5netcdf", encoding=encoding)
    # The view is released here: left to the traceback of a failed write, it would outlive `whole`,
    # which cannot be closed under a view.
    with atomic(path) as temporary, temporary.open("wb") as stream, whole.getbuffer() as view:
        stream.write(view)


def write_json(path: Path, value: object) -> None:
    """Write a value as indented JSON, in one piece; nan and infinity are refused."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)
    with atomic(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")

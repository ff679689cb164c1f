"""Files that are whole or not there: JSON, NetCDF, archives of arrays."""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import xarray as xr

from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER

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

    Those of other processes that still live are kept; this process must not be writing there.

    Raises:
        OSError: One cannot be removed.
    """
    for path in folder.rglob(".*.part"):
        match = _PART.fullmatch(path.name)
        # In a container the number of this process may be that of a run before.
        if match is None or (int(match[1]) != os.getpid() and psutil.pid_exists(int(match[1]))):
            continue
        if path.is_file():
            path.unlink(missing_ok=True)


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


def write_archive(path: Path, key: str, content: dict[str, Any]) -> None:
    """Write arrays and numbers by name.

    Args:
        path: The file.
        key: Hash of what they depend on.
        content: The arrays; "key" is no name.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    # np.savez leaves its archive open where the disk is full, to fail again when it is collected.
    with (
        atomic(path) as temporary,
        temporary.open("wb") as stream,
        zipfile.ZipFile(stream, "w") as archive,
    ):
        for name, value in (content | {"key": key}).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.save(member, value, allow_pickle=False)


def read_archive(path: Path, key: str) -> dict[str, Any] | None:
    """Read all arrays of a file.

    Returns:
        The arrays by name; None where there is no file, where it was made from something else, and
        where it is damaged, which is told.
    """
    try:
        # NumPy leaves a damaged file open that it has opened itself.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            # Large arrays of another run are not read.
            return dict(content) if str(content["key"]) == key else None
    except FileNotFoundError:
        return None
    except Exception as error:  # whatever NumPy and zipfile make of a file that is cut short
        LOGGER.warning("warning: %s is damaged (%s); computed again", path, error)
        return None

"""Files: those of the user, read with a fault in place of an exception, and those that are written.

What is written, JSON, NetCDF and archives of arrays, is whole or not there.
"""

from __future__ import annotations

import codecs
import errno
import json
import os
import re
import shutil
import stat
import sys
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import psutil

from impactfem.system.errors import Fault, ImpactfemError
from impactfem.system.log import LOGGER

if TYPE_CHECKING:
    import xarray as xr

StrPath = str | os.PathLike[str]
"""A path as users give it."""
NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
"""Answers of a file system that cannot lock, as some shared ones cannot."""
LARGEST = 20_000_000  # size of the largest table [byte]
LARGEST_FILE = 200_000_000  # size of the largest file of another kind, as a record [byte]
LARGEST_MESH = 300_000_000  # size of the largest mesh [byte]: some two million nodes
LARGEST_FORCES = 500_000_000  # size of the largest file of impact forces [byte]
LARGEST_TOML = 1_000_000  # size of the largest case file [byte]; the paper's has 10,000
_ROOT = Path(__file__).parents[3]
_INSTALLED = Path(sys.prefix) / "share" / "impactfem"
_PART = re.compile(r"\..+\.([1-9]\d{0,8})\.part")


def in_source_tree(name: str) -> Path:
    """A file or folder of the source tree, as "geometry/frame.toml"; of a package `geometry` alone.

    ImpactfemError where the program runs without its source tree.
    """
    for root in (_ROOT, _INSTALLED):
        if (root / name).exists():
            return root / name
    raise ImpactfemError(f"{_ROOT / name} is not there: this needs a clone of the source tree")


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary path in the folder of `path`; replace `path` by it when the block succeeds.

    A kill or a full disk leaves the old file, or none, never half of one. ImpactfemError where the
    file cannot be written; says why.
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


@contextmanager
def private_copy(content: bytes, name: str) -> Iterator[Path]:
    """Write a file into a new folder of this user alone, and remove both when the block ends.

    For libraries that look for further files next to the one that they read. ImpactfemError where
    the folder of temporary files has no space or cannot be written.
    """
    with ExitStack() as held:
        try:
            copy = Path(held.enter_context(TemporaryDirectory(prefix="impactfem-")), name)
            copy.write_bytes(content)
        except OSError as error:
            raise ImpactfemError(
                f"cannot write a copy of {1e-6 * len(content):.3g} MB to the folder of temporary "
                f"files: {error.strerror or error}; set TMPDIR to a folder with free space"
            ) from error
        yield copy


def remove_parts(folder: Path) -> None:
    """Remove the temporary files of `atomic` below a folder, but those of other living processes.

    OSError where one cannot be removed.
    """
    for path in folder.rglob(".*.part"):
        match = _PART.fullmatch(path.name)
        if match is None or not path.is_file():
            continue
        # In a container the number of this process may be that of an earlier run.
        process = int(match[1])
        if process == os.getpid() or not psutil.pid_exists(process):
            path.unlink(missing_ok=True)


def write_netcdf(path: Path, dataset: xr.Dataset) -> None:
    """Write a dataset as compressed NetCDF 4, whole; ImpactfemError where it cannot be written."""
    encoding = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind == "f" and variable.size > 1000
    }
    # Made in memory first: HDF5 aborts the process when its own writing hits a full disk.
    whole = dataset.to_netcdf(engine="netcdf4", encoding=encoding)
    with atomic(path) as temporary:
        temporary.write_bytes(whole)


def write_json(path: Path, value: object) -> None:
    """Write a value as indented JSON, whole; nan and infinity are refused."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)
    with atomic(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def write_archive(path: Path, key: str, content: dict[str, Any]) -> None:
    """Write arrays and numbers by name, with the hash `key` of what they depend on."""
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
    """The arrays of a file by name; None without it, for another key and, warned of, if damaged."""
    try:
        # NumPy leaves a damaged file open that it has opened itself.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            # Large arrays of another run are not read.
            return dict(content) if str(content["key"]) == key else None
    except FileNotFoundError:
        return None
    except Exception as error:  # NumPy and zipfile raise many kinds for a damaged file
        LOGGER.warning("warning: %s is damaged (%s); computed again", path, error)
        return None


def _files_of(whole: Path) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the files of an archive; none without it, and none that is damaged."""
    try:
        archive = zipfile.ZipFile(whole)
    except FileNotFoundError:
        return
    except zipfile.BadZipFile as error:
        LOGGER.warning("warning: %s is damaged (%s); computed again", whole, error)
        return
    with archive:
        for name in archive.namelist():
            try:
                content = archive.read(name)
            except (zipfile.BadZipFile, zlib.error) as error:
                LOGGER.warning(
                    "warning: %s in %s is damaged (%s); computed again", name, whole, error
                )
            else:
                yield name, content


@contextmanager
def kept_in_one_file(folder: Path) -> Iterator[Path]:
    """Give a folder with the files of the archive `FOLDER.zip`, which replaces it at the end.

    After a failure or a kill the folder stays, and the next block continues with its files. A
    damaged file of the archive is left out, with a warning. ImpactfemError if a file cannot be
    written.
    """
    whole = folder.with_suffix(".zip")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in _files_of(whole):
        path = folder / Path(name).name
        if not path.exists():
            with atomic(path) as temporary:
                temporary.write_bytes(content)
    yield folder
    with (
        atomic(whole) as temporary,
        temporary.open("wb") as stream,
        zipfile.ZipFile(stream, "w") as archive,
    ):
        for path in sorted(folder.iterdir()):
            archive.write(path, path.name)
    shutil.rmtree(folder)


def read_bytes(path: Path, what: str, largest: float = LARGEST_FILE) -> bytes | Fault:
    """Return the content of a file, or the fault that says why there is none.

    `what` is expected, for the message, as ``a case file (TOML)``; `largest` is in bytes.
    """
    fault = unreadable(path, what, largest)
    if fault is not None:
        return fault
    try:
        content = path.read_bytes()
    except OSError as error:
        reason = f"cannot be read ({error.strerror or error})"
        return Fault(path, "", None, f"{reason}; expected {what}", "file")
    if content.strip():
        return content
    return Fault(path, "", None, f"the file is empty; expected {what}", "file")


def unreadable(path: Path, what: str, largest: float = LARGEST_FILE) -> Fault | None:
    """Return the fault of a file that is not there, no ordinary file or too large; else None.

    As `read_bytes`; nothing is read.
    """
    try:
        # From Python 3.14 on, `exists` and its like no longer say why a path cannot be looked at.
        status = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        # Of a path as Windows writes it.
        turned = str(path).replace("\\", "/")
        reason = (
            "no such file" if turned == str(path) else f"no such file; write / in paths: {turned}"
        )
    except (OSError, ValueError) as error:
        reason = f"cannot be read ({getattr(error, 'strerror', None) or error})"
    else:
        if stat.S_ISREG(status.st_mode) and status.st_size > largest:
            size, most = _size(status.st_size), _size(largest)
            return Fault(
                path, "", None, f"the file has {size}; expected at most {most}: {what}", "file"
            )
        reason = "" if stat.S_ISREG(status.st_mode) else "this is not an ordinary file"
        reason = "this is a directory" if stat.S_ISDIR(status.st_mode) else reason
    return Fault(path, "", None, f"{reason}; expected {what}", "file") if reason else None


def _size(count: float) -> str:
    """A number of bytes in words."""
    return f"{1e-9 * count:.4g} GB" if count >= 1e9 else f"{1e-6 * count:.3g} MB"


def read_text(path: Path, what: str, largest: float = LARGEST) -> str | Fault:
    """Return the text of a UTF-8 file, or the fault that says why there is none; as `read_bytes`.

    A byte order mark at the beginning, which spreadsheets write, is dropped; after that of UTF-16
    the file is read as such.
    """
    content = read_bytes(path, what, largest)
    if isinstance(content, Fault):
        return content
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = content.decode("utf-16" if wide else "utf-8-sig")
        position = text.find("\0")
        reason = f"NUL at position {position}" if position >= 0 else ""
    except UnicodeDecodeError as error:
        text, coding = "", "UTF-16" if wide else "UTF-8"
        reason = f"byte {content[error.start]:#04x} at position {error.start} is not {coding}"
    if not reason:
        return text
    save = "save it as text in UTF-8 (in a spreadsheet: CSV UTF-8)"
    return Fault(path, "", None, f"not a text file ({reason}); {save}; expected {what}", "file")


def wrong_separators(header: str) -> str | None:
    """What separates the columns of a CSV header in place of commas, in words; None for commas."""
    words = {";": "semicolons", "\t": "tabs"}
    return None if "," in header else next((words[sign] for sign in words if sign in header), None)

"""Arrays in one file, as NumPy's archive: written in one piece, read whole or not at all."""

from __future__ import annotations

import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

# What a file that is cut short, or has other bytes in it, makes NumPy and zipfile raise.
DAMAGE = (
    OSError,
    ValueError,
    KeyError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    TypeError,
    MemoryError,
    SyntaxError,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)


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
    except DAMAGE as error:
        LOGGER.warning("warning: %s is damaged (%s); computed again", path, error)
        return None

"""The folder of a run: an empty one, or that of an earlier run."""

from __future__ import annotations

import os
from pathlib import Path

from impactfem.errors import Fault, InputError
from impactfem.files import remove_parts

LOG = "run.log"  # tells the folder of a run from any other


def open_folder(folder: Path, resume: bool, log: str = LOG) -> None:
    """Make the folder of a run, or see that it may be used.

    What a killed run left half written is removed.

    Args:
        folder: The folder.
        resume: Whether it must hold a run already.
        log: Name of the log that tells such a folder from any other.

    Raises:
        InputError: The folder may not or cannot be used; nothing is written then.
    """
    try:
        if resume and not (folder / log).is_file():
            raise InputError([Fault(folder, "--resume", None, "a folder that holds a run")])
        if folder.exists() and not folder.is_dir():
            raise InputError([Fault(folder, "--out", None, "a folder, this is a file")])
        if folder.is_dir() and any(folder.iterdir()) and not (folder / log).is_file():
            expected = "an empty folder or one of an earlier run; this one holds other files"
            raise InputError([Fault(folder, "--out", None, expected)])
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, os.strerror(13))
        (folder / log).touch()
        remove_parts(folder)
    except OSError as error:
        expected = f"a folder that can be written: {error.strerror or error}"
        raise InputError([Fault(folder, "--out", None, expected)]) from error

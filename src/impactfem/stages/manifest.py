"""`<stage>.stage.json`: what a finished stage wrote, with the hash of each file."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, FiniteFloat


class Manifest(BaseModel):
    """What a finished stage wrote.

    Args:
        inputs: Hash of what it depends on.
        seconds: Wall time of each of its steps when it ran [s].
        peak_memory: Largest resident memory of all its processes [byte], if it is known.
        files: Hash of each file by its name, relative to the run's folder.
        drawn_from: Hash of what its tables and figures depend on; "" before they are drawn.
        drawings: Hash of each table and figure, as `files`.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    inputs: str
    seconds: dict[str, FiniteFloat]
    peak_memory: FiniteFloat | None = None
    files: dict[str, str]
    drawn_from: str = ""
    drawings: dict[str, str] = {}

    @property
    def every(self) -> dict[str, str]:
        """Hash of each file and each drawing by its name."""
        return self.files | self.drawings


def manifest_file(folder: Path, stage: str) -> Path:
    """The manifest of a stage in a run's folder."""
    return folder / f"{stage}.stage.json"


def read_manifest(folder: Path, stage: str) -> Manifest:
    """Read the manifest of a stage.

    Raises:
        OSError: There is none, or it cannot be read.
        ValueError: It is none.
    """
    return Manifest.model_validate_json(manifest_file(folder, stage).read_bytes())


def changed_file(folder: Path, files: Mapping[str, str]) -> Path | None:
    """The first file that is missing or is not as it was written; None when all are whole.

    Args:
        folder: The run's folder.
        files: Hash of each file by its name.
    """
    for name, digest in files.items():
        path = folder / name
        try:
            if not path.is_file() or file_digest(path) != digest:
                return path
        except OSError:
            return path
    return None


def file_digest(path: Path) -> str:
    """Hash of a file.

    Raises:
        OSError: It cannot be read.
    """
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()

"""`<stage>.stage.json`: what a finished stage wrote, and whether it may be reused."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, FiniteFloat

from impactfem.stages.stage import DRAWING
from impactfem.system.files import atomic, write_json
from impactfem.system.log import LOGGER


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


def is_finished(folder: Path, stage: str, key: str) -> bool:
    """Whether all files of a stage are there, whole, and made from the same inputs.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of its inputs now.
    """
    try:
        manifest = read_manifest(folder, stage)
    except FileNotFoundError:
        return False
    except (OSError, ValueError):
        LOGGER.warning("warning: %s is damaged; computed again", manifest_file(folder, stage))
        return False
    if manifest.inputs != key:
        return False
    changed = changed_file(folder, manifest.files)
    if changed is not None:
        LOGGER.warning("warning: %s is missing or was changed; computed again", changed)
    return changed is None


def is_drawn(folder: Path, stage: str, key: str) -> bool:
    """Whether all tables and figures of a finished stage are there, whole, and as now drawn.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of what they depend on now.
    """
    manifest = read_manifest(folder, stage)
    return manifest.drawn_from == key and changed_file(folder, manifest.drawings) is None


def mark_drawn(folder: Path, stage: str, key: str, files: list[Path], seconds: float) -> None:
    """Write down the tables and figures of a finished stage.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of what they depend on.
        files: All tables and figures, below the folder.
        seconds: Wall time [s].
    """
    manifest = read_manifest(folder, stage)
    drawn = {
        "drawn_from": key,
        "drawings": _digests(folder, files),
        "seconds": manifest.seconds | {f"{stage}: {DRAWING}": seconds},
    }
    write_json(manifest_file(folder, stage), manifest.model_dump() | drawn)


def mark_finished(
    folder: Path,
    stage: str,
    key: str,
    files: list[Path],
    seconds: dict[str, float],
    memory: float | None = None,
) -> None:
    """Write down what a stage computed, last of all: without it the stage is not finished.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of its inputs.
        files: All files that it wrote, below the folder.
        seconds: Wall time of each of its steps [s].
        memory: Largest resident memory of all its processes [byte], if it is known.
    """
    digests = _digests(folder, files)
    written = Manifest(inputs=key, seconds=seconds, peak_memory=memory, files=digests)
    write_json(manifest_file(folder, stage), written.model_dump())


def _digests(folder: Path, files: list[Path]) -> dict[str, str]:
    return {str(path.relative_to(folder)): file_digest(path) for path in sorted(files)}


def take_over(folder: Path, others: Iterable[Path], stage: str, key: str) -> Path | None:
    """Copy a stage that another run has finished with the same inputs.

    Args:
        folder: The run's folder.
        others: Folders of other runs, which need not exist.
        stage: Name of the stage.
        key: Hash of its inputs.

    Returns:
        The folder it was copied from; None when none has it, or this run has it already.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    if _claims(folder, stage, key):
        return None
    for other in others:
        if _claims(other, stage, key) and is_finished(other, stage, key):
            manifest = read_manifest(other, stage)
            drawn = changed_file(other, manifest.drawings) is None
            names = manifest.every if drawn else manifest.files
            for name in (*names, manifest_file(other, stage).name):  # the manifest last of all
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                with atomic(folder / name) as temporary:
                    shutil.copyfile(other / name, temporary)
            return other
    return None


def _claims(folder: Path, stage: str, key: str) -> bool:
    """Whether a run says that it has finished a stage with these inputs."""
    try:
        return read_manifest(folder, stage).inputs == key
    except (OSError, ValueError):
        return False

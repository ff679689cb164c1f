"""Finished stages: what a stage wrote, and whether it may be reused."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from impactfem.files import atomic, write_json
from impactfem.log import LOGGER


def is_finished(folder: Path, stage: str, key: str) -> bool:
    """Whether all files of a stage are there, whole, and made from the same inputs.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of its inputs now.
    """
    path = _manifest(folder, stage)
    try:
        manifest = _read(path)
        same = manifest["inputs"] == key
        listed = dict(manifest["files"])
    except FileNotFoundError:
        return False
    except (OSError, ValueError, KeyError, TypeError) as error:
        LOGGER.warning("%s cannot be read (%s); computed again", path, error)
        return False
    if not same:
        return False
    for name, digest in listed.items():
        path = folder / name
        if not path.is_file() or _file_digest(path) != digest:
            LOGGER.warning("%s is missing or was changed; computed again", path)
            return False
    return True


def mark_finished(
    folder: Path,
    stage: str,
    key: str,
    files: list[Path],
    seconds: dict[str, float],
    memory: float | None = None,
) -> None:
    """Write down what a stage wrote, last of all: without it the stage is not finished.

    Args:
        folder: The run's folder.
        stage: Name of the stage.
        key: Hash of its inputs.
        files: All files that it wrote, below the folder.
        seconds: Wall time of each of its steps [s].
        memory: Largest resident memory of all its processes [byte], if it is known.
    """
    listed = {str(path.relative_to(folder)): _file_digest(path) for path in sorted(files)}
    written = {"inputs": key, "seconds": seconds, "peak_memory": memory, "files": listed}
    write_json(_manifest(folder, stage), written)


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
            manifest = _manifest(other, stage)
            for name in [*_read(manifest)["files"], manifest.name]:  # the manifest last of all
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                with atomic(folder / name) as temporary:
                    shutil.copyfile(other / name, temporary)
            return other
    return None


def _claims(folder: Path, stage: str, key: str) -> bool:
    """Whether a run says that it has finished a stage with these inputs."""
    try:
        return bool(_read(_manifest(folder, stage))["inputs"] == key)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def seconds_of(folder: Path, stage: str) -> dict[str, float]:
    """Wall time of each step of a finished stage when it ran [s]."""
    seconds: dict[str, float] = _read(_manifest(folder, stage))["seconds"]
    return seconds


def memory_of(folder: Path, stage: str) -> float | None:
    """Largest resident memory of a finished stage when it ran [byte], if it is known."""
    memory: float | None = _read(_manifest(folder, stage)).get("peak_memory")
    return memory


def _manifest(folder: Path, stage: str) -> Path:
    return folder / f"{stage}.stage.json"


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _file_digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()

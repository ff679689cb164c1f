"""Finished stages: what a stage wrote, and whether it may be reused."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from impactfem.stages.manifest import (
    Manifest,
    changed_file,
    file_digest,
    manifest_file,
    read_manifest,
)
from impactfem.stages.stage import DRAWING
from impactfem.system.files import atomic, write_json
from impactfem.system.log import LOGGER


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
            names = [*_whole(other, read_manifest(other, stage)), manifest_file(other, stage).name]
            for name in names:  # the manifest last of all
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                with atomic(folder / name) as temporary:
                    shutil.copyfile(other / name, temporary)
            return other
    return None


def _whole(folder: Path, manifest: Manifest) -> dict[str, str]:
    """All files of a stage; those of its stores where a table or a figure was changed."""
    drawn = changed_file(folder, manifest.drawings) is None
    return manifest.every if drawn else manifest.files


def _claims(folder: Path, stage: str, key: str) -> bool:
    """Whether a run says that it has finished a stage with these inputs."""
    try:
        return read_manifest(folder, stage).inputs == key
    except (OSError, ValueError):
        return False


def seconds_of(folder: Path, stage: str) -> dict[str, float]:
    """Wall time of each step of a finished stage when it ran [s]."""
    return read_manifest(folder, stage).seconds


def memory_of(folder: Path, stage: str) -> float | None:
    """Largest resident memory of a finished stage when it ran [byte], if it is known."""
    return read_manifest(folder, stage).peak_memory

"""The files of a run that a report is made from."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import xarray as xr

from impactfem.errors import ImpactfemError
from impactfem.results.overview import OVERVIEW

CASE, SUMMARY, PROVENANCE, CHECKS = "case.json", "summary.json", "provenance.json", "checks.json"


class RunFiles:
    """A run's folder, read as far as it goes.

    Args:
        folder: The folder.

    Raises:
        ImpactfemError: It holds no finished run, or a file of it cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        missing = [name for name in (CASE, SUMMARY, PROVENANCE, CHECKS) if not self.has(name)]
        if missing:
            raise ImpactfemError(
                f"{folder} holds no run to report on: {', '.join(missing)} "
                f"{'is' if len(missing) == 1 else 'are'} missing; 'impactfem run CASE.toml' "
                "writes them"
            )
        self.case: dict[str, Any] = self._json(CASE, dict)
        self.summary: list[dict[str, Any]] = self._json(SUMMARY, list)
        self.provenance: dict[str, Any] = self._json(PROVENANCE, dict)
        self.checks: list[dict[str, Any]] = self._json(CHECKS, list)

    def has(self, name: str) -> bool:
        """Whether the run wrote a file of this name."""
        return (self.folder / name).is_file()

    @cached_property
    def values(self) -> dict[str, float]:
        """Scalar results in SI by their name, without those that have no value."""
        return {
            entry["name"]: entry["value"] for entry in self.summary if entry["value"] is not None
        }

    @property
    def stages(self) -> list[str]:
        """Names of the stages of the run, in order."""
        return list(self.provenance["inputs"])

    @contextmanager
    def store(self, name: str) -> Iterator[xr.Dataset]:
        """A store of the run, open.

        Raises:
            ImpactfemError: It cannot be read.
        """
        path = self.folder / name
        try:
            with xr.open_dataset(path, engine="h5netcdf") as store:
                yield store
        except OSError as error:
            raise ImpactfemError(f"cannot read {path}: {error}") from error

    def files_of(self, stage: str, part: str) -> list[Path]:
        """Files that a stage wrote into a part of the folder, by their names.

        The first stage's figures begin with those that show the run as a whole.

        Args:
            stage: Name of the stage.
            part: `figures` or `tables`.
        """
        listed = self._json(f"{stage}.stage.json", dict)["files"]
        wanted = [name for name in listed if Path(name).parent.name == part]
        whole = part == "figures" and stage == self.stages[0]
        overview = [f"{part}/{name}" for name in OVERVIEW if whole]
        return [
            *(self.folder / name for name in overview if self.has(name)),
            *sorted(self.folder / name for name in wanted),
        ]

    def _json(self, name: str, kind: type) -> Any:
        path = self.folder / name
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ImpactfemError(f"cannot read {path}: {error}") from error
        if not isinstance(content, kind):
            raise ImpactfemError(f"cannot read {path}: it is not what a run writes there")
        return content

"""The files of a run that a report is made from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import AbstractContextManager
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import Any

import xarray as xr
from pydantic import ValidationError

from impactfem.stages.manifest import (
    Label,
    Manifest,
    Provenance,
    changed_file,
    further_buildings,
    manifest_file,
    read_manifest,
)
from impactfem.stages.stores import open_store
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.log import LOGGER
from impactfem.system.scalar import alone

COMPARISON = "comparison"
"""What `impactfem compare` writes is listed as if it were a stage, which no run has."""
DRAWING, SPECTRA = "case", "decision_spectra"
SCENE = "building_scene.html"
"""Figures of the run as a whole."""
CASE, SUMMARY, PROVENANCE, CHECKS = "case.json", "summary.json", "provenance.json", "checks.json"
VERDICTS = "verdicts.json"


class RunFiles:
    """The folder of a finished run whose files are as the run wrote them.

    InputError where it holds no finished run, ImpactfemError where a file is missing or changed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.part = folder, ""
        missing = [name for name in (CASE, SUMMARY, PROVENANCE, CHECKS) if not self.has(name)]
        if missing:
            expected = (
                f"the folder holds no run to report on: {', '.join(missing)} "
                f"{'is' if len(missing) == 1 else 'are'} missing; expected what "
                "'impactfem run CASE.toml' writes"
            )
            raise InputError([Fault(folder, "", None, expected)])
        # HDF5 may crash on a damaged store: nothing is opened before all are known to be whole.
        path = folder / PROVENANCE
        try:
            made = Provenance.model_validate_json(path.read_bytes())
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise _damaged(path, f"{where}: {first['msg']}" if where else first["msg"]) from error
        except OSError as error:
            raise _damaged(path, error.strerror or str(error)) from error
        self._refuse_changed(made.files)
        for stage, inputs in made.inputs.items():
            manifest = self._manifest(stage)
            if manifest.inputs != inputs:
                reason = f"the stage has other inputs than in {PROVENANCE}"
                raise _damaged(manifest_file(folder, stage), reason)
            self._refuse_changed(manifest.every)
        # In a folder of the run are the stages of a further building with a 3D model, or all those
        # of another run.
        below = folder.glob("*/*.stage.json")
        further = [one for one in below if not (one.parent / PROVENANCE).is_file()]
        for path in sorted([*folder.glob("*.stage.json"), *further]):
            stage = str(path.relative_to(folder)).removesuffix(".stage.json")
            # Of an earlier run, whose files may have been removed; a comparison is checked below.
            if stage not in made.inputs and stage != COMPARISON:
                listed = self._manifest(stage).every
                self._refuse_changed({n: digest for n, digest in listed.items() if self.has(n)})
        self.provenance: dict[str, Any] = made.model_dump()
        self.case: dict[str, Any] = self._json(CASE)
        #: Names of further buildings with a 3D model, which have folders of their own.
        self.further = further_buildings(self.case, folder / CASE)
        self.summary: list[dict[str, Any]] = self._json(SUMMARY)
        self.checks: list[dict[str, Any]] = self._json(CHECKS)
        #: Demands with their capacities; none in a run of version 0.2 or before.
        self.verdicts: list[dict[str, Any]] = self._json(VERDICTS) if self.has(VERDICTS) else []

    def has(self, name: str) -> bool:
        """Whether the run wrote a file of this name."""
        return (self.folder / name).is_file()

    def ran(self, stage: str) -> bool:
        """Whether the run has a stage: a store may be there of an earlier run."""
        return (f"{self.part}/{stage}" if self.part else stage) in self.stages

    @cached_property
    def values(self) -> dict[str, float]:
        """Scalar results in SI by their name, without those that have no value."""
        return {one["name"]: one["value"] for one in self.summary if one["value"] is not None}

    @property
    def stages(self) -> list[str]:
        """Names of the stages of the run, in order; `B2/reduce` of a further building."""
        return list(self.provenance["inputs"])

    @property
    def models(self) -> dict[str, RunFiles]:
        """The files of each building with a 3D model, the first one's first."""
        structure = self.case["structure"]
        first = {structure["building"]: self} if structure else {}
        return first | {name: self.of(name) for name in self.further}

    def of(self, building: str) -> RunFiles:
        """The files and results of a further building, by the names that they have alone."""
        found = copy(self)
        found.folder, found.part = self.folder / building, building
        known = {alone(name, building): value for name, value in self.values.items()}
        found.values = {name: value for name, value in known.items() if name is not None}
        return found

    def named(self, title: str, stage: str) -> str:
        """The title of a stage, of several 3D models with the name of the building."""
        of_case = ("pounding", "ensemble", "equipment", "sensitivity", COMPARISON)
        if not self.further or stage in of_case:
            return title
        building = Label.of(stage).part or self.case["structure"]["building"]
        return f"{title}: {building}"

    @property
    def inputs_key(self) -> str:
        """Hash of the inputs of all stages."""
        return hashlib.sha256(json.dumps(self.provenance["inputs"]).encode()).hexdigest()

    @cached_property
    def compared(self) -> bool:
        """Whether the folder has a comparison with another run, whole and of these results."""
        if not manifest_file(self.folder, COMPARISON).is_file():
            return False
        try:
            manifest = read_manifest(self.folder, COMPARISON)
            made_of_these = manifest.inputs == self.inputs_key
            whole = changed_file(self.folder, manifest.files) is None
        except (OSError, ValueError):
            made_of_these = whole = False
        if not (made_of_these and whole):
            LOGGER.warning(
                "warning: the comparison with another run in %s is of other results, or damaged, "
                "and not shown; 'impactfem compare' makes it again",
                self.folder,
            )
        return made_of_these and whole

    def store(self, name: str) -> AbstractContextManager[xr.Dataset]:
        """A store of the run, to be opened by `with`."""
        return open_store(self.folder / name)

    def files_of(self, stage: str, part: str) -> list[Path]:
        """Files that a stage wrote into `figures` or `tables`, by their names."""
        names = sorted(n for n in self._manifest(stage).every if Path(n).parent.name == part)
        return [self.folder / name for name in names]

    def _manifest(self, stage: str) -> Manifest:
        try:
            return read_manifest(self.folder, stage)
        except (OSError, ValueError) as error:
            reason = "it is not what a run writes there"
            raise _damaged(manifest_file(self.folder, stage), reason) from error

    def _refuse_changed(self, files: Mapping[str, str]) -> None:
        changed = changed_file(self.folder, files)
        if changed is not None:
            raise _damaged(changed, "it is missing, or not as the run wrote it")

    def _json(self, name: str) -> Any:
        return json.loads((self.folder / name).read_text(encoding="utf-8"))


def _damaged(path: Path, reason: str) -> ImpactfemError:
    return ImpactfemError(f"cannot read {path}: {reason}; 'impactfem run' writes it again")

"""`<stage>.stage.json`: the files of a finished stage, and the inputs for its reuse.

`provenance.json`: the origin of a run, so that it can be made again.
"""

import hashlib
import platform
import re
import shutil
import sys
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, FiniteFloat

import impactfem
from impactfem.stages.inputs import program_key
from impactfem.system.errors import CONTROL, Fault, InputError
from impactfem.system.files import atomic, write_json
from impactfem.system.log import LOGGER

PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "netCDF4",
    "pydantic",
    "pint",
    "matplotlib",
    "fenics-dolfinx",
    "petsc4py",
    "slepc4py",
    "mpi4py",
    "gmsh",
    "pyvista",
)
"""Packages whose versions a run records."""


def _inner(name: str) -> str:
    """Check the name of a file below the folder of a run, which may come from somebody else."""
    parts = name.split("/")
    if {"", ".", ".."} & set(parts) or CONTROL.search(name):
        raise ValueError("expected the name of a file below the folder of the run")
    return name


def _drawn(name: str) -> str:
    if name.rpartition("/")[0].rpartition("/")[2] not in DRAWN:
        raise ValueError(f"expected a file in one of the folders {', '.join(DRAWN)}")
    return name


DRAWN = ("figures", "tables", "products")
"""Folders of tables and figures: other files are not removed with the drawings of a stage."""
InnerName = Annotated[str, AfterValidator(_inner)]
DrawnName = Annotated[InnerName, AfterValidator(_drawn)]


def further_buildings(case: Mapping[str, Any], file: Path) -> list[str]:
    """Return the further buildings with a 3D model in `case.json`, which name folders of the run.

    InputError where one is not the name of a folder.
    """
    names = [one["building"] for one in case.get("further_structures", ())]
    for name in names:
        if not isinstance(name, str) or not re.fullmatch("[A-Za-z][A-Za-z0-9_-]*", name):
            expected = "expected a name of letters, digits, '_' and '-'"
            raise InputError([Fault(file, "further_structures.building", name, expected)])
    return names


class Manifest(BaseModel):
    """The files of a finished stage, and their inputs."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    inputs: str  #: hash of what it depends on
    seconds: dict[str, FiniteFloat]  #: wall time of each of its steps when it ran [s]
    #: largest resident memory of all its processes [byte], if it is known
    peak_memory: FiniteFloat | None = None
    files: dict[InnerName, str]  #: hash of each file by its name, relative to the run's folder
    drawn_from: str = ""  #: hash of what its tables and figures depend on; "" before they are drawn
    drawings: dict[DrawnName, str] = {}  #: hash of each table and figure, as `files`

    @property
    def every(self) -> dict[str, str]:
        """Hash of each file and each drawing by its name."""
        return self.files | self.drawings


class Label(NamedTuple):
    """A stage in a run, as in `B2/reduce`."""

    part: str  #: the building in whose folder it is; "" for that of the run
    stage: str

    @classmethod
    def of(cls, text: str) -> Self:
        """Read it."""
        part, _, stage = text.rpartition("/")
        return cls(part, stage)


def manifest_file(folder: Path, stage: str) -> Path:
    """Return the path of the manifest of a stage, by its label in a run."""
    return folder / f"{stage}.stage.json"


def read_manifest(folder: Path, stage: str) -> Manifest:
    """Read a manifest; OSError where it cannot be read, ValueError where it is damaged."""
    return Manifest.model_validate_json(manifest_file(folder, stage).read_bytes())


def changed_file(folder: Path, files: Mapping[str, str]) -> Path | None:
    """Return the first file of a folder that is missing or was changed; None for none."""
    for name, digest in files.items():
        path = folder / name
        try:
            if not path.is_file() or file_digest(path) != digest:
                return path
        except OSError:
            return path
    return None


def file_digest(path: Path) -> str:
    """Compute the hash of the content of a file."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def is_finished(folder: Path, stage: str, key: str) -> bool:
    """Return whether all files of a stage exist, unchanged, from inputs with the hash `key`."""
    try:
        manifest = read_manifest(folder, stage)
    except FileNotFoundError:
        return False
    except (OSError, ValueError):
        LOGGER.warning("warning: %s is damaged; not reused", manifest_file(folder, stage))
        return False
    if manifest.inputs != key:
        return False
    changed = changed_file(folder, manifest.files)
    if changed is not None:
        LOGGER.warning("warning: %s is missing or was changed; not reused", changed)
    return changed is None


def mark_finished(
    folder: Path,
    stage: str,
    key: str,
    files: list[Path],
    seconds: dict[str, float],
    memory: float | None = None,
) -> None:
    """Record the files of a stage, as its last step: without it the stage is not finished.

    `files` are all that it wrote, below the folder; `seconds` is the wall time of each of its steps
    [s], `memory` the largest resident memory of all its processes [byte], if it is known.
    """
    found = digests(folder, files)
    written = Manifest(inputs=key, seconds=seconds, peak_memory=memory, files=found)
    write_json(manifest_file(folder, stage), written.model_dump())


def remove_drawings(folder: Path, stage: str) -> None:
    """Remove the tables and figures of a stage whose results are others now."""
    try:
        drawings = read_manifest(folder, stage).drawings
    except (OSError, ValueError):
        return  # not finished before, or damaged: what it drew is not known
    for name in drawings:
        (folder / name).unlink(missing_ok=True)


def digests(folder: Path, files: list[Path]) -> dict[str, str]:
    """Compute the hash of each file by its name, relative to the folder."""
    return {str(path.relative_to(folder)): file_digest(path) for path in sorted(files)}


def take_over(folder: Path, others: Iterable[Path], stage: str, key: str) -> Path | None:
    """Copy a stage that another run has finished with the same inputs; it need not exist.

    Gives the folder it was copied from; None when none has it, or this run has it already.
    ImpactfemError where a file cannot be written.
    """

    def manifest_of(run: Path) -> Manifest | None:
        """Of a run with these inputs."""
        try:
            manifest = read_manifest(run, stage)
        except (OSError, ValueError):
            return None
        return manifest if manifest.inputs == key else None

    if manifest_of(folder) is not None:
        return None
    for other in others:
        manifest = manifest_of(other)
        if manifest is not None and is_finished(other, stage, key):
            drawn = changed_file(other, manifest.drawings) is None
            names = manifest.every if drawn else manifest.files
            own = str(manifest_file(other, stage).relative_to(other))
            for name in (*names, own):  # the manifest as the last
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                with atomic(folder / name) as temporary:
                    shutil.copyfile(other / name, temporary)
            return other
    return None


class Provenance(BaseModel):
    """The origin of a run."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    impactfem: str  #: version of the program
    sources: str  #: hash of its sources
    python: str  #: version of Python
    system: str  #: name, release and processor of the system
    command: list[str]  #: the command with its arguments
    packages: dict[str, str]  #: version of each package that the program stands on
    case: str  #: name of the case file
    case_hash: str  #: hash of the case and all files that it names
    input_files: dict[str, str]  #: hash of each of these by its name
    inputs: dict[InnerName, str]  #: hash of the inputs of each stage, in the order of the stages
    needs: dict[str, list[str]]  #: names of the stages that each stage needs directly
    seeds: dict[str, int]  #: seeds of motions, calibration and ensemble by their keys in the case
    started: str  #: when the run began
    reused: list[str]  #: names of the stages that had finished before
    seconds: dict[str, FiniteFloat]  #: wall time of each step by stage and step [s]
    peak_memory: dict[str, FiniteFloat | None]  #: largest of each stage [byte]; None: not known
    ranks: int  #: number of processes
    files: dict[InnerName, str]  #: hash of each file that says what all stages found, by its name


def provenance(**facts: Any) -> dict[str, Any]:
    """Return the versions of the program and its packages, with the facts of a run."""
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return {
        "impactfem": impactfem.__version__,
        "sources": program_key(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "command": ["impactfem", *sys.argv[1:]],
        "packages": versions,
        **facts,
    }

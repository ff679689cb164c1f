"""The folder of a run: one run at a time works in it; then it is open for reading.

    from impactfem.study import open_run

    run = open_run("runs/npp_pair")
    run.value("pounding.peak_force.floor_8")
    run.transient.acceleration.sel(probe="edge_8", component="y").plot()

Its scalar results are read by name, its stores as xarray's data sets. Nothing is computed, and
neither dolfinx nor VTK is loaded. `docs/run-folder.md` describes the results and the variables.
"""

from __future__ import annotations

import errno
import json
import os
import re
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from copy import copy
from dataclasses import dataclass, replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import pandas as pd
import xarray as xr
from filelock import FileLock, Timeout

from impactfem.case import Case
from impactfem.case.device_tables import read_given_spectra
from impactfem.device.spectrum import AnchorSpectrum, given_spectra
from impactfem.plot.table import Table
from impactfem.run.stages import OF_CASE, STAGES
from impactfem.stages.manifest import further_buildings
from impactfem.stages.stores import open_store
from impactfem.system.errors import CONTROL, Fault, InputError
from impactfem.system.files import NO_LOCKS, remove_parts
from impactfem.system.log import LOGGER
from impactfem.system.scalar import alone, scalars_of

if TYPE_CHECKING:
    from impactfem.run.plots import RunPlots

LOG = "run.log"  # distinguishes the folder of a run from any other
LOCK = ".lock"
PATIENCE = 0.1
"""Time in which a lock is tried again [s], as its holder may be removing the file just now."""
A_FILE = "'{}' is a file, not a folder: move it, or type another folder"
CASE_LINE = re.compile(r" DEBUG   case (.+), hash ([0-9a-f]{64})$")
STORES = {name: file for stage in STAGES for name, file in stage.stores.items()}
"""Files of the stores by the name of the attribute that opens them."""
SHARED = {name for stage in OF_CASE for name in stage.stores}
"""Those that serve all buildings of a run."""


@contextmanager
def open_folder(folder: Path, resume: bool, log: str = LOG) -> Iterator[None]:
    """Make or check the folder of a run, and keep other runs out while the block runs.

    Half-written files of a killed run are removed. With `resume` it must hold a run already; a
    folder of runs has the log of this name. Not collective: rank 0 opens it for all. InputError
    where the folder may not or cannot be used, or another run works in it; nothing is written then.
    """
    with ExitStack() as held:
        try:
            if resume and not (folder / log).is_file():
                raise _refused(folder, "--resume", "expected a folder that holds a run")
            if CONTROL.search(str(folder)):
                raise _refused(folder, "--out", "expected a name without control characters")
            if folder.exists() and not folder.is_dir():
                raise _refused(folder, "--out", A_FILE.format(folder))
            if folder.is_dir() and any(folder.iterdir()) and not (folder / log).is_file():
                expected = "expected an empty folder or one of an earlier run"
                raise _refused(folder, "--out", f"{expected}; this one holds other files")
            _refuse_links(folder, "--out")
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            (folder / log).touch()
            held.enter_context(locked(folder, "--out"))
            remove_parts(folder)
        except OSError as error:
            raise _not_writable(folder, "--out", error) from error
        yield


@contextmanager
def locked(folder: Path, key: str = "") -> Iterator[None]:
    """Keep other runs out of the folder of a run while the block runs. Not collective.

    The kernel releases the lock when the process ends, however it ends. InputError where another
    run works in it, or it cannot be written; `key` is the option that names it on the command line,
    "" for an argument.
    """
    path = folder / LOCK
    with ExitStack() as held:
        try:
            _refuse_links(folder, key)
            held.enter_context(FileLock(path, timeout=PATIENCE, fallback_to_soft=False))
            path.write_text(f"process {os.getpid()} on {socket.gethostname()}\n", encoding="utf-8")
        except Timeout:
            holder = path.read_text(errors="replace").strip() if path.is_file() else ""
            expected = f"expected a folder in which no other run works; {holder or 'one'} does now"
            raise _refused(folder, key, expected) from None
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise _not_writable(folder, key, error) from error
            LOGGER.warning(
                "warning: %s cannot be locked (%s). A second run in this folder would not be "
                "refused, and would mix its files with those of this run. Start no other run there",
                folder,
                error.strerror,
            )
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()  # before the lock is released: nobody holds a file that is removed


def check_same_case(folder: Path, case: Case) -> None:
    """Refuse to resume the run in a folder with a case of other content, whatever its name.

    InputError where the last run in the folder had another case.
    """
    lines = (folder / LOG).read_text(encoding="utf-8", errors="replace").splitlines()
    before = [found for line in lines if (found := CASE_LINE.search(line)) is not None]
    # A run that was stopped before it knew its case has computed nothing.
    if before and before[-1][2] != case.content_hash():
        name, digest = before[-1].groups()
        expected = (
            f"the folder holds a run of {name} with the hash {digest[:12]}, and {case.path.name} "
            f"has the hash {case.content_hash()[:12]}: one or more of its texts or files differ; "
            "expected the same case (without --resume what has changed is computed again)"
        )
        raise _refused(folder, "--resume", expected)


def _refuse_links(folder: Path, key: str) -> None:
    """Refuse symbolic links in a folder: files written there would land elsewhere."""
    for path in folder.rglob("*"):
        if path.is_symlink():
            name = path.relative_to(folder)
            raise _refused(folder, key, f"expected no symbolic links in it; {name} is one")


def _refused(folder: Path, key: str, expected: str) -> InputError:
    """The error for a folder that an option names, or, without a key, an argument."""
    if key:
        return InputError([Fault("command line", key, str(folder), expected)])
    return InputError([Fault(folder, "", None, expected)])


def _not_writable(folder: Path, key: str, error: OSError) -> InputError:
    if isinstance(error, NotADirectoryError | FileExistsError):
        path = next(one for one in (folder, *folder.parents) if one.is_file())
        return _refused(folder, key, A_FILE.format(path))
    expected = f"expected a folder that can be written: {error.strerror or error}"
    return _refused(folder, key, expected)


@dataclass(frozen=True)
class Entry:
    """A scalar result as `summary.json` has it."""

    name: str  #: dotted name
    value: float | None  #: in SI; None when it does not exist
    unit: str  #: SI unit; "-" when it has none
    paper: float | None  #: the published value; None where there is none
    note: str  #: what to know when reading it
    #: What the publication states: "=", or ">" or "<" its value; None without.
    relation: str | None = None
    #: "result", or "input", "fitted", "scaled", "selected" or "derived", where the published value
    #: tests nothing; None without.
    kind: str | None = None


def open_run(folder: str | os.PathLike[str]) -> Run:
    """Open the folder of a run; InputError where it holds none."""
    return Run(Path(folder))


class Run:
    """A run's folder. Stores are opened when they are used first, and read as far as necessary.

    Close it, or use it in a `with` statement, before the case is run again.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._open = ExitStack()
        path = folder / "summary.json"
        try:
            entries = json.loads(path.read_text(encoding="utf-8"))
            self.summary = {entry["name"]: Entry(**entry) for entry in entries}
        except FileNotFoundError as error:
            expected = (
                "missing; expected the folder of a run, as 'impactfem run CASE.toml' writes it"
            )
            raise InputError([Fault(path, "", None, expected)]) from error
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise InputError([Fault(path, "", None, f"cannot be read ({error})")]) from error
        self._building = ""

    def of(self, building: str) -> Run:
        """What the run has of a building with a 3D model, by the names that it has alone.

            run.of("B2").building.frequency

        Of the first one this is the run itself; stores of the whole run are those of all.
        InputError where the run has no 3D model of it.

        Args:
            building: Its name.
        """
        if building not in self.buildings_3d:
            known = ", ".join(self.buildings_3d) or "none"
            expected = f"the buildings with a 3D model are: {known}"
            path = self.folder / "case.json"
            raise InputError([Fault(path, "structure.building", building, expected)])
        if building == self.buildings_3d[0]:
            return self
        found = copy(self)
        found.folder, found._building, found._open = self.folder / building, building, ExitStack()
        self._open.callback(found.close)
        known_as = {alone(name, building): entry for name, entry in self.summary.items()}
        found.summary = {
            name: replace(entry, name=name) for name, entry in known_as.items() if name is not None
        }
        for name in STORES:
            found.__dict__.pop(name, None)
        return found

    @cached_property
    def case(self) -> dict[str, Any]:
        """The case in SI, as `case.json` has it."""
        text = (self.folder / "case.json").read_text(encoding="utf-8")
        return dict(json.loads(text))

    @property
    def buildings_3d(self) -> tuple[str, ...]:
        """Names of the buildings with a 3D model, the first one of the case first."""
        first = (self.case.get("structure") or {}).get("building", "")
        further = further_buildings(self.case, self.folder / "case.json")
        return tuple(name for name in (first, *further) if name)

    @property
    def plot(self) -> RunPlots:
        """Plots: `run.plot.floor_spectrum(building, floor)`, `.gap(pair)`, `.building(field)`."""
        from impactfem.run.plots import RunPlots  # matplotlib and its colour bars load slowly

        return RunPlots(self)

    def to_dataframe(self) -> pd.DataFrame:
        """Return all scalar results: name as index; value, unit, published value and note."""
        rows = [(one.value, one.unit, one.paper, one.note) for one in self.summary.values()]
        columns = ["value", "unit", "published", "note"]
        return pd.DataFrame(rows, index=pd.Index(self.summary, name="result"), columns=columns)

    def __repr__(self) -> str:
        impacts = self.summary.get("pounding.impacts")
        count = "" if impacts is None or impacts.value is None else f"{impacts.value:.0f} impacts, "
        return (
            f"<Run {str(self.folder)!r}: {self.case['title']!r}, {count}{len(self.summary)} "
            f"scalar results, stores: {', '.join(self.stores) or 'none'}>"
        )

    @property
    def stores(self) -> tuple[str, ...]:
        """Names of the stores that the run has."""
        return tuple(name for name in STORES if self._path(name).is_file())

    def _path(self, name: str) -> Path:
        shared = self._building and name in SHARED
        return (self.folder.parent if shared else self.folder) / STORES[name]

    @cached_property
    def details(self) -> dict[str, Entry]:
        """The scalar results of the results files by name, also those not in `summary.json`."""
        scalars = (
            scalar
            for name in self.stores
            if "result" in (store := getattr(self, name)).dims
            for scalar in scalars_of(store)
        )
        return {one.name: Entry(one.name, one.value, one.unit, None, one.note) for one in scalars}

    def value(self, name: str) -> float:
        """A scalar result in SI, of `summary.json` or of a results file.

        InputError where there is none of this name, or it has no value.
        """
        entry = self.summary.get(name) or self.details.get(name)
        if entry is not None and entry.value is not None:
            return entry.value
        if entry is not None:
            expected = f"the result has no value in this run. {entry.note}".strip()
        else:
            near = get_close_matches(name, [*self.summary, *self.details], n=1)
            expected = "expected the name of a result" + (
                f"; did you mean '{near[0]}'?" if near else ""
            )
        raise InputError([Fault(self.folder / "summary.json", name, None, expected)])

    def anchor_spectra(
        self, building: str, floor: int, *, rotations: bool = False
    ) -> tuple[AnchorSpectrum, ...]:
        """Broadened floor spectra, as the input of a response spectrum analysis.

            spectrum_analysis(device, run.anchor_spectra("B2", 3)).value("force y")

        They are those of `products/floor_spectra.csv`: of the sticks, along the directions of the
        ground motions. InputError where the run has no spectra of this floor.

        Args:
            building: Its name; a stick is enough.
            floor: Number of the floor, from 1.
            rotations: Whether the spectra of the floor's rotations, of
                `products/floor_rotations.nc`, are inputs as well, where it turns.
        """
        path, faults = self.folder / "products" / "floor_spectra.csv", list[Fault]()
        known = read_given_spectra(path, faults)
        if known is not None:
            faults += [Fault(path, "", None, text) for text in known.lacks(building, [floor])]
        if known is None or faults:
            raise InputError(faults)
        found = given_spectra(known.at(building, [floor]))
        turned = self.folder / "products" / "floor_rotations.nc"
        if not rotations or not turned.is_file():
            return found
        with open_store(turned) as store:
            spectra = store.sel(station=f"{building}.floor_{floor}")
            return found + tuple(
                AnchorSpectrum(
                    component=str(one["direction"].item()),
                    frequency=one["design_frequency"].values,
                    damping=one["damping"].values,
                    psa=one["broadened"].transpose("damping", "design_frequency").values,
                    zpa=one["zpa"].item(),
                )
                for one in (spectra.isel(direction=k) for k in range(spectra.sizes["direction"]))
            )

    def table(self, *patterns: str) -> Table:
        """Scalar results with their units and, where there are some, the published values.

        Args:
            patterns: Names, in which * stands for any letters; all results without any.
        """
        rows = tuple(
            (entry.name, entry.value, entry.unit, entry.paper)
            for entry in self.summary.values()
            if not patterns or any(fnmatchcase(entry.name, pattern) for pattern in patterns)
        )
        columns = (("result", ""), ("value", ""), ("unit", ""), ("published", ""))
        return Table("summary", str(self.folder), columns, rows).comparing({"published"})

    def __getattr__(self, name: str) -> xr.Dataset:
        """A store by its name, as `run.transient`: those of `STORES`.

        InputError where the run has no such store.
        """
        if name not in STORES:
            raise AttributeError(name)
        path = self._path(name)
        if not path.is_file():
            found = ", ".join(self.stores) or "none"
            expected = f"missing; the stores of this run are: {found}"
            raise InputError([Fault(path, "", None, expected)])
        store = self._open.enter_context(open_store(path))
        setattr(self, name, store)
        return store

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.stores]

    def close(self) -> None:
        """Close the stores."""
        self._open.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

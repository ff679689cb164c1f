"""Stores of a run: the declared outputs of a stage, how they are written and opened.

Each stage has one table of outputs in its `store.py`: name, dimensions, unit, long name. A label is
a coordinate that says what the entries of a dimension are, as `station_floor` does of `station`:
readers select by it.

    top = store.isel(station=store.station_floor == 8)
    top.psa.sel(direction="y", damping=0.05)
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.dynamics.damping import DampingLaw, RatioTable, Rayleigh
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.scalar import Scalar, with_scalars

FORMAT = 2
"""Version of the layout of stores; 0.1 had none, and its scalars in an attribute."""
LOADED = 1 << 23
"""Size up to which an output is read when its store is opened [byte]. From a list of entries
netCDF4 reads each by itself, and of an empty one it may fail."""

# What xarray and HDF5 raise for a file that is missing, of another kind, or damaged.
DAMAGE = (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError)


@dataclass(frozen=True)
class Output:
    """The declaration of one variable of a store."""

    dims: str  #: its dimensions, by a blank between them; "" for a single number
    #: SI unit, "-" for a number without one; "" for words, numbers of things and flags.
    unit: str = ""
    long_name: str = ""  #: what it is, where its name does not say it
    label: bool = False  #: whether it says what the entries of its dimension are
    shown: str = ""  #: unit in tables; "" for the SI unit


def dataset(
    outputs: Mapping[str, Output],
    values: Mapping[str, Any],
    *,
    attributes: Mapping[str, Any],
    scalars: Iterable[Scalar] | None = None,
    notes: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Results as a store, with dimensions, units and labels, by the declared outputs of the stage.

    An output that a run does not have is left out. Attributes hold for the store as a whole: title,
    hashes, words; scalars are None where another store has them; notes are of single outputs of
    this run. ValueError where a result is not declared, has other dimensions or has no unit.
    """
    fields: dict[str, xr.Variable] = {}
    for name, value in values.items():
        if name not in outputs:
            raise ValueError(f"{name} is no declared output")
        output = outputs[name]
        array = np.asarray(value)
        if array.dtype.kind in "UO":
            array = np.array(value, dtype=object)
        elif array.dtype.kind == "f" and array.size and not output.unit:
            raise ValueError(f"{name} is declared without a unit")
        about = {"units": output.unit, "long_name": output.long_name, "shown": output.shown}
        about["note"] = (notes or {}).get(name, "")
        about = {key: text for key, text in about.items() if text}
        fields[name] = xr.Variable(output.dims.split(), array, about)
    labels = [name for name in fields if outputs[name].label or outputs[name].dims == name]
    found = xr.Dataset(
        {name: field for name, field in fields.items() if name not in labels},
        coords={name: fields[name] for name in labels},
        attrs={"format": FORMAT, **attributes},
    )
    return found if scalars is None else with_scalars(found, scalars)


def damping_outputs(dimension: str) -> dict[str, Output]:
    """Outputs that describe laws of damping, those of damping cases or of buildings."""
    return {
        "mass_coefficient": Output(dimension, "1/s", "α of Rayleigh damping"),
        "stiffness_coefficient": Output(dimension, "s", "β of Rayleigh damping"),
        "law_frequency": Output("law_frequency", "Hz", "at which the laws of damping are given"),
        "law_ratio": Output(f"{dimension} law_frequency", "-", "damping ratio by the law"),
    }


def damping_values(laws: Sequence[DampingLaw]) -> dict[str, Any]:
    """Laws of damping as `damping_outputs`, at the points of their tables, too."""
    points = [law.frequency for law in laws if isinstance(law, RatioTable)]
    frequency = np.unique(np.concatenate([np.geomspace(0.1, 1e3, 401), *points]))
    return {
        "mass_coefficient": [law.coefficients[0] for law in laws],
        "stiffness_coefficient": [law.coefficients[1] for law in laws],
        "law_frequency": frequency,
        "law_ratio": [law.ratio(frequency) for law in laws],
    }


def damping_of(one: xr.Dataset) -> DampingLaw:
    """The law of one damping case or building of a store, from `damping_outputs`."""
    α, β = float(one["mass_coefficient"]), float(one["stiffness_coefficient"])
    if np.isfinite(α):
        return Rayleigh(α, β)
    return RatioTable(tuple(one["law_frequency"].values), tuple(one["law_ratio"].values))


@contextmanager
def open_store(path: Path) -> Iterator[xr.Dataset]:
    """Give the store in a NetCDF file, open until the block ends; no one may change it.

    ImpactfemError where it is missing, cannot be read or is of another version.
    """
    if (kept := _KEPT.get()) is not None:
        # A file that is written again is another one.
        state = path.stat() if path.is_file() else None
        yield kept(path, state and (state.st_ino, state.st_mtime_ns))
        return
    with _opened(path) as store:
        yield store


@contextmanager
def stores_kept_open() -> Iterator[None]:
    """Within the block a store that was opened stays open for who opens it next.

    Opening one takes some 30 ms, as all of its outputs are read, and a page opens one 30 times.
    """
    if _KEPT.get() is not None:
        yield
        return
    with ExitStack() as opened:
        token = _KEPT.set(cache(lambda path, _: opened.enter_context(_opened(path))))
        try:
            yield
        finally:
            _KEPT.reset(token)


_KEPT: ContextVar[Callable[[Path, object], xr.Dataset] | None] = ContextVar(
    "opens stores that stay open", default=None
)


def _names_of_files(store: xr.Dataset) -> Iterator[str]:
    """The texts of a store of which names of files are made."""
    yield str(store.attrs.get("building", ""))
    for name in ("building", "component", "device", "direction", "pair", "probe", "station"):
        if name in store.coords and store[name].dtype.kind in "OUST":
            yield from map(str, np.atleast_1d(store[name].values))


@contextmanager
def _opened(path: Path) -> Iterator[xr.Dataset]:
    try:
        store = xr.open_dataset(path, engine="netcdf4")
    except DAMAGE as error:
        raise ImpactfemError(f"cannot read {path}: {error}") from error
    with store:
        if "scalars" in store.attrs or store.attrs.get("format", FORMAT) != FORMAT:
            raise ImpactfemError(f"{path} is of another version; run the case again")
        try:
            for variable in store.variables.values():
                if variable.nbytes <= LOADED:
                    variable.load()
            outside = [one for one in _names_of_files(store) if ".." in one.split("/")]
        except DAMAGE as error:
            raise ImpactfemError(f"cannot read {path}: {error}") from error
        if outside:
            raise ImpactfemError(f"cannot read {path}: {outside[0]!r} would name another folder")
        yield store


def of_run(folder: Path, name: str) -> Path:
    """A file that serves all buildings of a run: in a folder, or where that of the run is."""
    own, shared = folder / name, folder.parent / name
    return shared if shared.is_file() and not own.is_file() else own


@contextmanager
def open_stores(folder: Path) -> Iterator[Callable[[str], xr.Dataset]]:
    """Give a function that opens a store of a run by its file name, as `open_store`."""
    with ExitStack() as stores:
        yield lambda name: stores.enter_context(open_store(of_run(folder, name)))


def padded(arrays: Sequence[Array]) -> Array:
    """Arrays of unequal sizes as one, along a new first axis, filled up with nan."""
    found = np.full((len(arrays), *np.max([one.shape for one in arrays], axis=0)), np.nan)
    for row, one in zip(found, arrays, strict=True):
        row[tuple(slice(size) for size in one.shape)] = one
    return found


def number_of(store: xr.Dataset, name: str, **labels: str) -> float:
    """A number of a store that a later stage computes with, of the entry with some labels.

    ImpactfemError where the store has no such number.
    """
    try:
        value = float(store[name].sel(labels))
    except KeyError:
        value = np.nan
    if not np.isfinite(value):
        of = "".join(f", {dim} {label}" for dim, label in labels.items())
        raise ImpactfemError(f"{store.encoding.get('source', 'the store')} has no {name}{of}")
    return value


def names_of(store: xr.Dataset, dimension: str) -> list[str]:
    """The labels of a dimension, as texts."""
    return [str(name) for name in store[dimension].values]


def by_line(forces: xr.Dataset) -> xr.Dataset:
    """`forces.nc` with one force for each line, in place of those of its points."""
    if "line" not in forces:
        return forces
    lines = forces["line"].values.astype(str)
    names = np.where(lines == "", forces["pair"].values.astype(str), lines)
    unique, first = np.unique(names, return_index=True)
    order = np.argsort(first)
    whole = forces.isel(pair=first[order]).assign_coords(pair=unique[order])
    every = forces["force"].transpose("time", "pair").values
    joined = np.column_stack([every[:, names == name].sum(axis=1) for name in unique[order]])
    return whole.assign(force=(("time", "pair"), joined, forces["force"].attrs))


def time_step(store: xr.Dataset) -> float:
    """Step of the histories of a store [s]."""
    return float(store["time"][1] - store["time"][0])

"""Scalar results by name, from a stage through its store to the summary."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class Scalar:
    """One scalar result."""

    name: str  #: dotted name, for example ``pounding.peak_force.floor_8``
    #: Its value in SI units; None when it does not exist (no impact, for example).
    value: float | None
    unit: str  #: SI unit; "-" when it has none
    note: str = ""  #: what to know when reading it
    detail: bool = False  #: in `summary.json` only if it has a published value


def with_scalars(store: xr.Dataset, scalars: Iterable[Scalar]) -> xr.Dataset:
    """A store with `result_value` over the names `result`, with unit and note; nan for no value."""
    table = tuple(scalars)
    values = [math.nan if s.value is None else s.value for s in table]
    return (
        store.drop_dims("result", errors="ignore")
        .assign_coords(
            result=("result", words(s.name for s in table)),
            result_unit=("result", words(s.unit for s in table)),
            result_note=("result", words(s.note for s in table)),
            result_detail=("result", np.array([s.detail for s in table], dtype=bool)),
        )
        .assign(result_value=("result", np.array(values, dtype=float), {"units": "as result_unit"}))
    )


def scalars_of(store: xr.Dataset) -> list[Scalar]:
    """The scalars of a store; a KeyError where it has none."""
    names = ("result", "result_value", "result_unit", "result_note", "result_detail")
    rows = zip(*(store[name].values.tolist() for name in names), strict=True)
    return [Scalar(name, None if math.isnan(v) else v, *of) for name, v, *of in rows]


def words(values: Iterable[str]) -> np.ndarray[tuple[int], np.dtype[np.object_]]:
    """Texts as an array that NetCDF takes."""
    return np.array([str(value) for value in values], dtype=object)


def of_building(name: str, building: str) -> str:
    """Name of a result of the 3D model of a further building: `building.B2.frequency.1`.

    Results of the first building, of which the name is "" here, keep theirs.
    """
    first, dot, rest = name.partition(".")
    return f"{first}.{building}{dot}{rest}" if building else name


def alone(name: str, building: str) -> str | None:
    """The same without the building; None of a result that is of none, or of another one."""
    if not building:
        return name
    first, _, rest = name.partition(".")
    own, _, rest = rest.partition(".")
    return f"{first}.{rest}" if own == building and rest and first != "sticks" else None

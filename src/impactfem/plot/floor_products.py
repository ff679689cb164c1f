"""Floor response spectra as products: tables and a store for those who design equipment.

Everything is made from a store with `psa` over damping, station, direction and frequency, `pfa`
over station and direction, and both over `motion` before that when it holds an ensemble.

Written are, into `products/`, `floor_spectra.csv` (a row for each building, floor, direction,
damping and frequency), `floor_peaks.csv` (a row for each spectrum), `floor_spectra.xlsx` (a sheet
for each building, direction and damping) and `floor_spectra.nc`, and a figure for each building.
Ordinates that were not computed, at the corners of broadened peaks, are left empty.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.floor_figures import floor_figures
from impactfem.plot.floor_workbook import write_workbook
from impactfem.plot.table import Cell, Table
from impactfem.spectra.design import ZPA_TOLERANCE, Ratio
from impactfem.spectra.frequency_list import FloatArray
from impactfem.spectra.product import DesignFloorSpectra, FloorSpectrumSet, Station
from impactfem.spectra.statistics import Statistic, statistic_words
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import scalars_of

FOLDER = "products"
FRACTILES = (0.16, 0.5, 0.84)
DIGITS = 6  # significant ones in tables


def write_floor_products(
    folder: Path,
    store: Path,
    *,
    broadening: Ratio = 0.15,
    clipping: bool = False,
    statistic: Statistic = "envelope",
) -> list[Path]:
    """Write all products of a store.

    Args:
        folder: The run's folder.
        store: `pounding.nc`, or the store of an ensemble.
        broadening: Of the peaks to either side: a ratio, or one down and one up [-].
        clipping: Whether narrow peaks are reduced before they are broadened.
        statistic: Over the motions of an ensemble: "envelope", "mean" or a probability.

    Returns:
        The files.

    Raises:
        ImpactfemError: The store is not usable, or a file cannot be written.
    """
    spectra, inputs = read_floor_spectra(store)
    design = spectra.design(broadening, clipping=clipping, statistic=statistic)
    target, figures = folder / FOLDER, folder / "figures"
    for one in (target, figures):
        one.mkdir(parents=True, exist_ok=True)
    files = [table.write_csv(target) for table in (spectrum_table(design), peak_table(design))]
    for name, write in (("xlsx", write_workbook), ("nc", _write_store(inputs))):
        path = target / f"floor_spectra.{name}"
        write(path, design)
        files.append(path)
    return files + floor_figures(figures, design)


def read_floor_spectra(store: Path) -> tuple[FloorSpectrumSet, str]:
    """Read floor spectra from a store.

    Args:
        store: `pounding.nc`, or one of the same form with the dimension `motion`.

    Returns:
        The spectra, and the hash of the inputs that the store was made from.

    Raises:
        ImpactfemError: The file cannot be read, or holds no floor spectra.
    """
    try:
        with xr.open_dataset(store, engine="h5netcdf") as data:
            return _spectra_of(data), str(data.attrs.get("inputs", ""))
    except KeyError as error:
        raise ImpactfemError(f"{store} holds no floor spectra: {error.args[0]}") from error
    except (OSError, ValueError) as error:
        raise ImpactfemError(f"cannot read floor spectra from {store}: {error}") from error


def _spectra_of(data: xr.Dataset) -> FloorSpectrumSet:
    psa, pfa = data["psa"], data["pfa"]
    if "motion" not in psa.dims:
        psa, pfa = psa.expand_dims("motion"), pfa.expand_dims("motion")
        motions: tuple[str, ...] = ("that of the case",)
    else:
        motions = tuple(str(name) for name in data["motion"].values)
    elevation = (
        data["elevation"].values if "elevation" in data else np.full(psa["station"].size, np.nan)
    )
    stations = zip(
        data["station_building"].values, data["station_floor"].values, elevation, strict=True
    )
    return FloorSpectrumSet(
        frequency=np.asarray(data["frequency"].values, dtype=float),
        damping=np.asarray(data["damping"].values, dtype=float),
        stations=tuple(
            Station(str(building), str(floor), ("mass centre",), float(z))
            for building, floor, z in stations
        ),
        directions=tuple(str(name) for name in data["direction"].values),
        psa=psa.transpose("motion", "damping", "station", "direction", "frequency").values,
        zpa=pfa.transpose("motion", "station", "direction").values,
        motions=motions,
        title=str(data.attrs.get("title", "")),
        method=_method(data),
    )


def _method(data: xr.Dataset) -> str:
    text = "pseudo-acceleration of oscillators on the floor, time histories with pounding"
    scalars = {s.name: s for s in scalars_of(data)} if "result" in data.dims else {}
    points = scalars.get("frs.points_per_cycle")
    if points is not None and points.value is not None:
        text += f", {points.value:.3g} points in a cycle {points.note}"
    return text


def spectrum_table(design: DesignFloorSpectra) -> Table:
    """All spectra as a tidy table."""
    columns = {"raw": design.computed, "broadened": design.psa}
    columns |= {name: design.at_design(values) for name, values in _statistics(design).items()}
    frequency = [_cell(f) for f in design.frequency]
    rows: list[tuple[Cell, ...]] = []
    for labels, index in _each(design):
        ordinates = [[_cell(value) for value in values[index]] for values in columns.values()]
        rows += ((*labels, *row) for row in zip(frequency, *ordinates, strict=True))
    return Table(
        "floor_spectra",
        f"Floor response spectra; {design.broadening_text}",
        (*_LABELS, ("frequency", "Hz"), *((name, "m/s2") for name in columns)),
        tuple(rows),
    )


def peak_table(design: DesignFloorSpectra) -> Table:
    """The peak, the zero-period acceleration and its frequency of each spectrum."""
    rows: list[tuple[Cell, ...]] = []
    for labels, (d, s, x) in _each(design):
        raw = design.raw[d, s, x]
        numbers = (
            design.source.stations[s].elevation,
            raw.max(),
            design.source.frequency[int(np.argmax(raw))],
            design.psa[d, s, x].max(),
            design.zpa[s, x],
            design.rigid[d, s, x],
        )
        rows.append((*labels, *(_cell(float(number)) for number in numbers)))
    return Table(
        "floor_peaks",
        "Peaks and zero-period accelerations of the floor response spectra",
        (
            *_LABELS,
            ("elevation", "m"),
            ("raw peak", "m/s2"),
            ("frequency of the raw peak", "Hz"),
            ("broadened peak", "m/s2"),
            ("zero-period acceleration", "m/s2"),
            (f"within {100 * ZPA_TOLERANCE:g} % of it from", "Hz"),
        ),
        tuple(rows),
    )


_LABELS = (("building", ""), ("floor", ""), ("direction", ""), ("damping", "-"))


def _each(
    design: DesignFloorSpectra,
) -> Iterator[tuple[tuple[Cell, ...], tuple[int, int, int]]]:
    """The labels and the index of each spectrum."""
    source = design.source
    for s, station in enumerate(source.stations):
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                yield (station.building, station.floor, direction, _cell(damping)), (d, s, x)


def _statistics(design: DesignFloorSpectra) -> dict[str, FloatArray]:
    """Statistics over several motions, at the list of the source."""
    source = design.source
    if len(source.motions) == 1:
        return {}
    wanted: tuple[Statistic, ...] = ("mean", *FRACTILES, "envelope")
    return {statistic_words(one): source.over_motions(one)[0] for one in wanted}


def _cell(value: float) -> Cell:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def _write_store(inputs: str) -> Any:
    def write(path: Path, design: DesignFloorSpectra) -> None:
        write_netcdf(path, floor_store(design, inputs))

    return write


def floor_store(design: DesignFloorSpectra, inputs: str = "") -> xr.Dataset:
    """The products as a dataset.

    Args:
        design: The spectra.
        inputs: Hash of what they were made from.
    """
    source = design.source
    curve = ("damping", "station", "direction")
    si = {"units": "m/s2"}
    stations = source.stations
    variables: dict[str, tuple[Any, ...]] = {
        "raw": ((*curve, "frequency"), design.raw, si | {"long_name": "as computed"}),
        "broadened": ((*curve, "design_frequency"), design.psa, si | {"long_name": "for design"}),
        "zpa": (curve[1:], design.zpa, si | {"long_name": "zero-period acceleration"}),
        "rigid_frequency": (
            curve,
            design.rigid,
            {
                "units": "Hz",
                "long_name": f"raw stays within {100 * ZPA_TOLERANCE:g} % of zpa from here on",
            },
        ),
        "frequency": ("frequency", source.frequency, {"units": "Hz"}),
        "design_frequency": ("design_frequency", design.frequency, {"units": "Hz"}),
        "damping": ("damping", source.damping, {"units": "-"}),
        "direction": ("direction", _words(source.directions)),
        "station": ("station", _words(f"{s.building}.floor_{s.floor}" for s in stations)),
        "station_building": ("station", _words(s.building for s in stations)),
        "station_floor": ("station", _words(s.floor for s in stations)),
        "station_points": ("station", _words(", ".join(s.points) for s in stations)),
        "elevation": ("station", np.array([s.elevation for s in stations]), {"units": "m"}),
    }
    for name, values in _statistics(design).items():
        key = name.replace(" % ", "_").replace(" ", "_")
        variables[key] = ((*curve, "frequency"), values, si | {"long_name": f"{name} of motions"})
    return xr.Dataset(
        variables,
        attrs={
            "title": source.title,
            "inputs": inputs,
            "method": source.method,
            "motions": design.motions_text,
            "design": design.broadening_text,
            "interpolation": "straight lines on doubly logarithmic axes between the frequencies",
        },
    )


def _words(values: Any) -> Any:
    return np.array(list(values), dtype=object)

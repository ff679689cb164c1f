"""Design spectra of the 3D building as tables, workbooks and stores, beside those of the sticks.

Into `products/`: `design_spectra.csv`, `.xlsx` and `.nc` under the case's own motion and
`design_peaks.csv`; with an ensemble that was carried through the 3D model `design_ensemble.csv`
with its statistics, and a workbook and a store of each of them. Statistics are taken frequency by
frequency over the envelopes of the members, and broadened afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.floor_products import FOLDER, floor_store, read_floor_spectra
from impactfem.plot.floor_workbook import write_workbook
from impactfem.plot.table import Cell, Table
from impactfem.spectra.design import ZPA_TOLERANCE, Ratio
from impactfem.spectra.frequency_list import interpolate_frequency, merged_frequencies
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.spectra.statistics import STATISTICS
from impactfem.stages.design.view import VERTICES, DesignView
from impactfem.system.files import write_netcdf

Array = NDArray[np.float64]
UNIT = "m/s2"
LABELS = (("building", ""), ("floor", ""), ("direction", ""), ("damping", "-"))
ENDS = (("points", ""), ("unit of the accelerations", ""), ("method", ""))
Index = tuple[int, int, int]


def coverage_table(view: DesignView) -> Table | None:
    """Of each floor and direction, what its points have of the envelope of all its vertices.

    Args:
        view: The design spectra.

    Returns:
        The table; None where there are no spectra over whole floors.
    """
    source = view.case
    rows: list[tuple[Cell, ...]] = []
    for s, x in view.places:
        station = source.stations[s]
        for d, damping in enumerate(source.damping):
            whole = view.whole(d, s, x)
            if whole is None:
                continue
            frequency, vertices = whole
            at, share = view.reached(s, x)
            worst, peak = int(np.argmin(share[:-1])), int(np.argmax(vertices))
            rows.append(
                (
                    *(station.building, station.floor, source.directions[x], _cell(damping)),
                    view.number_of_points(s, x) - int(view.vertex_counts[s, x]),
                    *(int(view.vertex_counts[s, x]), view.vertices(s)),
                    *map(_cell, (view.probes_peak(d, s, x), source.psa[0, d, s, x].max())),
                    *map(_cell, (vertices[peak], frequency[peak])),
                    *map(_cell, (share[worst], at[worst], share[-1])),
                )
            )
    if not rows:
        return None
    return Table(
        "design_coverage",
        "What the points of each floor have of the envelope of all its vertices, as computed",
        (
            *(("building", ""), ("floor", ""), ("direction", ""), ("damping", "-")),
            *(("probes", ""), ("vertices that govern", ""), ("vertices", "")),
            ("peak of the probes alone", "m/s2"),
            ("peak of the points", "m/s2"),
            ("peak of all vertices, without samples between", "m/s2"),
            ("at", "Hz"),
            ("least part at any frequency, sampled alike", "-"),
            ("there", "Hz"),
            ("part of the peak acceleration", "-"),
        ),
        tuple(rows),
    )


def vertex_table(view: DesignView) -> Table | None:
    """The vertices that govern: where they are, their peaks, and where they are the largest.

    Args:
        view: The design spectra.

    Returns:
        The table; None without such vertices.
    """
    store, source = view.store, view.case
    if "vertex" not in store.dims:
        return None
    probes = store.sizes["point"] - store.sizes["vertex"]
    rows: list[tuple[Cell, ...]] = []
    for v, s in enumerate(store["vertex_station"].values):
        x = source.directions.index(str(store["vertex_direction"].values[v]))
        largest = store["governing"].values[:, s, x] == probes + v
        rows.append(
            (
                *(source.stations[s].building, source.stations[s].floor, source.directions[x]),
                int(store["vertex_node"].values[v]),
                *map(_cell, store["vertex_position"].values[v]),
                _cell(float(largest.mean())),
            )
        )
    return Table(
        VERTICES,
        "The vertices that govern the envelopes of the floors under the case's motion",
        (
            *(("building", ""), ("floor", ""), ("direction", ""), ("node", "")),
            *((axis, "m") for axis in "xyz"),
            ("part of the frequencies at which it is the largest", "-"),
        ),
        tuple(rows),
    )


@dataclass(frozen=True, eq=False)
class DesignProducts:
    """The design spectra of a run.

    Args:
        view: What the store says of them.
        case: Under the case's own motion.
        stick: The same of the sticks at their mass centres.
        statistics: Over the members of an ensemble, by name; none without one.
    """

    view: DesignView
    case: DesignFloorSpectra
    stick: DesignFloorSpectra
    statistics: dict[str, DesignFloorSpectra]

    def of_stick(self, damping: int, station: int, direction: int) -> tuple[Array, Array] | None:
        """Frequencies [Hz] and design spectrum [m/s2] of the sticks; None where there is none."""
        source, wanted = self.stick.source, self.case.source
        names = [(one.building, one.floor) for one in source.stations]
        place, along = wanted.stations[station], wanted.directions[direction]
        if (place.building, place.floor) not in names or along not in source.directions:
            return None
        s, x = names.index((place.building, place.floor)), source.directions.index(along)
        return self.stick.frequency, self.stick.psa[damping, s, x]


def design_products_of(
    store: xr.Dataset, sticks: Path, broadening: Ratio, clipping: bool
) -> DesignProducts:
    """Make the design spectra.

    Args:
        store: The open `design.nc`.
        sticks: `pounding.nc` of the same case.
        broadening: Of the peaks to either side: a ratio, or one down and one up [-].
        clipping: Whether narrow peaks are reduced before they are broadened.

    Raises:
        ImpactfemError: A store is not usable.
    """
    view = DesignView(store)
    stick, _ = read_floor_spectra(sticks)
    members = view.members
    return DesignProducts(
        view=view,
        case=view.case.design(broadening, clipping=clipping),
        stick=stick.design(broadening, clipping=clipping),
        statistics={}
        if members is None
        else {
            name: members.of_members(name).design(broadening, clipping=clipping)
            for name in STATISTICS
        },
    )


def write_design_products(folder: Path, products: DesignProducts) -> list[Path]:
    """Write tables, workbooks and stores.

    Args:
        folder: The run's folder.
        products: What to write.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    target, others = folder / FOLDER, folder / "tables"
    for one in (target, others):
        one.mkdir(parents=True, exist_ok=True)
    tables = [case_table(products), peak_table(products)]
    if products.statistics:
        tables.append(statistics_table(products))
    files = [table.write_csv(target) for table in tables]
    for table in (coverage_table(products.view), vertex_table(products.view)):
        if table is not None:
            files.append(table.write_csv(others))
    named = {"design_spectra": products.case}
    named |= {f"design_ensemble_{name}": one for name, one in products.statistics.items()}
    for name, design in named.items():
        book, store = target / f"{name}.xlsx", target / f"{name}.nc"
        write_workbook(book, design)
        write_netcdf(store, floor_store(design, products.view.inputs))
        files += [book, store]
    return files


def case_table(products: DesignProducts) -> Table:
    """The spectra under the case's own motion, beside the design spectra of the sticks."""
    design = products.case
    rows: list[tuple[Cell, ...]] = []
    for labels, index, ends in _each(products.view, design):
        stick = products.of_stick(*index)
        columns = [design.computed[index], design.psa[index]]
        columns += [_inside(one, design.frequency) for one in (stick, products.view.whole(*index))]
        rows += _rows(labels, design.frequency, columns, ends)
    names = (
        "computed",
        "for design",
        "for design, sticks at the mass centre",
        "computed, all vertices of the floor, without samples between",
    )
    return _table(
        "design_spectra", "Design spectra of the 3D building under the case's motion", names, rows
    )


def statistics_table(products: DesignProducts) -> Table:
    """The design spectra of the case's own motion and of the ensemble's statistics."""
    designs = [products.case, *products.statistics.values()]
    frequency = merged_frequencies(np.concatenate([one.frequency for one in designs]))
    rows: list[tuple[Cell, ...]] = []
    for labels, index, ends in _each(
        products.view, next(iter(products.statistics.values())), members=True
    ):
        columns = [interpolate_frequency(d.frequency, d.psa[index], frequency) for d in designs]
        rows += _rows(labels, frequency, columns, ends)
    names = ("the case's motion", *(STATISTICS[name] for name in products.statistics))
    return _table(
        "design_ensemble", "Design spectra of the 3D building over an ensemble", names, rows
    )


def peak_table(products: DesignProducts) -> Table:
    """Peaks and zero-period accelerations, and which point has the peak."""
    design, view = products.case, products.view
    source = design.source
    rows: list[tuple[Cell, ...]] = []
    for labels, (d, s, x), _ in _each(products.view, design):
        raw = design.raw[d, s, x]
        peak = int(np.argmax(raw))
        stick = products.of_stick(d, s, x)
        numbers = (
            source.stations[s].elevation,
            float(raw[peak]),
            float(source.frequency[peak]),
            float(design.zpa[s, x]),
            float(design.rigid[d, s, x]),
        )
        others = [
            float(np.nan) if stick is None else float(stick[1].max()),
            *(float(one.psa[d, s, x].max()) for one in products.statistics.values()),
        ]
        rows.append(
            (
                *labels,
                *map(_cell, numbers),
                view.governing(d, s, x, peak),
                view.number_of_points(s, x),
                *map(_cell, others),
            )
        )
    return Table(
        "design_peaks",
        "Peaks and zero-period accelerations of the design spectra of the 3D building",
        (
            *LABELS,
            ("elevation", "m"),
            ("peak", UNIT),
            ("frequency of the peak", "Hz"),
            ("zero-period acceleration", UNIT),
            (f"within {100 * ZPA_TOLERANCE:g} % of it from", "Hz"),
            ("point of the peak", ""),
            ("number of points", ""),
            ("peak, sticks at the mass centre", UNIT),
            *((f"peak, {STATISTICS[name]}", UNIT) for name in products.statistics),
        ),
        tuple(rows),
    )


def _each(
    view: DesignView, design: DesignFloorSpectra, *, members: bool = False
) -> Iterator[tuple[tuple[Cell, ...], Index, tuple[Cell, ...]]]:
    """Labels, index, and points, unit and method of each spectrum."""
    source = design.source
    enveloped = view.members_enveloped if members else view.enveloped
    method = f"{enveloped}; {design.broadening_text}"
    for s, station in enumerate(source.stations):
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                labels = (station.building, station.floor, direction, _cell(float(damping)))
                points = view.member_points(s) if members else view.points(s, x)
                yield labels, (d, s, x), ("; ".join(points), UNIT, method)


def _rows(
    labels: tuple[Cell, ...], frequency: Array, columns: list[Array], ends: tuple[Cell, ...]
) -> Iterator[tuple[Cell, ...]]:
    for f, *values in zip(frequency, *columns, strict=True):
        yield (*labels, _cell(float(f)), *(_cell(float(value)) for value in values), *ends)


def _inside(curve: tuple[Array, Array] | None, wanted: Array) -> Array:
    """A spectrum at the frequencies of another list; nan outside its own, and where it is None."""
    found = np.full(wanted.size, np.nan)
    if curve is not None:
        frequency, values = curve
        inside = (wanted >= frequency[0]) & (wanted <= frequency[-1])
        found[inside] = interpolate_frequency(frequency, values, wanted[inside])
    return found


def _table(name: str, title: str, columns: tuple[str, ...], rows: list[tuple[Cell, ...]]) -> Table:
    heads = (*LABELS, ("frequency", "Hz"), *((column, UNIT) for column in columns), *ENDS)
    return Table(name, title, heads, tuple(rows))


def _cell(value: float) -> Cell:
    return float(f"{value:.6g}") if np.isfinite(value) else None

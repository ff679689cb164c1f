"""Design spectra of the 3D building as tables, a workbook and a NetCDF file, and the pounding.

Into `products/`: `design_spectra.csv`, `.xlsx` and `.nc` under the motion of the case and
`design_peaks.csv`; `design_rotations.csv` of the rotations of the floors; `design_ensemble.csv`
with statistics over the motions of an ensemble that was carried through the 3D model. Statistics
are taken frequency by frequency over the envelopes of the members, and broadened afterwards. Into
`tables/`: the share of each floor's envelope that its points have, the governing vertices, and the
members of the ensemble.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.floor_products import (
    FOLDER,
    LABELS,
    WITHIN,
    curve_rows,
    curve_table,
    floor_store,
    labelled,
    read_floor_spectra,
    write_design_files,
)
from impactfem.plot.table import Cell, Table, cell, heads
from impactfem.spectra.design import Ratio
from impactfem.spectra.frequency_list import interpolate_frequency, merged_frequencies
from impactfem.spectra.product import DesignFloorSpectra, FloorSpectrumSet, Station
from impactfem.spectra.statistics import STATISTICS
from impactfem.stages.design.envelopes import largest_impact, statistics
from impactfem.stages.design.floors import STILL
from impactfem.stages.stores import names_of
from impactfem.system.arrays import Array

Place = tuple[int, int, int]

VERTICES = "design_vertices"
"""Name of the table of the vertices that govern."""
EACH = "the vertices that govern under each motion"
"""The points in addition to the probes under motions of an ensemble, in words."""
ALONE = (
    "envelope of the PROBES ALONE, which is not that of the whole floor: without fields over the "
    "floors it is not known how much of a floor its probes have"
)
UNIT = "m/s2"


def share_reached(store: xr.Dataset) -> xr.DataArray:
    """Compute envelope of the vertices that govern / envelope of all vertices, from the fields [-].

    Over `station`, `direction` and `whole_frequency` [Hz], which ends with infinity for the peak
    acceleration; nan if no vertex governs.
    """
    psa, zpa = (
        (store[f"reached_{name}"] / store[f"whole_{name}"]).where(store[f"whole_{name}"] > 0.0, 1.0)
        for name in ("psa", "zpa")
    )
    share = xr.concat([psa, zpa.expand_dims(whole_frequency=[np.inf])], "whole_frequency")
    return share.where(store["vertex_count"] > 0)


@dataclass(frozen=True, eq=False)
class DesignProducts:
    """The design spectra of a run."""

    store: xr.Dataset  #: `design.nc`
    case: DesignFloorSpectra  #: under the case's own motion
    rotations: DesignFloorSpectra | None  #: the same of rotations; None where none is known
    sticks: xr.Dataset  #: the same of the mass centres as they pounded, as a store
    #: Under the motions of an ensemble, as computed; None without one.
    members: FloorSpectrumSet | None
    #: Over the members of an ensemble, by name; none without one.
    statistics: dict[str, DesignFloorSpectra]

    def of_stick(self, place: Place) -> tuple[Array, Array] | None:
        """Frequencies [Hz] and design spectrum [m/s2] of the pounding model; None without one."""
        d, s, x = place
        there = {name: self.store[name].values[k] for name, k in (("station", s), ("direction", x))}
        try:
            curve = self.sticks["broadened"].isel(damping=d).sel(there)
        except KeyError:
            return None
        return curve["design_frequency"].values, curve.values

    def of_vertices(self, place: Place) -> tuple[Array, Array] | None:
        """Frequencies [Hz] and the envelope of all vertices of a floor [m/s2].

        None where there are no fields over the floors, or for another damping.
        """
        d, s, x = place
        damping = self.store["damping"].values[d]
        if "whole_psa" not in self.store or not np.isclose(self.store["whole_damping"], damping):
            return None
        return self.store["whole_frequency"].values, self.store["whole_psa"].values[s, x]


def design_products_of(
    store: xr.Dataset, sticks: Path, broadening: Ratio, clipping: bool
) -> DesignProducts:
    """Make the design spectra from the open `design.nc` and `pounding.nc` of the same case.

    Peaks are broadened by a ratio to either side, or by one down and one up; with `clipping`,
    narrow peaks are reduced before. ImpactfemError: a store is not usable.
    """
    of_sticks, *_ = read_floor_spectra(sticks)
    design = partial(FloorSpectrumSet.design, broadening=broadening, clipping=clipping)
    members, statistics = None, {}
    if "motion" in store.dims:
        members = _spectra(store, "member_", (EACH,) if "vertex" in store.dims else ())
        statistics = {name: design(members.of_members(name)) for name in STATISTICS}
    rotations = design(_rotations(store)) if "rotation" in store.dims else None
    own, stick_store = design(_spectra(store, "", ())), floor_store(design(of_sticks))
    return DesignProducts(store, own, rotations, stick_store, members, statistics)


def _rotations(store: xr.Dataset) -> FloorSpectrumSet:
    """Read the spectra of rotations, at the probes with recorded rotations."""
    moving = store["rotational_pfa"].max("station").values
    moves = np.flatnonzero(moving > STILL * moving.max())
    return _spectrum_set(
        store,
        probes_of(store, "rotational_probes"),
        directions=tuple(np.array(names_of(store, "rotation"))[moves]),
        psa=store["rotational_psa"].values[None][:, :, :, moves],
        zpa=store["rotational_pfa"].values[None][:, :, moves],
        motions=("that of the case",),
        method=(
            "pseudo-acceleration of oscillators that turn with the nodes of probes; 3D model of "
            "shells and beams under ground motion and impact forces, valid up to "
            f"{store.attrs['maximum_frequency']:g} Hz; envelope of the PROBES ALONE"
        ),
    )


def _spectra(store: xr.Dataset, prefix: str, further: tuple[str, ...]) -> FloorSpectrumSet:
    """Read the spectra whose variables have a prefix, with further points in words."""
    directions, points = names_of(store, "direction"), []
    psa, zpa = store[f"{prefix}psa"].values, store[f"{prefix}zpa"].values
    for probes, counts in zip(probes_of(store), store["vertex_count"].values, strict=True):
        along = [f"{_vertices(n)} along {x}" for n, x in zip(counts, directions, strict=True) if n]
        points.append((*probes, *(further if prefix else along)))
    method = (
        "pseudo-acceleration of oscillators at points of the floor; 3D model of shells and beams "
        f"under ground motion and impact forces, valid up to {store.attrs['maximum_frequency']:g} "
        f"Hz; {enveloped_words(store, members=bool(prefix))}"
    )
    if store.sizes["elsewhere"]:
        method += f"; on no floor: {', '.join(names_of(store, 'elsewhere'))}"
    if store["vertex_count"].any():
        method += f"; see tables/design_coverage.csv and tables/{VERTICES}.csv"
    return _spectrum_set(
        store,
        points,
        directions=tuple(directions),
        psa=psa if prefix else psa[None],
        zpa=zpa if prefix else zpa[None],
        motions=tuple(names_of(store, "motion")) if prefix else ("that of the case",),
        method=method,
    )


def probes_of(store: xr.Dataset, flags: str = "station_probes") -> list[tuple[str, ...]]:
    """Return the names of the probes of each floor, from the flags of one variable."""
    names = np.array(names_of(store, "probe"))
    return [tuple(names[floor].tolist()) for floor in store[flags].values.astype(bool)]


def _spectrum_set(
    store: xr.Dataset, points: Sequence[tuple[str, ...]], **spectra: Any
) -> FloorSpectrumSet:
    """Make spectra at the floors of the store, with the points of each."""
    building, floors = str(store.attrs["building"]), store["station_floor"].values
    of_floors = zip(floors, points, store["elevation"].values, strict=True)
    return FloorSpectrumSet(
        frequency=np.asarray(store["frequency"].values, dtype=np.float64),
        damping=np.asarray(store["damping"].values, dtype=np.float64),
        stations=tuple(Station(building, str(k), on, float(z)) for k, on, z in of_floors),
        title=str(store.attrs["title"]),
        **spectra,
    )


def enveloped_words(store: xr.Dataset, *, members: bool) -> str:
    """Describe the envelope of each floor, under the case's motion or those of members."""
    if not store["vertex_count"].any():
        return ALONE
    if members:
        part = 100.0 * (1.0 - float(store.attrs["missed"]))
        return (
            f"envelope of the probes and of {EACH}: the fewest that have {part:g} % of what "
            f"{int(store['candidates'].sum())} have, which are the largest ones of their floors "
            "under the case's own"
        )
    return (
        "envelope of the probes and of the vertices of the floor that govern; under the case's "
        f"motion these have at least {100.0 * float(share_reached(store).min()):.3g} % of the "
        "envelope of all vertices at every frequency, sampled alike"
    )


def _vertices(count: int) -> str:
    return "1 vertex" if count == 1 else f"{count} vertices"


def write_design_products(folder: Path, products: DesignProducts) -> list[Path]:
    """Write tables, workbook and NetCDF file into the folder of a run; return the files.

    ImpactfemError: a file cannot be written.
    """
    target, others, store = folder / FOLDER, folder / "tables", products.store
    for one in (target, others):
        one.mkdir(parents=True, exist_ok=True)
    files = [table.write_csv(target) for table in _spectrum_tables(products)]
    if products.members is not None:
        files.append(_statistics_table(products).write_csv(target))
        files.append(member_table(store).write_csv(others))
    if store["vertex_count"].any():
        files += [make(products).write_csv(others) for make in (coverage_table, vertex_table)]
    if products.rotations is not None:
        files.append(curve_table(products.rotations, "design_rotations").write_csv(target))
    inputs = str(store.attrs["inputs"])
    return files + write_design_files(target / "design_spectra", products.case, inputs)


def _spectrum_tables(products: DesignProducts) -> list[Table]:
    """The spectra under the case's own motion, and their peaks with the point of each."""
    design, store = products.case, products.store
    source, statistics = design.source, products.statistics
    curves: list[tuple[Cell, ...]] = []
    peaks: list[tuple[Cell, ...]] = []
    for labels, place in labelled(design):
        _, s, x = place
        points = list(probes_of(store)[s])
        probes, count = len(points), int(store["vertex_count"].values[s, x])
        if count:
            points.append(f"{_vertices(count)} of tables/{VERTICES}.csv")
        stick, raw = products.of_stick(place), design.raw[place]
        others = [_inside(one, design.frequency) for one in (stick, products.of_vertices(place))]
        columns = [design.frequency, design.computed[place], design.psa[place], *others]
        method = f"{enveloped_words(store, members=False)}; {design.broadening_text}"
        curves += curve_rows(labels, columns, ("; ".join(points), UNIT, method))
        k = int(np.argmax(raw))
        peaks.append(
            (
                *labels,
                *map(cell, (source.stations[s].elevation, raw[k], source.frequency[k])),
                *map(cell, (design.zpa[s, x], design.rigid[place])),
                str(store["point"].values[store["governing"].values[(*place, k)]]),
                probes + count,
                None if stick is None else cell(stick[1].max()),
                *(cell(one.psa[place].max()) for one in statistics.values()),
            )
        )
    heads_of_peaks = heads(
        "elevation [m]; peak [m/s2]; frequency of the peak [Hz]; zero-period acceleration [m/s2]; "
        f"{WITHIN}; point of the peak; number of points; "
        "peak, mass centre in the pounding [m/s2]"
    )
    return [
        _curve_table(
            "design_spectra",
            "Design spectra of the 3D building under the case's motion",
            (
                "computed",
                "for design",
                "for design, mass centre in the pounding",
                "computed, all vertices of the floor, without samples between",
            ),
            curves,
        ),
        Table(
            "design_peaks",
            "Peaks and zero-period accelerations of the design spectra of the 3D building",
            (*LABELS, *heads_of_peaks, *((f"peak, {STATISTICS[n]}", UNIT) for n in statistics)),
            tuple(peaks),
        ),
    ]


def _statistics_table(products: DesignProducts) -> Table:
    """The design spectra of the case's own motion and of the ensemble's statistics."""
    designs = [products.case, *products.statistics.values()]
    frequency = merged_frequencies(np.concatenate([one.frequency for one in designs]))
    first = designs[1]
    method = f"{enveloped_words(products.store, members=True)}; {first.broadening_text}"
    rows: list[tuple[Cell, ...]] = []
    for labels, place in labelled(first):
        columns = [interpolate_frequency(d.frequency, d.psa[place], frequency) for d in designs]
        points = "; ".join(first.source.stations[place[1]].points)
        rows += curve_rows(labels, [frequency, *columns], (points, UNIT, method))
    names = ("the case's motion", *(STATISTICS[name] for name in products.statistics))
    title = "Design spectra of the 3D building over an ensemble"
    return _curve_table("design_ensemble", title, names, rows)


def _curve_table(
    name: str, title: str, columns: tuple[str, ...], rows: list[tuple[Cell, ...]]
) -> Table:
    ends = heads("points; unit of the accelerations; method")
    units = (("frequency", "Hz"), *((column, UNIT) for column in columns))
    return Table(name, title, (*LABELS, *units, *ends), tuple(rows))


def _inside(curve: tuple[Array, Array] | None, wanted: Array) -> Array:
    """Interpolate a spectrum at other frequencies; nan outside its range, and for None."""
    found = np.full(wanted.size, np.nan)
    if curve is not None:
        frequency, values = curve
        inside = (wanted >= frequency[0]) & (wanted <= frequency[-1])
        found[inside] = interpolate_frequency(frequency, values, wanted[inside])
    return found


def coverage_table(products: DesignProducts) -> Table:
    """Compare the points of each floor with the envelope of all its vertices, by direction."""
    store, share = products.store, share_reached(products.store)
    rows: list[tuple[Cell, ...]] = []
    for labels, place in labelled(products.case):
        d, s, x = place
        vertices, count = products.of_vertices(place), int(store["vertex_count"].values[s, x])
        if vertices is None or not count:
            continue
        frequency, whole = vertices
        part = share.isel(station=s, direction=x)
        worst = part.isel(whole_frequency=slice(-1))
        numbers = (
            *(store[name].values[d, s, x].max() for name in ("probes_psa", "psa")),
            whole.max(),
            frequency[whole.argmax()],
            float(worst.min()),
            float(worst.idxmin()),
            float(part[-1]),
        )
        probes, every = (int(store[name].values[s]) for name in ("probe_count", "vertices"))
        rows.append((*labels, probes, count, every, *map(cell, numbers)))
    return Table(
        "design_coverage",
        "What the points of each floor have of the envelope of all its vertices, as computed",
        (
            *LABELS,
            *heads(
                "probes; vertices that govern; vertices; peak of the probes alone [m/s2]; "
                "peak of the points [m/s2]; peak of all vertices, without samples between [m/s2]; "
                "at [Hz]; least part at any frequency, sampled alike [-]; there [Hz]; "
                "part of the peak acceleration [-]"
            ),
        ),
        tuple(rows),
    )


def vertex_table(products: DesignProducts) -> Table:
    """List the vertices that govern, with places and parts of the frequencies."""
    store, stations = products.store, products.case.source.stations
    first = store.sizes["point"] - store.sizes["vertex"]
    rows: list[tuple[Cell, ...]] = []
    for v, s in enumerate(store["vertex_station"].values):
        vertex, floor = store.isel(vertex=v), stations[s]
        direction = str(vertex["vertex_direction"].values)
        largest = store["governing"].isel(station=s).sel(direction=direction) == first + v
        where = [*vertex["vertex_position"].values, float(largest.mean())]
        node = int(vertex["vertex_node"])
        rows.append((floor.building, floor.floor, direction, node, *map(cell, where)))
    return Table(
        VERTICES,
        "The vertices that govern the envelopes of the floors under the case's motion",
        heads(
            "building; floor; direction; node; x [m]; y [m]; z [m]; "
            "part of the frequencies at which it is the largest [-]"
        ),
        tuple(rows),
    )


def member_table(store: xr.Dataset) -> Table:
    """List the members: largest impact force, spectral peaks of floors, forces on anchors."""
    axis = str(store.attrs["shown_direction"])
    psa = store["member_psa"].isel(damping=0).sel(direction=axis).max("frequency").values
    force = largest_impact(store["member_impact_force"].values)
    columns: list[tuple[str, str, Array]] = [("largest impact force", "N", force)]
    columns += [
        (f"peak of the spectrum of floor {floor}", UNIT, psa[:, s])
        for s, floor in enumerate(store["station_floor"].values)
    ]
    for name in names_of(store, "device") if "device" in store.dims else ():
        one = store.sel(device=name, component=axis)
        for kind, words in (("force", "3D model"), ("spectrum", store.attrs["analysis"])):
            values = one[f"member_device_{kind}"].values
            columns.append((f"F{axis} of {name}, {words}", "N", values))
    rows: list[tuple[Cell, ...]] = [
        (motion, *(cell(values[m]) for *_, values in columns))
        for m, motion in enumerate(names_of(store, "motion"))
    ]
    over = [statistics(values) for *_, values in columns]
    for k, words in enumerate(STATISTICS.values()):
        rows.append((words, *(cell(values[k]) for values in over)))
    return Table(
        "design_members",
        f"Members of the ensemble through the 3D building, along {axis}",
        (("motion", ""), *((name, unit) for name, unit, _ in columns)),
        tuple(rows),
    )

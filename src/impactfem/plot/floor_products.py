"""Floor response spectra as products: tables and a store for those who design equipment.

Everything is made from a store with `psa` over damping, station, direction and frequency, `pfa`
over station and direction, and both over `motion` before that when it holds an ensemble. Rotations
are `rotational_psa` and `rotational_pfa` over `rotation` in place of direction.

Into `products/`: `floor_spectra.csv` (a row for each building, floor, direction, damping and
frequency), `floor_peaks.csv` (a row for each spectrum), `floor_spectra.xlsx` (a sheet for each
building, direction and damping) and `floor_spectra.nc`; of rotations `floor_rotations.csv` and
`.nc`. Ordinates that were not computed, at the corners of broadened peaks, are left empty.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from openpyxl import Workbook
from openpyxl.cell import WriteOnlyCell
from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE
from openpyxl.styles import Alignment, Font
from openpyxl.utils import get_column_letter

from impactfem.case.analysis import Spectra
from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED
from impactfem.plot.table import Cell, Table, cell, heads
from impactfem.spectra.design import ZPA_TOLERANCE
from impactfem.spectra.product import DesignFloorSpectra, FloorSpectrumSet, Station
from impactfem.spectra.statistics import Statistic, statistic_words
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic, write_netcdf
from impactfem.system.scalar import words

FOLDER = "products"
FRACTILES = (0.16, 0.5, 0.84)
LABELS = heads("building; floor; direction; damping [-]")
COLUMNS = 4
PANEL = (2.6, 2.0)
"""Width and height of a panel [inch]."""
DIRECTION_COLOURS = {"x": RED, "y": BLUE, "z": GREEN}
WITHIN = f"within {100 * ZPA_TOLERANCE:g} % of it from [Hz]"
LONGEST_NAME = 31  # of a sheet, by the file format
LABEL_WIDTH, COLUMN_WIDTH = 26, 13  # characters


def write_floor_products(
    folder: Path, store: Path, rules: Spectra, *, statistic: Statistic = "envelope"
) -> list[Path]:
    """Write the products of `pounding.nc`, or of a results file of an ensemble; gives the files.

    Args:
        folder: The folder in which `products/` is.
        store: The results file.
        rules: The section `spectra` of the case.
        statistic: Over the motions of an ensemble: "envelope", "mean" or a probability. An ensemble
            has no workbook, NetCDF file and rotations.

    Raises:
        ImpactfemError: The results file is not usable, or a file cannot be written.
    """
    translations, rotations, inputs = floor_designs(store, rules, statistic)
    target = folder / FOLDER
    target.mkdir(parents=True, exist_ok=True)
    files = [table.write_csv(target) for table in (curve_table(translations), _peaks(translations))]
    if len(translations.source.motions) > 1:
        return files
    files += write_design_files(target / "floor_spectra", translations, inputs)
    if rotations is not None:
        files.append(curve_table(rotations, "floor_rotations").write_csv(target))
        files.append(target / "floor_rotations.nc")
        write_netcdf(files[-1], floor_store(rotations, inputs))
    return files


def write_design_files(stem: Path, design: DesignFloorSpectra, inputs: str) -> list[Path]:
    """Write design spectra as workbook and NetCDF file, at `stem` with their endings."""
    book, store = (stem.with_name(f"{stem.name}.{ending}") for ending in ("xlsx", "nc"))
    write_workbook(book, design)
    write_netcdf(store, floor_store(design, inputs))
    return [book, store]


class FloorDesigns(NamedTuple):
    """Floor response spectra for design."""

    translations: DesignFloorSpectra
    rotations: DesignFloorSpectra | None  #: None if there are none
    inputs: str  #: hash of the inputs of their results file


def floor_designs(store: Path, rules: Spectra, statistic: Statistic = "envelope") -> FloorDesigns:
    """Read the floor spectra of a results file and broaden them.

    `rules` is the section `spectra` of the case; the statistic is over the motions.
    """
    translations, rotations, inputs = read_floor_spectra(store)
    design = partial(
        FloorSpectrumSet.design,
        broadening=rules.broadening,
        clipping=rules.clipping,
        statistic=statistic,
    )
    turned = None if rotations is None else design(rotations)
    return FloorDesigns(design(translations), turned, inputs)


def building_page(design: DesignFloorSpectra, building: str) -> CurveFigure:
    """Return a figure of the spectra of a building at the first damping, a panel for each floor."""
    source = design.source
    turned = source.unit == "rad/s2"
    ends = design.frequency[[0, -1]]
    panels: list[tuple[str, list[Curve]]] = []
    for s, station in enumerate(source.stations):
        if station.building != building:
            continue
        curves: list[Curve] = []
        for x, direction in enumerate(source.directions):
            colour = DIRECTION_COLOURS.get(direction[-1], ORANGE)
            raw, psa, zpa = design.raw[0, s, x], design.psa[0, s, x], design.zpa[s, x].repeat(2)
            along = f"{'about' if turned else 'along'} $e_{direction[-1]}$"
            curves += [
                Curve(source.frequency, raw, f"computed, {along}", colour, width=0.6),
                Curve(design.frequency, psa, f"for design, {along}", colour, width=1.4),
                Curve(ends, zpa, "", colour, ":", 0.8),
            ]
        panels.append((station.label, curves))
    caption = (
        f"Floor response spectra of building {building} ("
        f"{'rotational ' if turned else ''}pseudo-acceleration, "
        f"{100.0 * source.damping[0]:g} % damping) as computed (thin) and for design (thick); "
        f"{design.broadening_text}. Dotted: zero-period acceleration. {design.motions_text}."
    )
    # The slope of a slab at a struck edge is many times that of other floors.
    if turned:
        caption += " Scales of the floors differ."
    return floor_page(caption, panels, unit=source.unit, alike=not turned)


def floor_page(
    caption: str,
    panels: Sequence[tuple[str, Sequence[Curve]]],
    unit: str = "m/s2",
    **options: Any,
) -> CurveFigure:
    """A page of spectra with a panel for each floor, and one legend above all."""
    count, columns = len(panels), min(COLUMNS, len(panels))
    look: dict[str, Any] = {"log": "x", "bottom": 0.0, "legend": ""}
    pages = [
        Panel(
            "frequency [Hz]" if k + columns >= count else "",
            f"acceleration [{unit.replace('2', '²')}]" if k % columns == 0 else "",
            curves,
            title,
            **look,
        )
        for k, (title, curves) in enumerate(panels)
    ]
    whole = max(columns, 3) * PANEL[0], math.ceil(count / columns) * PANEL[1] + 0.5
    return CurveFigure(caption, pages, columns, whole, above=True, **options)


def read_floor_spectra(store: Path) -> tuple[FloorSpectrumSet, FloorSpectrumSet | None, str]:
    """Floor spectra of `pounding.nc`, or of a store of the same form with the dimension `motion`.

    Those of translations, and of rotations where there are some; the hash of the inputs that the
    store was made from. ImpactfemError where it cannot be read, or holds no floor spectra.
    """
    try:
        with xr.open_dataset(store, engine="netcdf4") as data:
            turned = "rotational_psa" in data
            rotations = _spectra_of(data, "rotational_", "rotation") if turned else None
            return _spectra_of(data), rotations, str(data.attrs.get("inputs", ""))
    except KeyError as error:
        raise ImpactfemError(f"{store} holds no floor spectra: {error.args[0]}") from error
    except (OSError, ValueError) as error:
        raise ImpactfemError(f"cannot read floor spectra from {store}: {error}") from error


def _spectra_of(data: xr.Dataset, prefix: str = "", along: str = "direction") -> FloorSpectrumSet:
    """The spectra whose variables have a prefix, over a dimension of their directions."""
    psa, pfa = data[f"{prefix}psa"], data[f"{prefix}pfa"]
    motions: tuple[str, ...] = ("that of the case",)
    if "motion" in psa.dims:
        motions = tuple(str(name) for name in data["motion"].values)
    else:
        psa, pfa = psa.expand_dims("motion"), pfa.expand_dims("motion")
    height = data.get("elevation", xr.full_like(data["station_floor"], np.nan, dtype=float))
    method = "pseudo-acceleration of oscillators on the floor, time histories with pounding"
    if "points_per_cycle" in data:
        points = float(data["points_per_cycle"])
        method += f", {points:.3g} points in a cycle of the highest frequency"
    stations = zip(
        data["station_building"].values, data["station_floor"].values, height.values, strict=True
    )
    return FloorSpectrumSet(
        frequency=np.asarray(data["frequency"].values, dtype=float),
        damping=np.asarray(data["damping"].values, dtype=float),
        stations=tuple(
            Station(str(b), str(floor), ("mass centre",), float(z)) for b, floor, z in stations
        ),
        directions=tuple(str(name) for name in data[along].values),
        psa=psa.transpose("motion", "damping", "station", along, "frequency").values,
        zpa=pfa.transpose("motion", "station", along).values,
        motions=motions,
        title=str(data.attrs.get("title", "")),
        method=method,
    )


def labelled(design: DesignFloorSpectra) -> Iterator[tuple[tuple[Cell, ...], tuple[int, int, int]]]:
    """The cells of `LABELS` and the index (damping, station, direction) of each spectrum."""
    source = design.source
    for s, station in enumerate(source.stations):
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                yield (station.building, station.floor, direction, cell(damping)), (d, s, x)


def curve_rows(
    before: tuple[Cell, ...], columns: Iterable[Array], after: tuple[Cell, ...] = ()
) -> list[tuple[Cell, ...]]:
    """Rows of a table for ordinates of one spectrum, with the same cells before and after each."""
    return [(*before, *map(cell, row), *after) for row in zip(*columns, strict=True)]


def curve_table(design: DesignFloorSpectra, name: str = "floor_spectra") -> Table:
    """Return all spectra as a table with a row for each frequency."""
    unit = design.source.unit
    columns = {"raw": design.computed, "broadened": design.psa}
    columns |= {name: design.at_design(values) for name, values in _statistics(design).items()}
    rows: list[tuple[Cell, ...]] = []
    for labels, at in labelled(design):
        rows += curve_rows(labels, [design.frequency, *(v[at] for v in columns.values())])
    heading = (*LABELS, ("frequency", "Hz"), *((column, unit) for column in columns))
    title = f"Floor response spectra; {design.broadening_text}"
    return Table(name, title, heading, tuple(rows))


def _peaks(design: DesignFloorSpectra) -> Table:
    """Return the peak and the zero-period acceleration of each spectrum."""
    source, unit = design.source, design.source.unit
    rows: list[tuple[Cell, ...]] = []
    for labels, (d, s, x) in labelled(design):
        at, raw = (d, s, x), design.raw[d, s, x]
        highest = float(source.frequency[int(np.argmax(raw))])
        numbers = (source.stations[s].elevation, raw.max(), highest, design.psa[at].max())
        rows.append((*labels, *map(cell, (*numbers, design.zpa[s, x], design.rigid[at]))))
    columns = heads(
        f"elevation [m]; raw peak [{unit}]; frequency of the raw peak [Hz]; broadened peak [{unit}]"
        f"; zero-period acceleration [{unit}]; {WITHIN}"
    )
    title = "Peaks and zero-period accelerations of the floor response spectra"
    return Table("floor_peaks", title, (*LABELS, *columns), tuple(rows))


def _statistics(design: DesignFloorSpectra) -> dict[str, Array]:
    """Statistics over several motions, at the list of the source."""
    source = design.source
    if len(source.motions) == 1:
        return {}
    wanted: tuple[Statistic, ...] = ("mean", *FRACTILES, "envelope")
    return {statistic_words(one): source.over_motions(one)[0] for one in wanted}


def floor_store(design: DesignFloorSpectra, inputs: str = "") -> xr.Dataset:
    """The products as a dataset, with the hash of what they were made from."""
    source = design.source
    curve = ("damping", "station", "direction")
    si, stations = {"units": source.unit}, source.stations
    within = f"raw stays within {100 * ZPA_TOLERANCE:g} % of zpa from here on"
    variables: dict[str, tuple[Any, ...]] = {
        "raw": ((*curve, "frequency"), design.raw, si | {"long_name": "as computed"}),
        "broadened": ((*curve, "design_frequency"), design.psa, si | {"long_name": "for design"}),
        "zpa": (curve[1:], design.zpa, si | {"long_name": "zero-period acceleration"}),
        "rigid_frequency": (curve, design.rigid, {"units": "Hz", "long_name": within}),
        "frequency": ("frequency", source.frequency, {"units": "Hz"}),
        "design_frequency": ("design_frequency", design.frequency, {"units": "Hz"}),
        "damping": ("damping", source.damping, {"units": "-"}),
        "direction": ("direction", words(source.directions)),
        "station": ("station", words(f"{s.building}.floor_{s.floor}" for s in stations)),
        "station_building": ("station", words(s.building for s in stations)),
        "station_floor": ("station", words(s.floor for s in stations)),
        "station_points": ("station", words(", ".join(s.points) for s in stations)),
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


def write_workbook(path: Path, design: DesignFloorSpectra) -> None:
    """Write a workbook: a list of its sheets, and one a building, direction and damping."""
    book = Workbook(write_only=True)
    source = design.source
    buildings = list(dict.fromkeys(station.building for station in source.stations))
    contents = book.create_sheet("contents")
    contents.column_dimensions["A"].width = LABEL_WIDTH
    _append(contents, ["case", source.title])
    for line in _method_lines(design):
        _append(contents, line)
    _append(contents, [])
    _append(contents, ["sheet", "building", "direction", "damping [-]"], bold=True)
    names: set[str] = {"contents"}
    for building in buildings:
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                # A name that the format allows and that no sheet has, in whatever case.
                wanted = f"{building} {direction} {100.0 * damping:g} %"
                clean = re.sub(r"[\[\]:*?/\\']", "_", wanted)
                name, count = clean[:LONGEST_NAME], 1
                while name.lower() in names:
                    count += 1
                    name = f"{clean[: LONGEST_NAME - len(str(count)) - 1]}~{count}"
                names.add(name.lower())
                _append(contents, [name, building, direction, float(damping)])
                _sheet(book, name, design, building, x, d)
    with atomic(path) as temporary:
        book.save(temporary)


def _method_lines(design: DesignFloorSpectra) -> list[list[Cell]]:
    return [
        ["quantity", "pseudo-acceleration of floor response spectra"],
        ["units", f"accelerations in {design.source.unit}, frequencies in Hz, elevations in m"],
        ["method", design.source.method],
        ["motions", design.motions_text],
        ["design", design.broadening_text],
        ["between frequencies", "straight lines on doubly logarithmic axes"],
        ["empty cells", "frequencies added for the corners of broadened peaks: not computed"],
    ]


def _sheet(book: Any, name: str, design: DesignFloorSpectra, building: str, x: int, d: int) -> None:
    source = design.source
    numbers = [s for s, station in enumerate(source.stations) if station.building == building]
    stations = [source.stations[s] for s in numbers]
    sheet = book.create_sheet(name)
    sheet.column_dimensions["A"].width = LABEL_WIDTH
    for column in range(2, 2 + 2 * len(numbers)):
        sheet.column_dimensions[get_column_letter(column)].width = COLUMN_WIDTH
    # One entry over both columns of a floor, for filters and copies.
    floors: dict[str, list[Cell]] = {
        "floor": [station.label for station in stations],
        "points": ["; ".join(station.points) for station in stations],
        "elevation [m]": [cell(station.elevation) for station in stations],
        f"zero-period acceleration [{source.unit}]": [cell(design.zpa[s, x]) for s in numbers],
        WITHIN: [cell(design.rigid[d, s, x]) for s in numbers],
    }
    head: list[list[Cell]] = [
        ["case", source.title],
        ["building", building],
        ["direction", source.directions[x]],
        ["damping [-]", float(source.damping[d])],
        *_method_lines(design),
        [],
        *([name, *(one for one in cells for _ in range(2))] for name, cells in floors.items()),
    ]
    for line in head:
        _append(sheet, line)
    titles = [f"{title} [{source.unit}]" for _ in numbers for title in ("raw", "broadened")]
    _append(sheet, ["frequency [Hz]", *titles], bold=True)
    # Frozen below the titles and right of the frequencies.
    sheet.freeze_panes = f"B{len(head) + 2}"
    pairs = [values[d, s, x] for s in numbers for values in (design.computed, design.psa)]
    for row in curve_rows((), [design.frequency, *pairs]):
        sheet.append(row)


def _append(sheet: Any, cells: Sequence[Cell], bold: bool = False) -> None:
    row = []
    for value in cells:
        entry = WriteOnlyCell(sheet, value=None)
        if isinstance(value, str):
            # As text whatever it begins with: a title such as "=1+1" is no formula.
            entry.value = ILLEGAL_CHARACTERS_RE.sub(" ", value)
            entry.data_type = "s"
        else:
            entry.value = value
        entry.alignment = Alignment(horizontal="left")
        entry.font = Font(bold=bold)
        row.append(entry)
    sheet.append(row)

"""Plausibility warnings: valid values outside of their usual range, and a few that contradict.

`usual.csv` holds the ranges. Most are about twice as wide as the usual values, so that a warning
is worth reading: they hold buildings from sheds to reactors.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from impactfem.case.alignment import misalignments
from impactfem.case.base import Section
from impactfem.case.contacts import UnilateralLaw
from impactfem.case.design_spectrum import DecreeSpectrum, EurocodeSpectrum
from impactfem.case.floors import Floor
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import SyntheticMotion
from impactfem.case.place import SEARCHED, Place, step, value_at
from impactfem.case.quantity import RIGID
from impactfem.case.report import STAGE_OF
from impactfem.case.source import Source, read_source
from impactfem.case.unused import unused
from impactfem.system.errors import Fault


@dataclass(frozen=True)
class Usual:
    """The usual range of some values."""

    #: Places in the case file, apart by blanks; ``*`` is any name or index, ``row`` any row of a
    #: table (CSV) that a key names. A last name may be a property, which no file states.
    keys: str
    low: float  #: least usual value in SI
    high: float  #: largest usual value in SI
    words: str  #: what is usual


def _read_usual() -> tuple[Usual, ...]:
    """Read the table of ranges."""
    text = Path(__file__).with_name("usual.csv").read_text(encoding="utf-8")
    lines = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    return tuple(
        Usual(row["keys"], float(row["low"]), float(row["high"]), row["usual"]) for row in lines
    )


USUAL = _read_usual()
"""Keys of the case file, columns of its tables, and properties of both, by `usual.csv`."""


def _row(key: str) -> Usual:
    """The range of a key."""
    return next(usual for usual in USUAL if key in usual.keys.split())


MODULUS, PGA = _row("materials.*.young_modulus"), _row("motions.*.pga")
STEP, LASTING = _row("motions.*.time_step"), _row("motions.*.duration")
PERIOD_PER_STOREY = (0.02, 0.5)
"""Usual first period of a building on a clamped base over its number of storeys [s]; that of frames
is about 0.1 s, of buildings of walls 0.05 s."""
FIT = (
    Usual("targets.*.modes.row.frequency", 0.05, 200.0, "0.3 to 50 Hz"),
    Usual("targets.*.modes.row.damping", 2e-3, 0.2, "0.5 % to 10 %"),
    Usual("targets.*.shape_deviation", 1e-3, 1.0, "0.02 to 0.1 of the largest amplitude"),
    Usual("targets.*.deviation", 1e-3, 1.0, "0.05 to 0.3 of each ordinate"),
)
"""Ranges of the file of a fit; deviations that are quantities have other units."""
FEWEST = 10
"""Fewest frequencies of spectra without a warning."""
HEAVY = 0.1
"""Mass of a device over that of its floor from which on it belongs into the model of the building:
US NRC SRP 3.7.2 (II.3.B); below 0.01 it may be left out."""
LOWEST_CORNER = 1000.0
"""Frequency above which contact points have no mass, from which on it is usual [Hz]: with 810 Hz
floor spectra of the paper's pair at 100 Hz change by 6 %."""


def unusual(values: Case | Section, source: Source, table: Iterable[Usual] = USUAL) -> list[Fault]:
    """Find values outside of their usual range: one warning a value or a column of a table.

    Args:
        values: A case, or the content of another file.
        source: What the file states.
        table: The ranges.
    """
    found: dict[tuple[str, str], Fault] = {}
    for usual in table:
        for keys in usual.keys.split():
            for fault in _outside(usual, keys.split("."), (), (source.raw, values), source):
                # A table that several buildings name has one warning for each of its columns, and
                # a property none if what it follows from has one.
                file = str(fault.file)
                keys_there = [at for other, at in found if other == file]
                known = [at for at in keys_there if ", " in at or at.startswith(f"{fault.key}.")]
                if not (fault.kind == "derived" and known):
                    found.setdefault((file, fault.key), fault)
    return list(found.values())


def _outside(
    usual: Usual, keys: list[str], place: Place, at: tuple[Any, Any], source: Source
) -> Iterator[Fault]:
    """Values outside of a range at the keys that are left: as written, and in SI."""
    raw, value = at
    if value is None:
        return
    if not keys:
        if isinstance(value, float | int) and not usual.low <= value <= usual.high:
            of = place
            while value_at(of, source.raw) is None:  # of a property, what it belongs to
                of = of[:-1]
            name = " ".join(map(str, place[len(of) :])).replace("_", " ")
            lead = f"{name} {value:.3g}; " if name else ""
            text = f"{lead}outside the usual range, {usual.words}: check value and unit"
            yield source.fault(of, raw, text, "derived" if name else "unusual")
    elif keys[0] == "row":
        if isinstance(raw, str):
            yield from _off_column(usual, keys[1:], value, source.path.parent / raw)
    elif keys[0] == "*" and isinstance(raw, Mapping | list):
        for part in raw if isinstance(raw, Mapping) else range(len(raw)):
            if place == ("contacts",):
                below = next(contact for contact in value if contact.table == part)
            else:
                below = value[part]
            yield from _outside(usual, keys[1:], (*place, part), (step(raw, part), below), source)
    elif keys[0] == "*" and isinstance(value, Mapping):
        for part, below in value.items():
            yield from _outside(usual, keys[1:], (*place, part), (None, below), source)
    elif keys[0] != "*":
        key = keys[0]
        below = value.get(key) if isinstance(value, Mapping) else getattr(value, key, None)
        stated = step(raw, key)
        derived = isinstance(getattr(type(value), key, None), property)
        if stated is not None or derived:
            yield from _outside(usual, keys[1:], (*place, key), (stated, below), source)


def _off_column(usual: Usual, column: list[str], rows: Any, file: Any) -> Iterator[Fault]:
    """A column of a table with values outside of a range: a wrong unit is that of all rows."""
    off = []
    for number, row in enumerate(rows, start=1):
        value = getattr(row, column[0])
        every = value if isinstance(value, tuple) else (value,)
        off += [(number, one) for one in every if one and not usual.low <= one <= usual.high]
    if off:
        (number, value), others = off[0], len({k for k, _ in off}) - 1
        row = rows[number - 1]
        where = f"floor {row.floor}" if isinstance(row, Floor) else f"row {number}"
        more = f"; the same applies to {others} more rows" if others else ""
        text = f"in SI; outside the usual range, {usual.words}: check the unit{more}"
        derived = isinstance(getattr(type(row), column[0], None), property)
        kind = "derived" if derived else "unusual"
        yield Fault(file, f"{where}, {column[0]}", float(f"{value:.6g}"), text, kind)


def implausible(case: Case, longest: float) -> list[Fault]:
    """Find implausible values of a case, one warning a value, with what is usual.

    The longest motion has this duration [s], 0 without one.
    """
    source = read_source(case.path, CaseFile)
    found = [*unusual(case, source), *unused(source, case)]
    for check in (
        _directions,
        _points,
        _heavy_devices,
        _given_spectra,
        _few_frequencies,
        _rigid_edges,
        _wall,
    ):
        found += check(source, case)
    # Names that no result can have, by their first word; a run knows the others.
    file = source.path.parent / str(value_at(("published",), source.raw))
    text = f"no result; their names begin with {', '.join(STAGE_OF)} (docs/run-folder.md)"
    strange = (name for name in case.published if name.split(".")[0] not in STAGE_OF)
    return found + [Fault(file, "name", name, text) for name in strange]


def _directions(source: Source, case: Case) -> Iterator[Fault]:
    """Spectra of motions in another direction."""
    for k, motion in enumerate(case.motions):
        spectrum = motion.spectrum if isinstance(motion, SyntheticMotion) else None
        if not isinstance(spectrum, EurocodeSpectrum | DecreeSpectrum):
            continue
        if spectrum.vertical != (motion.direction == "z"):
            kind = "vertical" if spectrum.vertical else "horizontal"
            text = f"its spectrum is the {kind} one (vertical of [motions.spectrum])"
            yield source.remark(("motions", k, "direction"), text)


def _points(source: Source, case: Case) -> Iterator[Fault]:
    """Contact points that are not aligned: one warning for each table of contacts."""
    misaligned: dict[Place, list[str]] = {}
    for contact in case.contacts:
        for one in misalignments(contact, case):
            table: Place = ("contacts", contact.table)
            place = (*table, one.side, "offset") if one.side else table
            if contact.table == SEARCHED:
                place = ("contact_search",)
            if not one.wrong:
                misaligned.setdefault(place, []).append(one.text)
    for at, (text, *others) in misaligned.items():
        more = f". The same applies to {len(others)} more of this table" if others else ""
        value = value_at(at, source.raw) if len(at) > 2 else None
        yield source.fault(at, value, text + more)


def _heavy_devices(source: Source, case: Case) -> Iterator[Fault]:
    """Devices with a tenth of the mass of their floor or more."""
    for k, device in enumerate(case.devices):
        rows = device.modes or ()
        along = [sum(one.effective_mass for one in rows if one.direction == c) for c in "xyz"]
        totals = {} if device.matrices is None else device.matrices.total_masses
        mass = device.mass or max(*along, *totals.values())
        building = case.building(device.building)
        levels = zip(building.floors, building.elevations, strict=True)
        z = device.anchor_points[0].point[2]
        floor = min(levels, key=lambda one: abs(one[1] - z))[0]
        if mass > HEAVY * floor.mass:
            text = (
                f"{mass / floor.mass:.3g} times the mass of floor {floor.floor} of "
                f"{building.name}, {1e-3 * floor.mass:.4g} t. Above {HEAVY:.0%} of the floor mass, "
                "equipment must be modelled with the building (SRP 3.7.2)"
            )
            model = "modes" if device.matrices is None else "matrices"
            yield source.remark(("devices", k, "mass" if device.mass else model), text)


def _given_spectra(source: Source, case: Case) -> Iterator[Fault]:
    """Given spectra and modes of devices without a direction of the ground."""
    for k, device in enumerate(case.devices):
        for key, rows in (("spectra", device.spectra), ("modes", device.modes)):
            known = {row.direction for row in rows or ()}
            lacking = [one.direction for one in case.motions if one.direction not in known]
            if known and lacking:
                text = f"no row along {' and '.join(lacking)}, along which the ground moves"
                yield source.remark(("devices", k, key), text)


def _few_frequencies(source: Source, case: Case) -> Iterator[Fault]:
    """Spectra with too few frequencies to show a peak."""
    count = len(case.spectra.frequency_values)
    if count < FEWEST:
        text = (
            f"{count} {'frequency' if count == 1 else 'frequencies'}: spectra miss their peaks; "
            'type frequencies = { minimum = "0.5 Hz", maximum = "100 Hz", per_decade = 30 }'
        )
        yield source.fault(("spectra", "frequencies"), None, text)


def _rigid_edges(source: Source, case: Case) -> Iterator[Fault]:
    """Edges without compliance, and a division of the flexibility within the band of spectra."""
    for name, law in case.contact_laws.items():
        if isinstance(law, UnilateralLaw) and law.edge_stiffness == RIGID:
            text = (
                "without a compliance of the edges, masses on them (facades, edge beams) raise the "
                "largest force in proportion to contact_frequency: use the default, or for a mass "
                "m per length m (2 π f)² with the highest frequency f of interest"
            )
            yield source.remark(("contact_laws", name, "edge_stiffness"), text)
    frequency = case.pounding.contact_frequency
    if frequency is not None and frequency < LOWEST_CORNER:
        text = (
            f"contact points without mass above {frequency:g} Hz change floor spectra up to 100 Hz;"
            f" usual is at least {LOWEST_CORNER:g} Hz"
        )
        yield source.remark(("pounding", "contact_frequency"), text)


def _wall(source: Source, case: Case) -> Iterator[Fault]:
    """A wall that the released building cannot reach: it swings back about as far."""
    wall = case.wall_impact
    if wall is None or case.structure is None:
        return
    building = case.building(wall.building)
    heights = {floor: z - building.base for floor, z in building.levels.items()}
    higher = max(heights[k] for k in wall.floors) / heights[wall.displaced_floor]
    reach = abs(wall.displacement) * max(1.0, higher)
    if wall.gap > reach:
        text = f"the building swings back {reach:.3g} m at most; usual is a gap of half of that"
        yield source.remark(("wall_impact", "gap"), text)

"""Usual values of the keys of a case file, and of the columns of its tables.

Most ranges reach about twice as far as what is usual, so that a warning is worth reading: they hold
buildings from sheds to reactors.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from impactfem.case.base import Section
from impactfem.case.floors import Floor
from impactfem.case.model import Case
from impactfem.case.place import Place, step
from impactfem.case.source import Source
from impactfem.system.errors import Fault


@dataclass(frozen=True)
class Usual:
    """The usual range of a value."""

    #: Its place in the case file; ``*`` is any name or index, ``row`` any row of a table (CSV) that
    #: a key names.
    keys: str
    low: float  #: least usual value in SI
    high: float  #: largest usual value in SI
    words: str  #: what is usual


MODEL = "buildings.*.structure."
SOIL = "buildings.*.soil."
MODULUS = Usual(
    "materials.*.young_modulus", 3e8, 2.5e11, "concrete 20 to 45 GPa, masonry 1 to 15 GPa"
)
PGA = Usual("motions.*.pga", 0.2, 15.0, "0.5 to 10 m/s2")
STEP = Usual("motions.*.time_step", 1e-4, 0.04, "1 to 20 ms")
LASTING = Usual("motions.*.duration", 2.0, 300.0, "5 to 60 s")
MASS = Usual("buildings.*.floors.row.mass", 1e3, 3e7, "20 to 5000 t")
PERIOD_PER_STOREY = (0.02, 0.5)
"""Usual first period of a building on a clamped base over its number of storeys [s]; that of frames
is about 0.1 s, of buildings of walls 0.05 s."""
USUAL = (
    MODULUS,
    Usual("materials.*.density", 300.0, 1e4, "concrete 2200 to 2600 kg/m3, steel 7850 kg/m3"),
    Usual("materials.*.compressive_strength", 1e6, 2e8, "concrete 12 to 100 MPa"),
    Usual("materials.*.poisson_ratio", 0.05, 0.4, "0.15 to 0.3"),
    *(
        Usual(f"{place}.{key}", low, high, words)
        for place in ("damping", "damping_cases.*", "buildings.*.damping", "devices.*.damping")
        for key, low, high, words in (
            ("ratio", 2e-3, 0.2, "1 % to 10 %"),
            ("ratios.*", 2e-3, 0.2, "1 % to 10 %"),
            ("frequencies.*", 0.05, 200.0, "0.5 to 50 Hz"),
            ("mass_coefficient", 0.0, 10.0, "below 5 1/s"),
            ("stiffness_coefficient", 0.0, 0.03, "below 10 ms"),
        )
    ),
    Usual("damping_cases.*.restitution", 0.1, 1.0, "0.4 to 0.9"),
    Usual("buildings.*.stiffness_factor", 0.02, 5.0, "0.1 to 1: cracked or fitted storeys"),
    Usual("buildings.*.second_moment_factor", 0.02, 5.0, "0.1 to 1"),
    Usual("buildings.*.length", 2.0, 400.0, "5 to 200 m"),
    Usual("buildings.*.width", 2.0, 400.0, "5 to 200 m"),
    Usual("buildings.*.setback", 0.0, 20.0, "0 to 5 m"),
    Usual("buildings.*.rigid_below", 0.0, 3.0, "0.1 to 1 m"),
    Usual("buildings.*.rigid_above", 0.0, 3.0, "0.1 to 1 m"),
    Usual(f"{SOIL}shear_velocity", 50.0, 5e3, "150 to 3000 m/s"),
    Usual(f"{SOIL}density", 1e3, 3500.0, "1600 to 2700 kg/m3"),
    Usual(f"{SOIL}damping_ratio", 0.0, 0.15, "0 to 10 %; SRP 3.7.2 allows 15 %"),
    Usual(f"{SOIL}embedment", 0.0, 50.0, "0 to 20 m"),
    Usual(f"{SOIL}raft.length", 2.0, 500.0, "5 to 200 m"),
    Usual(f"{SOIL}raft.width", 2.0, 500.0, "5 to 200 m"),
    Usual(f"{SOIL}raft.radius", 1.0, 250.0, "3 to 100 m"),
    Usual(f"{SOIL}raft.thickness", 0.1, 20.0, "0.5 to 6 m"),
    Usual(f"{SOIL}raft.density", 500.0, 8e3, "2400 kg/m3"),
    Usual(f"{SOIL}raft.mass", 1e3, 1e9, "20 to 50,000 t"),
    Usual(f"{MODEL}storey_stiffness_factor", 0.02, 5.0, "0.1 to 1: cracked or fitted"),
    Usual(f"{MODEL}calibration.frequency", 0.1, 40.0, "0.3 to 15 Hz"),
    Usual(f"{MODEL}drilling", 1e-3, 1e3, "1"),
    Usual(f"{MODEL}mesh.length", 2.0, 400.0, "5 to 200 m"),
    Usual(f"{MODEL}mesh.width", 2.0, 400.0, "5 to 200 m"),
    Usual(f"{MODEL}mesh.slab_thickness", 0.05, 3.0, "0.1 to 1 m"),
    Usual(f"{MODEL}mesh.slabs.*.thickness", 0.05, 3.0, "0.1 to 1 m"),
    Usual(f"{MODEL}mesh.wall_setback.*", 0.0, 2.0, "0 to 0.5 m"),
    Usual(f"{MODEL}mesh.parapet.height", 0.1, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.parapet.thickness", 0.05, 2.0, "0.1 to 0.5 m"),
    *(
        Usual(f"{MODEL}mesh.{key}", 0.05, 4.0, "0.3 to 1.5 m")
        for key in ("size", "floor_size", "storey_size", "beam_size", "column_size")
    ),
    Usual(f"{MODEL}mesh.shells.*.thickness", 0.003, 3.0, "0.1 to 1 m"),
    Usual(f"{MODEL}mesh.beams.*.width", 0.02, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.beams.*.depth", 0.02, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.beams.*.offset", -2.0, 2.0, "0 to -1 m: below the slab"),
    Usual("contacts.*.gap", 0.0, 0.6, "0 to 30 cm"),
    Usual("contacts.*.bearing_area", 1e-2, 200.0, "0.1 to 50 m2"),
    Usual("contact_laws.*.stiffness", 1e7, 1e13, "1e8 to 1e11 N/m, 1e9 to 1e12 N/m^1.5"),
    Usual("contact_laws.*.restitution", 0.1, 1.0, "0.4 to 0.9"),
    Usual("contact_laws.*.damping_ratio", 0.0, 0.6, "5 % to 35 %"),
    Usual("contact_laws.*.slowest_approach", 0.0, 0.1, "0.1 to 10 mm/s"),
    *(
        Usual(f"{stage}.contact_spacing", 0.1, 10.0, "0.5 to 3 m")
        for stage in ("pounding", "wall_impact")
    ),
    *(
        Usual(f"{stage}.time_step", 1e-6, 0.01, "0.1 to 2 ms")
        for stage in ("pounding", "transient", "wall_impact", "device_analysis")
    ),
    Usual("transient.duration", 0.1, 1e3, "that of the motion"),
    Usual("transient.maximum_frequency", 5.0, 1e3, "30 to 200 Hz"),
    Usual("transient.shift", 1.0, 200.0, "10 to 60 Hz"),
    Usual("transient.tolerance", 1e-6, 0.2, "0.1 % to 5 %"),
    Usual("transient.largest_basis", 50.0, 1e5, "some hundreds to some thousands"),
    PGA,
    STEP,
    Usual("motions.*.resample", STEP.low, STEP.high, STEP.words),
    LASTING,
    Usual("motions.*.damping", 2e-3, 0.2, "5 %"),
    Usual("motions.*.spectrum.corner_periods.*", 0.01, 20.0, "0.05 to 10 s"),
    Usual("motions.*.spectrum.amplification", 1.5, 4.0, "2.5 to 3"),
    Usual("motions.*.spectrum.importance_factor", 0.5, 4.0, "0.8 to 1.6"),
    Usual("wave_passage.apparent_velocity", 200.0, 2e4, "500 to 5000 m/s"),
    Usual("spectra.damping.*", 2e-3, 0.2, "0.5 % to 10 %"),
    Usual("spectra.frequencies.minimum", 0.02, 10.0, "0.1 to 1 Hz"),
    Usual("spectra.frequencies.maximum", 20.0, 1e3, "33 to 500 Hz"),
    Usual("spectra.frequencies.per_decade", 10.0, 500.0, "30 to 100"),
    Usual("spectra.broadening", 0.0, 0.3, "10 % to 15 %"),
    Usual("devices.*.mass", 1.0, 1e5, "10 kg to 50 t"),
    Usual("devices.*.mass_height", -20.0, 20.0, "0.2 to 5 m"),
    Usual("devices.*.radius", 0.02, 5.0, "0.1 to 2 m"),
    Usual("devices.*.supports.*.radius", 0.02, 5.0, "0.1 to 2 m"),
    Usual("devices.*.modes.row.frequency", 0.3, 1e3, "1 to 100 Hz"),
    Usual("devices.*.modes.row.effective_mass", 0.0, 1e5, "10 kg to 50 t"),
    Usual("devices.*.modes.row.height", -20.0, 20.0, "0.2 to 5 m"),
    Usual("devices.*.modes.row.damping", 2e-3, 0.2, "1 % to 10 %"),
    Usual("device_analysis.broadening", 0.0, 0.3, "10 % to 15 %"),
    Usual("wall_impact.duration", 0.05, 100.0, "0.5 to 5 s"),
    Usual("wall_impact.gap", 0.0, 0.6, "0 to 30 cm"),
    Usual("wall_impact.displacement", -0.6, 0.6, "-10 to -1 cm"),
    MASS,
    Usual("buildings.*.floors.row.storey_height", 1.5, 20.0, "2.5 to 8 m"),
    Usual("buildings.*.floors.row.A", 1e-4, 1e4, "0.1 to 300 m2"),
    Usual("buildings.*.floors.row.Avy", 1e-5, 1e4, "1e-3 to 200 m2"),
    Usual("buildings.*.floors.row.Avz", 1e-5, 1e4, "1e-3 to 200 m2"),
    Usual("buildings.*.floors.row.Ix", 1e-6, 1e7, "0.1 to 1e5 m4"),
    Usual("buildings.*.floors.row.Iy", 1e-6, 1e7, "0.1 to 1e5 m4"),
    Usual("buildings.*.floors.row.Iz", 1e-6, 1e7, "0.1 to 1e5 m4"),
    Usual(f"{MODEL}mesh.walls.row.thickness", 0.05, 5.0, "0.1 to 2 m"),
    Usual(f"{MODEL}mesh.beams.row.width", 0.05, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.beams.row.depth", 0.05, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.beams.row.offset", -2.0, 2.0, "0 to -1 m: below the slab"),
    Usual(f"{MODEL}mesh.columns.row.width_x", 0.05, 5.0, "0.2 to 2 m"),
    Usual(f"{MODEL}mesh.columns.row.width_y", 0.05, 5.0, "0.2 to 2 m"),
)
"""Keys of the case file, and columns of its tables; no damping at all is another warning."""


FIT = (
    Usual("targets.*.modes.row.frequency", 0.05, 200.0, "0.3 to 50 Hz"),
    Usual("targets.*.modes.row.damping", 2e-3, 0.2, "0.5 % to 10 %"),
    Usual("targets.*.shape_deviation", 1e-3, 1.0, "0.02 to 0.1 of the largest amplitude"),
    Usual("targets.*.deviation", 1e-3, 1.0, "0.05 to 0.3 of each ordinate"),
)
"""The same of the file of a fit; deviations there that are quantities have units of their own."""


def unusual(found: Case | Section, source: Source, table: Iterable[Usual] = USUAL) -> list[Fault]:
    """Values outside of their usual range, one warning a value or a column of a table.

    They are those of a case, or of another file with a table of its own.
    """
    # A table that several buildings name has one warning for each of its columns.
    return list(
        dict.fromkeys(
            fault
            for usual in table
            for fault in _outside(usual, usual.keys.split("."), (), source.raw, found, source)
        )
    )


def _outside(
    usual: Usual, keys: list[str], place: Place, raw: Any, value: Any, source: Source
) -> Iterator[Fault]:
    """Values outside of their range, of what is written in the case file and its tables."""
    # The keys are those that are left from the place on; the file has there what is raw, the case
    # the value, in SI.
    if raw is None or value is None:
        return
    if not keys:
        if isinstance(value, float | int) and not usual.low <= value <= usual.high:
            yield source.fault(place, raw, f"usual is {usual.words}")
    elif keys[0] not in ("*", "row"):
        (key, *rest), table = keys, isinstance(value, Mapping)
        below = value.get(key) if table else getattr(value, key, None)
        yield from _outside(usual, rest, (*place, key), step(raw, key), below, source)
    elif keys[0] == "row" and isinstance(raw, str):
        file, column = source.path.parent / raw, keys[1]
        # A wrong unit in the header is that of all rows: they have one warning.
        found = {number: getattr(row, column) for number, row in enumerate(value, start=1)}
        off = [
            number
            for number, one in found.items()
            if one is not None and not usual.low <= one <= usual.high
        ]
        if off:
            row = value[off[0] - 1]
            where = f"floor {row.floor}" if isinstance(row, Floor) else f"row {off[0]}"
            text = f"in SI; usual is {usual.words}"
            text += f"; so it is in {len(off) - 1} more" if len(off) > 1 else ""
            yield Fault(file, f"{where}, {column}", float(f"{found[off[0]]:.6g}"), text)
    elif keys[0] == "*" and isinstance(raw, Mapping | list):
        for part in raw if isinstance(raw, Mapping) else range(len(raw)):
            if place == ("contacts",):
                below = next(contact for contact in value if contact.table == part)
            else:
                below = value[part]
            yield from _outside(usual, keys[1:], (*place, part), step(raw, part), below, source)

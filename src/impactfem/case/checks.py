"""What does not go together between the sections of a case.

Each check takes a case, as far as it could be read, and how it is read; it gives the faults with
their places. `CHECKS` says which sections a check needs besides those that it looks up itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from impactfem.case.contact_checks import distance_faults, struck_edge_faults
from impactfem.case.contacts import KelvinVoigtLaw
from impactfem.case.design_spectrum import TABLE, TableSpectrum, read_spectrum
from impactfem.case.devices import DeviceSupport, unknown_patterns
from impactfem.case.loads import read_force_table
from impactfem.case.members import TOUCH
from impactfem.case.model import Case
from impactfem.case.motions import RecordMotion, RestMotion
from impactfem.case.place import Place
from impactfem.case.quantity import CALIBRATED
from impactfem.case.reading import Reading
from impactfem.case.structure import GeneratedMesh
from impactfem.case.transient import OUTSIDE, Probe
from impactfem.system.errors import Fault

REDUCED = {
    "wall_impact": "the impact on a wall",
    "devices": "the study of devices",
    "damping_cases": "the damping cases",
}
"""Sections that use the reduced basis, by name, and what they are."""
FOLDERS = ("figures", "tables", "products", "ensemble", "design")
"""Folders of a run, in which those of further buildings with a 3D model are."""
UNIQUE = (
    *(("buildings", "name"), ("motions", "direction")),
    *(("damping_cases", "name"), ("devices", "name")),
)
"""Arrays of tables with the key that only one table of each may have with a value."""


def missing_sections(reading: Reading) -> Iterator[Fault]:
    """What needs a section that the file does not have, from the file as it stands."""

    def lacks(place: Place, expected: str) -> Fault:
        found = reading.value(*place)
        return reading.source.fault(
            place, found if not isinstance(found, dict | list) else None, expected
        )

    raw = reading.source.raw
    if not (raw.get("motions") or raw.get("loads")):
        expected = "missing; expected [[motions]], [[loads]] or both: what moves the buildings"
        yield reading.source.fault(("motions",), None, expected)
    # A [structure] of an earlier version, and [buildings] that is no array, are other faults.
    structured = reading.three_d or "structure" in raw or isinstance(raw.get("buildings"), dict)
    for section in ("wall_impact", "transient"):
        if section in raw and not structured:
            expected = "expected a [buildings.structure] beside it: the 3D model that moves"
            yield lacks((section,), expected)
    if "wall_impact" not in raw:
        expected = "expected a section [wall_impact] beside it: the impact that gives it"
        laws = raw.get("contact_laws")
        for name, law in laws.items() if isinstance(laws, dict) else ():
            for key in ("stiffness", "restitution"):
                of_type = isinstance(law, dict) and law.get("type") == "kelvin-voigt"
                if of_type and law.get(key) == CALIBRATED:
                    yield lacks(("contact_laws", name, key), expected)
        for index, entry in reading.tables("damping_cases"):
            if entry.get("restitution") == CALIBRATED:
                yield lacks(("damping_cases", index, "restitution"), expected)
    if reading.value("transient", "serve_damping_cases") is True and "damping_cases" not in raw:
        expected = "expected [[damping_cases]] beside it: the dampings to serve"
        yield lacks(("transient", "serve_damping_cases"), expected)
    if "devices" in raw:
        needed = {
            "buildings.structure": "the 3D model of their building",
            "transient": "the response of that model in time",
        }
        there = raw.keys() | ({"buildings.structure"} if structured else set())
        lacking = [f"[{name}]: {what}" for name, what in needed.items() if name not in there]
        if lacking:
            yield lacks(("devices",), f"expected beside them {', and '.join(lacking)}")
    elif "device_analysis" in raw:
        yield lacks(("device_analysis",), "expected [[devices]] beside it: the devices to analyse")
    if any(isinstance(reading.value(*at, "damping"), list) for at in reading.three_d.values()):
        solver = reading.value("transient", "solver")
        if solver != "full":
            expected = (
                "expected 'full' beside [[buildings.structure.damping]]: with damping by part "
                "there is no reduced basis"
            )
            yield reading.source.fault(("transient", "solver"), solver, expected)
        for name, what in REDUCED.items():
            if name in raw:
                expected = (
                    f"expected none beside [[buildings.structure.damping]]: {what} uses the "
                    "reduced basis, which serves one Rayleigh damping of the whole building at a "
                    "time"
                )
                yield lacks((name,), expected)


def duplicates(reading: Reading) -> Iterator[Fault]:
    """Names and directions that only one table may have, from the file as it stands."""
    for group, key in UNIQUE:
        seen: dict[str, int] = {}
        tables = dict(reading.tables(group))
        for index, entry in tables.items():
            value = entry.get(key)
            if not isinstance(value, str):
                continue
            # Files are named by these names: on some systems X and x are one file.
            first = seen.setdefault(value.lower(), index)
            if first != index:
                alike = value == tables[first].get(key)
                of_case = "" if alike else ", upper and lower case alike"
                expected = f"duplicate {key}{of_case}, the first is {group}[{first}].{key}"
                yield reading.source.fault((group, index, key), value, expected)


def structure_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Buildings with a 3D model whose floors have a gap, or whose name another thing has.

    Floors are named by their number in the mesh: there is no gap between 1 and the top. Of a
    further building with a 3D model folder and results have the name.
    """
    for building in case.buildings:
        numbers = [floor.floor for floor in building.floors]
        if building.name in reading.three_d and numbers != list(range(1, len(numbers) + 1)):
            found = ", ".join(map(str, numbers))
            expected = f"expected a building with floors from 1 without a gap, found {found}"
            yield reading.source.fault(reading.three_d[building.name], None, expected)
    devices = {str(entry.get("name")).lower() for _, entry in reading.tables("devices")}
    for name, (_, index, _) in list(reading.three_d.items())[1:]:
        if name.lower() in FOLDERS or name.lower() in devices:
            what = "a folder of the run" if name.lower() in FOLDERS else "one of [[devices]]"
            expected = f"expected a name for a second building with a 3D model that {what} has not"
            yield reading.source.fault(("buildings", index, "name"), name, expected)


def pairs_twice(case: Case, reading: Reading) -> Iterator[Fault]:
    """The same two points twice, which would double the stiffness of their contact unseen."""
    seen = set()
    for contact in case.contacts:
        if (contact.a, contact.b) in seen:
            expected = (
                f"expected each pair of points once, found {contact.a.label} and "
                f"{contact.b.label} twice"
            )
            yield reading.fault(("contacts",), reading.value("contacts"), expected)
            return
        seen.add((contact.a, contact.b))


def spectrum_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Motions whose damping the table of their design spectrum does not have."""
    for index, motion in enumerate(case.motions):
        if isinstance(motion, RecordMotion | RestMotion):
            continue
        if isinstance(motion.spectrum, TableSpectrum):
            file = reading.value(*reading.original(("motions", index, "spectrum", "file")))
            table = reading.table(file, TABLE, read_spectrum)
            if table is not None and table.at(motion.damping) is None:
                expected = f"expected a damping of {file}: {table.dampings}"
                yield reading.fault(("motions", index, "damping"), motion.damping, expected)


def calibrated_contacts(case: Case, reading: Reading) -> Iterator[Fault]:
    """Contacts with a law that is calibrated on a building they do not touch."""
    if case.wall_impact is None or case.structure is None:
        return
    building = case.wall_impact.building
    told: set[int] = set()
    for contact in case.contacts:
        law = case.contact_laws[contact.law]
        ends = (contact.a.building, contact.b.building)
        calibrated = isinstance(law, KelvinVoigtLaw) and law.calibrated
        if calibrated and building not in ends and contact.table not in told:
            told.add(contact.table)
            expected = (
                f"expected a law with values of its own: '{contact.law}' is calibrated on "
                f"{building}, the contact is of {' and '.join(ends)}"
            )
            yield reading.fault(("contacts", contact.table, "law"), contact.law, expected)


def bare_storeys(case: Case, reading: Reading) -> Iterator[Fault]:
    """Storeys of a generated building in which nothing stands."""
    for structure in case.structures:
        if not isinstance(structure.mesh, GeneratedMesh):
            continue
        stood_in = {
            k for row in (*structure.mesh.walls, *structure.mesh.columns) for k in row.levels
        }
        floors = case.building(structure.building).floors
        bare = [str(one.floor) for one in floors if one.floor not in stood_in]
        if bare:
            mesh = (*reading.three_d[structure.building], "mesh")
            tables = [reading.value(*mesh, key) for key in ("walls", "columns")]
            expected = (
                f"no wall and no column stands in storey {', '.join(bare)}; expected one or more "
                f"in each storey, in {' or '.join(filter(None, tables))}"
            )
            yield reading.source.fault((*mesh, "walls"), tables[0], expected)


def calibrated_structure(case: Case, reading: Reading) -> Iterator[Fault]:
    """A calibration on the 3D model's modes, without the 3D model of a building it names."""
    if case.calibration is None or not case.calibration.from_structure:
        return
    named = {target.building for target in case.calibration.targets}
    models = [one.building for one in case.structures]
    if case.structure is None:
        expected = "expected a [buildings.structure], whose modes are the targets"
    elif not named.intersection(models):
        expected = f"targets of the building with a 3D model, {' or '.join(models)}"
    else:
        return
    yield reading.fault(("calibration", "from_structure"), True, expected)


def load_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Loads at an angle to the edges of a generated building, which take its 3D model's forces."""
    edges = {
        one.building: one.mesh.impact_edge
        for one in case.structures
        if isinstance(one.mesh, GeneratedMesh)
    }
    for index, loads in enumerate(case.loads):
        table = read_force_table(loads.file, [])
        loaded = set() if table is None else {building for building, _ in table.floors}
        for name, edge in edges.items():
            across = abs(loads.direction["xyz".index(edge[0])])
            if name in loaded and across < 1.0 - 1e-6:
                expected = (
                    f"expected a direction along {edge[0]}, at right angles to the impact edge of "
                    f"{name}: forces act on the edges of slabs in its 3D model"
                )
                yield reading.fault(("loads", index, "direction"), list(loads.direction), expected)


def ensemble_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """What an ensemble lacks: other motions, a folder of records, a 3D model for its members."""
    ensemble, transient = case.ensemble, case.transient
    if ensemble is None:
        return
    there = ensemble.motions
    place, records = ("ensemble", "records"), ensemble.records
    if there is None and records is not None and records.is_dir():
        there = len(ensemble.files())
    carried, of = ensemble.structure_motions, ("ensemble", "structure_motions")
    if carried and there is not None and carried > there:
        yield reading.fault(of, carried, f"expected at most all members, {there}")
    if carried and transient is None and "transient" not in reading.source.raw:
        expected = "expected 0, or a section [transient], the 3D model"
        yield reading.fault(of, carried, expected)
    elif carried and transient is not None and transient.solver == "full":
        expected = "expected 0, or a [transient] with another solver than 'full'"
        yield reading.fault(of, carried, f"{expected}: members take the reduced model")
    elif carried and transient is not None and transient.forces is not None:
        expected = "expected 0: each member has its own impact forces, not transient.forces"
        yield reading.fault(of, carried, expected)
    if any(isinstance(motion, RestMotion) for motion in case.motions):
        expected = "expected [[motions]] as well: ground at rest has no other motions"
        yield reading.fault(("ensemble",), None, expected)
        return
    recorded = [motion for motion in case.motions if isinstance(motion, RecordMotion)]
    if ensemble.motions is not None and recorded:
        expected = "synthetic motions only: other seeds of a record there are none; use records"
        yield reading.fault(("ensemble", "motions"), ensemble.motions, expected)
    if records is None:
        return
    if len(reading.tables("motions")) != 1 or (case.motions and not recorded):
        expected = "expected a case with one motion of type 'record', whose file the records take"
        yield reading.fault(place, str(records), expected)
    if not records.is_dir():
        expected = "expected a folder of records; there is none of this name"
        yield reading.fault(place, str(records), expected)
    elif len(ensemble.files()) < 2:
        expected = f"at least two records in it, found {len(ensemble.files())}"
        yield reading.fault(place, str(records), expected)
    elif strange := sorted(set(ensemble.entries()) - set(ensemble.files())):
        expected = f"expected ordinary files only; {strange[0].name} in it is none"
        yield reading.fault(place, str(records), expected)


def device_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Anchors beside the building, probes that there are not, an analysis that does not fit."""
    transient, analysis = case.transient, case.device_analysis
    structures = {one.building: one for one in case.structures}
    for index, device in enumerate(case.devices):
        if device.building in structures:
            structure, levels = structures[device.building], case.building(device.building).levels
            of = ("", device.building)
            probes = [one for one in transient.probes if one.building in of] if transient else []
            for k, anchor in enumerate(device.anchors):
                own: Place = ("supports", k) if device.supports else ()
                place = ("devices", index, *own)
                if isinstance(structure.mesh, GeneratedMesh):
                    wrong = "; ".join(_misplaced(anchor, structure.mesh, levels))
                    if wrong:
                        yield reading.written((*place, "point"), wrong)
                unknown = list(unknown_patterns(anchor.envelope, probes, list(levels)))
                if unknown and (transient is not None or "transient" not in reading.source.raw):
                    expected = (
                        "expected names of probes of [transient], or patterns of such names: there "
                        f"is none for {', '.join(unknown)}"
                    )
                    yield reading.written((*place, "envelope"), expected)
    if transient is None or analysis is None:
        return
    if analysis.time_step is not None and analysis.time_step > transient.time_step * (1.0 + 1e-9):
        expected = f"expected at most the time step of [transient], {transient.time_step:g} s"
        yield reading.written(("device_analysis", "time_step"), expected)
    if analysis.envelope_dampings and "damping_cases" not in reading.source.raw:
        expected = "expected [[damping_cases]] beside it: there is one damping only"
        yield reading.written(("device_analysis", "envelope_dampings"), expected)


def _misplaced(
    device: DeviceSupport, mesh: GeneratedMesh, levels: dict[int, float]
) -> Iterator[str]:
    """What is wrong with the point of a device in a generated mesh, in words."""
    x, y, z = device.point
    if not (-TOUCH <= x <= mesh.length + TOUCH and -TOUCH <= y <= mesh.width + TOUCH):
        yield (
            f"outside the building; expected x from 0 to {mesh.length:g} m and y from 0 to "
            f"{mesh.width:g} m"
        )
    if levels:
        floor = min(levels, key=lambda k: abs(levels[k] - z))
        within = mesh.slab_thickness / 2.0
        if abs(levels[floor] - z) > within + TOUCH:
            yield (
                f"at the level of no floor; expected z within half of the slab's thickness, "
                f"{within:g} m, of a floor: the nearest, floor {floor}, is at {levels[floor]:g} m"
            )


def transient_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """What does not go together between the response in time and the building or the sticks."""
    transient = case.transient
    if transient is None:
        return
    computed = None if transient.forces is not None else _computed_duration(case, reading)
    if computed is not None:
        if transient.duration is None and transient.time_step > computed / 2.0:
            expected = f"expected at most half of the duration, {computed:g} s"
            yield reading.written(("transient", "time_step"), expected)
        if transient.duration is not None and transient.duration > computed * (1.0 + 1e-9):
            expected = f"expected at most what is computed of the sticks, {computed:g} s"
            yield reading.written(("transient", "duration"), expected)
    known, start = transient.duration or computed, transient.export_start
    if transient.export and start is not None and known is not None and start >= known:
        expected = f"expected less than what is computed, {known:g} s"
        yield reading.written(("transient", "export_start"), expected)
    for view in case.views:
        yield from _faults_of_model(view, reading)


def _faults_of_model(view: Case, reading: Reading) -> Iterator[Fault]:
    """What does not go together between the response in time and one of the 3D models."""
    transient, structure = view.transient, view.structure
    if transient is None or structure is None:
        return
    building = view.building(structure.building)
    mesh, levels = structure.mesh, (building.base, *building.elevations)
    of = building.name if view.whole.further_structures else "the building"
    if isinstance(mesh, GeneratedMesh):
        edge = mesh.length if mesh.impact_edge.startswith("y") else mesh.width
        if abs(transient.eccentricity) > edge / 2.0:
            expected = f"expected a distance within the edge, {edge / 2.0:g} m to either side"
            yield reading.written(("transient", "eccentricity"), expected)
        if len(levels) > 1:
            yield from _outside_faults(reading, view, mesh, levels, of)
    numbers = [floor.floor for floor in building.floors]
    absent = [str(floor) for floor in transient.floors or () if numbers and floor not in numbers]
    if absent:
        expected = f"no floor {', '.join(absent)} in {building.name}; expected some of {numbers}"
        yield reading.written(("transient", "floors"), expected)
    for index, probe in view.numbered_probes:
        level = re.search("_([1-9][0-9]*)", probe.group or "")
        if level is not None and 0 < len(levels) - 1 < int(level[1]):
            expected = f"expected a number of 1 to {len(levels) - 1}, the floors of {of}"
            yield reading.written(("transient", "probes", index, "group"), expected)


def _outside_faults(
    reading: Reading, view: Case, mesh: GeneratedMesh, levels: tuple[float, ...], of: str
) -> Iterator[Fault]:
    """Probes away from the box around a generated building; its nodes are not known yet."""
    top = levels[-1] + (0.0 if mesh.acroterion is None else mesh.acroterion.height)
    box = ((0.0, mesh.length), (0.0, mesh.width), (levels[0], top))
    sizes = (mesh.size, mesh.floor_size, mesh.storey_size, mesh.beam_size, mesh.column_size)
    # As far as the stage may take the nearest node for the point.
    away = max(OUTSIDE, *(0.5 * size for size in sizes if size is not None))
    for index, probe in view.numbered_probes:
        for key, point in _points_of(probe):
            inside = zip(point, box, strict=True)
            if all(low - away <= x <= high + away for x, (low, high) in inside):
                continue
            sides = ", ".join(
                f"{axis} of {low:g} to {high:g} m"
                for axis, (low, high) in zip("xyz", box, strict=True)
            )
            expected = f"expected a point of {of}, which has {sides}"
            yield reading.fault(("transient", "probes", index, key), list(point), expected)


def _points_of(probe: Probe) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """The points that a probe is written with, by their keys."""
    for key, point in (("point", probe.point), ("from", probe.start), ("to", probe.end)):
        if point is not None:
            yield key, point


def _computed_duration(case: Case, reading: Reading) -> float | None:
    """Time that is computed of the sticks [s]; None when a record has to be read to know it."""
    if reading.left_out & {"pounding", "motions"}:
        return None
    if case.pounding.duration is not None:
        return case.pounding.duration
    known = [m.duration for m in case.motions if not isinstance(m, RecordMotion)]
    return max(known, default=None) if len(known) == len(case.motions) else None


CHECKS: tuple[tuple[Callable[[Case, Reading], Iterator[Fault]], frozenset[str]], ...] = (
    (struck_edge_faults, frozenset()),
    (structure_faults, frozenset()),
    (pairs_twice, frozenset()),
    (spectrum_faults, frozenset()),
    (calibrated_contacts, frozenset()),
    (device_faults, frozenset()),
    (bare_storeys, frozenset({"structure"})),
    (ensemble_faults, frozenset()),
    (transient_faults, frozenset()),
    (calibrated_structure, frozenset({"structure"})),
    (load_faults, frozenset({"structure", "transient"})),
    (distance_faults, frozenset()),
)

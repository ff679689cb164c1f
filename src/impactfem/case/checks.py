"""Consistency checks between the sections of a case.

A check takes the valid sections of a case, and how it is read; it gives the places in the
file that are at fault with what was expected there. The name of a check is the kind of its faults.
"""

import re
from collections.abc import Iterator

from impactfem.case.alignment import misalignments
from impactfem.case.base import nearest
from impactfem.case.buildings import Building, GeneratedMesh
from impactfem.case.contact_checks import Finding, of_contacts, of_search, of_struck_sides
from impactfem.case.contacts import KelvinVoigtLaw, UnilateralLaw
from impactfem.case.damping import DampingEntry, RayleighDamping, TableDamping
from impactfem.case.design_spectrum import TABLE, TableSpectrum, read_spectrum
from impactfem.case.equipment_checks import of_equipment
from impactfem.case.members import TOUCH
from impactfem.case.model import Case
from impactfem.case.motions import RecordMotion, RestMotion, SyntheticMotion, read_force_table
from impactfem.case.place import Place
from impactfem.case.quantity import CALIBRATED
from impactfem.case.reading import Reading
from impactfem.case.soil import TableSoil
from impactfem.case.transient import OUTSIDE, Transient
from impactfem.dynamics.soil import BAND

REDUCED = {
    "wall_impact": "the impact on a wall",
    "devices": "the study of devices",
    "damping_cases": "the damping cases",
}
"""Sections that use the reduced basis, by name, and what they are."""
LOWEST = 1.0
"""Height of a storey that no building has less of [m]."""
FOLDERS = ("figures", "tables", "products", "ensemble", "design")
"""Folders of a run, in which those of further buildings with a 3D model are."""
UNIQUE = {"buildings": "name", "motions": "direction", "damping_cases": "name", "devices": "name"}
"""Arrays of tables with the key that only one table of each may have with a value."""


def _duplicate(reading: Reading) -> Iterator[Finding]:
    """Tables of an array with the name or direction of another one."""
    for group, key in UNIQUE.items():
        seen: dict[str, int] = {}
        tables = dict(reading.tables(group))
        for index, entry in tables.items():
            value = entry.get(key)
            if not isinstance(value, str):
                continue
            # Files are named by these names: on some systems X and x are one file.
            first = seen.setdefault(value.lower(), index)
            alike = "" if value == tables[first].get(key) else ", upper and lower case alike"
            if first != index:
                expected = f"duplicate {key}{alike}, the first is {group}[{first}].{key}"
                yield (group, index, key), expected


def _missing_section(reading: Reading) -> Iterator[Finding]:
    """Sections that need others which the file lacks."""
    raw = reading.source.raw
    if not (raw.get("motions") or raw.get("loads")):
        expected = "missing; expected [[motions]], [[loads]] or both: what moves the buildings"
        yield ("motions",), expected
    # [structure], which moved, and [buildings] that is no array, are other faults.
    structured = reading.three_d or "structure" in raw or isinstance(raw.get("buildings"), dict)
    for section in ("wall_impact", "transient"):
        if section in raw and not structured:
            yield (section,), "requires [buildings.structure]: the 3D model that moves"
    if "wall_impact" not in raw:
        expected = "requires a section [wall_impact]: the impact that gives it"
        laws = raw.get("contact_laws")
        for name, law in laws.items() if isinstance(laws, dict) else ():
            for key in ("stiffness", "restitution"):
                of_type = isinstance(law, dict) and law.get("type") == "kelvin-voigt"
                if of_type and law.get(key) == CALIBRATED:
                    yield ("contact_laws", name, key), expected
        for index, entry in reading.tables("damping_cases"):
            if entry.get("restitution") == CALIBRATED:
                yield ("damping_cases", index, "restitution"), expected
    serving = ("transient", "serve_damping_cases")
    if reading.value(*serving) is True and "damping_cases" not in raw:
        yield serving, "requires [[damping_cases]]: the dampings to serve"
    lacking = [] if structured else ["[buildings.structure]: the 3D model of their building"]
    lacking += [] if "transient" in raw else ["[transient]: the response of that model in time"]
    if "devices" in raw and lacking:
        yield ("devices",), f"requires {', and '.join(lacking)}"
    if "devices" not in raw and "device_analysis" in raw:
        yield ("device_analysis",), "requires [[devices]]: the devices to analyse"


def _no_reduced_basis(reading: Reading) -> Iterator[Finding]:
    """Sections that use the reduced basis, with damping by part."""
    raw, solver = reading.source.raw, ("transient", "solver")
    if any(isinstance(reading.value(*at, "damping"), list) for at in reading.three_d.values()):
        by_part = "with [[buildings.structure.damping]]:"
        if reading.value(*solver) != "full":
            expected = f"expected 'full' {by_part} damping by part has no reduced basis"
            yield solver, expected
        for name, what in REDUCED.items():
            if name in raw:
                expected = (
                    f"expected none {by_part} {what} uses the reduced basis, which serves one "
                    "Rayleigh damping of the whole building at a time"
                )
                yield (name,), expected


def _of_damping(case: Case, reading: Reading) -> Iterator[Finding]:
    """Laws of damping that end below the frequencies in use, or that full order cannot take."""
    highest = case.spectra.frequency_values[-1]
    if case.transient is not None:
        highest = max(highest, case.transient.maximum_frequency)
    laws: list[tuple[Place, DampingEntry]] = [(("damping",), case.damping)]
    laws += [(("buildings", k, "damping"), one.damping) for k, one in enumerate(case.buildings)]
    laws += [(("damping_cases", k), one) for k, one in enumerate(case.damping_cases)]
    by_part = any(structure.damping for structure in case.structures)
    for place, damping in laws:
        if reading.value(*place) is None or isinstance(damping, RayleighDamping):
            continue
        last = damping.points[-1][0] if isinstance(damping, TableDamping) else highest
        if last < highest * (1.0 - 1e-9):
            yield (*place, "points"), f"expected points up to {highest:g} Hz, which are in use"
        if by_part and place[0] != "damping_cases":
            yield (*place, "type"), "expected 'rayleigh' with [[buildings.structure.damping]]"


def _of_models(case: Case, reading: Reading) -> Iterator[Finding]:
    """Models of [pounding] that do not exist, and contacts that edges in 3D cannot have."""
    known = reading.names("buildings")
    wrong = "pounding" in reading.left_out  # what pounds in 3D is not known then
    for name, model in case.pounding.models.items():
        place: Place = ("pounding", "models", name)
        expected = ""
        if known is not None and name not in known:
            expected = f"expected names of buildings, {nearest(name, list(known))}"
        elif model == "structure" and name not in reading.three_d:
            expected = f"expected 'stick', or a [buildings.structure] of {name}: it has none"
        if expected:
            wrong = True
            yield place, expected
    kinds: dict[bool, str] = {}
    reported: set[int] = set()
    for contact in case.contacts:
        at = reading.original(("contacts", contact.table))
        law = case.contact_laws[contact.law]
        unilateral, touches = isinstance(law, UnilateralLaw), case.touches_in_3d(contact)
        kinds.setdefault(unilateral, contact.law)
        if contact.table in reported:
            continue
        if unilateral and not (touches or wrong):
            reported.add(contact.table)
            expected = (
                f"'{contact.law}' is unilateral, and nothing of {contact.words} pounds in 3D: "
                "expected a law with a restitution, or models of [pounding] with 'structure' for "
                "one of them"
            )
            yield (*at, "law"), expected
        elif len(kinds) > 1:
            reported.add(contact.table)
            words = " and ".join(f"'{kinds[k]}'" for k in (True, False))
            expected = (
                f"expected all contacts unilateral, or none: {words} need different steps in time"
            )
            yield (*at, "law"), expected
        inside = [end.storey is not None for end, _ in contact.ends]
        if touches and inside == [True, True]:
            reported.add(contact.table)
            expected = "expected a floor on one side: in 3D the edge of a floor meets walls"
            yield (*at, "b", "storey"), expected


def _of_buildings_in_3d(case: Case, reading: Reading) -> Iterator[Finding]:
    """Laws and neighbours that 3D models that pound cannot have."""
    in_3d = case.pounding_in_3d
    if not in_3d:
        return
    for contact in case.contacts:
        modelled = {*contact.buildings} & {*reading.three_d}  # of others that is a fault already
        alone = sorted(modelled - {*in_3d})
        if alone and modelled & {*in_3d} and case.transient is not None:
            expected = (
                f"expected 'structure' for {alone[0]}, too: its 3D model touches another one in "
                f"{contact.name}"
            )
            yield ("pounding", "models"), expected
            break
    if case.pounding.update == "lagged":
        expected = "expected 'implicit': edges that touch in 3D have no force one step late"
        yield ("pounding", "update"), expected
    if any(structure.damping for structure in case.structures if structure.building in in_3d):
        expected = "expected 'stick' with [[buildings.structure.damping]]: it has no reduced model"
        yield ("pounding", "models"), expected
    ends = {name for one in case.contacts for name in one.buildings}
    apart = [name for name in in_3d if name not in ends]
    if apart and "contacts" not in reading.left_out:
        expected = f"expected 'stick' for {', '.join(apart)}, which is in no pair of [[contacts]]"
        yield ("pounding", "models"), expected
    for contact in case.contacts:
        law = case.contact_laws[contact.law]
        calibrated = isinstance(law, KelvinVoigtLaw) and law.calibrated
        if calibrated and case.touches_in_3d(contact):
            place = reading.original(("contacts", contact.table))
            expected = (
                f"expected a law with values, or a unilateral law: what '{contact.law}' is "
                "calibrated to holds the softness of the slab, which the 3D model has, too"
            )
            yield (*place, "law"), expected
            break
    transient = case.transient
    for key in ("eccentricity", "spread"):
        if transient is not None and getattr(transient, key) != Transient.model_fields[key].default:
            expected = "expected none with 3D models in [pounding]: forces act where edges touch"
            yield ("transient", key), expected


def _of_buildings(case: Case, reading: Reading) -> Iterator[Finding]:
    """3D models whose building does not go with them, and a calibration that has none."""
    models = reading.three_d
    for index, building in enumerate(case.buildings):
        for key, expected in _rigid_storeys(building):
            yield (*reading.original(("buildings", index)), key), expected
    # Floors are named by their number in the mesh: there is no gap between 1 and the top.
    for building in case.buildings:
        numbers = [floor.floor for floor in building.floors]
        if building.name in models and numbers != list(range(1, len(numbers) + 1)):
            found = ", ".join(map(str, numbers))
            expected = f"expected a building with floors from 1 without a gap, found {found}"
            yield models[building.name], expected
    # Of a further building with a 3D model folder and results have the name.
    devices = {str(entry.get("name")).lower() for _, entry in reading.tables("devices")}
    for name, place in list(models.items())[1:]:
        if name.lower() in FOLDERS or name.lower() in devices:
            what = "a folder of the run" if name.lower() in FOLDERS else "one of [[devices]]"
            expected = f"expected a name for a second building with a 3D model that {what} has not"
            yield (*place[:2], "name"), expected
    if "structure" in reading.left_out:
        return
    for structure in case.structures:
        mesh, place = structure.mesh, (*models[structure.building], "mesh")
        if isinstance(mesh, GeneratedMesh):
            stood_in = {k for row in (*mesh.walls, *mesh.columns) for k in row.levels}
            floors = case.building(structure.building).floors
            bare = [str(one.floor) for one in floors if one.floor not in stood_in]
            tables = [reading.value(*place, key) for key in ("walls", "columns")]
            if bare:
                expected = (
                    f"no wall and no column stands in storey {', '.join(bare)}; expected one or "
                    f"more in each storey, in {' or '.join(filter(None, tables))}"
                )
                yield (*place, "walls"), expected
    calibration, named = case.calibration, [one.building for one in case.structures]
    if calibration is not None and calibration.from_structure:
        place = ("calibration", "from_structure")
        targeted = {one.building for one in calibration.targets if reading.names("buildings")}
        if not named:
            yield place, "expected a [buildings.structure], whose modes are the targets"
        elif targeted and targeted.isdisjoint(named):  # where known
            yield place, f"expected targets of the building with a 3D model, {' or '.join(named)}"


def _of_sticks(case: Case, reading: Reading) -> Iterator[Finding]:
    """Sticks of 3D models that are missing or to be fitted, and own ones without stiffness."""
    targets = () if case.calibration is None else case.calibration.targets
    for index, building in enumerate(case.buildings):
        own = building.name not in case.sticks_on_models and "structure" not in reading.left_out
        if own and not building.floors[0].has_stiffness:
            expected = (
                "expected the storey stiffness of the stick, which [calibration] fits; type "
                "columns Ix, Iy, Iz, A, Avx and Avy"
            )
            yield ("buildings", index, "floors"), expected
        if building.stick != "structure":
            continue
        place = ("buildings", index, "stick")
        if building.name not in reading.three_d:
            yield place, 'expected a [buildings.structure] of the building, or stick = "own"'
        elif any(target.building == building.name for target in targets):
            yield place, 'expected "own": [calibration] fits this stick'


def _rigid_storeys(building: Building) -> Iterator[tuple[str, str]]:
    """Storeys without a flexible part between the rigid zones of their floors: which key, and why.

    The table of floors is at fault where a storey is too low for people, else the larger zone.
    """
    reported = set()
    for index, floor in enumerate(building.floors):
        below, above, height = building.rigid_below, building.rigid_above, floor.storey_height
        rigid = below + (above if index else 0.0)
        if height > rigid:
            continue
        zones = f"rigid_below, {below:g} m" + (f", and rigid_above, {above:g} m" if index else "")
        expected = f"the storey below floor {floor.floor} is {height:g} m high by the floor table; "
        if height < LOWEST:
            key, more = "floors", f"expected more than its rigid zones together, {zones}"
        else:
            key = "rigid_above" if index and above > below else "rigid_below"
            more = f"expected rigid zones together of less, not {zones}"
        if key not in reported:
            reported.add(key)
            yield key, expected + more


def _of_soil(case: Case, reading: Reading) -> Iterator[Finding]:
    """Full order on soil, rafts smaller than their buildings, tables without all frequencies."""
    on_soil = any(one.soil is not None and one.structure is not None for one in case.buildings)
    if on_soil and case.transient is not None and case.transient.solver != "reduced":
        expected = "expected 'reduced' with [buildings.soil]: in full order the base is clamped"
        yield ("transient", "solver"), expected
    for index, building in enumerate(case.buildings):
        soil, place = building.soil, ("buildings", index, "soil")
        if soil is None:
            continue
        mesh = None if building.structure is None else building.structure.mesh
        plan = mesh if isinstance(mesh, GeneratedMesh) else building
        for size, side, what in zip(
            (plan.length, plan.width), soil.raft.sides, ("length", "width"), strict=True
        ):
            if size is not None and side < size * (1.0 - 1e-9):
                key = "radius" if soil.raft.radius is not None else what
                expected = f"expected a raft as large as the building, {size:g} m in {what}"
                yield (*place, "raft", key), expected
        if isinstance(soil, TableSoil):
            low, high = BAND[0], min(case.spectra.frequency_values[-1], BAND[1])
            first, last = max(f[0] for f, *_ in soil.curves), min(f[-1] for f, *_ in soil.curves)
            if first > low * (1.0 + 1e-9) or last < high * (1.0 - 1e-9):
                expected = f"expected each component from {low:g} Hz or below up to {high:g} Hz"
                yield (*place, "file"), f"{expected}; all have {first:g} to {last:g} Hz"


def _of_alignment(case: Case, reading: Reading) -> Iterator[Finding]:
    """Pairs whose points cannot meet, once for each end of a table of [[contacts]]."""
    reported = set[Place]()
    for contact in case.contacts:
        place = reading.original(("contacts", contact.table))
        for one in misalignments(contact, case):
            at: Place = (*place, one.side, "offset") if one.side else place
            if one.wrong and at not in reported:
                reported.add(at)
                yield at, one.text


def _of_motions(case: Case, reading: Reading) -> Iterator[Finding]:
    """Motions, loads and ensembles that do not go with their files, or with the 3D models."""
    for index, motion in enumerate(case.motions):
        if isinstance(motion, SyntheticMotion) and isinstance(motion.spectrum, TableSpectrum):
            place = reading.original(("motions", index, "damping"))
            file = reading.value(*place[:2], "spectrum", "file")
            table = reading.table(file, TABLE, read_spectrum)
            if table is not None and table.at(motion.damping) is None:
                given = reading.value(*place) is not None
                default = "" if given else f", not the default {100.0 * motion.damping:g} %"
                yield place, f"expected a damping of {file}: {table.dampings}{default}"
    unknown = reading.left_out & {"structure", "transient"}
    for index, loads in () if unknown else enumerate(case.loads):
        forces = read_force_table(loads.file, [])
        loaded = set() if forces is None else {building for building, _ in forces.floors}
        for name, mesh in ((one.building, one.mesh) for one in case.structures):
            axis = mesh.impact_edge[0] if isinstance(mesh, GeneratedMesh) else ""
            # The 3D model takes forces on the edges of its slabs.
            if axis and name in loaded and abs(loads.direction["xyz".index(axis)]) < 1.0 - 1e-6:
                expected = (
                    f"expected a direction along {axis}, at right angles to the impact edge of "
                    f"{name}: forces act on the edges of slabs in its 3D model"
                )
                yield reading.original(("loads", index, "direction")), expected
    if case.wave_passage is not None:
        axes = [building.axis for building in case.buildings]
        place = ("wave_passage",)
        if case.motions and all(isinstance(one, RestMotion) for one in case.motions):
            yield place, "expected [[motions]] with it: ground at rest has no waves"
        elif len(set(axes)) < len(axes) or len(axes) == 1:
            expected = "expected two [[buildings]] or more, all with different axes: the delay is"
            yield place, f"{expected} their distance over the apparent velocity"
    # What an ensemble lacks: other motions, a folder of records, a 3D model for its members.
    ensemble, transient = case.ensemble, case.transient
    if ensemble is None:
        return
    place, records = ("ensemble", "records"), ensemble.records
    there = ensemble.motions
    if there is None and records is not None and records.is_dir():
        there = len(ensemble.files())
    carried, of = ensemble.structure_motions, ("ensemble", "structure_motions")
    if there is not None and carried > there:
        yield of, f"expected at most all members, {there}"
    if carried and transient is None and "transient" not in reading.source.raw:
        yield of, "expected 0, or a section [transient], the 3D model"
    elif carried and transient is not None and transient.solver == "full":
        another = "expected 0, or a [transient] with another solver than 'full'"
        yield of, f"{another}: members take the reduced model"
    elif carried and transient is not None and transient.forces is not None:
        yield of, "expected 0: each member has its own impact forces, not transient.forces"
    if any(isinstance(motion, RestMotion) for motion in case.motions):
        yield ("ensemble",), "expected [[motions]] as well: ground at rest has no other motions"
        return
    recorded = any(isinstance(motion, RecordMotion) for motion in case.motions)
    if ensemble.motions is not None and recorded:
        expected = "synthetic motions only: other seeds of a record there are none; use records"
        yield ("ensemble", "motions"), expected
    if records is None:
        return
    if len(reading.tables("motions")) != 1 or (case.motions and not recorded):
        yield place, "expected a case with one motion of type 'record', whose file the records take"
    if not records.is_dir():
        yield place, "expected a folder of records; there is none of this name"
    elif len(ensemble.files()) < 2:
        yield place, f"at least two records in it, found {len(ensemble.files())}"
    elif strange := sorted(set(ensemble.entries()) - set(ensemble.files())):
        yield place, f"expected ordinary files only; {strange[0].name} in it is none"


def _of_devices(case: Case, reading: Reading) -> Iterator[Finding]:
    """Anchors outside the building, unknown probes, an analysis that does not fit."""
    transient, analysis = case.transient, case.device_analysis
    meshes = {one.building: one.mesh for one in case.structures}
    for index, device in enumerate(case.devices):
        name = device.building
        levels = case.building(name).levels if name in meshes else {}
        mesh = meshes.get(name)
        known = () if transient is None else transient.probes
        probes = [one for one in known if one.building in ("", name)]
        for k, anchor in enumerate(device.anchor_points if name in meshes else ()):
            own = ("supports", k) if device.supports else ()
            place = reading.original(("devices", index, *own))
            (x, y, z), wrong = anchor.point, []
            if isinstance(mesh, GeneratedMesh):
                limits = zip((x, y), (mesh.length, mesh.width), strict=True)
                if not all(-TOUCH <= at <= limit + TOUCH for at, limit in limits):
                    wrong.append(
                        f"outside the building; expected x from 0 to {mesh.length:g} m and y from "
                        f"0 to {mesh.width:g} m"
                    )
                floor = min(levels, key=lambda k: abs(levels[k] - z), default=0)
                within = mesh.slab(floor) / 2.0
                if levels and abs(levels[floor] - z) > within + TOUCH:
                    wrong.append(
                        "at the level of no floor; expected z within half of the slab's thickness, "
                        f"{within:g} m, of a floor: the nearest, floor {floor}, is at "
                        f"{levels[floor]:g} m"
                    )
            if wrong:
                yield (*place, "point"), "; ".join(wrong)
            unknown = list(anchor.unknown_probes(probes, list(levels)))
            if unknown and (transient is not None or "transient" not in reading.source.raw):
                expected = (
                    "expected names of probes of [transient], or patterns of such names: there is "
                    f"none for {', '.join(unknown)}"
                )
                yield (*place, "envelope"), expected
    if transient is None or analysis is None:
        return
    if analysis.time_step is not None and analysis.time_step > transient.time_step * (1.0 + 1e-9):
        expected = f"expected at most the time step of [transient], {transient.time_step:g} s"
        yield ("device_analysis", "time_step"), expected
    if analysis.envelope_dampings and "damping_cases" not in reading.source.raw:
        expected = "requires [[damping_cases]]: there is one damping only"
        yield ("device_analysis", "envelope_dampings"), expected


def _transient_times(case: Case, reading: Reading) -> Iterator[Finding]:
    """Times of the response that contradict those of the pounding."""
    transient = case.transient
    if transient is None:
        return
    computed = None
    if transient.forces is None:
        # What else [pounding] has wrong hides nothing.
        given = reading.value("pounding", "duration")
        computed = None if "pounding" in reading.left_out else case.pounding.duration
        known = [m.duration for m in case.motions if not isinstance(m, RecordMotion)]
        # The duration of a record is not known before it is read.
        whole = case.motions and not reading.left_out & {"motions", "loads"}
        if given is None and whole and len(known) == len(case.motions):
            computed = case.computed_time(max(known, default=0.0))
    if computed is not None:
        if transient.time_step > computed / 2.0:
            expected = f"expected at most half of the duration, {computed:g} s"
            yield ("transient", "time_step"), expected
        if transient.duration is not None and transient.duration > computed * (1.0 + 1e-9):
            expected = f"expected at most what is computed of the pounding, {computed:g} s"
            yield ("transient", "duration"), expected
    lasting, start = transient.duration or computed, transient.export_start
    if transient.export and start is not None and lasting is not None and start >= lasting:
        yield ("transient", "export_start"), f"expected less than what is computed, {lasting:g} s"


def _transient_points(case: Case, reading: Reading) -> Iterator[Finding]:
    """Floors and probes of the response that the 3D models do not have."""
    for modelled in case.in_time:
        transient, building, mesh = modelled.transient, modelled.entry, modelled.structure.mesh
        levels = (building.base, *building.elevations)
        of = building.name if case.further_structures else "the building"
        numbers = [floor.floor for floor in building.floors]
        absent = [str(k) for k in transient.floors or () if k not in numbers]
        if absent:
            expected = (
                f"no floor {', '.join(absent)} in {building.name}; expected some of {numbers}"
            )
            yield ("transient", "floors"), expected
        for index, probe in modelled.numbered_probes:
            level = re.search("_([1-9][0-9]*)", probe.group or "")
            if level is not None and int(level[1]) > len(numbers):
                expected = f"expected a number of 1 to {len(numbers)}, the floors of {of}"
                yield ("transient", "probes", index, "group"), expected
        if not isinstance(mesh, GeneratedMesh):
            continue
        edge = mesh.length if mesh.impact_edge.startswith("y") else mesh.width
        if abs(transient.eccentricity) > edge / 2.0:
            expected = f"expected a distance within the edge, {edge / 2.0:g} m to either side"
            yield ("transient", "eccentricity"), expected
        # Probes away from the box around the building, whose nodes are not known yet, by more than
        # the stage may take the nearest node for the point.
        top = levels[-1] + (0.0 if mesh.parapet is None else mesh.parapet.height)
        box = ((0.0, mesh.length), (0.0, mesh.width), (levels[0], top))
        sizes = (mesh.size, mesh.floor_size, mesh.storey_size, mesh.beam_size, mesh.column_size)
        away = max(OUTSIDE, *(0.5 * size for size in sizes if size is not None))
        sides = [f"{axis} of {a:g} to {b:g} m" for axis, (a, b) in zip("xyz", box, strict=True)]
        for index, probe in modelled.numbered_probes:
            for key, point in (("point", probe.point), ("from", probe.start), ("to", probe.end)):
                pairs = zip(point or (), box, strict=False)
                if not all(a - away <= x <= b + away for x, (a, b) in pairs):
                    expected = f"expected a point of {of}, which has {', '.join(sides)}"
                    yield ("transient", "probes", index, key), expected


FILE_CHECKS = (_duplicate, _missing_section, _no_reduced_basis)
"""Checks of the file as it stands."""
CHECKS = (
    of_struck_sides,
    _of_damping,
    _of_models,
    _of_buildings_in_3d,
    _of_buildings,
    _of_soil,
    _of_sticks,
    of_contacts,
    of_search,
    _of_alignment,
    _of_motions,
    _of_devices,
    of_equipment,
    _transient_times,
    _transient_points,
)
"""Checks of the valid sections of a case."""

"""What is valid and hardly meant: unusual values, and values that do not go together.

Each is a warning with the file, the key, the value and what is usual; nothing is refused.
"""

import math
from collections.abc import Iterator

import numpy as np

from impactfem.case.alignment import misalignments
from impactfem.case.contacts import KelvinVoigtLaw, UnilateralLaw
from impactfem.case.design_spectrum import DecreeSpectrum, EurocodeSpectrum
from impactfem.case.device_tables import DeviceMatrices
from impactfem.case.devices import SAME_MASS
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import SyntheticMotion, read_force_table
from impactfem.case.place import Place, value_at
from impactfem.case.plausible_buildings import BESIDE, NO_BODY, SAME, of_buildings
from impactfem.case.report import STAGE_OF
from impactfem.case.soil import HalfSpaceSoil
from impactfem.case.source import Source, read_source
from impactfem.case.unused import unused
from impactfem.case.usual import unusual
from impactfem.records.accelerogram import STANDARD_GRAVITY
from impactfem.system.errors import Fault

DURATION = 5.0
"""Usual time of the sticks over the longest motion: above, there is little left to see."""
HEAVY = 0.1
"""Mass of a device over that of its floor from which on it belongs into the model of the building:
US NRC SRP 3.7.2 (II.3.B); below 0.01 it may be left out."""
WIDE = 3.0
"""Largest usual radius of gyration of a device over its size: the radius of its anchor or the
height of its mass centre."""
SLOW = 0.5
"""Least usual frequency of a device on one of its springs, or by its matrices [Hz]."""
MASSES = (5.0, 1e5)
"""Least and largest usual mass of a device by its matrices [kg]."""
FAST = 500.0
"""Largest usual first frequency of a device by its matrices [Hz]."""
SPEED = 0.5
"""Speed of approach that tells how long an impact of a law after Hertz lasts [m/s]."""
RAYLEIGH = 0.87
"""Least speed of Rayleigh waves over that of shear waves, at a Poisson's ratio of 0."""
FRACTILES = {
    "motions": (10, "the fractiles of 5 % and 95 %"),
    "structure_motions": (4, "fractiles of 84 %"),
}
"""Least number n of motions by the key of [ensemble], with 1 - 1/(2n) at least the probability p,
and the fractiles that need them."""
WEIGHTS = 50.0
"""Largest usual force on a floor over its weight: that of an aircraft is some tens."""


def implausible(case: Case, longest: float) -> list[Fault]:
    """What is hardly meant in a case, one a value or a column of a table, with what is usual.

    The longest motion has this duration [s], 0 without one.
    """
    source = read_source(case.path, CaseFile)
    values = unusual(case, source)
    found = [
        *values,
        *unused(source, case),
        *of_buildings(source, case, {fault.key for fault in values}),
        *_motions(source, case, longest),
        *_pairs(source, case),
        *_devices(source, case),
        *_analysis(source, case, longest),
        *_ensemble(source, case),
        *_passage(source, case),
        *_pounding(source, case, longest),
        *_wall(source, case),
    ]
    # Names that no result can have, by their first word; a run knows the others.
    file = source.path.parent / str(value_at(("published",), source.raw))
    text = f"no result; their names begin with {', '.join(STAGE_OF)} (docs/run-folder.md)"
    strange = (name for name in case.published if name.split(".")[0] not in STAGE_OF)
    return found + [Fault(file, "name", name, text) for name in strange]


def _motions(source: Source, case: Case, longest: float) -> Iterator[Fault]:
    """Spectra of motions in another direction; forces of many weights, or that do not act."""
    for k, motion in enumerate(case.motions):
        spectrum = motion.spectrum if isinstance(motion, SyntheticMotion) else None
        if not isinstance(spectrum, EurocodeSpectrum | DecreeSpectrum):
            continue
        if spectrum.vertical != (motion.direction == "z"):
            kind = "vertical" if spectrum.vertical else "horizontal"
            text = f"its spectrum is the {kind} one (vertical of [motions.spectrum])"
            yield source.fault(("motions", k, "direction"), motion.direction, text)
    for k, loads in enumerate(case.loads):
        table = read_force_table(loads.file, [])
        if table is None:
            continue
        acting = np.abs(table.force[table.time <= case.computed_time(longest)])
        if not acting.any():
            text = f"no force within the {case.computed_time(longest):g} s that are computed"
            yield source.remark(("loads", k, "file"), text)
            continue
        for (name, number), force in zip(table.floors, acting.max(axis=0), strict=True):
            floor = next(one for one in case.building(name).floors if one.floor == number)
            times = float(force) / (STANDARD_GRAVITY * floor.mass)
            if times > WEIGHTS:
                text = f"{times:.3g} times its weight; usual is below ten"
                yield Fault(loads.file, f"{name}.floor_{number}", f"{force:.4g} N", text)


def _pairs(source: Source, case: Case) -> Iterator[Fault]:
    """Vertical normals, points that are not aligned, once for each table; ground at rest."""
    vertical, beside = set[int](), set[Place]()
    misaligned: dict[Place, list[str]] = {}
    level = [contact.normal for contact in case.contacts if abs(contact.normal[2]) <= SAME]
    # Forces on floors may drive them as well.
    moving = [motion.direction for motion in case.motions] if not case.loads else []
    if level and moving and not any(abs(n["xyz".index(d)]) > SAME for n in level for d in moving):
        text = "no contact has a normal along it: the buildings are not driven against each other"
        yield source.fault(("motions", 0, "direction"), moving[0], text)
    for contact in case.contacts:
        index = contact.table
        for side, (end, _) in zip("ab", contact.ends, strict=False):
            building = case.building(end.building)
            for c, size in enumerate((building.length, building.width)):
                if size is not None and abs(end.offset[c]) > 0.5 * size + BESIDE:
                    place = ("contacts", index, side, "offset")
                    if place not in beside:
                        beside.add(place)
                        text = (
                            f"{abs(end.offset[c]):.4g} m from the axis along {'xy'[c]}, and the "
                            f"plan of {building.name} reaches {0.5 * size:.4g} m"
                        )
                        yield source.remark(place, text)
        if abs(contact.normal[2]) > SAME and index not in vertical:
            vertical.add(index)
            text = "not horizontal; buildings side by side push each other along x or y"
            yield source.remark(("contacts", index, "normal"), text)
        for one in misalignments(contact, case):
            place = ("contacts", index, *((one.side, "offset") if one.side else ()))
            if not one.wrong:
                misaligned.setdefault(place, []).append(one.text)
    for at, (text, *others) in misaligned.items():
        more = f". The same applies to {len(others)} more of this table" if others else ""
        value = value_at(at, source.raw) if len(at) > 2 else None
        yield source.fault(at, value, text + more)


def _devices(source: Source, case: Case) -> Iterator[Fault]:
    """Devices that are heavy for their floor, do not go with their moments of inertia, or sway."""
    for k, device in enumerate(case.devices):
        place: Place = ("devices", k)
        anchors, rows = device.anchors, device.modes or ()
        along = [sum(one.effective_mass for one in rows if one.direction == c) for c in "xyz"]
        totals = {} if device.matrices is None else device.matrices.total_masses
        m = device.mass or max(*along, *totals.values())
        if device.matrices is not None:
            yield from _matrices(source, (*place, "matrices"), device.matrices)
        if not m or not anchors:
            continue
        building = case.building(device.building)
        z = anchors[0].point[2]
        levels = zip(building.floors, building.elevations, strict=True)
        floor = min(levels, key=lambda one: abs(one[1] - z))[0]
        if m > HEAVY * floor.mass:
            text = (
                f"{m / floor.mass:.3g} times the mass of floor {floor.floor} of {building.name}, "
                f"{1e-3 * floor.mass:.4g} t; usual is below a hundredth. From a tenth on a device "
                "is part of the building (SRP 3.7.2), and the sticks have the masses of the floor "
                "table alone"
            )
            model = "modes" if device.matrices is None else "matrices"
            yield source.remark((*place, "mass" if device.mass else model), text)
        if device.mass is None or device.mass_height is None:
            continue
        if device.mass_height < 0.0:
            text = (
                "the mass centre is below the anchor; net tension is that of a device that stands "
                "on the floor, whose weight holds it down: one that hangs pulls with its weight"
            )
            yield source.remark((*place, "mass_height"), text)
        h, J = abs(device.mass_height), device.inertia or (0.0, 0.0, 0.0)
        size = max(h, anchors[0].radius)
        for c, own in enumerate(J):
            if math.sqrt(own / m) > WIDE * size:
                text = (
                    f"√(J/mass) is {math.sqrt(own / m):.3g} m; usual is at most the size of the "
                    f"device, and its anchor and mass_height are within {size:.3g} m"
                )
                yield source.remark((*place, "inertia", c), text)
            elif own > (sum(J) - own) * (1.0 + SAME):
                yield source.remark((*place, "inertia", c), NO_BODY)
        springs, beam = device.stiffness, device.beam
        moved = (m, m, m, J[0] + m * h**2, J[1] + m * h**2, J[2])
        swaying: list[tuple[Place, float | str, float]] = []
        if springs is not None:
            pairs = zip(springs, moved, strict=True)
            swaying += [(("stiffness", name), stiff, of) for (name, stiff), of in pairs]
        if beam is not None:
            swaying.append((("beam", "bending"), 3.0 * min(beam.bending) / beam.length**3, m))
        for key, stiff, of in swaying:
            if isinstance(stiff, float) and stiff < of * (2.0 * math.pi * SLOW) ** 2:
                frequency = math.sqrt(stiff / of) / (2.0 * math.pi)
                text = f"{frequency:.2g} Hz of the body on it alone; usual is 1 to 50 Hz"
                yield source.remark((*place, *key), text)


def _matrices(source: Source, place: Place, matrices: DeviceMatrices) -> Iterator[Fault]:
    """Matrices of a device in units that are not those of their headers."""
    masses, frequency = matrices.total_masses, matrices.first_frequency
    texts = []
    for axis, mass in masses.items():
        if not MASSES[0] <= mass <= MASSES[1]:
            texts.append(f"the device has {mass:.3g} kg along {axis}; usual is 10 kg to 50 t")
    if masses and max(masses.values()) > (1.0 + SAME_MASS) * min(masses.values()):
        found = ", ".join(f"{mass:.4g} kg along {axis}" for axis, mass in masses.items())
        texts.append(f"the device has {found}; a device has one mass along all axes")
    if frequency is not None and not SLOW <= frequency <= FAST:
        text = "its first frequency on supports at rest is {:.3g} Hz; usual is 1 to 100 Hz"
        texts.append(text.format(frequency))
    for text in texts:
        also = "Its anchor forces are proportional to its mass. Check the units in the headers"
        yield source.fault(place, None, f"{text}. {also}; with mass the total is compared")


def _analysis(source: Source, case: Case, longest: float) -> Iterator[Fault]:
    """Given spectra without a direction of the ground; a strong motion too long, or not used."""
    for k, device in enumerate(case.devices):
        for key, rows, what, then in (
            (
                "spectra",
                device.spectra,
                "spectrum",
                ": the analysis with these spectra leaves it out",
            ),
            ("modes", device.modes, "mode", ""),
        ):
            known = {row.direction for row in rows or ()}
            lacking = [one.direction for one in case.motions if one.direction not in known]
            if known and lacking:
                along = " and ".join(lacking)
                text = f"no {what} along {along}, along which the ground moves{then}"
                yield source.remark(("devices", k, key), text)
    analysis = case.device_analysis
    if analysis is None or analysis.duration is None:
        return
    text = ""
    if not {"dsc", "dsc-abs"} & set(analysis.combination):
        text = "not used: only the combinations 'dsc' and 'dsc-abs' have a duration"
    elif analysis.duration > longest > 0.0:
        text = f"the strong motion is a part of the motion, which lasts {longest:g} s"
    if text:
        yield source.remark(("device_analysis", "duration"), text)


def _ensemble(source: Source, case: Case) -> Iterator[Fault]:
    """Fewer motions than the fractiles of the results need."""
    ensemble = case.ensemble
    if ensemble is None:
        return
    folder = ensemble.records is not None
    counts = {
        "motions": len(ensemble.files()) if folder else ensemble.motions,
        "structure_motions": ensemble.structure_motions,
    }
    for key, (least, fractiles) in FRACTILES.items():
        count = counts[key]
        if count and count < least:
            text = f"{fractiles} of fewer than {least} motions say no more than their range does"
            place = ("ensemble", "records" if folder and key == "motions" else key)
            yield source.remark(place, text)


def _passage(source: Source, case: Case) -> Iterator[Fault]:
    """Waves that pass slower than shear waves, or reach all buildings at the same time."""
    if case.wave_passage is None:
        return
    speed = case.wave_passage.apparent_velocity
    soils = [one.soil for one in case.buildings if isinstance(one.soil, HalfSpaceSoil)]
    fastest = max((soil.shear_velocity for soil in soils), default=0.0)
    if speed < RAYLEIGH * fastest:
        text = (
            f"waves do not pass slower than those of [buildings.soil], {fastest:g} m/s: of waves "
            "from below the apparent velocity is that over the sine of their angle to the vertical"
        )
        yield source.remark(("wave_passage", "apparent_velocity"), text)
    if not max(case.delays.values()) > SAME:
        text = "the waves reach all buildings at the same time: the axes are at right angles to it"
        yield source.remark(("wave_passage", "direction"), text)


def _pounding(source: Source, case: Case, longest: float) -> Iterator[Fault]:
    """Times that are long for motions or the shortest impact, of two free floors."""
    computed = case.pounding.duration
    if computed is not None and longest > 0.0 and computed > DURATION * longest:
        text = (
            f"{computed / longest:.3g} times the longest motion, {longest:g} s; usual are the "
            "motion and some seconds"
        )
        yield source.remark(("pounding", "duration"), text)
    durations = []
    for contact in case.contacts:
        law = case.contact_laws[contact.law]
        if isinstance(law, UnilateralLaw):
            continue
        hit = {(end.building, end.floor or end.storey) for end, _ in contact.ends}
        floors = ((one.name, floor) for one in case.buildings for floor in one.floors)
        M = 1.0 / sum(1.0 / floor.mass for name, floor in floors if (name, floor.floor) in hit)
        K = law.stiffness
        if not isinstance(K, float):
            continue
        if isinstance(law, KelvinVoigtLaw):
            durations.append((math.pi * math.sqrt(M / K), contact.name))
        else:
            # Hertz: 2.943 p / v with the largest penetration p = (5 M v² / (4 K))^(2/5).
            depth = (1.25 * M * SPEED**2 / K) ** 0.4
            durations.append((2.943 * depth / SPEED, contact.name))
    if not durations:
        return
    shortest, name = min(durations)
    asked, dt = case.pounding.points_per_impact, case.pounding.time_step
    if asked * dt > shortest * (1.0 + SAME):
        text = (
            f"{shortest / dt:.3g} steps in an impact of {name}, which lasts {1e3 * shortest:.3g} "
            f"ms; {asked} are requested ([pounding] points_per_impact), "
            f"{1e3 * shortest / asked:.3g} ms"
        )
        yield source.remark(("pounding", "time_step"), text)


def _wall(source: Source, case: Case) -> Iterator[Fault]:
    """A wall that a building let go cannot reach: it swings back about as far as it was drawn."""
    wall = case.wall_impact
    if wall is None or case.structure is None:
        return
    building = case.building(wall.building)
    heights = {floor: z - building.base for floor, z in building.levels.items()}
    higher = max(heights[k] for k in wall.floors) / heights[wall.displaced_floor]
    reach = abs(wall.displacement) * max(1.0, higher)
    if wall.gap > reach:
        text = (
            f"the wall is out of reach: let go at {wall.displacement:g} m, floors swing back "
            f"{reach:.3g} m at most; usual is a gap of half of that"
        )
        yield source.remark(("wall_impact", "gap"), text)

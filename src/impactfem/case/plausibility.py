"""What is valid and hardly meant: unusual values, and values that do not go together.

Each is a warning with the file, the key, the value and what is usual; nothing is refused.
"""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contacts import KelvinVoigtLaw, UnilateralLaw
from impactfem.case.damping import Damping
from impactfem.case.design_spectrum import DecreeSpectrum, EurocodeSpectrum
from impactfem.case.facade import GRAZING, side_of
from impactfem.case.facing import LEVEL, facing_floors, levels_of
from impactfem.case.floors import Floor
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import SyntheticMotion
from impactfem.case.place import Place, value_at
from impactfem.case.quantity import CALIBRATED
from impactfem.case.report import STAGE_OF
from impactfem.case.soil import HalfSpaceSoil, MatrixSoil, TableSoil
from impactfem.case.source import Source, read_source
from impactfem.case.usual import MASS, MODULUS, unusual
from impactfem.dynamics.damping import UNDAMPED
from impactfem.system.errors import Fault

CONCRETE = ((2200.0, 2600.0), (5e9, 6e10))
"""Densities of concrete [kg/m3], and its moduli, from cracked to of high strength [Pa]."""
ON_SOIL = (0.2, 0.2, 1.0)
"""Least usual frequencies of a rigid building along x, y and z on the springs of its soil [Hz];
isolators are as soft. None is too high: some springs are meant to be rigid."""
GYRATION = (0.5, 80.0)
"""Usual radius of gyration of a floor, √(J/m) [m]."""
DURATION = (0.5, 5.0)
"""Usual time of the sticks over the longest motion: below, much of it is not computed, above, there
is little left to see."""
HEAVY = 0.1
"""Mass of a device over that of its floor from which on it belongs into the model of the building:
US NRC SRP 3.7.2 (II.3.B); below 0.01 it may be left out."""
WIDE = 3.0
"""Largest usual radius of gyration of a device over its size: the radius of its anchor or the
height of its mass centre."""
SLOW = 0.5
"""Least usual frequency of a device on one of its springs [Hz]."""
BESIDE = 0.1
"""How far a point of contact may be outside of the plan [m]."""
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
SAME = 1e-9  # relative difference of numbers that are the same
RATES = np.geomspace(1e-2, 1e9, 60)  # ω² at which laws of damping are compared [1/s2]


def implausible(case: Case, longest: float) -> list[Fault]:
    """What is hardly meant in a case, one a value or a column of a table, with what is usual.

    The longest motion has this duration [s], 0 without one.
    """
    source = read_source(case.path, CaseFile)
    return [
        *unusual(case, source),
        *_concretes(source, case),
        *_dampings(source, case),
        *_plans(source, case),
        *_rafts(source, case),
        *_soils(source, case),
        *_verticals(source, case),
        *_floors(case, source),
        *_pairs(source, case),
        *_edges(source, case),
        *_devices(source, case),
        *_analysis(source, case, longest),
        *_ensemble(source, case),
        *_passage(source, case),
        *_pounding(source, case, longest),
        *_wall(source, case),
        *_published(source, case),
    ]


def _concretes(source: Source, case: Case) -> Iterator[Fault]:
    """Materials as dense as concrete that are softer or stiffer, where both are possible."""
    (light, dense), (soft, stiff) = CONCRETE
    for name, material in case.materials.items():
        rho, E = material.density, material.young_modulus
        # What no material has was told already.
        told = not MODULUS.low <= E <= MODULUS.high
        if rho is not None and light <= rho <= dense and not (told or soft <= E <= stiff):
            place = ("materials", name, "young_modulus")
            text = f"with a density of {rho:g} kg/m3; usual is concrete 20 to 45 GPa"
            yield _written(source, place, text)


def _dampings(source: Source, case: Case) -> Iterator[Fault]:
    places: list[tuple[Place, Damping]] = [
        (("damping",), case.damping),
        *((("buildings", k, "damping"), one.damping) for k, one in enumerate(case.buildings)),
        *((("damping_cases", k), one) for k, one in enumerate(case.damping_cases)),
    ]
    for place, damping in places:
        if damping.law == UNDAMPED and value_at(place, source.raw) is not None:
            yield source.fault(place, None, "both coefficients are 0: no damping at all")
        for k, (_, ratio) in enumerate(damping.points or ()):
            point: Place = (*place, "points", k)
            if not 1e-3 <= ratio <= 1.0 and value_at(point, source.raw) is not None:
                yield _written(source, point, "usual is 1 % to 10 %")
    for (i, a), (j, b) in itertools.combinations(enumerate(case.damping_cases), 2):
        if _same(a, b) and a.restitution == b.restitution:
            text = f"the same damping and restitution as damping_cases[{i}], {a.name}"
            yield source.fault(("damping_cases", j, "name"), b.name, text)
    if all(one.damping == case.damping for one in case.buildings):
        for j, b in enumerate(case.damping_cases):
            if _same(case.damping, b) and b.restitution == CALIBRATED:
                text = "the same damping and restitution as [damping]"
                yield source.fault(("damping_cases", j, "name"), b.name, text)


def _same(a: Damping, b: Damping) -> bool:
    """Whether two laws of damping give the same ratios."""
    pairs = zip(a.law.modal(RATES), b.law.modal(RATES), strict=True)
    return all(math.isclose(p, q, rel_tol=SAME) for p, q in pairs)


def _plans(source: Source, case: Case) -> Iterator[Fault]:
    """Buildings in one another, by their axes or by their plans."""
    names = [building.name for building in case.buildings]
    for (i, a), (j, b) in itertools.combinations(enumerate(case.buildings), 2):
        if a.axis == b.axis:
            place = ("buildings", j, "axis")
            text = f"the axis of buildings[{i}], {a.name}: one stands in the other"
            yield source.fault(place, value_at(place, source.raw), text)
    told = set()
    for one in facing_floors(case).overlapping:
        both = tuple(sorted((names.index(one.a.building), names.index(one.b.building))))
        apart = case.buildings[both[0]].axis != case.buildings[both[1]].axis
        if both not in told and apart:
            told.add(both)
            place = ("buildings", both[1], "axis")
            text = (
                f"the plan overlaps that of {names[both[0]]} by {-one.gap:.3g} m, as at "
                f"{one.a.label} and {one.b.label}; buildings stand side by side"
            )
            yield source.fault(place, value_at(place, source.raw), text)


def _rafts(source: Source, case: Case) -> Iterator[Fault]:
    """Rafts that overlap one another, or the plan of another building."""
    on_rafts = [building.soil is not None for building in case.buildings]
    extents = [(b.length, b.width) if b.soil is None else b.soil.raft.sides for b in case.buildings]
    for j, i in itertools.permutations(range(len(case.buildings)), 2):
        a, b = case.buildings[i], case.buildings[j]
        # Of two rafts, that of the later building is named.
        if not on_rafts[j] or (on_rafts[i] and i > j) or a.axis == b.axis:
            continue
        pairs = zip(extents[i], extents[j], a.axis, b.axis, strict=True)
        into = min(0.5 * ((p or 0.0) + (q or 0.0)) - abs(x - y) for p, q, x, y in pairs)
        if into > BESIDE:
            other = "the raft of " if on_rafts[i] else ""
            text = f"the raft reaches {into:.3g} m into the plan of {other}{a.name}"
            yield source.fault(("buildings", j, "soil", "raft"), None, text)


def _soils(source: Source, case: Case) -> Iterator[Fault]:
    """Springs under a building, written without units, that do not go with its mass."""
    for k, building in enumerate(case.buildings):
        soil, place = building.soil, ("buildings", k, "soil")
        if not isinstance(soil, MatrixSoil | TableSoil):
            continue
        mass = float(soil.raft.inertia[0, 0]) + sum(floor.mass for floor in building.floors)
        for c, least in enumerate(ON_SOIL):
            at: Place = (*place, "file")
            if isinstance(soil, MatrixSoil):
                at, stiffness = (*place, "stiffness", c, c), soil.stiffness[c][c]
            else:
                stiffness = float(soil.curves[c][1, 0])
            frequency = math.sqrt(stiffness / mass) / (2.0 * math.pi)
            if frequency < least:
                text = (
                    f"{stiffness:.3g} N/m along {'xyz'[c]} under {1e-3 * mass:.4g} t are "
                    f"{frequency:.2g} Hz of the rigid building; usual is 1 to 30 Hz"
                )
                yield _written(source, at, text)
                break  # the unit is that of all


def _verticals(source: Source, case: Case) -> Iterator[Fault]:
    """Vertical spectra of horizontal motions, and horizontal ones of vertical motions."""
    for k, motion in enumerate(case.motions):
        spectrum = motion.spectrum if isinstance(motion, SyntheticMotion) else None
        if not isinstance(spectrum, EurocodeSpectrum | DecreeSpectrum):
            continue
        if spectrum.vertical != (motion.direction == "z"):
            kind = "vertical" if spectrum.vertical else "horizontal"
            text = f"its spectrum is the {kind} one (vertical of [motions.spectrum])"
            yield source.fault(("motions", k, "direction"), motion.direction, text)


def _floors(case: Case, source: Source) -> Iterator[Fault]:
    """Moments of inertia that do not go with the masses; of a table that several name once."""
    files: dict[Path, tuple[Floor, ...]] = {}
    for k, building in enumerate(case.buildings):
        raw = value_at(("buildings", k, "floors"), source.raw)
        if isinstance(raw, str):
            files.setdefault(source.path.parent / raw, building.floors)
    low, high = GYRATION
    for file, floors in files.items():
        for floor in floors:
            # A mass that is hardly meant has its own warning.
            for name in ("Jx", "Jy", "Jz") if MASS.low <= floor.mass <= MASS.high else ():
                radius = math.sqrt(getattr(floor, name) / floor.mass)
                if not low <= radius <= high:
                    text = f"√({name}/mass) of floor {floor.floor}; usual is 2 to 30 m"
                    yield Fault(file, f"floor {floor.floor}, {name}", f"{radius:.3g} m", text)


def _pairs(source: Source, case: Case) -> Iterator[Fault]:
    """Vertical normals, points beside a plan or not level, once for each table; still ground."""
    vertical, uneven, beside = set(), set(), set()
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
                        yield _written(source, place, text)
        if abs(contact.normal[2]) > SAME and index not in vertical:
            vertical.add(index)
            text = "not horizontal; buildings side by side push each other along x or y"
            yield _written(source, ("contacts", index, "normal"), text)
        first, second = levels_of(contact, case)
        flat = abs(contact.normal[2]) <= SAME
        if flat and abs(first - second) > LEVEL and index not in uneven:
            uneven.add(index)
            text = (
                f"the points of {contact.name} are at {first:.4g} m and {second:.4g} m; points "
                f"that meet are level, within {LEVEL:g} m"
            )
            yield source.fault(("contacts", index), None, text)


def _edges(source: Source, case: Case) -> Iterator[Fault]:
    """Impact edges of 3D models on a side where no pair strikes: the results at edges are there."""
    for k, building in enumerate(case.buildings):
        mesh = None if building.structure is None else building.structure.mesh
        if not isinstance(mesh, GeneratedMesh):
            continue
        edge = mesh.impact_edge
        axis, sign = "xy".index(edge[0]), float(f"{edge[1]}1")
        struck = [
            (out * contact.normal[0], out * contact.normal[1], 0.0)
            for contact in case.contacts
            for end, out in contact.ends
            if end.building == building.name
        ]
        if struck and all(sign * outward[axis] < GRAZING for outward in struck):
            sides = " and ".join(dict.fromkeys(side_of(outward) for outward in struck))
            text = (
                f"the pairs of {building.name} are on its side {sides}; results at the edges of "
                f"floors are those of side {edge}, which nothing strikes"
            )
            yield _written(source, ("buildings", k, "structure", "mesh", "impact_edge"), text)


def _devices(source: Source, case: Case) -> Iterator[Fault]:
    """Devices that are heavy for their floor, do not go with their moments of inertia, or sway."""
    for k, device in enumerate(case.devices):
        place: Place = ("devices", k)
        anchors, rows = device.anchors, device.modes or ()
        along = [sum(one.effective_mass for one in rows if one.direction == c) for c in "xyz"]
        m = device.mass or max(along)
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
            yield _written(source, (*place, "mass" if device.mass else "modes"), text)
        if device.mass is None or device.mass_height is None:
            continue
        if device.mass_height < 0.0:
            text = (
                "the mass centre is below the anchor; net tension is that of a device that stands "
                "on the floor, whose weight holds it down: one that hangs pulls with its weight"
            )
            yield _written(source, (*place, "mass_height"), text)
        h, J = abs(device.mass_height), device.inertia or (0.0, 0.0, 0.0)
        size = max(h, anchors[0].radius)
        for c, own in enumerate(J):
            if math.sqrt(own / m) > WIDE * size:
                text = (
                    f"√(J/mass) is {math.sqrt(own / m):.3g} m; usual is at most the size of the "
                    f"device, and its anchor and mass_height are within {size:.3g} m"
                )
                yield _written(source, (*place, "inertia", c), text)
            elif own > (sum(J) - own) * (1.0 + SAME):
                text = "more than the sum of the other two, which no body can have"
                yield _written(source, (*place, "inertia", c), text)
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
                yield _written(source, (*place, *key), text)


def _analysis(source: Source, case: Case, longest: float) -> Iterator[Fault]:
    """Given spectra without a direction of the ground; a strong motion too long, or not used."""
    for k, device in enumerate(case.devices):
        known = {one.direction for one in device.spectra or ()}
        lacking = [one.direction for one in case.motions if one.direction not in known]
        if known and lacking:
            text = (
                f"no spectrum along {' and '.join(lacking)}, along which the ground moves: the "
                "analysis with these spectra leaves it out"
            )
            yield _written(source, ("devices", k, "spectra"), text)
    analysis = case.device_analysis
    if analysis is None or analysis.duration is None:
        return
    text = ""
    if not {"dsc", "dsc-abs"} & set(analysis.combination):
        text = "not used: only the combinations 'dsc' and 'dsc-abs' have a duration"
    elif analysis.duration > longest > 0.0:
        text = f"the strong motion is a part of the motion, which lasts {longest:g} s"
    if text:
        yield _written(source, ("device_analysis", "duration"), text)


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
            yield _written(source, place, text)


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
        yield _written(source, ("wave_passage", "apparent_velocity"), text)
    if not max(case.delays.values()) > SAME:
        text = "the waves reach all buildings at the same time: the axes are at right angles to it"
        yield _written(source, ("wave_passage", "direction"), text)


def _pounding(source: Source, case: Case, longest: float) -> Iterator[Fault]:
    """Times that are long for motions or the shortest impact, of two free floors; unused points."""
    if case.pounding.contact_spacing is not None and not case.pounding_in_3d:
        text = (
            "not used: sticks touch at the points of [[contacts]], edges in 3D have such distances "
            "(models of [pounding], 'structure')"
        )
        yield _written(source, ("pounding", "contact_spacing"), text)
    computed = case.pounding.duration
    low, high = (part * longest for part in DURATION)
    if computed is not None and longest > 0.0 and not low <= computed <= high:
        text = (
            f"{computed / longest:.3g} times the longest motion, {longest:g} s; usual are the "
            "motion and some seconds"
        )
        yield _written(source, ("pounding", "duration"), text)
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
        yield _written(source, ("pounding", "time_step"), text)


def _wall(source: Source, case: Case) -> Iterator[Fault]:
    """A wall that a building let go cannot reach: it swings back about as far as it was drawn."""
    wall = case.wall_impact
    if wall is None or case.structure is None:
        return
    building = case.building(wall.building)
    heights = {
        floor.floor: z - building.base
        for floor, z in zip(building.floors, building.elevations, strict=True)
    }
    higher = max(heights[k] for k in wall.floors) / heights[wall.displaced_floor]
    reach = abs(wall.displacement) * max(1.0, higher)
    if wall.gap > reach:
        text = (
            f"the wall is out of reach: let go at {wall.displacement:g} m, floors swing back "
            f"{reach:.3g} m at most; usual is a gap of half of that"
        )
        yield _written(source, ("wall_impact", "gap"), text)


def _published(source: Source, case: Case) -> Iterator[Fault]:
    """Names that no result can have, by their first word; a run knows the others."""
    file = source.path.parent / str(value_at(("published",), source.raw))
    for name in case.published:
        if name.split(".")[0] not in STAGE_OF:
            text = f"no result; their names begin with {', '.join(STAGE_OF)} (docs/run-folder.md)"
            yield Fault(file, "name", name, text)


def _written(source: Source, place: Place, text: str) -> Fault:
    """A warning about what stands at a place, as it is written there."""
    return source.fault(place, value_at(place, source.raw), text)

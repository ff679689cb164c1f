"""What is hardly meant of buildings: their materials, damping, plans, floors, soil and fits."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from impactfem.case.buildings import GeneratedMesh
from impactfem.case.damping import DampingEntry
from impactfem.case.facade import GRAZING, side_of
from impactfem.case.facing import facing_floors
from impactfem.case.floors import Floor
from impactfem.case.model import Case
from impactfem.case.place import Place, dotted, value_at
from impactfem.case.quantity import CALIBRATED
from impactfem.case.soil import MatrixSoil, TableSoil
from impactfem.case.source import Source
from impactfem.case.usual import MASS, MODULUS
from impactfem.dynamics.damping import UNDAMPED
from impactfem.system.errors import Fault

CONCRETE = ((2200.0, 2600.0), (5e9, 6e10))
"""Densities of concrete [kg/m3], and its moduli, from cracked to of high strength [Pa]."""
ON_SOIL = (0.2, 0.2, 1.0)
"""Least usual frequencies of a rigid building along x, y and z on the springs of its soil [Hz];
isolators are as soft. None is too high: some springs are meant to be rigid."""
GYRATION = (0.5, 80.0)
"""Usual radius of gyration of a floor, √(J/m) [m]."""
BAND = np.geomspace(1.0, 20.0, 14)
"""Frequencies at which buildings answer to earthquakes [Hz]."""
MOST_DAMPED = 0.25
"""Largest usual damping ratio there."""
ROUNDED = 1.05
"""One and the rounding of numbers in a table, that of two digits."""
RATES = np.geomspace(1e-2, 1e9, 60)  # ω² at which laws of damping are compared [1/s2]
BESIDE = 0.1
"""How far a point of contact may be outside of the plan [m]."""
NO_BODY = "more than the sum of the other two, which no body can have"
SAME = 1e-9  # relative difference of numbers that are the same


def of_buildings(source: Source, case: Case, told: set[str]) -> Iterator[Fault]:
    """All of it; of keys that were told already no more."""
    # Materials as dense as concrete that are softer or stiffer, where both are possible; what no
    # material has was told already.
    (light, dense), (soft, stiff) = CONCRETE
    for name, material in case.materials.items():
        rho, E = material.density, material.young_modulus
        possible = MODULUS.low <= E <= MODULUS.high
        if rho is not None and light <= rho <= dense and possible and not soft <= E <= stiff:
            text = f"with a density of {rho:g} kg/m3; usual is concrete 20 to 45 GPa"
            yield source.remark(("materials", name, "young_modulus"), text)
    yield from _dampings(source, case, told)
    for further in (_plans, _rafts, _soils, _floors, _targets, _edges):
        yield from further(source, case)


def _dampings(source: Source, case: Case, told: set[str]) -> Iterator[Fault]:
    """No damping, too much of it, or twice the same; of keys that were told already no more."""
    places: list[tuple[Place, DampingEntry]] = [
        (("damping",), case.damping),
        *((("buildings", k, "damping"), one.damping) for k, one in enumerate(case.buildings)),
        *((("damping_cases", k), one) for k, one in enumerate(case.damping_cases)),
    ]
    for place, damping in places:
        if damping.law == UNDAMPED and value_at(place, source.raw) is not None:
            yield source.fault(place, None, "both coefficients are 0: no damping at all")
        strange = any(key.startswith(f"{dotted(place)}.") for key in told)
        for k, (_, ratio) in enumerate(getattr(damping, "points", ())):
            point: Place = (*place, "points", k)
            if not 1e-3 <= ratio <= 1.0 and value_at(point, source.raw) is not None:
                strange = True
                yield source.remark(point, "usual is 1 % to 10 %")
        ratios = damping.law.ratio(BAND)
        if ratios.max() > MOST_DAMPED and not strange and value_at(place, source.raw) is not None:
            text = (
                f"{100.0 * ratios.max():.3g} % of critical at {BAND[ratios.argmax()]:.3g} Hz; "
                f"usual is 1 % to 10 % from {BAND[0]:g} to {BAND[-1]:g} Hz"
            )
            yield source.fault(place, None, text)
    for (i, a), (j, b) in itertools.combinations(enumerate(case.damping_cases), 2):
        if _same(a, b) and a.restitution == b.restitution:
            text = f"the same damping and restitution as damping_cases[{i}], {a.name}"
            yield source.fault(("damping_cases", j, "name"), b.name, text)
    if all(one.damping == case.damping for one in case.buildings):
        for j, b in enumerate(case.damping_cases):
            if _same(case.damping, b) and b.restitution == CALIBRATED:
                text = "the same damping and restitution as [damping]"
                yield source.fault(("damping_cases", j, "name"), b.name, text)


def _same(a: DampingEntry, b: DampingEntry) -> bool:
    """Whether two laws of damping give the same ratios."""
    pairs = zip(a.law.modal(RATES), b.law.modal(RATES), strict=True)
    return all(math.isclose(p, q, rel_tol=SAME) for p, q in pairs)


def _plans(source: Source, case: Case) -> Iterator[Fault]:
    """Buildings in one another, by their axes or by their plans."""
    names = [building.name for building in case.buildings]
    for k, building in enumerate(case.buildings):
        mesh = None if building.structure is None else building.structure.mesh
        for key in ("length", "width") if isinstance(mesh, GeneratedMesh) else ():
            given, made = getattr(building, key), getattr(mesh, key)
            if given is not None and abs(given - made) > BESIDE:
                text = f"the {key} of its mesh is {made:g} m; usual is the same"
                yield source.remark(("buildings", k, key), text)
    for (i, a), (j, b) in itertools.combinations(enumerate(case.buildings), 2):
        if a.axis == b.axis:
            place = ("buildings", j, "axis")
            text = f"the axis of buildings[{i}], {a.name}: one stands in the other"
            yield source.remark(place, text)
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
            yield source.remark(place, text)


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
                yield source.remark(at, text)
                break  # the unit is that of all


def _floors(source: Source, case: Case) -> Iterator[Fault]:
    """Moments of inertia and shear areas that no floor has; of a table that several name once."""
    files: dict[Path, tuple[Floor, ...]] = {}
    for k, building in enumerate(case.buildings):
        raw = value_at(("buildings", k, "floors"), source.raw)
        if isinstance(raw, str):
            files.setdefault(source.path.parent / raw, building.floors)
    low, high = GYRATION
    for file, floors in files.items():
        # A mass that is hardly meant has its own warning.
        told = [floor.floor for floor in floors if not MASS.low <= floor.mass <= MASS.high]
        for name in ("Jx", "Jy", "Jz"):
            radii = {one.floor: math.sqrt(getattr(one, name) / one.mass) for one in floors}
            off = [k for k, radius in radii.items() if k not in told and not low <= radius <= high]
            if off:
                J = next(getattr(one, name) for one in floors if one.floor == off[0])
                text = f"√({name}/mass) is {radii[off[0]]:.3g} m; usual is 2 to 30 m"
                text += f"; so it is in {len(off) - 1} more" if len(off) > 1 else ""
                yield Fault(file, f"floor {off[0]}, {name}", f"{J:.4g} kg m2", text)
                told += off
        for floor in floors:
            J_all = {"Jx": floor.Jx, "Jy": floor.Jy, "Jz": floor.Jz}
            for name, own in J_all.items() if floor.floor not in told else ():
                if own > (sum(J_all.values()) - own) * ROUNDED:
                    yield Fault(file, f"floor {floor.floor}, {name}", f"{own:.4g} kg m2", NO_BODY)
            for name, shear in (("Avy", floor.Avy), ("Avz", floor.Avz)):
                if shear > floor.A * ROUNDED:
                    text = f"more than A, {floor.A:g} m2; a shear area is a part of it"
                    yield Fault(file, f"floor {floor.floor}, {name}", f"{shear:g} m2", text)


def _targets(source: Source, case: Case) -> Iterator[Fault]:
    """Targets of a fit that contradict one another, or buildings that it does not start from."""
    fit = case.calibration
    if fit is None:
        return
    file = source.path.parent / str(value_at(("calibration", "targets"), source.raw))
    weights = [row.frequency_weight + row.mass_weight for row in fit.targets]
    if not any(weights):
        yield Fault(file, "frequency_weight, mass_weight", 0, "all are 0: nothing is fitted")
    for name in dict.fromkeys(row.building for row in fit.targets):
        rows = sorted((r for r in fit.targets if r.building == name), key=lambda row: row.mode)
        for below, row in itertools.pairwise(rows):
            if row.frequency <= below.frequency:
                text = f"mode {below.mode} of {name} has {below.frequency:g} Hz; modes are in order"
                yield Fault(file, f"mode {row.mode}, frequency", f"{row.frequency:g} Hz", text)
        whole = sum(floor.mass for floor in case.building(name).floors)
        if (mass := sum(row.effective_mass for row in rows)) > whole * ROUNDED:
            text = f"the modes of {name} together; the building has {1e-3 * whole:.4g} t"
            yield Fault(file, "effective_mass", f"{1e-3 * mass:.4g} t", text)
    if fit.mode != "fit":
        return
    low, high = fit.stiffness_factor
    starts = [case.building(name) for name in dict.fromkeys(row.building for row in fit.targets)]
    other = [b for b in starts if abs(b.rigid_below + b.rigid_above - fit.rigid_depth) > 1e-3]
    if other:
        words = " and ".join(f"{b.rigid_below + b.rigid_above:g} m of {b.name}" for b in other)
        text = f"usual is rigid_below + rigid_above, {words}"
        yield source.remark(("calibration", "rigid_depth"), text)
    outside = [b for b in starts if not low <= b.stiffness_factor <= high]
    if outside:
        words = " and ".join(f"{b.stiffness_factor:g} of {b.name}" for b in outside)
        text = f"the fit starts from the stiffness_factor, {words}"
        yield source.remark(("calibration", "stiffness_factor"), text)


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
            yield source.remark(("buildings", k, "structure", "mesh", "impact_edge"), text)

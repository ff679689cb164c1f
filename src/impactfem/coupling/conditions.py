"""Conditions that make a case invalid unless its key `allow` lists them.

Results under these conditions are almost always those of an input error. Each message ends with
what to type. "gap" and "depth" are among the checks of the pairs.
"""

import math
from collections.abc import Iterator
from itertools import combinations

from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contacts import KelvinVoigtLaw, UnilateralLaw
from impactfem.case.levels import Level, band, level_at
from impactfem.case.model import Case, CaseFile
from impactfem.case.place import Place
from impactfem.case.plan import overlap
from impactfem.case.source import read_source
from impactfem.coupling.periods import shear_period, stick_period, storey_stiffness, unusual_periods
from impactfem.system.errors import Fault

Finding = tuple[Place, str]
SPEED = 0.5
"""Approach velocity at which the duration of an impact of a law after Hertz is estimated [m/s]."""
SAME = 1e-9
"""Relative difference of numbers that are the same."""
MODELS = 1.2
"""Largest ratio of the first periods of a 3D model and of the stick of one building."""


def conditions(case: Case) -> list[Fault]:
    """Find the conditions of a case that it must allow; the kind of a fault is the name to type."""
    source, found = read_source(case.path, CaseFile), list[Fault]()
    for kind, check in (
        ("overlap", _overlapping_plans),
        ("direction", _no_motion_along_a_normal),
        ("steps", _few_steps),
        ("period", unusual_periods),
        ("stick", _another_stick),
    ):
        more = ""
        if kind not in case.allow:
            listed = ", ".join(f'"{name}"' for name in (*case.allow, kind))
            more = f"; or type allow = [{listed}] at the top of the file to accept this"
        found += [source.fault(place, None, text + more, kind) for place, text in check(case)]
    return found


def _overlapping_plans(case: Case) -> Iterator[Finding]:
    """Find buildings that overlap in plan at a level."""
    for (_, a), (j, b) in combinations(enumerate(case.buildings), 2):
        for index, z in enumerate(a.elevations):
            here, there = Level(a, index, None, z), level_at(b, z, band(a, z))
            if there is None or here.plan is None or there.plan is None:
                continue
            if overlap(here.plan, there.plan):
                axes = (f"{one.name} ({one.axis[0]:g} m, {one.axis[1]:g} m)" for one in (a, b))
                text = (
                    f"the buildings overlap in plan at floor {a.floors[index].floor} of {a.name}; "
                    f"the axes are {' and '.join(axes)}: change axis, or reduce length, width or "
                    "plan"
                )
                yield ("buildings", j, "axis"), text
                break


def _no_motion_along_a_normal(case: Case) -> Iterator[Finding]:
    """Find motions along no normal of the contacts, where no load moves the buildings either."""
    level = [contact.normal for contact in case.contacts if abs(contact.normal[2]) <= SAME]
    along = [] if case.loads else ["xyz".index(motion.direction) for motion in case.motions]
    if level and along and not any(abs(normal[c]) > SAME for normal in level for c in along):
        moved = ", ".join("xyz"[c] for c in along)
        most = max("xy", key=lambda axis: max(abs(normal["xy".index(axis)]) for normal in level))
        text = (
            f"the ground moves along {moved}, and no contact normal does: the buildings will not "
            f'pound; type direction = "{most}"'
        )
        yield ("motions", 0, "direction"), text


def _few_steps(case: Case) -> Iterator[Finding]:
    """Find a time step that is long for the shortest impact of two free floors."""
    durations = []
    for contact in case.contacts:
        law = case.contact_laws[contact.law]
        K = None if isinstance(law, UnilateralLaw) else law.stiffness
        if not isinstance(K, float):
            continue
        hit = {(end.building, end.floor or end.storey) for end, _ in contact.ends}
        floors = ((one.name, floor) for one in case.buildings for floor in one.floors)
        M = 1.0 / sum(1.0 / floor.mass for name, floor in floors if (name, floor.floor) in hit)
        if isinstance(law, KelvinVoigtLaw):
            durations.append((math.pi * math.sqrt(M / K), contact.name))
        else:
            # Hertz: 2.943 p / v with the largest penetration p = (5 M v² / (4 K))^(2/5).
            depth = (1.25 * M * SPEED**2 / K) ** 0.4
            durations.append((2.943 * depth / SPEED, contact.name))
    shortest, name = min(durations, default=(math.inf, ""))
    points, dt = case.pounding.points_per_impact, case.pounding.time_step
    if points * dt > shortest * (1.0 + SAME):
        # Rounded down.
        step = math.floor(1e5 * shortest / points) / 100.0
        text = (
            f"{shortest / dt:.3g} steps in an impact of {name}, which lasts {1e3 * shortest:.3g} "
            f"ms; at least {points} are required (points_per_impact): type time_step = "
            f'"{step:g} ms"'
        )
        yield ("pounding", "time_step"), text


def _another_stick(case: Case) -> Iterator[Finding]:
    """Find sticks that are certainly stiffer than the 3D model of their building.

    The first period of rigid slabs on clamped walls and columns is a lower bound of that of the 3D
    model. Softer sticks are known after its modes: the stage `pounding` checks them.
    """
    fitted = case.calibration is not None and case.calibration.from_structure
    for k, building in enumerate(case.buildings):
        structure = building.structure
        if structure is None or fitted or building.soil is not None:
            continue
        if building.name in case.sticks_on_models:
            continue
        if not isinstance(structure.mesh, GeneratedMesh) or structure.calibration is not None:
            continue
        least = min(shear_period(building, stiffness) for stiffness in storey_stiffness(building))
        period = stick_period(building)
        if least > MODELS * period:
            text = (
                f"the first period of {building.name} is {period:.3g} s by its stick and at least "
                f"{least:.3g} s by its 3D model: the impact forces are those of another building; "
                f'type stick = "structure", or periods = {{ x = "{least:.3g} s" }} in [[buildings]]'
            )
            yield ("buildings", k, "floors"), text

"""Places of contact points: their distance, and the sides of 3D models that take their forces.

The force of a pair acts on the side of the floor, or on the walls and columns of the storey, that
the line through its point along its normal meets. A pair whose line meets none is refused.
"""

import math
from collections.abc import Iterator, Sequence

from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contact_search import facing_floors
from impactfem.case.contacts import Contact, ContactPoint, KelvinVoigtLaw, Vector
from impactfem.case.facade import (
    ALIGNED,
    ROUNDING,
    Facade,
    axis_in_plan,
    rectangle,
    side_of,
    struck,
    words_of,
)
from impactfem.case.levels import flexible, storey_level
from impactfem.case.model import Case
from impactfem.case.place import SEARCHED, Place
from impactfem.case.reading import Reading

Finding = tuple[Place, str]
"""A place in the file that is at fault, and what was expected there."""
SAME = 1e-3
"""Distance and gap may differ by so much [m] and count as the same."""
ROUNDED = 1e-9
"""Rounding of sums of coordinates [m]."""

TURNED = 1.0
"""Distance and gap differ by less than so much [m] once a normal is turned round that was wrong."""


def pair_distance(contact: Contact, case: Case) -> float:
    """Distance of the points of a pair along its normal, n · (x_b − x_a) in plan [m].

    It is nan where the case does not say it: both buildings have the same axis, so that no plan was
    given, the normal is not level, or b is a wall.
    """
    a, b = contact.a, contact.b
    if b is None:
        return math.nan
    (ax, ay), (bx, by) = (case.building(point.building).axis for point in (a, b))
    x, y, z = contact.normal
    if (ax, ay) == (bx, by) or z != 0.0:
        return math.nan
    return x * (bx + b.offset[0] - ax - a.offset[0]) + y * (by + b.offset[1] - ay - a.offset[1])


def of_contacts(case: Case, reading: Reading) -> Iterator[Finding]:
    """Contacts that stand twice, are the wrong way round, or have the law of another building."""
    seen: set[frozenset[ContactPoint | str | None]] = set()
    reported: set[tuple[str, int]] = set()  # of each table of [[contacts]] once
    twice = False
    struck = case.wall_impact.building if case.wall_impact and case.structure else ""
    for contact in case.contacts:
        table, ends = contact.table, frozenset((contact.a, contact.b or contact.wall))
        place = reading.original(("contacts", table))
        # Twice the same points would double the stiffness of their contact unseen.
        if ends in seen and not twice:
            twice = True
            labels = f"{contact.a.label} and {contact.b.label if contact.b else contact.wall}"
            yield ("contacts",), f"expected each pair of points once, found {labels} twice"
        seen.add(ends)
        for side, (point, _) in zip("ab", contact.ends, strict=False):
            if (expected := rigid_zone_fault(point, case)) and (side, table) not in reported:
                reported.add((side, table))
                given = "level" if reading.value(*place, side, "level") else "relative_height"
                yield (*place, side, given), expected
        law = case.contact_laws[contact.law]
        calibrated = struck and isinstance(law, KelvinVoigtLaw) and law.calibrated
        if calibrated and struck not in contact.buildings and ("law", table) not in reported:
            reported.add(("law", table))
            expected = (
                f"expected a law with values: '{contact.law}' is calibrated on "
                f"{struck}, the contact is of {contact.words}"
            )
            yield (*place, "law"), expected
        distance = pair_distance(contact, case)
        if ("distance", table) in reported or not math.isfinite(distance):
            continue
        if distance >= -SAME:
            if abs(distance - contact.gap) > SAME + ROUNDED and "gap" not in case.allow:
                reported.add(("distance", table))
                yield (*place, "gap"), _other_gap(contact, distance)
            continue
        reported.add(("distance", table))
        apart = f"by axis and offset the points of {contact.name} are {distance:.4g} m apart along "
        x, y, _ = contact.normal
        a, b = (case.building(name) for name in contact.buildings)
        # Where the axes lie so, too, and the gap is there with the normal turned round, the normal
        # is at fault, else axes or offsets.
        opposite = x * (b.axis[0] - a.axis[0]) + y * (b.axis[1] - a.axis[1]) < 0.0
        if opposite and -distance - contact.gap < TURNED:
            gap = f"and the gap is {contact.gap:.4g} m"
            yield (*place, "normal"), f"expected the direction from a to b: {apart}it, {gap}"
        else:
            axes = " and ".join(f"{k.name} ({k.axis[0]:g} m, {k.axis[1]:g} m)" for k in (a, b))
            expected = (
                f"expected buildings that stand side by side: {apart}the normal, and the gap is "
                f"{contact.gap:.4g} m; see axis of [[buildings]], {axes}, and the offsets"
            )
            yield place, expected


def rigid_zone_fault(point: ContactPoint, case: Case) -> str:
    """Expectation of a point of a storey that is in the rigid zone of a floor; empty for others."""
    if point.storey is None or point.relative_height is None:
        return ""
    building = case.building(point.building)
    index = [floor.floor for floor in building.floors].index(point.storey)
    low, high = flexible(building, index)
    z = storey_level(building, index, point.relative_height)
    if low < z < high or low >= high:  # without a flexible part the storey is at fault
        return ""
    height = building.floors[index].storey_height
    least, most = (1.0 - (building.elevations[index] - end) / height for end in (low, high))
    floor = building.floors[index if z >= high else index - 1].floor
    return (
        f"expected a height between the rigid zones, {low:.4g} to {high:.4g} m: {z:.4g} m is in "
        f"that of floor {floor}; type floor = {floor}, or a relative_height of {least:.4g} to "
        f"{most:.4g}"
    )


def _other_gap(contact: Contact, distance: float) -> str:
    """Expectation of a gap that is not the distance of its points [m]."""
    return (
        f"expected the distance of the points by axes and offsets: that of {contact.name} is "
        f"{1e3 * distance:.6g} mm, the gap {1e3 * contact.gap:.6g} mm; type gap = "
        f'"{1e3 * max(distance, 0.0):.6g} mm", or correct axis of [[buildings]] and offset, or '
        'type allow = ["gap"] at the top of the file to use the given gap'
    )


def of_search(case: Case, reading: Reading) -> Iterator[Finding]:
    """A search without plans, or that makes no pair; its pairs may all be in [[contacts]]."""
    search = case.contact_search
    if search is None or reading.left_out & {"buildings", "contacts", "contact_search"}:
        return
    if len(case.buildings) < 2:
        yield ("contact_search",), "expected two buildings or more; remove [contact_search]"
        return
    facing = facing_floors(case, search.buildings)
    lacking = dict.fromkeys(name for *_, names in facing.unknown for name in names)
    if lacking:
        yield (
            ("contact_search",),
            f"expected the plan of {' and '.join(lacking)}: type length and width, or plan, in its "
            "table of [[buildings]]",
        )
    elif all(one.table != SEARCHED for one in case.contacts) and (
        facing.pairs or not case.contacts
    ):
        nearest = min(facing.pairs, key=lambda pair: pair.gap, default=None)
        expected = "expected floors that face each other and are in no pair of [[contacts]]"
        if nearest is not None:
            gap = f'{1e3 * nearest.gap:.4g} mm"'
            expected += f'; the nearest ones are {nearest.words}: type largest_gap = "{gap}'
        yield ("contact_search",), expected + ", or remove [contact_search]"


HEIGHT = 0.1
"""Largest distance of a pair from the floor's mass centre in height [m]: forces act in the slab."""


def strike_fault(
    outward: Vector, offset: Vector, inside: bool, sides: Sequence[Facade], met: bool
) -> tuple[str, str] | None:
    """Why a 3D building cannot take the force of a pair: "normal" or "offset", and why.

    Args:
        outward: Unit vector of the pair, out of the building.
        offset: From the stick's axis to its point [m].
        inside: Whether this is inside a storey.
        sides: The sides of the floor; none where they are not known.
        met: Whether the line through the point along the normal meets one of these.
    """
    if abs(outward[2]) > ALIGNED:
        expected = "expected a horizontal normal: floors of a 3D building are struck on their sides"
        return "normal", expected
    if not inside and abs(offset[2]) > HEIGHT:
        return "offset", (
            "the 3D building takes the forces of a floor in its slab, and this pair is "
            f"{abs(offset[2]):.4g} m {'above' if offset[2] > 0.0 else 'below'} the floor's mass "
            f"centre; expected at most {HEIGHT:g} m"
        )
    if sides and not met:
        spans = (
            f"{side_of(one.outward)} from {words_of(one.start)} to {words_of(one.end)} m"
            for one in sides
        )
        return "offset", (
            "expected a point on the side of the floor of the 3D building that the normal leads "
            f"through: {', '.join(spans)}"
        )
    return None


def of_struck_sides(case: Case, reading: Reading) -> Iterator[Finding]:
    """Contacts of a case whose forces its 3D buildings cannot take in [transient].

    Of a mesh from a file what holds for every mesh; `check` reads the mesh later.
    """
    if "transient" not in reading.source.raw:
        return
    transient = case.transient
    eccentricity = 0.0 if transient is None else transient.eccentricity
    calibrated = transient is not None and transient.spread == "calibrated"
    for building in reading.three_d:
        wall = case.wall_impact
        floors = () if wall is None or wall.building != building else wall.floors
        meshes = [one.mesh for one in case.structures if one.building == building]
        mesh = meshes[0] if meshes and isinstance(meshes[0], GeneratedMesh) else None
        unknown: list[str] = []  # to spread `calibrated`
        places: list[tuple[Facade, float]] = []
        ends = [
            (("contacts", index), side, end, tuple(sign * x for x in contact.normal))
            for index, contact in reading.entries.get("contacts", {}).items()
            for side, sign in (("a", 1.0), ("b", -1.0))
            if (end := getattr(contact, side)) is not None and end.building == building
        ]
        axes = [one.axis for one in case.buildings if one.name == building]
        plan, axis = tuple[Facade, ...](), (0.0, 0.0)
        if mesh is not None and axes:
            plan = rectangle(mesh.length, mesh.width, mesh.impact_edge)
            on_floors = [(plan, end.offset, n) for *_, end, n in ends if end.storey is None]
            axis = axis_in_plan(axes[0], (0.0, 0.0), (mesh.length, mesh.width), on_floors)
        for place, side, end, (x, y, z) in ends:
            sides = plan if abs(z) <= ALIGNED else ()
            point = axis[0] + end.offset[0], axis[1] + end.offset[1]
            met = struck(sides, point, (x, y, 0.0))
            wrong = strike_fault(
                (x, y, z), end.offset, end.storey is not None, sides, met is not None
            )
            if wrong is not None:
                key, expected = wrong
                yield (*place, "normal") if key == "normal" else (*place, side, key), expected
            elif met is not None:
                places.append(met)
            if calibrated and end.floor is not None:
                unknown += [f"floor {k}" for k in end.floor if k not in floors]
                unknown += [side_of((x, y, z))] if met is not None and met[0].side else []
        if places:
            # One fault for all pairs: that of the one which is moved the farthest off its side.
            worst = max(
                places,
                key=lambda met: max(-met[1] - eccentricity, met[1] + eccentricity - met[0].length),
            )
            if expected := moved_beside(worst, eccentricity):
                yield ("transient", "eccentricity"), expected
        if unknown:
            what = ", ".join(dict.fromkeys(unknown))
            yield ("transient", "spread"), calibrated_only(what, building)


def moved_beside(met: tuple[Facade, float], eccentricity: float) -> str:
    """Expectation of an eccentricity [m] that moves a force off its side; else empty."""
    facade, s = met
    if -ROUNDING <= s + eccentricity <= facade.length + ROUNDING:
        return ""
    return (
        f"expected a distance of {-s + 0.0:.4g} to {facade.length - s:.4g} m, which moves no pair "
        f"beyond the ends of its side: one is {s:.4g} m from the start of {side_of(facade.outward)}"
    )


def calibrated_only(what: str, building: str) -> str:
    """Expectation of a spread that the impact on the wall does not know."""
    return (
        f"expected 'uniform' or 'patch': pairs strike {what} of {building}, and 'calibrated' is "
        "known of the edges that hit the wall alone (floors of [wall_impact], its building)"
    )

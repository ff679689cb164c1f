"""Where the points of contacts are: how far apart, and whether the 3D stage can take their forces.

The forces of all pairs of a floor become one line load on the edge of its slab, even along it, at
right angles to it, in the middle. A pair that is anything else is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contacts import Contact, ContactEntry, ContactPoint, KelvinVoigtLaw, Vector
from impactfem.case.model import Case
from impactfem.case.place import Place
from impactfem.case.reading import Reading

Finding = tuple[Place, str]
"""A place in the file that is at fault, and what was expected there."""
SMALLEST, PART = 1e-3, 0.1
"""Distance and gap may differ by so much [m], or by this part of the gap, and count as the same."""

TURNED = 1.0
"""Distance and gap differ by less than so much [m] once a normal is turned round that was wrong."""


def allowed(gap: float) -> float:
    """Difference of distance and gap up to which they count as the same [m], for a gap [m]."""
    return max(SMALLEST, PART * gap)


def pair_distance(contact: Contact, case: Case) -> float:
    """Distance of the points of a pair along its normal, n · (x_b − x_a) in plan [m].

    It is nan where the case does not say it: both buildings have the same axis, so that no plan was
    given, or the normal is not level.
    """
    a, b = contact.a, contact.b
    (ax, ay), (bx, by) = (case.building(point.building).axis for point in (a, b))
    x, y, z = contact.normal
    if (ax, ay) == (bx, by) or z != 0.0:
        return math.nan
    return x * (bx + b.offset[0] - ax - a.offset[0]) + y * (by + b.offset[1] - ay - a.offset[1])


def of_contacts(case: Case, reading: Reading) -> Iterator[Finding]:
    """Contacts that stand twice, are the wrong way round, or have the law of another building."""
    seen: set[tuple[ContactPoint, ContactPoint]] = set()
    reported: set[tuple[str, int]] = set()  # of each table of [[contacts]] once
    twice = False
    struck = case.wall_impact.building if case.wall_impact and case.structure else ""
    for contact in case.contacts:
        table, ends = contact.table, (contact.a, contact.b)
        place = reading.original(("contacts", table))
        a, b = (case.building(end.building) for end in ends)
        # Twice the same points would double the stiffness of their contact unseen.
        if ends in seen and not twice:
            twice = True
            labels = f"{contact.a.label} and {contact.b.label}"
            yield ("contacts",), f"expected each pair of points once, found {labels} twice"
        seen.add(ends)
        law = case.contact_laws[contact.law]
        calibrated = struck and isinstance(law, KelvinVoigtLaw) and law.calibrated
        if calibrated and struck not in (a.name, b.name) and ("law", table) not in reported:
            reported.add(("law", table))
            expected = (
                f"expected a law with values of its own: '{contact.law}' is calibrated on "
                f"{struck}, the contact is of {a.name} and {b.name}"
            )
            yield (*place, "law"), expected
        distance = pair_distance(contact, case)
        if not distance < -allowed(contact.gap) or ("distance", table) in reported:
            continue
        reported.add(("distance", table))
        apart = f"by axis and offset the points of {contact.name} are {distance:.4g} m apart along "
        x, y, _ = contact.normal
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


ALIGNED = 1e-3
"""Largest difference of a pair's normal, a unit vector, from where it has to point."""
CENTRAL = 0.01
"""A pair is central within this part of the edge's length from its middle; EN 1998-1, 4.3.2, has
five times as much for what nobody knows of where the masses are."""
HEIGHT = 0.1
"""How far above or below the floor's mass centre a pair may be [m]: forces act in the slab."""

VERTICAL = "expected a horizontal normal: floors of a 3D building are struck on their edges"


@dataclass(frozen=True)
class StruckEdge:
    """The edge of a floor that can be struck."""

    outward: Vector  #: horizontal unit vector at right angles to it, out of the building
    #: From where to where it goes along x or y, whichever it is closer to [m].
    ends: tuple[float, float]
    low: tuple[float, float]  #: lowest x and y of the floor [m]
    high: tuple[float, float]  #: highest x and y of the floor [m]
    words: str  #: what says so, for messages

    @property
    def along(self) -> int:
        """The direction, 0 or 1 for x or y, that the edge is closer to."""
        return 0 if abs(self.outward[1]) > abs(self.outward[0]) else 1

    @property
    def length(self) -> float:
        """Extent of the edge in that direction [m]."""
        return self.ends[1] - self.ends[0]

    def eccentricity(self, axis: tuple[float, float], offset: Vector) -> float:
        """Distance of a point from the middle of the edge, along x or y [m].

        A stick whose axis [m] is not within the plan has other coordinates than the mesh: its axis
        counts as the middle.
        """
        along = self.along
        inside = all(low < x < high for x, low, high in zip(axis, self.low, self.high, strict=True))
        middle = 0.5 * sum(self.ends) if inside else axis[along]
        return axis[along] + offset[along] - middle


def side_of(vector: Vector) -> str:
    """The side of a building that a horizontal unit vector points to: "y+", or the vector."""
    for axis, name in enumerate("xy"):
        if abs(vector[1 - axis]) <= ALIGNED and vector[axis] != 0.0:
            return f"{name}{'+' if vector[axis] > 0.0 else '-'}"
    return words_of(vector)


def words_of(vector: Iterable[float]) -> str:
    """A vector in words, without signs of zeros."""
    return "({})".format(", ".join(f"{float(x) + 0.0:g}" for x in vector))


def normal_fault(outward: Vector, edge: StruckEdge | None) -> str | None:
    """Why a unit vector out of the building is not normal to an edge; None where it may be."""
    if abs(outward[2]) > ALIGNED:
        return VERTICAL
    if edge is None:  # not known yet
        return None
    across = sum(a * b for a, b in zip(outward, edge.outward, strict=True))
    off = math.dist(outward, [across * x for x in edge.outward])
    side = side_of(outward)
    if (across < 0.0 and off <= ALIGNED) or off > 1.0 - ALIGNED:
        return (
            f"a 3D building can be struck on one side only ({edge.words}); this pair strikes {side}"
        )
    if off > ALIGNED:
        return (
            f"expected a normal at right angles to the edge, {words_of(edge.outward)} out of the "
            f"3D building ({edge.words}); this one is {side}"
        )
    return None


def offset_fault(
    axis: tuple[float, float], offset: Vector, edge: StruckEdge, eccentricity: float
) -> str | None:
    """Why a point is not the middle of an edge; None where it is.

    The offset leads to it from the axis of the stick in plan; the eccentricity is where [transient]
    puts the forces of all pairs, from the middle [m].
    """
    e, allowed = edge.eccentricity(axis, offset), CENTRAL * edge.length
    if min(abs(e), abs(e - eccentricity)) > allowed:
        return (
            "the 3D building takes the forces of a floor in the middle of its edge, and this pair "
            f"is {e:.4g} m away from it along the edge; expected at most {allowed:.3g} m (1 % of "
            f"the edge of {edge.length:.4g} m), or [transient] eccentricity = '{e:.4g} m' where "
            "all pairs are there"
        )
    if abs(offset[2]) > HEIGHT:
        return (
            "the 3D building takes the forces of a floor in its slab, and this pair is "
            f"{abs(offset[2]):.4g} m {'above' if offset[2] > 0.0 else 'below'} the floor's mass "
            f"centre; expected at most {HEIGHT:g} m"
        )
    return None


def of_struck_edges(case: Case, reading: Reading) -> Iterator[Finding]:
    """Contacts of a case whose forces its 3D buildings cannot take in [transient].

    From the file as it stands: another table with a fault of its own hides none of these. Of a mesh
    from a file what holds for every mesh; `check` reads the mesh later.
    """
    if "transient" not in reading.source.raw:
        return
    eccentricity = None if case.transient is None else case.transient.eccentricity
    for building, model in reading.three_d.items():
        with reading.model_of(building):
            mesh = reading.valid(GeneratedMesh, reading.value(*model, "mesh"))
        edge = None
        if mesh is not None:
            sign = 1.0 if mesh.impact_edge[1] == "+" else -1.0
            along_x = mesh.impact_edge[0] == "y"
            edge = StruckEdge(
                outward=(0.0, sign, 0.0) if along_x else (sign, 0.0, 0.0),
                ends=(0.0, mesh.length if along_x else mesh.width),
                low=(0.0, 0.0),
                high=(mesh.length, mesh.width),
                words=f'impact_edge = "{mesh.impact_edge}"',
            )
        axis = next((one.axis for one in case.buildings if one.name == building), None)
        # The first contact of each floor and where it strikes.
        struck: dict[int, tuple[int, Vector]] = {}
        for index, one in reading.tables("contacts"):
            contact = reading.valid(ContactEntry, one)
            for side, sign in (("a", 1.0), ("b", -1.0)) if contact is not None else ():
                end, place = getattr(contact, side), ("contacts", index)
                if end.building != building:
                    continue
                if end.storey is not None:
                    expected = (
                        "expected floor in place of storey: a 3D building can be struck on the "
                        "edges of its floors only (section [transient])"
                    )
                    yield (*place, side, "storey"), expected
                x, y, z = (sign * component for component in contact.normal)
                wrong = normal_fault((x, y, z), edge)
                for floor in end.floor or () if edge is None and wrong is None else ():
                    first, other = struck.setdefault(floor, (index, (x, y, z)))
                    if math.dist((x, y, z), other) > ALIGNED:
                        wrong = (
                            f"a 3D building can be struck on one side only: contacts[{first}] "
                            f"strikes floor {floor} on {side_of(other)}, this pair on "
                            f"{side_of((x, y, z))}"
                        )
                        break
                if wrong is not None:
                    yield (*place, "normal"), wrong
                if edge is not None and eccentricity is not None and axis is not None:
                    aside = offset_fault(axis, end.offset, edge, eccentricity)
                    if aside is not None:
                        yield (*place, side, "offset"), aside

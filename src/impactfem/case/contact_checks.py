"""Where the points of contacts are: how far apart, and whether the 3D stage can take their forces.

The forces of all pairs of a floor become one line load on the edge of its slab, even along it, at
right angles to it, in the middle. A pair that is anything else is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from impactfem.case.contacts import Contact, ContactEntry, Vector
from impactfem.case.model import Case
from impactfem.case.place import Place
from impactfem.case.reading import Reading
from impactfem.case.structure import GeneratedMesh
from impactfem.system.errors import Fault

SMALLEST, PART = 1e-3, 0.1
"""Distance and gap may differ by so much [m], or by this part of the gap, and count as the same."""


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


def distance_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Contacts whose points lie the other way round along the normal than from a to b.

    Where the axes lie so, too, the normal is at fault, else axes or offsets.
    """
    told: set[int] = set()
    for contact in case.contacts:
        distance = pair_distance(contact, case)
        if distance >= -allowed(contact.gap) or math.isnan(distance) or contact.table in told:
            continue
        told.add(contact.table)
        place = ("contacts", contact.table)
        apart = f"by axis and offset the points of {contact.name} are {distance:.4g} m apart along "
        a, b = (case.building(end.building) for end in (contact.a, contact.b))
        x, y, _ = contact.normal
        if x * (b.axis[0] - a.axis[0]) + y * (b.axis[1] - a.axis[1]) < 0.0:
            expected = (
                f"expected the direction from a to b: {apart}it, and the gap is {contact.gap:.4g} m"
            )
            yield reading.fault((*place, "normal"), list(contact.normal), expected)
        else:
            expected = (
                f"expected buildings that stand side by side: {apart}the normal, and the gap "
                f"is {contact.gap:.4g} m; see axis of [[buildings]], {a.name} {_point(a.axis)} "
                f"and {b.name} {_point(b.axis)}, and the offsets"
            )
            yield reading.fault(place, None, expected)


def _point(axis: tuple[float, float]) -> str:
    return f"({axis[0]:g} m, {axis[1]:g} m)"


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


def generated_edge(mesh: GeneratedMesh) -> StruckEdge:
    """The edge of every floor of a generated mesh."""
    sign = 1.0 if mesh.impact_edge[1] == "+" else -1.0
    outward = (sign, 0.0, 0.0) if mesh.impact_edge[0] == "x" else (0.0, sign, 0.0)
    words = f'impact_edge = "{mesh.impact_edge}"'
    length = mesh.length if mesh.impact_edge[0] == "y" else mesh.width
    return StruckEdge(outward, (0.0, length), (0.0, 0.0), (mesh.length, mesh.width), words)


def normal_fault(outward: Vector, edge: StruckEdge) -> str | None:
    """Why a unit vector out of the building is not normal to an edge; None where it is."""
    if abs(outward[2]) > ALIGNED:
        return VERTICAL
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

    Args:
        axis: Plan position of the stick's axis [m].
        offset: From the axis to the point [m].
        edge: The edge.
        eccentricity: Where [transient] puts the forces of all pairs, from the middle [m].
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


def struck_edge_faults(case: Case, reading: Reading) -> Iterator[Fault]:
    """Contacts of a case whose forces its 3D buildings cannot take in [transient].

    From the file as it stands: another table with a fault of its own hides none of these. Of a mesh
    from a file what holds for every mesh; `check` reads the mesh later.
    """
    if "transient" in reading.source.raw:
        for building, place in reading.three_d.items():
            yield from _struck_edge_faults(case, reading, building, place)


def _struck_edge_faults(
    case: Case, reading: Reading, building: str, model: Place
) -> Iterator[Fault]:
    """The same of one of its 3D buildings, whose 3D model stands at a place of the file."""
    with reading.model_of(building):
        mesh = reading.valid(GeneratedMesh, reading.value(*model, "mesh"))
    edge = None if mesh is None else generated_edge(mesh)
    axis = next((one.axis for one in case.buildings if one.name == building), None)
    struck: dict[int, tuple[int, Vector]] = {}
    for index, one in reading.tables("contacts"):
        contact = reading.valid(ContactEntry, one)
        if contact is None:
            continue
        place = ("contacts", index)
        for side, end, sign in (("a", contact.a, 1.0), ("b", contact.b, -1.0)):
            if end.building != building:
                continue
            if end.storey is not None:
                expected = (
                    "expected floor in place of storey: a 3D building can be struck on the edges "
                    "of its floors only (section [transient])"
                )
                yield reading.source.fault((*place, side, "storey"), list(end.storey), expected)
            x, y, z = (sign * component for component in contact.normal)
            if edge is None:
                wrong = _two_sides(struck, index, end.floor or (), (x, y, z))
            else:
                wrong = normal_fault((x, y, z), edge)
            if wrong is not None:
                yield reading.source.fault((*place, "normal"), list(contact.normal), wrong)
            if edge is not None and case.transient is not None and axis is not None:
                aside = offset_fault(axis, end.offset, edge, case.transient.eccentricity)
                if aside is not None:
                    yield reading.source.fault((*place, side, "offset"), list(end.offset), aside)


def _two_sides(
    struck: dict[int, tuple[int, Vector]], index: int, floors: tuple[int, ...], outward: Vector
) -> str | None:
    """Why a normal is that of no edge of any mesh: vertical, or two sides of one floor.

    The first contact of each floor and where it strikes are kept in ``struck``.
    """
    if abs(outward[2]) > ALIGNED:
        return VERTICAL
    for floor in floors:
        first, other = struck.setdefault(floor, (index, outward))
        if math.dist(outward, other) > ALIGNED:
            return (
                f"a 3D building can be struck on one side only: contacts[{first}] strikes floor "
                f"{floor} on {side_of(other)}, this pair on {side_of(outward)}"
            )
    return None

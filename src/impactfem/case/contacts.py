"""Contacts: pairs of points of two buildings that may pound, and the law of the contact force."""

import math
from bisect import bisect_left
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import Field, StrictBool, ValidationInfo, field_validator, model_validator
from scipy.special import roots_legendre

from impactfem.case.base import Section, either, once, refuse, rule
from impactfem.case.floors import floors_of
from impactfem.case.leaf import BuildingName, FloorNumbers, LawName, Name, OneOrMore, Whole
from impactfem.case.place import SEARCHED
from impactfem.case.quantity import (
    CALIBRATED,
    Area,
    CalibratedRestitution,
    CalibratedStiffness,
    DampingRatio,
    Depth,
    EdgeStiffness,
    HertzStiffness,
    Length,
    Number,
    PositiveLength,
    PositiveSpeed,
    Restitution,
    Si,
)

Vector = tuple[float, float, float]
LINE_ONLY = 'expected length together with it: type length = "10 m", that of the façades in common'
Points = Annotated[int, Whole(1, 20)]
HEIGHT_DECIMALS = 6
"""Of relative heights: sums of storey heights leave rounding behind."""


def check_floors(floors: tuple[int, ...], info: ValidationInfo) -> None:
    """Refuse numbers of floors that the building of a section lacks, where its floors are known."""
    building = info.data.get("building", "")
    known = [floor.floor for floor in floors_of(building, info)]
    absent = ", ".join(str(number) for number in floors if known and number not in known)
    if absent:
        its = ", ".join(map(str, known))
        raise refuse(f"{building} has no floor {absent}; its floors are {its}", kind="no_floor")


def unit_vector(value: Vector) -> Vector:
    """The vector of length 1 along a vector of the case file; one of zeros is refused."""
    largest = max(abs(component) for component in value)
    if largest == 0.0:
        raise refuse("expected a vector that is not zero", kind="zero")
    # Scaled first, so that the squares neither overflow nor vanish.
    x, y, z = (component / largest for component in value)
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


class KelvinVoigtLaw(Section):
    """A spring and a dashpot in parallel, acting while the gap is closed.

    Either ``restitution`` or ``damping_ratio``: the paper's equation 4 leads from one to the other,
    without ``tension`` the relation of Schwager and Pöschel (2007), as contact then ends earlier.
    "calibrated" takes a value from the impact of [wall_impact].
    """

    type: Literal["kelvin-voigt"]
    """Spring and dashpot in parallel."""
    stiffness: CalibratedStiffness
    """Stiffness K_C of the contact; calibrated by the paper's equation 6."""
    restitution: CalibratedRestitution | None = None
    """Coefficient of restitution requested: velocity after over velocity before; calibrated by the
    paper's equation 5."""
    damping_ratio: DampingRatio | None = Field(default=None, validate_default=True)
    """Damping ratio ξ_C of the contact, with the reduced mass of the two floors."""
    tension: StrictBool = True
    """true keeps the tensile force at the end of an impact, as the paper does; false clips the
    force at zero."""

    _damped = either("restitution", "damping_ratio", "restitution or damping_ratio", apart=True)

    @property
    def calibrated(self) -> bool:
        """True if a value is left to the calibration."""
        return CALIBRATED in (self.stiffness, self.restitution)


def _refuse_word(value: Any) -> Any:
    """Refuse the word for a law that takes no other values than those of the case file."""
    if value == CALIBRATED:
        expected = "expected a value: only a law of type 'kelvin-voigt' is calibrated"
        raise refuse(expected, kind="not_calibrated")
    return value


class HertzLaw(Section):
    """An elastic spring with a force proportional to the penetration to the power 1.5."""

    type: Literal["hertz"]
    """Elastic contact of Hertz, without restitution."""
    stiffness: HertzStiffness
    """Stiffness K of F = K p^1.5."""

    _as_given = field_validator("stiffness", mode="before")(_refuse_word)


class _DampedHertzLaw(Section):
    """Keys of the laws that damp a contact of Hertz."""

    stiffness: HertzStiffness
    """Stiffness K of the elastic part K p^1.5."""
    restitution: Restitution
    """Coefficient of restitution requested: velocity after over velocity before."""
    relation: Literal["published", "exact"] = "published"
    """Relation of damping and restitution: published formula, or exact for two free masses."""

    _as_given = field_validator("stiffness", "restitution", mode="before")(_refuse_word)


class _SpeedDampedLaw(_DampedHertzLaw):
    slowest_approach: PositiveSpeed = 1e-3
    """Lower limit of the approach velocity in the damping, which is unbounded for a contact that
    begins at rest."""


class HertzDampLaw(_SpeedDampedLaw):
    """Hertz contact with the damping of Lankarani and Nikravesh: no jump of the force at onset."""

    type: Literal["hertz-damp"]
    """F = K p^1.5 (1 + 3/4 (1 - ε²) v/v_0), Muthukumar and DesRoches 2006."""


class HuntCrossleyLaw(_SpeedDampedLaw):
    """Hertz contact with the damping of Hunt and Crossley: no jump of the force at onset."""

    type: Literal["hunt-crossley"]
    """F = K p^1.5 (1 + 3/2 (1 - ε) v/v_0), Hunt and Crossley 1975."""


class JankowskiLaw(_DampedHertzLaw):
    """Hertz contact that is damped while the floors approach, and elastic while they part."""

    type: Literal["jankowski"]
    """Damped approach, elastic separation; Jankowski 2005 and 2006."""


class UnilateralLaw(Section):
    """Edges that do not penetrate, for buildings that pound in 3D (see models of [pounding]).

    Stiffness and restitution are no inputs: both result from the waves in the buildings.
    """

    type: Literal["unilateral"]
    """Contact without penetration."""
    edge_stiffness: EdgeStiffness | None = None
    """Stiffness of the surfaces of both edges: line load over the approach that the 3D models do
    not have. Default: slabs that touch over half of their thickness, 3.69 E/(1 - ν²) of each
    edge, in series. 'rigid' for none. Not used by the scheme 'moreau'."""


ContactLaw = (
    KelvinVoigtLaw | HertzLaw | HertzDampLaw | HuntCrossleyLaw | JankowskiLaw | UnilateralLaw
)
ContactLawEntry = Annotated[ContactLaw, Field(discriminator="type")]


class ContactEnd(Section):
    """A point of a building, or one point a floor: on floors, or inside storeys."""

    building: BuildingName
    """Name of the building."""
    floor: FloorNumbers | None = None
    """Floor of the point; a list makes one pair for each floor."""
    level: Annotated[tuple[Length, ...], Field(min_length=1), OneOrMore()] | None = None
    """In place of floor: elevation of the point, between two floors."""
    storey: FloorNumbers | None = Field(default=None, validate_default=True)
    """In place of floor and level: the storey below this floor."""
    relative_height: (
        Annotated[
            tuple[Annotated[float, Si("-", gt=0, lt=1)], ...], Field(min_length=1), OneOrMore()
        ]
        | None
    ) = Field(default=None, validate_default=True)
    """With storey: height of the point from floor to floor, between 0, the mass centre of the lower
    floor or the base, and 1, that of the upper floor; a list has a height for each storey."""
    offset: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Vector (x, y, z) from the stick's axis, at the floor's mass centre or the height in the
    storey, to the point."""

    @field_validator("floor", "storey")
    @classmethod
    def _existing(cls, value: Any, info: ValidationInfo) -> Any:
        check_floors(value or (), info)
        return value

    @rule("storey", "floor", "level", kind="either")
    @staticmethod
    def _on_a_level(storey: Any, floor: Any, level: Any) -> Iterator[str]:
        given = sum(one is not None for one in (floor, level, storey))
        if given != 1:
            lead = "missing; " if not given else ""
            yield f"{lead}expected one of floor, level, and storey with relative_height"

    @rule("relative_height", "storey")
    @staticmethod
    def _of_storey(heights: tuple[float, ...] | None, storey: Any) -> Iterator[str]:
        if heights is None and storey is not None:
            yield "required with `storey`: a number between 0 and 1"
        if heights is not None and storey is None:
            yield "`relative_height` requires `storey`; it cannot be used with `floor` or `level`"
        elif heights is not None and len(heights) not in (1, len(storey)):
            yield f"expected one height, or one for each of {len(storey)} storeys"

    @model_validator(mode="after")
    def _storey_of_level(self, info: ValidationInfo) -> Self:
        """Find the storey of each level, where the building is known."""
        known = {} if info.context is None else info.context.values
        of = next((one for one in known.get("buildings", ()) if one.name == self.building), None)
        if self.level is None or of is None:
            return self
        storeys, heights = [], []
        for z in self.level:
            if not of.base < z < of.elevations[-1]:
                expected = f"expected a level of {of.name}, {of.base:g} to {of.elevations[-1]:g} m"
                raise refuse(expected, "level", kind="no_storey")
            index = bisect_left(of.elevations, z)
            floor = of.floors[index]
            storeys.append(floor.floor)
            height = 1.0 - (of.elevations[index] - z) / floor.storey_height
            heights.append(round(height, HEIGHT_DECIMALS))
        found = {"storey": tuple(storeys), "relative_height": tuple(heights)}
        return self.model_copy(update=found)

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.floor or self.level or self.storey or ())

    @property
    def in_building(self) -> bool:
        """Whether the storeys of its levels are found: not where the building has a fault."""
        return self.level is None or self.storey is not None


class ContactEntry(Section):
    """One contact pair, or one pair for each floor if the ends list floors.

    Either ``b`` or ``wall``: a rigid wall is a plane at right angles to the normal, that moves with
    the ground.
    """

    a: ContactEnd
    """The point on the first building."""
    b: ContactEnd | None = None
    """The point on the second building."""
    wall: Name | None = Field(default=None, validate_default=True)
    """Name of a rigid wall in place of b, used in the names of the pairs."""
    normal: tuple[Number, Number, Number]
    """Direction (x, y, z) from a to b or the wall, of any length."""
    gap: Depth
    """Distance of the points, or of a and the wall, along the normal at rest."""
    law: LawName
    """Name of the contact law."""
    bearing_area: Area | None = None
    """Contact area, for the mean bearing pressure. Default: length by depth, where both are
    given."""
    length: PositiveLength | None = None
    """Length of a line contact along the façades, at right angles to the normal; the points a and b
    are its middle. Without it, the contact is a point of a stick, and in 3D a line as long as both
    sides face each other."""
    points: Points | None = None
    """With length: number of points of the line in sticks, each with its share of stiffness and
    area; Gauss points, of which two have the rotational stiffness of the line. Results give the
    line as one pair, with the sum of the forces. Default 2."""
    depth: PositiveLength | None = None
    """With length: depth of the slab edge. On a storey of a 3D model the force acts on a strip of
    this depth."""
    gap_slope: Number = 0.0
    """With length: growth of the gap for each metre along the façades, to the left of the normal;
    the normal is the bisector of both façades."""

    @rule("points", "length")
    @staticmethod
    def _points_of_a_line(points: int | None, length: float | None) -> Iterator[str]:
        if points is not None and length is None:
            yield LINE_ONLY

    @rule("depth", "length")
    @staticmethod
    def _depth_of_a_line(depth: float | None, length: float | None) -> Iterator[str]:
        if depth is not None and length is None:
            yield LINE_ONLY

    @rule("gap_slope", "length", "gap", "normal")
    @staticmethod
    def _open_along_the_line(
        slope: float, length: float | None, gap: float, normal: Vector
    ) -> Iterator[str]:
        if slope != 0.0 and length is None:
            yield LINE_ONLY
        if length is not None and normal[2] != 0.0:
            yield "expected no length with a normal that is not horizontal: remove length"
        if length is not None and 0.5 * abs(slope) * length > gap + 1e-9:
            most = 2.0 * gap / length
            yield f"expected at most {most:.3g}: the gap is negative at one end of the line"

    @rule("b", "a")
    @staticmethod
    def _pairs(b: ContactEnd | None, a: ContactEnd) -> Iterator[str]:
        if b is None:
            return
        if a.building == b.building:
            yield f"expected another building than '{a.building}', the one of a"
        if a.count != b.count:
            yield (
                f"expected lists of the same length: a has {a.count} points, b has {b.count}, and "
                "pairs are formed one to one"
            )

    @rule("wall", "b", sited=True)
    @staticmethod
    def _building_or_wall(
        wall: str | None, b: ContactEnd | None, info: ValidationInfo
    ) -> Iterator[str]:
        if wall is None and b is None:
            yield "missing; expected either b, the point on another building, or wall"
        if wall is not None and b is not None:
            yield "expected either b or wall, not both"
        if info.context is not None and wall in (info.context.names("buildings") or ()):
            yield "expected a name that no building has"

    _unit_vector = field_validator("normal")(unit_vector)


class ContactPoint(Section):
    """One point of a building: on a floor, or inside the storey below a floor.

    Args:
        building: Name of the building.
        floor: Number of the floor, or None.
        storey: Number of the floor above the storey, when ``floor`` is None.
        relative_height: Height from floor to floor, 0 to 1, with ``storey``.
        offset: Vector (x, y, z) from the stick's axis to the point [m].
    """

    building: str
    floor: int | None
    storey: int | None
    relative_height: float | None
    offset: Vector

    @property
    def level(self) -> int:
        """Number of the floor, or of the one above the storey."""
        return int(self.floor if self.floor is not None else self.storey or 0)

    @property
    def label(self) -> str:
        """Name of the point in results: ``B1.floor_8`` or ``B1.storey_8_at_0.5``."""
        if self.floor is not None:
            return f"{self.building}.floor_{self.floor}"
        return f"{self.building}.storey_{self.storey}_at_{self.relative_height:.4g}"


class Contact(Section):
    """One pair of points that may touch.

    Args:
        name: Name in results, unique: ``B1.floor_8-B2.floor_8``.
        a: The point on the first building.
        b: The point on the second building; None for a rigid wall.
        wall: Name of the rigid wall, or None.
        normal: Unit vector from a to b or the wall.
        gap: Distance along the normal at rest [m].
        law: Name of the contact law.
        bearing_area: Area the force is spread over [m2], or None.
        table: Index of the table of [[contacts]] that it comes from; `SEARCHED` for a pair of
            [contact_search].
        line: Name of the first point of its line contact; "" for a contact at one point.
        share: Part of the stiffness of the law that it has.
        along: Position on its line, from the middle, to the left of the normal [m].
        length: Length of its line [m], or None.
        depth: Depth of the slab edge of its line [m], or None.
    """

    name: str
    a: ContactPoint
    b: ContactPoint | None
    wall: str | None = None
    normal: Vector
    gap: float
    law: str
    bearing_area: float | None
    table: int = 0
    line: str = ""
    share: float = 1.0
    along: float = 0.0
    length: float | None = None
    depth: float | None = None

    @property
    def pair(self) -> str:
        """Name of its pair in results: that of its line, or its own."""
        return self.line or self.name

    @property
    def place(self) -> str:
        """Section or table of the case file that it comes from."""
        return "contact_search" if self.table == SEARCHED else f"contacts[{self.table}]"

    @property
    def tangent(self) -> Vector:
        """Horizontal unit vector along its line, to the left of the normal."""
        x, y, _ = self.normal
        size = math.hypot(x, y) or 1.0
        return -y / size, x / size, 0.0

    @property
    def ends(self) -> tuple[tuple[ContactPoint, float], ...]:
        """Its points on buildings, each with the sign of the normal out of its building."""
        return ((self.a, 1.0),) if self.b is None else ((self.a, 1.0), (self.b, -1.0))

    @property
    def buildings(self) -> tuple[str, ...]:
        """Names of its buildings."""
        return tuple(point.building for point, _ in self.ends)

    @property
    def words(self) -> str:
        """Its sides: two buildings, or one and the wall."""
        names = self.buildings
        return " and ".join(names if self.wall is None else (*names, f"the wall {self.wall}"))


def expand(entries: tuple[ContactEntry, ...], table: int | None = None) -> tuple[Contact, ...]:
    """Make a contact of each pair of points, with unique names.

    Points on the same two floors, at two corners for instance, get ``#2``, ``#3`` behind the name.

    Args:
        entries: Tables of [[contacts]].
        table: Index of the table of all of them; by default they are counted.
    """
    contacts: list[Contact] = []
    uses: dict[str, int] = {}
    for index, entry in enumerate(entries):
        if not all(end is None or end.in_building for end in (entry.a, entry.b)):
            continue
        kept = {"wall", "normal", "gap", "law", "bearing_area", "length", "depth"}
        shared: dict[str, Any] = entry.model_dump(include=kept)
        others = [None] * entry.a.count if entry.b is None else _points(entry.b)
        for a, b in zip(_points(entry.a), others, strict=True):
            name, line = f"{a.label}-{entry.wall if b is None else b.label}", ""
            middle = Contact(name=name, a=a, b=b, table=index if table is None else table, **shared)
            for point in _of_line(middle, entry):
                uses[name] = uses.get(name, 0) + 1
                unique = f"{name}#{uses[name]}" if uses[name] > 1 else name
                line = line or unique
                of = {"name": unique, "line": line if entry.length is not None else ""}
                contacts.append(point.model_copy(update=of))
    return tuple(contacts)


def _of_line(middle: Contact, entry: ContactEntry) -> Iterator[Contact]:
    """Yield the points of a line contact from its middle; this itself without a length.

    The Gauss points s_i with weights w_i have the stiffness and, from two points on, the rotational
    stiffness of a uniform line: Σ w_i = 1 and Σ w_i s_i² = L²/12. Along façades that are not
    parallel both points move off the middle along the normal, each by half of the growth of the
    gap.
    """
    if entry.length is None:
        yield middle
        return
    area = entry.bearing_area
    if area is None and entry.depth is not None:
        area = entry.length * entry.depth
    places, weights = roots_legendre(entry.points or 2)
    for place, weight in zip(places.tolist(), weights.tolist(), strict=True):
        along, share = 0.5 * entry.length * place, 0.5 * weight
        opened = 0.5 * entry.gap_slope * along
        ends: dict[str, Any] = {}
        for key, point, sign in (("a", middle.a, -1.0), ("b", middle.b, 1.0)):
            if point is not None:
                by = zip(point.offset, middle.tangent, middle.normal, strict=True)
                offset = tuple(x + along * t + sign * opened * n for x, t, n in by)
                ends[key] = point.model_copy(update={"offset": offset})
        yield middle.model_copy(
            update={
                **ends,
                "share": share,
                "along": along,
                "gap": max(entry.gap + entry.gap_slope * along, 0.0),
                "bearing_area": None if area is None else share * area,
            }
        )


def _points(end: ContactEnd) -> Iterator[ContactPoint]:
    place = end.model_dump(include={"building", "offset"})
    for number in end.floor or ():
        yield ContactPoint(floor=number, storey=None, relative_height=None, **place)
    storeys, heights = end.storey or (), end.relative_height or ()
    for number, height in zip(storeys, heights * len(storeys), strict=False):
        yield ContactPoint(floor=None, storey=number, relative_height=height, **place)


class ContactSearch(Section):
    """Contact pairs of neighbouring buildings from their plans, levels and depths.

    Floors whose depths overlap are a pair; any other floor is one with the storey of its neighbour
    at its level. Each pair is a line over the common length of both façades. `impactfem contacts
    CASE` prints the pairs. Floors in a pair of [[contacts]] with the same neighbour are left out.
    """

    law: LawName
    """Name of the contact law of floors against floors."""
    storey_law: LawName | None = None
    """Name of the contact law of floors against storeys; default law."""
    buildings: tuple[BuildingName, ...] | None = Field(default=None, min_length=2)
    """Names of the buildings, two or more; default all."""
    largest_gap: Depth | None = None
    """Largest gap of a pair; default the sum of the displacements of both points at a drift of
    2.5 %."""
    points: Points = 2
    """Number of points of each line in sticks."""

    _each_once = once("buildings", "building")

"""Lines along which buildings touch in 3D: the points of contact, and how each acts on both sides.

Where a building pounds by its 3D model, a pair of the case is no point but the whole length over
which both sides face each other, or a side faces a rigid wall. With the hat functions N_i of points
along it, N_i highest at s_i, and w_i = ∫ N_i ds, the gap of point i is that at s_i plus a weighted
mean of the motion, and its force F_i is a line load on both sides,

    δ_i = g(s_i) + ∫ N_i n · (u_b - u_a) ds / w_i,    q_i = F_i N_i / w_i,

integrated on each mesh by its own shape functions: the meshes need not match, and resultant and
moment of what acts on a are those of what acts on b. A floor of a stick is rigid: for it the mean
is the motion at the middle of the hat. Inside a storey the force acts on walls and columns over a
patch, of a line contact over its part of a strip as deep as the slab; where there are none, nothing
touches. A column that stands alone is touched where it stands, the floor at this point of its edge.

The gap g is that of the pair at its point, straight between the points of several pairs, and grows
with the distance from it where the sides are not parallel, less what an edge that is not quite
straight stands out of its side. It is not averaged: the mean of g along
the last hat is the gap a third of the hat inside the end, and a corner would touch too late by
that distance times the angle between the sides. The motion is averaged, and the force of the last
hat acts at its middle, a third inside.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from impactfem.building.facade import columns_along, facades
from impactfem.building.floor import contact_edge
from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case, Contact, ContactPoint
from impactfem.case.contacts import Vector
from impactfem.case.facade import Facade
from impactfem.case.levels import plan_of
from impactfem.case.plan import extent
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.sides import PairEnd, Sides, push
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError
from impactfem.system.log import LOGGER

Struck = tuple[Facade, float]
OPPOSITE = 0.01
"""Largest distance along the edges between the two points of a pair [m]."""
SHORTEST = 0.5
"""Part of the distance of points up to which one is too near to the end of a line."""
SHORT = 1e-6
"""Length up to which sides do not face each other [m]."""
CLOSED = 1e-9
"""Up to which a negative gap is rounding [m]."""


@dataclass(frozen=True, eq=False)
class LineEnd:
    """One side of a line."""

    point: ContactPoint  #: the point of its first pair
    offset: Array  #: from the stick's axis to each point of contact, shape (m, 3) [m]
    #: Begin, top and end of the hat of each point on the side of a 3D model, shape (m, 3) [m]; nan
    #: for a stick.
    hats: Array
    #: Patterns of the force of each point on the 3D model for 1 N; none for a stick.
    forces: tuple[EdgeForce, ...]


@dataclass(frozen=True, eq=False)
class ContactLine:
    """A line along which two buildings touch."""

    name: str  #: name of its first pair
    normal: Array  #: unit vector n from a to b, shape (3,)
    a: LineEnd  #: the side of the first building
    b: LineEnd | None  #: the side of the second building; None for a rigid wall
    position: Array  #: of the points along it, from its first pair, ascending, shape (m,) [m]
    weight: Array  #: w_i, shape (m,) [m]
    gap: Array  #: g(s_i), δ_i at rest, shape (m,) [m]
    pair_names: tuple[str, ...]  #: of its pairs
    columns: NDArray[np.bool_]  #: points where a column stands alone, shape (m,)

    def __len__(self) -> int:
        return len(self.position)

    def forces_on(self, building: str) -> tuple[EdgeForce, ...]:
        """Return the patterns of its points on the 3D model of a building, if it is touched."""
        return tuple(
            force
            for end in (self.a, self.b)
            if end is not None and end.point.building == building
            for force in end.forces
        )

    def middle(self, end: LineEnd) -> tuple[float, float, float]:
        """The middle of the line on one side, Σ w r / Σ w, from the building's axis [m]."""
        x, y, z = (self.weight @ end.offset / self.weight.sum()).tolist()
        return x, y, z

    def joined(self, every: int) -> tuple[Array, Array, Array]:
        """A line with every n-th point: shares of the points in its own, (m, fewer), w, and g(s).

        A hat of the latter is the sum of the hats that it covers: N_I = Σ_i N_I(s_i) N_i. Columns
        are kept.
        """
        if every == 1:
            return np.eye(len(self)), self.weight, self.gap
        walls, columns = np.flatnonzero(~self.columns), np.flatnonzero(self.columns)
        s = self.position[walls]
        at = np.append(np.arange(0, len(s) - 1, every), len(s) - 1) if len(s) else walls
        kept = s[at]
        hats = np.zeros((len(self), len(kept) + len(columns)))
        for k, one in enumerate(np.eye(len(kept))):
            hats[walls, k] = np.interp(s, kept, one)
        hats[columns, len(kept) + np.arange(len(columns))] = 1.0
        w = hats.T @ self.weight
        gap = self.gap[np.append(walls[at], columns)]
        return np.asarray(self.weight[:, None] * hats / w), np.asarray(w), gap

    def at_ends(self, share: Array) -> Array:
        """Motion of both ends, extrapolated from that of the last two joined points, (2, fewer)."""
        middle = share.T @ ((self.a.offset - self.a.point.offset) @ _along(self.normal))
        rows = np.zeros((2, len(middle)))
        for row, s, one, other in zip(rows, self.position[[0, -1]], (0, -1), (1, -2), strict=True):
            row[other] = (s - middle[one]) / (middle[other] - middle[one])
            row[one] = 1.0 - row[other]
        return rows


def contact_lines(case: Case, meshes: Mapping[str, BuildingMesh]) -> tuple[ContactLine, ...]:
    """Return the lines of a case along which 3D models touch, with their meshes by building.

    Pairs of the same sides of floors or storeys with the same normal are one line, and so are the
    points of a line contact, over its length.

    Raises:
        InputError: With every fault: sides that do not face each other, points that are not on a
            side or do not face each other, several laws along one line, a gap that is negative
            somewhere, walls that take no force.
    """
    faults, modelled = list[Fault](), case.modelled
    sides = {name: Sides(modelled[name], mesh) for name, mesh in meshes.items()}
    groups: dict[tuple[object, ...], tuple[list[Contact], list[_End]]] = {}
    for contact in case.contacts:
        if not case.touches_in_3d(contact):
            continue
        n = np.array(contact.normal)
        found = [
            _end(case, contact, point, sign * n, _along(n), sides) for point, sign in contact.ends
        ]
        ends = [end for end in found if not isinstance(end, Fault)]
        wrong = [end for end in found if isinstance(end, Fault)]
        table = contact.place
        if expected := _apart(case, contact, _along(n)):
            wrong.append(Fault(case.path, table, contact.name, expected))
        if wrong:
            faults += wrong
            continue
        normal = tuple(np.round(n, 9).tolist())
        places = (ends[0].place, (contact.wall,) if contact.b is None else ends[1].place)
        key = *places, normal, contact.line
        if (*places[::-1], tuple(-x + 0.0 for x in normal), contact.line) in groups:
            expected = "expected the same building as a in all pairs along the same edges"
            faults.append(Fault(case.path, table, contact.name, expected))
            continue
        pairs, _ = groups.setdefault(key, ([], ends))
        pairs.append(contact)
        if contact.law != pairs[0].law:
            expected = f"expected '{pairs[0].law}', the law of {pairs[0].name} along the same edges"
            faults.append(Fault(case.path, f"{table}.law", contact.law, expected))
    lines = []
    for pairs, ends in groups.values():
        line = _line(case, pairs, ends)
        if isinstance(line, str):
            faults.append(Fault(case.path, pairs[0].place, pairs[0].name, line))
        else:
            lines.append(line)
    if faults:
        raise InputError(faults)
    return tuple(lines)


def warn_of_narrow(lines: Sequence[ContactLine], case: Case) -> None:
    """Log where a gap along a line is smaller than those of its pairs."""
    given = {contact.name: contact.gap for contact in case.contacts}
    for line in lines:
        k, least = int(line.gap.argmin()), min(given[name] for name in line.pair_names)
        if line.gap[k] < least - CLOSED:
            LOGGER.warning(
                "warning: contacts: %s: %.4g m along the edges from there the gap is %.4g mm, by "
                "straight lines; that of its pairs is %.4g mm or more (pairs at both ends of the "
                "edges say it where it is)",
                line.name,
                line.position[k],
                1e3 * line.gap[k],
                1e3 * least,
            )


def _along(n: Array) -> Array:
    """Unit vector at right angles to a normal in plan."""
    return np.array([-n[1], n[0], 0.0])


def _apart(case: Case, contact: Contact, t: Array) -> str:
    """Return the expectation that the points of a pair do not meet; empty if they do."""
    places = []
    for point, _ in contact.ends:
        axis = case.building(point.building).axis
        places.append(np.array(point.offset) + np.array([*axis, 0.0]))
    apart = float(t @ (places[-1] - places[0]))
    if abs(apart) <= OPPOSITE:
        return ""
    return (
        f"expected points that face each other along the normal: by axis and offset they are "
        f"{abs(apart):.4g} m apart along the edges"
    )


@dataclass(frozen=True, eq=False)
class _End:
    """One side of a line before its points are known."""

    point: ContactPoint
    outward: Vector  #: unit vector towards the other side
    sides: Sides | None  #: of its 3D model; None for a stick
    met: Struck | None  #: the side that it is on, and where the first pair is along it
    sense: float  #: ds along the side for 1 m along the line
    span: tuple[float, float]  #: from where to where it reaches along the line [m]
    depth: float | None = None  #: of the slab of a line contact [m]

    @property
    def place(self) -> tuple[object, ...]:
        """The side that it is on, of a floor or a storey."""
        p, side = self.point, "" if self.met is None else self.met[0].side
        return p.building, p.floor, p.storey, p.relative_height, side

    @property
    def vertices(self) -> Array | None:
        """Possible places of constraints along the line, as of `contact_edge`; None without."""
        if self.sides is None or self.met is None or self.point.floor is None:
            return None
        facade, first = self.met
        spacing = self.sides.building.case.pounding.contact_spacing
        edge = contact_edge(self.sides.mesh, self.point.floor, spacing, facade.side)
        return np.sort((edge.position - first) / self.sense)

    @cached_property
    def shape(self) -> tuple[Array, Array]:
        """Places of the nodes of an edge along the line, and their distance from its side.

        Out of its straight side [m]: sides of meshes may be a little off one line; sticks and
        storeys are taken as straight, without nodes.
        """
        if self.sides is None or self.met is None or self.point.floor is None:
            return np.zeros(0), np.zeros(0)
        facade, first = self.met
        mesh, side, n = self.sides.mesh, facade.side, np.array(facade.outward)
        nodes = np.unique(facades(mesh, self.point.floor, side)[side][1])
        x = mesh.nodes[nodes] - np.array([*facade.start, 0.0])
        out, at = x @ n / (n @ self.outward), (x @ facade.along - first) / self.sense
        order = np.argsort(at)
        return at[order], np.where(np.abs(out) > CLOSED, out, 0.0)[order]

    def bulge(self, s: Array) -> Array:
        """Return the distance of an edge from its straight side along the normal at places [m]."""
        at, out = self.shape
        return np.asarray(np.interp(s, at, out)) if len(at) else np.zeros(len(s))

    @property
    def columns(self) -> Array:
        """Places of columns without walls along the line, at a point inside a storey."""
        if self.sides is None or self.met is None or self.point.floor is not None:
            return np.zeros(0)
        facade, first = self.met
        height = self.sides.elevation(self.end)
        force = push(self.end, facade)
        at = columns_along(self.sides.mesh, self.point.level, facade, height, force)
        return np.sort((at - first) / self.sense)

    def hats(self, begin: Array, s: Array, finish: Array) -> Array:
        """Return begin, top and end of the hat of each point on the side, shape (m, 3) [m].

        Inside a storey, where its middle is; of a line contact with its weight to both sides.
        """
        if self.met is None:
            return np.full((len(s), 3), np.nan)
        places = np.column_stack([begin, s, finish])
        if self.point.floor is None:
            part = 0.0 if self.depth is None else 0.25 * (finish - begin)[:, None]
            places = places.mean(axis=1)[:, None] + part * np.array([-1.0, 0.0, 1.0])
        return np.sort(self.met[1] + self.sense * places, axis=1)

    def forces(self, hats: Array, columns: NDArray[np.bool_]) -> list[EdgeForce | str]:
        """The force of each point on the 3D model, or why nothing takes it; none for a stick.

        Points of columns act on these alone, and no other point does.
        """
        if self.sides is None or self.met is None:
            return []
        mesh, found = self.sides.mesh, list[EdgeForce | str]()
        walls = mesh.triangles[mesh.triangles_of("storey", self.point.level)]
        for hat, of_column in zip(hats.tolist(), columns, strict=True):
            one = self.sides.point_force(replace(self.end, hat=tuple(hat)), self.met[0])
            if isinstance(one, EdgeForce) and one.height is not None:
                on_wall = bool(np.isin(one.load(mesh).nodes, walls).any())
                if on_wall == of_column:
                    one = "a column there is behind a wall, or touched where it stands"
            found.append(one)
        return found

    @property
    def end(self) -> PairEnd:
        """The end of its first pair."""
        return replace(PairEnd.of(self.point, np.array(self.outward)), depth=self.depth)


def _line(case: Case, pairs: Sequence[Contact], ends: Sequence[_End]) -> ContactLine | str:
    """A line; what is expected where it cannot be one."""
    one = pairs[0]
    n = np.array(one.normal)
    t = _along(n)
    low, high = max(end.span[0] for end in ends), min(end.span[1] for end in ends)
    if one.length is not None:
        low = max(low, -one.along - 0.5 * one.length)
        high = min(high, -one.along + 0.5 * one.length)
    if not high - low > SHORT:
        spans = " and ".join(
            f"{end.point.label} from {end.span[0]:.4g} to {end.span[1]:.4g} m" for end in ends
        )
        return f"expected sides that face each other; along them, from the pair, are {spans}"
    vertices = [known for end in ends if (known := end.vertices) is not None]
    if vertices:
        s = min((_within(known, low, high) for known in vertices), key=len)
    else:
        # The floor of a stick against walls: as many patches as have room.
        spread = next(end.sides.spread for end in ends if end.sides is not None)
        spacing = case.pounding.contact_spacing or spread.patch_width
        s = np.linspace(low, high, 1 + max(1, math.ceil((high - low) / spacing)))
    # Where an edge that is not quite straight is nearest to the other side there is a point, too.
    bent = np.concatenate([at[out != 0.0] for at, out in (end.shape for end in ends)])
    places = np.append(s, bent[(bent > low + SHORT) & (bent < high - SHORT)])
    gap = _gap(pairs, ends, n, t, places)
    if gap is not None and gap.min() < gap[: len(s)].min() - CLOSED:
        nearest = places[gap.argmin()]
        far = np.abs(s - nearest) > SHORTEST * np.diff(s).min()
        s = np.sort(np.append(s[far | (s == low) | (s == high)], nearest))
    begin, finish = np.append(s[:1], s[:-1]), np.append(s[1:], s[-1:])
    alone = np.unique(np.concatenate([end.columns for end in ends]))
    alone = np.clip(alone[(alone > low - SHORT) & (alone < high + SHORT)], low, high)
    order = np.argsort(np.append(s, alone), kind="stable")
    begin, s, finish = (np.append(one, alone)[order] for one in (begin, s, finish))
    columns = order >= len(order) - len(alone)
    # The mean of what is straight along a hat is its value at the middle of the hat.
    middle, weight = (begin + s + finish) / 3.0, 0.5 * (finish - begin)
    if alone.size:
        weight[columns] = next(end.sides for end in ends if end.sides).spread.patch_width
    hats = [end.hats(begin, s, finish) for end in ends]
    acting = [end.forces(one, columns) for end, one in zip(ends, hats, strict=True)]
    lacking = [one for forces in acting for one in forces if isinstance(one, str)]
    taken = np.array(
        [all(isinstance(one[k], EdgeForce) for one in acting if one) for k in range(len(s))]
    )
    if not taken.any():
        return (
            "expected walls or columns that take the force: "
            f"{lacking[len(lacking) // 2]}; see offset of the pair and [transient] patch_width"
        )
    gap = _gap(pairs, ends, n, t, s)
    if gap is None:
        return "expected one gap at one place along the edges"
    if gap.min() < -CLOSED:
        return (
            f"expected sides that do not overlap: {s[gap.argmin()]:.4g} m along them from the "
            f"pair their gap is {gap.min():.4g} m"
        )
    made = []
    for end, hat, forces in zip(ends, hats, acting, strict=True):
        offset = (np.array(end.point.offset) + middle[:, None] * t)[taken]
        good = [force for force, acts in zip(forces, taken, strict=False) if acts]
        kept = tuple(force for force in good if isinstance(force, EdgeForce))
        made.append(LineEnd(end.point, offset, hat[taken], kept))
    return ContactLine(
        name=one.name,
        normal=n,
        a=made[0],
        b=made[1] if len(made) > 1 else None,
        position=s[taken],
        weight=weight[taken],
        gap=np.maximum(gap, 0.0)[taken],
        pair_names=tuple(pair.name for pair in pairs),
        columns=columns[taken],
    )


def _end(
    case: Case,
    contact: Contact,
    point: ContactPoint,
    outward: Array,
    t: Array,
    sides: Mapping[str, Sides],
) -> _End | Fault:
    """A side of a line along t, the unit vector at right angles to the normal in plan."""
    x, y, z = (float(component) + 0.0 for component in outward)
    building = case.building(point.building)
    if point.building not in case.pounding_in_3d:
        # Its floor along t; infinite where its plan is not known.
        index = [floor.floor for floor in building.floors].index(point.level)
        plan = plan_of(building, index)
        low, high = (-math.inf, math.inf) if plan is None else extent(plan, t.tolist())
        middle = -float(t @ point.offset)
        span = middle + low, middle + high
        return _End(point, (x, y, z), None, None, 1.0, span, contact.depth)
    own = sides[point.building]
    end = _End(point, (x, y, z), own, None, 1.0, (0.0, 0.0), contact.depth)
    met = own.met(case.path, contact.name, end.end)
    if isinstance(met, Fault):
        return met
    facade, first = met
    # A metre along the line is this far along the side, which need not be parallel to it.
    sense = 1.0 / float(t @ facade.along)
    low, high = sorted(((0.0 - first) / sense, (facade.length - first) / sense))
    return replace(end, met=met, sense=sense, span=(low, high))


def _within(vertices: Array, low: float, high: float) -> Array:
    """Both ends of a line, and the vertices of a side between that are not too near to these."""
    nearest = SHORTEST * float(np.diff(vertices).min())
    inside = vertices[(vertices > low + nearest) & (vertices < high - nearest)]
    return np.concatenate([[low], inside, [high]])


def _gap(
    pairs: Sequence[Contact], ends: Sequence[_End], n: Array, t: Array, s: Array
) -> Array | None:
    """The gap along a line, straight between its pairs and along sides that are not parallel.

    Less what edges stand out there. A wall is at right angles to the normal. None where two pairs
    at one place have different gaps.
    """
    at = np.array([t @ (np.array(pair.a.offset) - pairs[0].a.offset) for pair in pairs])
    order = np.argsort(at)
    of_pairs, out = (sum(end.bulge(place) for end in ends) for place in (at, s))
    # Of the straight sides.
    known = (np.array([pair.gap for pair in pairs]) + of_pairs)[order]
    if len(pairs) > 1:
        place, first = np.unique(np.round(at[order], 6), return_index=True)
        if any(np.ptp(known[np.abs(at[order] - one) < SHORT]) > CLOSED for one in place):
            return None
        known = known[first]
        if len(place) == 1:
            return np.asarray(known[0] - out)
        found = np.interp(s, place, known)
        # Beyond the outermost pairs it goes on as between them.
        for end, inner, beyond in ((0, 1, s < place[0]), (-1, -2, s > place[-1])):
            slope = (known[end] - known[inner]) / (place[end] - place[inner])
            found = np.where(beyond, known[end] + slope * (s - place[end]), found)
        return np.asarray(found - out)
    away = [0.0 if end.met is None else float(n @ end.met[0].along) * end.sense for end in ends]
    return np.asarray(known[0] + (sum(away[1:]) - away[0]) * s - out)

"""Forces on the sides of a 3D building: the patterns that the force of a pair is made of.

Every spread keeps the resultant F of each pair and its moment F e about the vertical through the
middle of the side, e the distance of the pair from it along the side of the length L.

- `uniform`: F/L on the whole side and the linear part 12 F e (s − s0) / L³. All pairs of a side
  share these two; a central pair has the first alone.
- `patch`: on the given width about the pair; where the side ends before, the patch is cut and the
  load on it linear, with its resultant at the pair.
- `calibrated`: F p(s), p the impulse along the edge of the first impact on the wall over its
  resultant, and the linear part of what its middle is off the pair.

A line contact acts on its common length alone, where the side is longer. A force inside a storey
acts on its walls or columns over a patch (`patch_load`), of a line contact over a strip as deep as
the slab and as long as the line (`strip_load`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import eval_legendre

from impactfem.building.facade import Strip, facades, patch_load, strip_load
from impactfem.building.floor import Line, NodalLoad, edge_load, linear
from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.case.contacts import Vector
from impactfem.case.facade import Facade
from impactfem.case.transient import Transient
from impactfem.system.arrays import Array

CENTRAL = 1e-9
"""Part of the length of a side up to which a distance along it is rounding."""
FINE = 12
"""Decimals of places of line contacts, in metres: Gauss points are irrational."""
DECIMALS = 9
"""Of places, in metres, that patterns are made of: those of one place are one pattern."""


@dataclass(frozen=True)
class EdgeForce:
    """A pattern of forces on a side of a floor, or on the storey below it."""

    name: str  #: Its name, "floor 8"; the name of a pattern says all about it.
    floor: int  #: Number of the floor, or of the one above the storey.
    #: Horizontal unit vector along which a positive amplitude acts on the building.
    direction: Vector
    side: str = ""  #: Which side, as of `facades`; "" for that of the group edge_K.
    resultant: float = 1.0  #: Its resultant [N].
    #: Moment of the resultant about the middle of the side, positive forces times s [N m].
    moment: float = 0.0
    line: Line | None = None  #: The line load along the side; None for a uniform one.
    #: Elevation of a point inside the storey [m]; None for one of the floor.
    height: float | None = None
    #: Depth of the slab that strikes a strip of the storey as long as the line [m]; None for a
    #: square patch.
    depth: float | None = None

    @property
    def place(self) -> str:
        """What is struck: "floor 8", or "floor 8 y-" for another side than that of the group."""
        what = "floor" if self.height is None else "storey"
        return f"{what} {self.floor} {self.side}".rstrip()

    def load(self, mesh: BuildingMesh) -> NodalLoad:
        """Its nodal forces.

        Raises:
            KeyError: The mesh has no such side, or nothing there that takes the force.
        """
        if self.height is None:
            return edge_load(mesh, self.floor, self.side, self.line)
        found = _on_storey(mesh, self)
        if isinstance(found, str):
            raise KeyError(f"{self.name}: {found}")
        return found

    def vector(self, model: BuildingModel, mesh: BuildingMesh) -> Array:
        """The load at this rank's rows, shape (n_local,); KeyError as `load`."""
        return self.load(mesh).vector(model, self.direction)


Shares = tuple[tuple[EdgeForce, float], ...]
"""The patterns of a force, and the amplitude of each for 1 N."""


def _on_storey(mesh: BuildingMesh, force: EdgeForce) -> NodalLoad | str:
    facade, _ = facades(mesh, force.floor, force.side or None)[force.side]
    (start, _), (end, _) = force.line or ((0.0, 0.0), (facade.length, 0.0))
    place = 0.5 * facade.length + force.moment, force.height or 0.0
    if force.depth is not None:
        strip = Strip(start, end, place[1], force.depth)
        found = strip_load(mesh, force.floor, facade, strip, place[0], force.direction)
        return found if isinstance(found, str) else NodalLoad(*found)
    found = patch_load(mesh, force.floor, facade, place, end - start, force.direction)
    return found if isinstance(found, str) else NodalLoad(*found)


def missing(mesh: BuildingMesh, shares: Shares) -> str | None:
    """Why a storey cannot take a force, in words; None where it can, or a floor takes it."""
    for pattern, _ in shares:
        if pattern.height is not None and isinstance(found := _on_storey(mesh, pattern), str):
            return found
    return None


def even(floor: int, facade: Facade, direction: Vector) -> EdgeForce:
    """The uniform load of 1 N on a side of a floor."""
    name = f"floor {floor} {facade.side}".rstrip()
    return EdgeForce(_named(name, facade, direction), floor, direction, facade.side)


def _named(name: str, facade: Facade, direction: Vector) -> str:
    """The name with the direction of a force that is not at right angles to its side."""
    if direction == inward(facade):
        return name
    return f"{name} along ({direction[0]:.6g}, {direction[1]:.6g})"


def inward(facade: Facade) -> Vector:
    """Unit vector at right angles to a side, into the building."""
    x, y, z = (-component + 0.0 for component in facade.outward)
    return x, y, z


def floor_shares(
    floor: int,
    facade: Facade,
    direction: Vector,
    position: float,
    transient: Transient,
    contacts: tuple[Array, Array, Array] | None = None,
) -> Shares:
    """What a force on a side of a floor is made of, spread as [transient] says.

    It acts along a horizontal unit vector, whose line meets the side at a position [m]. Contacts
    are positions, lengths w_i and impulses of the points of contact along the edge, of the impact
    on the wall; the spread `calibrated` alone needs them.
    """
    one, L = even(floor, facade, direction), facade.length
    e = position - 0.5 * L
    if transient.spread == "patch":
        at, half = round(position, DECIMALS), 0.5 * transient.patch_width
        line = linear(max(at - half, 0.0), min(at + half, L), at)
        name = f"{one.name} at {at:.12g} m over {transient.patch_width:.6g} m"
        return ((_with(one, name, 1.0, at - 0.5 * L, line), 1.0),)
    if transient.spread == "uniform" or contacts is None:
        if abs(e) <= CENTRAL * L:
            return ((one, 1.0),)
        # The difference of two lines with resultants 1 m apart: 1 N m.
        turning = tuple((s, 6.0 * sign / L**2) for s, sign in ((0.0, -1.0), (L, 1.0)))
        return (one, 1.0), (_with(one, f"{one.name} turning", 0.0, 1.0, turning), e)
    s, w, impulse = contacts
    hats = [
        tuple(
            (float(s[j]), float(j == k) / float(w[k])) for j in (k - 1, k, k + 1) if 0 <= j < len(s)
        )
        for k in range(len(s))
    ]
    # Where the resultant of each hat is, which begins and ends at its neighbours.
    middle = (np.append(s[:1], s[:-1]) + s + np.append(s[1:], s[-1:])) / 3.0
    share = impulse / impulse.sum()
    # Of q = 12 m (s − L/2) / L³ the hat of s_i is q(s_i) w_i.
    share = share + 12.0 * (position - share @ middle) * (s - 0.5 * L) / L**3 * w
    return tuple(
        (_with(one, f"{one.name} contact {at:.9g} m", 1.0, float(c) - 0.5 * L, hat), float(factor))
        for at, c, hat, factor in zip(s, middle, hats, share, strict=True)
    )


def line_shares(
    floor: int, facade: Facade, direction: Vector, position: float, span: tuple[float, float]
) -> Shares:
    """What a force of a line contact on a part of a side is made of, with its resultant [m]."""
    start, end = (round(s, FINE) for s in span)
    one, at = even(floor, facade, direction), round(position, FINE)
    name = f"{one.name} at {at:.15g} m from {start:.15g} to {end:.15g} m"
    line = linear(start, end, at)
    return ((_with(one, name, 1.0, at - 0.5 * facade.length, line), 1.0),)


def strip_shares(
    storey: int, facade: Facade, direction: Vector, position: float, strip: Strip
) -> Shares:
    """What a force of a line contact inside a storey is made of, with its resultant [m]."""
    start, end, height = (round(x, FINE) for x in (strip.begin, strip.end, strip.z))
    at, moment = round(position, FINE), round(position, FINE) - 0.5 * facade.length
    name = (
        f"{f'storey {storey} {facade.side}'.rstrip()} at {at:.15g} m, z = {height:.15g} m "
        f"from {start:.15g} to {end:.15g} m, {strip.depth:.6g} m deep"
    )
    name = _named(name, facade, direction)
    line = ((start, 0.0), (end, 0.0))
    return (
        (
            EdgeForce(name, storey, direction, facade.side, 1.0, moment, line, height, strip.depth),
            1.0,
        ),
    )


def hat_force(
    floor: int, facade: Facade, direction: Vector, before: float, at: float, behind: float
) -> EdgeForce:
    """The line load of 1 N of a point of contact at a position on a side [m].

    It is a hat that falls to zero at the points before and behind, half of one at an end; a force
    at the position where all are one, as where a column is struck.
    """
    one, width = even(floor, facade, direction), behind - before
    peak = 2.0 / width if width > 0.0 else 1.0
    rise = ((before, 0.0),) if before < at else ()
    fall = ((behind, 0.0),) if behind > at else ()
    name = f"{one.name} contact {at:.9g} m from {before:.9g} to {behind:.9g} m"
    moment = (before + at + behind) / 3.0 - 0.5 * facade.length
    return _with(one, name, 1.0, moment, (*rise, (at, peak), *fall))


def smooth(forces: Sequence[EdgeForce], degree: int) -> Array:
    """Amplitudes of forces along edges that vary smoothly from point to point, shape (n, k).

    Of the points that touch along a side, in one direction and at one height: Legendre polynomials
    of their places up to a degree, or as many as there are points.
    """
    lines: dict[tuple[object, ...], list[int]] = {}
    for k, one in enumerate(forces):
        lines.setdefault((one.place, one.direction, one.height), []).append(k)
    found = []
    for points in lines.values():
        s = np.array([forces[k].moment for k in points])
        x = (2.0 * s - s.min() - s.max()) / max(float(np.ptp(s)), CENTRAL)
        degrees = np.arange(1 + min(degree, len(points) - 1))
        found.append(np.zeros((len(forces), len(degrees))))
        found[-1][points] = eval_legendre(degrees, x[:, None])
    return np.hstack([np.zeros((len(forces), 0)), *found])


def _with(one: EdgeForce, name: str, resultant: float, moment: float, line: Line) -> EdgeForce:
    return EdgeForce(name, one.floor, one.direction, one.side, resultant, moment, line)


def storey_share(
    storey: int,
    facade: Facade,
    direction: Vector,
    position: float,
    height: float,
    transient: Transient,
) -> Shares:
    """What a force inside a storey is made of, with its elevation [m]; others as `floor_shares`."""
    half = 0.5 * transient.patch_width
    position, height = round(position, DECIMALS), round(height, DECIMALS)
    name = (
        f"{f'storey {storey} {facade.side}'.rstrip()} at {position:.12g} m, z = {height:.12g} m "
        f"over {transient.patch_width:.6g} m"
    )
    line = ((position - half, 0.0), (position + half, 0.0))
    moment = position - 0.5 * facade.length
    name = _named(name, facade, direction)
    return ((EdgeForce(name, storey, direction, facade.side, 1.0, moment, line, height), 1.0),)

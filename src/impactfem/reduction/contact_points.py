"""Points of contact of the lines of a case: their pairs, links, and ports on both sides.

A line has one link for each of its points, with the law of the pair for the part w_i / Σ w of its
area. A port is the motion of the points along the normal, by the coordinates of one building.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from impactfem.case import Case
from impactfem.coupling.body import Port
from impactfem.coupling.from_case import law_between
from impactfem.coupling.laws import Law
from impactfem.coupling.line_response import line_pairs
from impactfem.coupling.links import Link
from impactfem.coupling.pounding import End, Pair, System
from impactfem.reduction.contact_line import ContactLine, LineEnd
from impactfem.system.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a line, with every n-th of its points."""

    line: ContactLine
    end: LineEnd
    at: End  #: the end of its pair, at the middle of the line
    share: Array  #: shares of the points of the line in those that are left, shape (m, fewer)
    sign: float  #: -1 for the first building, +1 for the second one


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Points of contact of all lines, line by line, then those of two sticks."""

    pairs: tuple[Pair, ...]  #: one pair for each line, then the pairs of two sticks
    points: tuple[Pair, ...]  #: all points of contact
    pair_of: Index  #: of each of them the index of its pair
    links: tuple[Link, ...]  #: of the points of lines
    weight: Array  #: w_i of the points of lines, shape (len(links),) [m]
    ports: dict[str, dict[str, Port]]  #: by building and line
    outermost: Index  #: the first and last point of each line with ends
    #: Motion of the ends of lines by that of the points, shape (len(outermost), n_points).
    ends: Array

    @classmethod
    def of(
        cls,
        case: Case,
        system: System,
        lines: Sequence[ContactLine],
        port: Callable[[Side], Port],
        every: int,
    ) -> ContactPoints:
        """Join every n-th point of the lines of a case; `port` gives the port of a side."""
        in_3d = {contact.name for contact in case.contacts if case.touches_in_3d(contact)}
        others = tuple(pair for pair in system.pairs if pair.name not in in_3d)
        pairs_of_sticks, pair_of_sticks = line_pairs(others)
        joined = [_joined(case, system, line, every) for line in lines]
        points = [point for one in joined for point in one.points]
        pair_of = [k for k, one in enumerate(joined) for _ in one.points]
        ports: dict[str, dict[str, Port]] = {stick.name: {} for stick in system.sticks}
        for one in joined:
            for side in one.sides:
                ports[side.at.building][one.pair.name] = port(side)
        outermost, rows, first = list[int](), list[Array](), 0
        every_point = len(points) + len(others)
        for one in joined:
            last = first + len(one.points) - 1
            if one.has_ends:
                outermost += [first, last]
                row = np.zeros((2, every_point))
                row[:, first : last + 1] = one.sides[0].line.at_ends(one.sides[0].share)
                rows.append(row)
            first = last + 1
        return cls(
            pairs=(*(one.pair for one in joined), *pairs_of_sticks),
            points=(*points, *others),
            pair_of=np.array([*pair_of, *(len(lines) + pair_of_sticks)], dtype=np.int64),
            links=tuple(link for one in joined for link in one.links),
            weight=np.concatenate([np.zeros(0), *(one.weight for one in joined)]),
            ports=ports,
            outermost=np.array(outermost, dtype=np.int64),
            ends=np.vstack([np.zeros((0, every_point)), *rows]),
        )


@dataclass(frozen=True, eq=False)
class _Joined:
    """A line with every n-th of its points."""

    pair: Pair  #: for the whole line, at its middle
    points: tuple[Pair, ...]
    links: tuple[Link, ...]
    weight: Array
    sides: tuple[Side, ...]

    @property
    def has_ends(self) -> bool:
        """It has several points, and none in a storey."""
        inside = any(side.at.relative_height is not None for side in self.sides)
        return len(self.points) > 1 and not inside


def _joined(case: Case, system: System, line: ContactLine, every: int) -> _Joined:
    first = {pair.name: pair for pair in system.pairs}
    pair = first[line.name]
    share, w, gaps = line.joined(every)
    ends = [(line.a, pair.a)]
    if line.b is not None and pair.b is not None:
        ends.append((line.b, pair.b))
    # The middle of the line is the same wherever its pairs are: they give its place and its gaps.
    middles = [replace(at, offset=line.middle(end)) for end, at in ends]
    contact = next(contact for contact in case.contacts if contact.name == line.name)
    law = law_between(case, contact, {stick.name: stick for stick in system.sticks}, middles)
    # Several pairs of a line press together; points of a line contact have a share each.
    law = law.part(sum(one.share for one in case.contacts if one.name in line.pair_names))
    areas = [first[name].area for name in line.pair_names]
    b = middles[1] if len(middles) > 1 else None
    area = None if None in areas else sum(a for a in areas if a is not None)
    gap = float(line.gap.min())
    whole = replace(pair, a=middles[0], b=b, law=law, gap=gap, area=area, line="")
    points, links = list[Pair](), list[Link]()
    for k, shares in enumerate(share.T):
        # Equation (1) of `contact_line`: F_i acts at the weighted mean of the points.
        placed = [replace(at, offset=tuple((shares @ end.offset).tolist())) for end, at in ends]
        part: Law = law.part(float(w[k] / w.sum()))
        hats = None
        if every == 1:
            hats = np.full((2, 3), np.nan)
            hats[: len(ends)] = [end.hats[k] for end, _ in ends]
        point = Pair(
            name=f"{line.name} at {shares @ line.position:.4f} m",
            a=placed[0],
            b=placed[1] if len(ends) > 1 else None,
            normal=pair.normal,
            gap=float(gaps[k]),
            law=part,
            hats=hats,
            line=line.name,
        )
        points.append(point)
        links.append(
            Link(
                name=point.name,
                a=(pair.a.building, line.name),
                # The ground, which a rigid wall moves with, has no port.
                b=None if pair.b is None else (pair.b.building, line.name),
                direction=np.eye(len(w))[k],
                gap=point.gap,
                law=None if law.unilateral else part,
            )
        )
    sides = tuple(
        Side(line, end, at, share, sign) for (end, at), sign in zip(ends, (-1.0, 1.0), strict=False)
    )
    return _Joined(whole, tuple(points), tuple(links), w, sides)

"""How near floors come that face each other and are in no contact pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import ContactPoint
from impactfem.case.facing import Facing
from impactfem.coupling.pounding import Response, System
from impactfem.sticks.element import rigid_link

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Approach:
    """The nearest that two places of neighbouring buildings come in a run.

    Args:
        facing: The places, their normal and their distance at rest.
        distance: Smallest distance along the normal [m]; negative where they overlap.
        time: When [s].
    """

    facing: Facing
    distance: float
    time: float


def approaches(response: Response, facing: Sequence[Facing]) -> list[Approach]:
    """The closest approach of each, at either end of the length over which they face each other.

    Floors are rigid and turn about their axes, so that the distance
    d(s, t) = gap + n · (u_b − u_a) is straight in s along the edges: its least value over them is
    at an end. Inside a storey the beam gives the motion of the axis.

    Args:
        response: The run.
        facing: What faces each other, of buildings of the run.
    """
    if not facing:
        return []
    rows = np.array([_row(response.system, one, s) for one in facing for s in (-1.0, 1.0)])
    rest = np.repeat([one.gap for one in facing], 2)
    d = (rest + response.u @ rows.T).reshape(len(response.u), len(facing), 2).min(axis=2)
    step = d.argmin(axis=0)
    return [
        Approach(one, float(d[k, j]), float(response.time[k]))
        for j, (one, k) in enumerate(zip(facing, step, strict=True))
    ]


def _row(system: System, facing: Facing, s: float) -> Array:
    """Row that gives n · (u_b − u_a), at the end s = -1 or 1 of the edges; shape (n,)."""
    normal = np.array(facing.normal)
    along = facing.half * s * np.abs(normal[[1, 0, 2]])
    row = np.zeros(system.M.shape[0])
    for point, sign in ((facing.a, -1.0), (facing.b, 1.0)):
        stick = system.stick(point.building)
        start = system.offsets[stick.name]
        offset = np.array(point.offset) + along
        row[start : start + stick.n] += sign * normal @ _translation(system, point, offset)
    return row


def _translation(system: System, point: ContactPoint, offset: Array) -> Array:
    """Operator from a stick's displacements to the translation of a point, shape (3, n)."""
    stick = system.stick(point.building)
    if point.floor is not None:
        return stick.translation(stick.floor_master(point.floor), offset.tolist())
    inside = stick.storey_motion(int(point.storey or 0), float(point.relative_height or 0.0))
    return np.asarray(rigid_link(offset)[:3] @ inside)

"""The points of each floor whose spectra are enveloped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]

LEVEL = 0.05
"""How far from its mass centre's level a point of a floor may be [m]."""


@dataclass(frozen=True)
class FloorPoints:
    """The points of a floor.

    Args:
        floor: Its number.
        elevation: Of its mass centre [m].
        centre: Number of the probe at its mass centre.
        names: Names of the points, in the order of the probes.
        probes: Their numbers among all probes.
    """

    floor: int
    elevation: float
    centre: int
    names: tuple[str, ...]
    probes: tuple[int, ...]


def floor_points(
    names: Sequence[str], position: Array, centres: Mapping[int, int]
) -> tuple[tuple[FloorPoints, ...], tuple[str, ...]]:
    """Sort probes by floors: a probe belongs to the floor that it is level with.

    Args:
        names: Names of the probes, that of the mass centre of each floor among them.
        position: Their positions, shape (n, 3) [m].
        centres: Which of them is at the mass centre of a floor, by the floor's number.

    Returns:
        The floors from the lowest, and the names of the probes that are on none.

    Raises:
        ImpactfemError: There is no probe at a mass centre.
    """
    if not centres:
        raise ImpactfemError("no probe at the mass centre of a floor")
    heights = {floor: float(position[probe, 2]) for floor, probe in centres.items()}
    found = []
    for floor, elevation in sorted(heights.items(), key=lambda one: one[1]):
        level = np.flatnonzero(np.abs(position[:, 2] - elevation) <= LEVEL)
        found.append(
            FloorPoints(
                floor,
                elevation,
                centres[floor],
                tuple(names[i] for i in level),
                tuple(map(int, level)),
            )
        )
    used = {i for one in found for i in one.probes}
    return tuple(found), tuple(name for i, name in enumerate(names) if i not in used)


def enveloped(values: Array, floors: Sequence[FloorPoints], axis: int) -> Array:
    """Envelope over the points of each floor.

    Args:
        values: Spectra or peak accelerations, any shape with the probes along one axis.
        floors: The floors.
        axis: The axis of the probes; that of the floors afterwards.
    """
    envelopes = [np.take(values, one.probes, axis=axis).max(axis=axis) for one in floors]
    return np.asarray(np.stack(envelopes, axis=axis), dtype=np.float64)

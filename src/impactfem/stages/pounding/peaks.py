"""Largest responses of floors and buildings, and synthetic motions relative to their targets."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from impactfem.coupling.force_history import PairEnds
from impactfem.coupling.pounding import Response
from impactfem.motion.from_case import GroundMotion
from impactfem.stages.pounding.compute import StickStudy
from impactfem.stages.pounding.foundation import DIRECTIONS
from impactfem.sticks.stick import Stick
from impactfem.system.arrays import Array
from impactfem.system.quantity import quantity, results, si

SHORT, LONG = 0.2, 2.0
"""Periods in which a motion represents its target, in first periods of the buildings: EN 1998-1,
3.2.3.1.2(4)c."""


@results
class FloorPeaks:
    """Largest values of a floor over the run with contact."""

    #: Of all pairs on one side of the floor together; None for a floor without a pair.
    peak_force: float | None = si("N", "largest force on one side of the floor", shown="MN")
    penetration: float | None = si("m", "largest penetration at the floor", shown="mm")
    peak_acceleration: float = si("m/s2", "largest absolute acceleration of the mass centre")
    #: Between mass centres, without the rotation of the base.
    storey_drift: float = si("-", "largest drift, of the storey below over its height", shown="%")
    storey_drift_no_contact: float = si(
        "-", "largest drift without contact, of the storey below over its height", shown="%"
    )

    @property
    @quantity("kg", "largest force / largest acceleration")
    def force_over_acceleration(self) -> float | None:
        """Largest force over largest acceleration [kg]; None without a force."""
        return self.peak_force / self.peak_acceleration if self.peak_force else None

    @property
    @quantity("m/N", "largest penetration / largest force")
    def penetration_over_force(self) -> float | None:
        """Largest penetration over largest force [m/N]; None without a force."""
        if not self.peak_force or self.penetration is None:
            return None
        return self.penetration / self.peak_force


@results
class BuildingPeaks:
    """Largest values of a building; displacements of its top relative to the ground under it."""

    peak_displacement: float = si("m", "largest displacement of the top", shown="mm")
    peak_displacement_no_contact: float = si(
        "m", "largest displacement of the top, without contact", shown="mm"
    )
    #: About its mean: a permanent load holds the building away from its position at rest.
    swing_at_end: float = si("-", "displacement in the last period / largest displacement")
    #: None without wave passage.
    passage_delay: float | None = si("s", "arrival of the waves after the first building")
    passage_apart: float | None = si(
        "m", "largest displacement of the ground relative to the first building", shown="mm"
    )
    passage_left: float | None = si(
        "m", "relative ground displacement that the velocity at the end leaves", shown="mm"
    )


@results
class OverTarget:
    """The spectrum of a synthetic motion relative to its target near the first periods."""

    over_target: float = si("-", "mean ratio of the spectrum to its target")
    over_target_from: float = si("Hz", "lowest frequency of this mean")
    over_target_to: float = si("Hz", "highest frequency of this mean")


def floor_peaks(study: StickStudy) -> Iterator[FloorPeaks]:
    """The largest values of each floor, in the order of the stations."""
    response = study.response
    for stick in study.system.sticks:
        sides = PairEnds.of_pairs(study.system.pairs).sides(stick.name)
        drift, drift_free = (storey_drifts(run, stick) for run in (response, study.free))
        floors = zip(study.system.floor_dofs(stick.name), stick.floors, strict=True)
        for k, (dofs, floor) in enumerate(floors):
            touching = [
                columns
                for side, columns in sides.items()
                if side.floor == floor.number and side.relative_height is None
            ]
            force = depth = None
            if touching:
                force = max(float(response.force[:, j].sum(axis=1).max()) for j in touching)
                depth = max(0.0, *(float((-response.gap[:, j]).max()) for j in touching))
            acceleration = response.absolute_acceleration[:, dofs[:3]]
            yield FloorPeaks(
                peak_force=force,
                penetration=depth,
                peak_acceleration=float(np.linalg.norm(acceleration, axis=1).max()),
                storey_drift=float(drift[k]),
                storey_drift_no_contact=float(drift_free[k]),
            )


def storey_drifts(response: Response, stick: Stick) -> Array:
    """Return the largest horizontal drift of each storey over its height, shape (n_floors,) [-].

    The drift is the displacement between the mass centres of two floors, less that by the rotation
    of the base, which moves the building as a rigid body.
    """
    u = response.u[:, response.system.floor_dofs(stick.name)[:, :3]]
    lower, rotation = np.zeros_like(u), np.zeros((len(u), 2))
    lower[:, 1:] = u[:, :-1]
    if stick.name in response.relative:
        lower[:, 0] += response.relative[stick.name][0]
    if stick.name in response.bases:
        base = response.bases[stick.name].u
        lower[:, 0] += base[:, :3]
        # θ × (0, 0, h) = h (θ_y, -θ_x, 0)
        rotation = np.stack([base[:, 4], -base[:, 3]], axis=1)
    height = np.diff(stick.positions[: u.shape[1], 2], prepend=stick.base)
    drift = (u - lower)[..., :2] / height[:, None] - rotation[:, None]
    return np.asarray(np.linalg.norm(drift, axis=2).max(axis=0), dtype=np.float64)


def building_peaks(study: StickStudy) -> Iterator[BuildingPeaks]:
    """The largest values of each building, in the order of the sticks."""
    response, delays = study.response, study.case.delays
    on_soil = {one.building: float(one.frequency.min()) for one in study.foundations}
    first = study.system.sticks[0].name
    for stick, modes in zip(study.system.sticks, study.modes, strict=True):
        lowest = min(float(modes.frequency[0]), on_soil.get(stick.name, np.inf))
        last = response.time >= response.time[-1] - 1.0 / lowest
        moved = _top(study, response, stick)
        peak = float(np.linalg.norm(moved, axis=1).max())
        swing = float(np.linalg.norm(moved[last] - moved[last].mean(axis=0), axis=1).max())
        delay = apart = left = None
        if stick.name in response.relative:
            delay = delays[stick.name] - delays[first]
            ground = response.relative[stick.name][0]
            apart = float(np.linalg.norm(ground, axis=1).max())
            left = abs(delay * math.hypot(*(m.measures.end_velocity for m in study.motions)))
        yield BuildingPeaks(
            peak_displacement=peak,
            peak_displacement_no_contact=float(
                np.linalg.norm(_top(study, study.free, stick), axis=1).max()
            ),
            swing_at_end=swing / peak if peak > 0.0 else 0.0,
            passage_delay=delay,
            passage_apart=apart,
            passage_left=left,
        )


def _top(study: StickStudy, response: Response, stick: Stick) -> Array:
    """Displacement of the top floor relative to the ground under it, shape (n_t, 3) [m]."""
    moved = response.u[:, study.system.floor_dofs(stick.name)[-1, :3]]
    if stick.name in response.relative:
        moved = moved - response.relative[stick.name][0]
    return moved


def over_target(study: StickStudy, motion: GroundMotion) -> OverTarget:
    """The mean ratio of a motion to its target near the first periods; nan if there is none."""
    direction = motion.direction
    firsts = [float(one.frequency[k]) for one in study.modes for k in one.of_family(direction)[:1]]
    if direction in DIRECTIONS:
        k = DIRECTIONS.index(direction)
        firsts += [float(one.frequency[k]) for one in study.foundations]
    if motion.misfit is not None and firsts:
        f, r = motion.misfit.frequency, motion.misfit.ratio
        near = (f >= min(firsts) / LONG) & (f <= max(firsts) / SHORT)
        if near.any():
            low, high = f[near][[0, -1]]
            return OverTarget(float(r[near].mean()), float(low), float(high))
    return OverTarget(math.nan, math.nan, math.nan)

"""Impacts: time and size of each contact, and its demand on the buildings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import gaussian_filter1d

from impactfem.case.contact_search import Facing
from impactfem.coupling.pounding import Pair, Response
from impactfem.sticks.element import rigid_link
from impactfem.system.arrays import Array
from impactfem.system.quantity import quantity, results, si

FORCE_BAND = 100.0
"""Corner of the low-pass filter of all contact forces [Hz]: 3D models are compared with full order
up to this frequency."""
LASTING = 5e-3
"""Half of a period of 100 Hz [s], up to which 3D models are compared with full order."""


@results
class Impact:
    """One impact of one pair: a run of steps with a contact force."""

    pair: Pair
    index: int  #: its index in the system
    first: int  #: index of the first time with a force
    last: int  #: index of the last time with a force
    start: float = si("s", "first contact, interpolated time", name="first_contact")
    end: float = si("s", "end, interpolated time at which the force ends")
    peak_time: float = si("s", "peak at, time of the largest force")
    #: Of `low_passed`; it depends less on the contact law and on the time step than the peak.
    band_force: float = si("N", "force up to 100 Hz, largest after the low-pass filter", shown="MN")
    peak_force: float = si("N", "peak force, without a filter", shown="MN")
    impulse: float = si("N s", "impulse, time integral of the force", shown="kN s")
    penetration: float = si("m", "penetration, largest of the impact", shown="mm")
    #: At the last time before the force, positive.
    approach: float = si("m/s", "approach, velocity before the impact")
    #: At the first time after the force, positive if the points separate.
    separation: float = si("m/s", "separation, velocity after the impact")
    dissipated: float = si("J", "energy dissipated, work of the contact law", shown="kJ")
    #: Minus the work of the force on the buildings, less what the law takes along the same motion.
    defect: float = si(
        "J", "defect of the scheme, energy lost (negative: added) by time stepping", shown="kJ"
    )

    @property
    @quantity("s", "duration", shown="ms")
    def duration(self) -> float:
        """Duration of the impact [s]."""
        return self.end - self.start

    @property
    @quantity("-", "steps, computed times with a force")
    def steps(self) -> int:
        """Number of computed times with a force."""
        return self.last - self.first + 1

    @property
    @quantity("-", "restitution")
    def restitution(self) -> float:
        """Speed of separation over speed of approach [-]; nan for a contact that begins at rest.

        The buildings' own forces act during the impact, too; for a point inside a storey, without
        mass, it is no restitution of bodies.
        """
        return self.separation / self.approach if self.approach > 0.0 else math.nan


def impacts(response: Response) -> list[Impact]:
    """All impacts of a response in order of their start.

    An impact that is still going on when the response ends is left out of no sum: it is listed
    with the last time as its end.
    """
    found, filtered = [], low_passed(response.force, response.time_step)
    for index in range(len(response.system.pairs)):
        touching = np.concatenate([[False], response.force[:, index] != 0.0, [False]])
        first, after = np.flatnonzero(np.diff(touching.astype(np.int8))).reshape(-1, 2).T
        # Pulses with a shorter pause are one impact.
        begins = np.append(True, (first[1:] - after[:-1]) * response.time_step >= response.pause)
        starts = first[begins[: len(first)]].tolist()
        ends = after[np.append(begins[1:], True)[: len(after)]].tolist()
        for start, end in zip(starts, ends, strict=True):
            band = float(filtered[start:end, index].max())
            found.append(_impact(response, index, start, end - 1, band))
    return sorted(found, key=lambda impact: impact.start)


def low_passed(force: Array, time_step: float) -> Array:
    """Remove what is above `FORCE_BAND` from forces at equal time steps, shape (n_t, m).

    The filter is a Gauss function of time, whose transfer function is 1/√2 at `FORCE_BAND`: it
    keeps the impulse, and a force in compression stays one.
    """
    width = math.sqrt(math.log(2.0)) / (2.0 * math.pi * FORCE_BAND)
    return np.asarray(
        gaussian_filter1d(force, width / time_step, axis=0, mode="constant", truncate=6.0)
    )


def largest_means(time: Array, force: Array) -> Array:
    """The largest mean over `LASTING` of each force, shape (n_t, n) at times (n_t,), shape (n,).

    The peak of a unilateral contact depends on the step, and grows as it becomes shorter.
    """
    impulse = cumulative_trapezoid(force, time, axis=0, initial=0.0)
    ends = [np.interp(time + LASTING, time, one) for one in impulse.T]
    return np.asarray(np.max(np.reshape(ends, force.T.shape).T - impulse, axis=0)) / LASTING


def _impact(response: Response, index: int, first: int, last: int, band_force: float) -> Impact:
    dt, pair = response.time_step, response.system.pairs[index]
    F, gap, rate = (x[:, index] for x in (response.force, response.gap, response.gap_rate))
    # The step in which the gap closes and the one after the last force belong to the impact: a
    # lagged force begins a step or more after contact.
    low = max(first - 1, 0)
    while low > 0 and gap[low] < 0.0 and F[low - 1] == 0.0:
        low -= 1
    high = min(last + 1, F.size - 1)
    f, g, v = F[low : high + 1], gap[low : high + 1], -rate[low : high + 1]
    mean = 0.5 * (f[:-1] + f[1:])
    work, taken = response.exchanged(index, low, high)
    peaks = response.largest_forces[:, index]
    peak = int(np.argmax(peaks[first : last + 1])) + first
    return Impact(
        pair=pair,
        index=index,
        first=first,
        last=last,
        start=_crossing(dt, low, min(low + 1, first), gap),
        end=_crossing(dt, last, high, gap),
        peak_time=float(dt * peak),
        band_force=band_force,
        peak_force=float(peaks[peak]),
        impulse=float(np.sum(dt * mean)),
        penetration=float(np.max(-g)),
        approach=float(v[0]),
        separation=float(rate[high]),
        dissipated=-work,
        defect=-work - taken,
    )


def _crossing(dt: float, i: int, j: int, gap: Array) -> float:
    """Time where the gap crosses zero between two times, or the later one where it does not."""
    if i == j or gap[i] * gap[j] > 0.0 or gap[i] == gap[j]:
        return float(dt * j)
    return float(dt * (i + (j - i) * gap[i] / (gap[i] - gap[j])))


VERTICAL = 1e-6  # a normal with a smaller horizontal part is vertical


@results
class Separation:
    """Largest approach of two points without contact, compared with their gap."""

    pair: Pair
    #: The largest approach without contact.
    required: float = si(
        "m", "required, gap that avoids contact", shown="mm", name="required_separation"
    )
    touched: bool = si("", "touched, the points touch in the run with contact")
    #: Relative to the ground under the first building, without contact.
    displacement_a: float = si(
        "m", "displacement of a, largest along the normal without contact", shown="mm"
    )
    #: None for a wall, which moves with the ground.
    displacement_b: float | None = si(
        "m", "displacement of b, largest along the normal without contact", shown="mm"
    )

    @property
    @quantity("m", "margin, gap less required separation", shown="mm")
    def margin(self) -> float:
        """Gap less the required separation [m]; negative where pounding is to be expected."""
        return self.pair.gap - self.required


def separations(free: Response, response: Response) -> list[Separation]:
    """Required separation of each pair, from the runs without and with contact."""
    # Zero is added, as a point that never approaches has -0, which would be written as such.
    required = np.maximum(free.closed(response.system.pairs).max(axis=0), 0.0) + 0.0
    return [
        Separation(
            pair,
            float(required[k]),
            bool(response.force[:, k].any()),
            free.largest_along(pair.a, pair.normal),
            None if pair.b is None else free.largest_along(pair.b, pair.normal),
        )
        for k, pair in enumerate(response.system.pairs)
    ]


@results
class ImpactCheck:
    """Demand of an impact on the buildings."""

    impact: Impact
    #: Peak force over the bearing area; nan if the area is not known.
    bearing_pressure: float = si("Pa", "mean bearing pressure", shown="MPa")
    #: nan if neither building has a compressive strength; the lower one counts.
    bearing_ratio: float = si("-", "over strength, bearing pressure / compressive strength")
    #: Elastic, along the horizontal part of the normal, in the two sticks; nan for a vertical
    #: normal, and if both buildings pound in 3D.
    storey_shear: float = si("N", "largest storey shear, during the impact", shown="MN")
    #: Shear over n_x² A_vx + n_y² A_vy of its storey; nan for storeys by stiffness.
    shear_stress: float = si("Pa", "shear stress, largest of a storey", shown="MPa")
    #: Above 1 the storey cracks in shear, and linear analysis overestimates its stiffness; nan if
    #: no strength is known.
    cracking_ratio: float = si("-", "over tensile strength, shear stress / mean tensile strength")
    #: Velocities are those of the centres of mass of all floors, along the normal; nan if the
    #: buildings do not approach, at a wall, and beyond 0 to 1, where other forces move them.
    building_restitution: float = si("-", "of the whole buildings, restitution")


def impact_checks(
    response: Response, impacts: Sequence[Impact], strength: Mapping[str, float | None]
) -> list[ImpactCheck]:
    """Mean bearing pressure and storey shears of each impact of a run with contact.

    The compressive strength is that of the storeys by building [Pa]; None where not given.
    """
    checks = []
    for impact in impacts:
        pair = impact.pair
        window = slice(max(impact.first - 1, 0), impact.last + 2)
        horizontal = float(np.hypot(pair.normal[0], pair.normal[1]))
        found, known = [], []
        for end in (pair.a, pair.b):
            if end is None:
                continue
            stick = response.system.stick(end.building)
            f_c = strength.get(stick.name)
            if f_c is not None:
                known.append(f_c)
            if horizontal < VERTICAL or stick.name in response.in_3d:
                continue
            n_x, n_y = pair.normal[:2] / horizontal
            forces = stick.element_forces(response.deformation("u", stick.name)[window])
            shear = np.abs(forces[..., 0] * n_x + forces[..., 1] * n_y).max(axis=0)
            sections = [stick.floors[element.storey].section for element in stick.elements]
            stress = shear / [section.shear_area(n_x, n_y) for section in sections]
            # f_ctm of EN 1992-1-1, table 3.1, up to C50/60 and above it [MPa].
            f = np.nan if f_c is None else 1e-6 * f_c
            f_ctm = 0.30 * np.cbrt(f) ** 2 if f <= 50.0 else 2.12 * np.log1p((f + 8.0) / 10.0)
            found.append((shear.max(), stress.max(), stress.max() / (1e6 * f_ctm)))
        # Of a vertical normal, or without a strength or a stick, there is nothing to compare with.
        demand = np.fmax.reduce(found) if found else np.full(3, np.nan)
        pressure = np.nan if pair.area is None else impact.peak_force / pair.area
        ratio = pressure / min(known) if known else np.nan
        rate = _apart(response, pair, (window.start, min(window.stop, len(response.v)) - 1))
        bounced = rate[1] / -rate[0] if rate[0] < 0.0 else np.nan
        bounced = bounced if 0.0 <= bounced <= 1.0 else np.nan
        checks.append(ImpactCheck(impact, *map(float, (pressure, ratio, *demand, bounced))))
    return checks


def _apart(response: Response, pair: Pair, steps: tuple[int, int]) -> Array:
    """Speed at which two buildings move apart along the normal of a pair, at some times [m/s]."""
    speed = np.zeros(len(steps))
    for end, sign in ((pair.a, -1.0), (pair.b, 1.0)):
        if end is None:
            return np.full(len(steps), np.nan)
        floors = response.system.stick(end.building).floors
        mass = np.array([floor.mass for floor in floors])
        dofs = response.system.floor_dofs(end.building)[:, :3]
        for k, step in enumerate(steps):
            speed[k] += sign * (mass @ response.v[step, dofs] @ pair.normal) / mass.sum()
    return speed


@dataclass(frozen=True)
class Approach:
    """The nearest that two places of neighbouring buildings come in a run."""

    facing: Facing  #: the places, their normal and their distance at rest
    distance: float  #: smallest distance along the normal [m]; negative where they overlap
    time: float  #: when [s]


def approaches(response: Response, facing: Sequence[Facing]) -> list[Approach]:
    """The closest approach of each, at either end of the length over which they face each other.

    Floors are rigid and turn about their axes, so that the distance
    d(s, t) = gap(s) + n · (u_b − u_a) is straight in s along the edges: its least value over them
    is at an end. Inside a storey the beam gives the motion of the axis.
    """
    if not facing:
        return []
    system = response.system
    rows = np.zeros((len(facing), 2, system.M.shape[0]))
    carried = np.zeros((len(facing), 2, len(response.u)))
    for ends, more, one in zip(rows, carried, facing, strict=True):
        normal = np.array(one.normal)
        tangent = np.array([-normal[1], normal[0], 0.0])
        for point, sign in ((one.a, -1.0), (one.b, 1.0)):
            stick = system.stick(point.building)
            columns = slice(system.offsets[stick.name], system.offsets[stick.name] + stick.n)
            if point.floor is not None:
                motion = np.eye(6, stick.n, 6 * stick.floor_master(point.floor))
            else:
                storey, height = int(point.storey or 0), float(point.relative_height or 0.0)
                motion = stick.storey_motion(storey, height)
            base = response.base("u", stick.name)
            for row, add, s in zip(ends, more, (-1.0, 1.0), strict=True):
                offset = np.array(point.offset) + one.half * s * tangent
                along = sign * normal @ rigid_link(offset)[:3]
                row[columns] += along @ motion
                if base is not None:
                    # Of a rigid motion of the base, what does not come by the floors: in the first
                    # storey the lower end.
                    axis = rigid_link((0.0, 0.0, one.level - stick.base - point.offset[2]))
                    add += base @ (along @ (axis - motion @ stick.rigid_body()))
    slopes = [one.opposite.gap_slope * one.half for one in facing]
    rest = np.array(
        [
            [one.opposite.gap - more, one.opposite.gap + more]
            for one, more in zip(facing, slopes, strict=True)
        ]
    )
    d = (rest + np.moveaxis(rows @ response.u.T + carried, -1, 0)).min(axis=2)
    step = d.argmin(axis=0)
    return [
        Approach(one, float(d[k, j]), float(response.time[k]))
        for j, (one, k) in enumerate(zip(facing, step, strict=True))
    ]

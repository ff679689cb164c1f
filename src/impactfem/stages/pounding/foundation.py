"""Foundations on soil: stiffness, periods and damping with it, what it radiates, uplift."""

from dataclasses import dataclass

import numpy as np

from impactfem.case import Case
from impactfem.coupling.base import coupled_modes, first_along
from impactfem.coupling.pounding import Response
from impactfem.records.accelerogram import STANDARD_GRAVITY
from impactfem.sticks.element import rigid_link
from impactfem.system.arrays import Array

DIRECTIONS = ("x", "y")


@dataclass(frozen=True, eq=False)
class Foundation:
    """The raft of a building, and the soil under it."""

    building: str
    stiffness: Array  #: at rest, about the middle of the underside, shape (6,) [N/m, N m]
    dashpot: Array  #: Im S/ω at the first frequency on soil, likewise, shape (6,) [N s/m, N m s]
    #: Frequencies in which the errors count: the lowest first frequency on soil, and twice the
    #: highest first frequency on a clamped base, shape (2,) [Hz].
    band: Array
    #: Largest error of the stiffness of the soil's model in this band, of |S|, shape (6,) [-].
    stiffness_error: Array
    damping_error: Array  #: of its damping, of Im S, likewise, shape (6,) [-]
    clamped_frequency: Array  #: first along x and along y on a clamped base, shape (2,) [Hz]
    frequency: Array  #: of these modes on soil, shape (2,) [Hz]
    clamped_ratio: Array  #: damping ratio on a clamped base, shape (2,) [-]
    ratio: Array  #: on soil, that of the soil included, shape (2,) [-]
    radiated: float  #: energy [J]
    weight: float  #: of building and raft [N]
    #: Least pressure of the soil on the raft, linear over its underside, shape (n_t,) [Pa];
    #: negative where it would have to pull.
    pressure: Array
    area: float  #: of the raft [m2]

    @property
    def static_pressure(self) -> float:
        """Mean pressure by gravity [Pa]."""
        return self.weight / self.area


def foundations(case: Case, response: Response) -> tuple[Foundation, ...]:
    """Of each building on soil in the order of the sticks."""
    found = []
    for stick, (_, body) in zip(response.system.sticks, response.system.modes, strict=True):
        given = case.building(stick.name).soil
        if given is None or stick.soil is None:
            continue
        raft, base = given.raft, response.bases[stick.name]
        # From the motion of the underside to that of the base.
        up = rigid_link((0.0, 0.0, raft.thickness))
        below = stick.soil.moved(up)
        modes = coupled_modes(body)
        d = body.damping.modal(body.eigenvalue)
        d, ω = (d if d.ndim == 1 else np.diag(d)), np.sqrt(body.eigenvalue)
        # Points inside storeys have no mass, and are not moved by the ground.
        order = np.argsort(ω)
        firsts = [int(order[first_along(body.participation[order, k] ** 2)]) for k in range(2)]
        ours = [first_along(modes.effective_mass[:, k]) for k in range(2)]
        ω_1 = 2.0 * np.pi * float(modes.frequency[ours].min())
        band = np.array([ω_1, 2.0 * ω[firsts].max()])
        errors = stick.soil.errors(*band)
        # A force on the soil at the base is this wrench about the underside.
        force = base.force @ up
        weight = STANDARD_GRAVITY * float(body.rigid_mass[0, 0])
        x, y = raft.gyration
        if raft.radius is not None:
            moment = np.hypot(force[:, 3], force[:, 4]) * raft.radius / x
        else:
            moment = np.abs(force[:, 3]) * raft.sides[1] / (2.0 * x)
            moment = moment + np.abs(force[:, 4]) * raft.sides[0] / (2.0 * y)
        found.append(
            Foundation(
                building=stick.name,
                stiffness=np.diag(below.static).copy(),
                dashpot=np.diag(below.impedance(np.array([ω_1]))[0]).imag / ω_1,
                band=band / (2.0 * np.pi),
                stiffness_error=errors[:, 0],
                damping_error=errors[:, 1],
                clamped_frequency=ω[firsts] / (2.0 * np.pi),
                frequency=modes.frequency[ours],
                clamped_ratio=d[firsts] / (2.0 * ω[firsts]),
                ratio=modes.ratio[ours],
                radiated=float(base.radiated[-1]),
                weight=weight,
                pressure=(weight - force[:, 2] - moment) / raft.area,
                area=raft.area,
            )
        )
    return tuple(found)

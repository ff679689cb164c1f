"""Foundations on soil: stiffness, periods and damping with it, what it radiates, uplift."""

import numpy as np

from impactfem.case import Case
from impactfem.coupling.base import coupled_modes, first_along
from impactfem.coupling.pounding import Response
from impactfem.records.accelerogram import STANDARD_GRAVITY
from impactfem.sticks.element import rigid_link
from impactfem.system.arrays import Array
from impactfem.system.quantity import quantity, results, si

DIRECTIONS = ("x", "y")


@results
class Foundation:
    """The raft of a building, and the soil under it."""

    building: str
    #: About the middle of the underside, shape (6,).
    stiffness: Array = si(
        "N/m, N m/rad", "stiffness at rest, of the soil", dims="foundation_component"
    )
    #: Im S/ω about the middle of the underside, shape (6,).
    dashpot: Array = si(
        "N s/m, N m s/rad", "dashpot at the first frequency", dims="foundation_component"
    )
    #: The lowest first frequency on soil, and twice the highest first frequency on a clamped base,
    #: shape (2,) [Hz]: the errors are the largest of this band.
    band: Array
    stiffness_error: Array = si(
        "-", "error of the stiffness, of |S|", shown="%", dims="foundation_component"
    )
    damping_error: Array = si(
        "-", "error of the damping, of Im S", shown="%", dims="foundation_component"
    )
    #: First modes along x and y, shape (2,) each.
    clamped_frequency: Array = si(
        "Hz", "clamped, first mode on a clamped base", dims="foundation_direction"
    )
    frequency: Array = si("Hz", "on soil, first mode", dims="foundation_direction")
    clamped_ratio: Array = si(
        "-", "damping clamped, first mode", shown="%", dims="foundation_direction"
    )
    ratio: Array = si("-", "damping on soil, first mode", shown="%", dims="foundation_direction")
    radiated: float = si("J", "energy radiated", shown="MJ")
    weight: float = si("N", "weight, of building and raft", shown="MN")
    #: Linear over the underside, shape (n_t,); negative where the soil would have to pull.
    pressure: Array
    area: float  #: of the raft [m2]

    @property
    @quantity("-", "period over clamped, first mode", dims="foundation_direction")
    def period_ratio(self) -> Array:
        """Periods of the first modes, on soil / clamped, shape (2,) [-]."""
        return self.clamped_frequency / self.frequency

    @property
    @quantity("Pa", "least pressure of the underside", shown="kPa")
    def least_pressure(self) -> float:
        """Least pressure of the soil on the raft; negative: tension [Pa]."""
        return float(self.pressure.min())

    @property
    @quantity("-", "least pressure / pressure by gravity")
    def least_pressure_ratio(self) -> float:
        """Least pressure over that by gravity; negative: the raft would lift [-]."""
        return self.least_pressure / self.static_pressure

    @property
    @quantity("Pa", "pressure by gravity, mean of the underside", shown="kPa")
    def static_pressure(self) -> float:
        """Mean pressure by gravity [Pa]."""
        return self.weight / self.area


def foundations(case: Case, response: Response) -> tuple[Foundation, ...]:
    """Of each building on soil in the order of the sticks."""
    found = []
    for stick in response.system.sticks:
        given = case.building(stick.name).soil
        if given is None or stick.soil is None:
            continue
        body = response.body(stick.name)
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

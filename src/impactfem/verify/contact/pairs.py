"""General contact pairs: eccentric, inside a storey, three in a row, one that is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Building, Case, ContactPoint, Damping, load_case
from impactfem.case.facing import facing_floors
from impactfem.coupling.contact import kelvin_voigt
from impactfem.coupling.from_case import system_of
from impactfem.coupling.impacts import approaches, impacts
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks import stick as sticks
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Stick, build_stick, mass_on_spring
from impactfem.system.files import in_source_tree
from impactfem.verify.contact import Y
from impactfem.verify.row import Rows, benchmark

Array = NDArray[np.float64]


@benchmark("eccentric impact", "impulse and angular momentum of a rigid body")
def eccentric_pair(rows: Rows) -> None:
    """A free floor (3014 t, J_z = 6.3e8 kg m²) hits a wall 15 m off its mass centre.

    With m = 1/(1/M + e²/J): impulse P = (1 + ε) m v, spin e P / J after. The contact begins at a
    time step, so that 2000 steps an impact are right to (π/2000)², 2.5e-6.
    """
    M, J, e, v = 3014e3, 6.3e8, 15.0, 0.2
    floor = mass_on_spring("floor", M, 0.0)
    floor = replace(floor, M=np.diag([*np.diag(floor.M)[:5], J]))
    offset, steps, effective = (e, 0.0, 0.0), 2000, 1.0 / (1.0 / M + e**2 / J)
    mass = floor.point_mass(0, offset, Y)
    law = kelvin_voigt(1e11, 0.12, mass)
    pair = Pair("wall", End("floor", 0, offset, 1), None, Y, 0.0, law)
    dt, allowed = law.duration(v) / steps, (np.pi / steps) ** 2
    ground, start = np.zeros((2300, 3)), v * np.eye(6)[1]
    response = simulate(System((floor,), (pair,)), ground, dt, v0=start)
    P = (1.0 + law.epsilon) * v * effective
    rows.add("effective mass", effective, mass, "kg", 1e-12)
    rows.add("impulse", P, impacts(response)[0].impulse, "N s", allowed)
    rows.add("spin after", -e * P / J, response.v[-1, 5], "rad/s", allowed)


@benchmark("pair inside a storey", "statics of the two sticks and the contact spring")
def storey_pair(rows: Rows) -> None:
    """A floor leans on the middle of a storey of its neighbour, pushed slowly by the ground.

    At the end F = (approach - g) / (1/K + c_a + c_b), where the approach is that of the buildings
    without contact and c = jᵀ K⁻¹ j their compliances at the points. The ground has been at rest
    for 20 s, in which the damping leaves exp(-40) of any vibration: only rounding is allowed for.
    """
    a, b = _tower("a", (3.0, 3.0), ()), _tower("b", (4.0, 4.0), ((2, 0.5),))
    K, gap, acceleration = 1e9, 1e-3, -3.0
    ends = End("a", 1, (0.0,) * 3, 2), End("b", b.storey_points[2, 0.5], (0.0,) * 3, 2, 0.5)
    a = replace(a, M=4.0 * a.M)
    pair = Pair("a-b", *ends, Y, gap, kelvin_voigt(K, 0.3, 1e5))
    system = System((a, b), (pair,))
    n_t, dt = 20001, 2e-3
    ground = np.zeros((n_t, 3))
    ground[:, 1] = acceleration * np.clip(np.linspace(0.0, 2.0, n_t), 0.0, 1.0)
    response = simulate(system, ground, dt)
    (j,) = system.J
    flexibility = np.linalg.inv(system.K)
    free = -float(j @ flexibility @ system.M @ system.ground[:, 1]) * acceleration
    force = (-free - gap) / (1.0 / K + float(j @ flexibility @ j))
    rows.add("force at rest", force, response.force[-1, 0], "N", 1e-10)


@benchmark("three in a row", "collisions of equal elastic masses; symmetry")
def three_buildings(rows: Rows) -> None:
    """Three equal free floors, elastic contact, gaps between: the first hits, the last flies off.

    Two collisions of equal masses hand the speed on. Then the outer two move towards the middle one
    at the same speed: by symmetry it never moves. An elastic contact leaves ½ K p₁ |p₀| where the
    gap closes inside a step, at most (ΩΔt)²/4 of the energy and half of that in the speed: with
    400 steps an impact, and two of them, (π/400)²/4 = 1.5e-5.
    """
    m, v, gap, steps = 2000e3, 0.25, 0.01, 400
    a, b, c = (mass_on_spring(name, m, 0.0) for name in "abc")
    law = kelvin_voigt(1e11, 0.0, m / 2.0)
    pairs = tuple(
        Pair(f"{p.name}-{q.name}", End.of_floor(p, 1), End.of_floor(q, 1), Y, gap, law)
        for p, q in ((a, b), (b, c))
    )
    system = System((a, b, c), pairs)
    dt, allowed = law.duration(v) / steps, 0.25 * (np.pi / steps) ** 2
    ground, unit = np.zeros((int(3.5 * gap / v / dt), 3)), np.eye(18)
    handed = simulate(system, ground, dt, v0=v * unit[1])
    mirrored = simulate(system, ground, dt, v0=v * (unit[1] - unit[13]))
    rows.add("speed of the last one", v, handed.v[-1, 13], "m/s", allowed)
    rows.add("speed of the first one", 0.0, handed.v[-1, 1], "m/s", allowed * v)
    between = np.abs(mirrored.u[:, 7]).max()
    rows.add("motion of the middle one between two mirrored ones", 0.0, between, "m", 1e-15)
    rows.add("rebound of the mirrored ones", v, mirrored.v[-1, 13], "m/s", allowed)


@benchmark(source="closed form of undamped oscillators on Timoshenko cantilevers")
def missing_pair(rows: Rows) -> None:
    """A row A, B, C of masses on columns under a sine of the ground; B and C are in no pair.

    A column of the height h carries the mass m; its lower part l = h − r bends and shears, the
    upper part r is rigid. A force on the mass moves it by 1/k = (h³ − r³)/(3 E I) + l/(G A_v), and

        u(t) = −a/(ω² − Ω²) (sin Ωt − (Ω/ω) sin ωt),   ω² = k/m,

    under the ground acceleration a sin Ωt. The floors of B and C are level; then C is lower, and
    its floor faces the column of B, which the force 1 on the mass moves at the height z by
    (h z²/2 − z³/6)/(E I) + z/(G A_v). A stands half a metre away and is not met. The floors turn
    with an inertia of 1 kg m², which changes ω² by 1e-6 at most; average acceleration makes periods
    longer by (ωΔt)²/12, less than 2e-6, over twenty of them: 3e-4 of the displacements of at most
    6 cm are 20 μm.
    """
    gap, z, time = 0.03, 1.3, 2.5e-4 * np.arange(20001)
    a, Ω = 2.0, 2.0 * np.pi * 1.3
    ground = np.zeros((len(time), 3))
    ground[:, 1] = a * np.sin(Ω * time)
    for label, height in (("level floors", 3.0), ("storey", z)):
        rows.name = f"missing pair, {label}"
        listed = _row_of_three(height, gap)
        case = listed.model_copy(update={"contacts": listed.contacts[:1]})
        found = facing_floors(case).pairs
        response = simulate(system_of(case, None), ground, float(time[1]))
        nearest = min(approaches(response, found), key=lambda one: one.distance)
        b, c = (_on_column(one, time, a, Ω) for one in listed.buildings[1:])
        if height == z:
            column = listed.buildings[1]
            b *= _flexibility(column, z) / _flexibility(column, 3.0)
        quantities = [f"places in no pair, with the pair {word}" for word in ("missing", "listed")]
        places = [len(found), len(facing_floors(listed).pairs)]
        rows.add(quantities, [1, 0], places, "-", 0.0, "the row as it is made", absolute=True)
        distance = gap + c - b
        smallest = distance.min()
        rows.add("smallest distance", smallest, nearest.distance, "m", 2e-5, absolute=True)
        rows.add("its time", time[distance.argmin()], nearest.time, "s", 1e-3)


def _row_of_three(height: float, gap: float) -> Case:
    """Three undamped masses on columns, C of a height [m]; A and B, B and C in a pair each."""
    case = load_case(in_source_tree("geometry/row_of_three.toml"))
    size, apart, level = 10.0, (0.5, gap), height == 3.0
    axes = (0.0, size + apart[0], 2.0 * size + sum(apart))
    undamped = Damping(mass_coefficient=0.0, stiffness_coefficient=0.0)
    columns = ((3.0, 0.0374), (3.0, 0.004), (height, 0.009 if level else 0.003))
    buildings = []
    for building, y, (h, Avy) in zip(case.buildings, axes, columns, strict=True):
        keys = {"mass": 150e3, "Jx": 1.0, "Jy": 1.0, "Jz": 1.0, "Ix": 0.5, "Avy": Avy}
        heights = dict.fromkeys(("storey_height", "storey_height_min", "storey_height_max"), h)
        floor = building.floors[0].model_copy(update=keys | heights)
        update = {"axis": (0.0, y), "length": size, "width": size, "damping": undamped}
        buildings.append(building.model_copy(update=update | {"floors": (floor,)}))

    def edge(building: str, y: float) -> ContactPoint:
        offset = (0.0, y, 0.0)
        return ContactPoint(
            building=building, floor=1, storey=None, relative_height=None, offset=offset
        )

    b = edge("B", 5.0)
    if not level:
        b = b.model_copy(update={"floor": None, "storey": 1, "relative_height": 0.5})
    contacts = []
    for p, q, d in ((edge("A", 5.0), edge("B", -5.0), apart[0]), (b, edge("C", -5.0), gap)):
        update = {"name": f"{p.building}-{q.building}", "a": p, "b": q, "gap": d}
        contacts.append(case.contacts[0].model_copy(update=update))
    return case.model_copy(update={"buildings": tuple(buildings), "contacts": tuple(contacts)})


def _flexibility(building: Building, z: float) -> float:
    """Motion of a column at the height z [m] under the force 1 on its mass [m/N]."""
    (floor,) = building.floors
    E, h = building.material.young_modulus, floor.storey_height
    EI, GA = E * floor.Ix, E / (2.0 * (1.0 + building.material.poisson_ratio)) * floor.Avy
    low = h - building.rigid_below
    if z <= low:
        return (h * z**2 / 2.0 - z**3 / 6.0) / EI + z / GA
    return (h**3 - (h - low) ** 3) / (3.0 * EI) + low / GA


def _on_column(building: Building, time: Array, a: float, Ω: float) -> Array:
    """Displacement of the mass under the ground acceleration a sin Ωt."""
    (floor,) = building.floors
    ω = (floor.mass * _flexibility(building, floor.storey_height)) ** -0.5
    u = -a / (ω**2 - Ω**2) * (np.sin(Ω * time) - Ω / ω * np.sin(ω * time))
    return np.asarray(u, dtype=np.float64)


def _tower(name: str, heights: tuple[float, ...], points: tuple[tuple[int, float], ...]) -> Stick:
    section = Section(E=30e9, G=12e9, A=2.0, Avx=1.0, Avy=1.0, Ix=0.5, Iy=0.5, Iz=0.5)
    damping = Rayleigh(4.0, 5e-3)
    floors = [
        sticks.Floor(k + 1, 3e5, (1e6, 1e6, 2e6), height, section, damping, below=0.2, above=0.2)
        for k, height in enumerate(heights)
    ]
    return build_stick(name, floors, storey_points=points)

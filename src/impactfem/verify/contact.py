"""Contact between sticks: laws, shocks in closed form, restitution, and general pairs.

`collision` and `against_wall` are the collisions of masses that benchmarks and tests share.
"""

from dataclasses import replace

import numpy as np

from impactfem.case import Building, Case, ContactPoint, RayleighDamping, load_case
from impactfem.case.contact_search import facing_floors
from impactfem.coupling import laws
from impactfem.coupling import restitution as relation
from impactfem.coupling.from_case import system_of
from impactfem.coupling.impacts import approaches, impacts
from impactfem.coupling.laws import Law
from impactfem.coupling.pounding import End, Pair, Response, System, Update, simulate
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, Stick, build_stick, mass_on_spring
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree
from impactfem.verify.row import Rows, benchmark, fitted_order

Y = np.array([0.0, 1.0, 0.0])


def collision(
    law: Law,
    m1: float,
    m2: float,
    speed: float,
    dt: float,
    *,
    phase: float = 0.0,
    update: Update = "implicit",
) -> Response:
    """Two free masses [kg], 1 towards 2 at rest, followed until the law has let them go.

    At a speed of approach [m/s] in steps dt [s], the gap closing after a part of a step, 0 to 1
    [-].
    """
    one, other = mass_on_spring("1", m1, 0.0), mass_on_spring("2", m2, 0.0)
    pair = Pair("1-2", End.of_floor(one, 1), End.of_floor(other, 1), Y, speed * dt * phase, law)
    # Heavily damped Hertz contacts part slowly.
    patience = 1.5 if isinstance(law, laws.KelvinVoigt) else 1.5 / law.epsilon
    n_t = int(np.ceil(patience * law.duration(speed) / dt)) + 3
    ground, v0 = np.zeros((n_t, 3)), speed * np.eye(12)[1]
    return simulate(System((one, other), (pair,)), ground, dt, update=update, v0=v0)


def against_wall(mass: Stick, law: Law, gap: float, speed: float, dt: float, n_t: int) -> Response:
    """One mass of `mass_on_spring` that moves towards a rigid wall, n_t steps of dt [s]."""
    system = System((mass,), (Pair("wall", End.of_floor(mass, 1), None, Y, gap, law),))
    return simulate(system, np.zeros((n_t, 3)), dt, v0=speed * np.eye(6)[1])


STEPS = 800  # time steps of an impact
ALLOWED = {
    "hertz": 1e-9,
    "hertz-damp": (np.pi / STEPS) ** 2,
    "hunt-crossley": (np.pi / STEPS) ** 2,
    "jankowski": 2e-4,
}
"""Error of the restitution. The force of Hertz, with or without damping by p^1.5, begins smoothly:
second order, (π/800)² = 1.5e-5. Without damping nothing is lost but by terms of fourth order,
(π/800)⁴ = 2e-10. Jankowski's begins as p^0.25: order 1.25, 800^-1.25 = 2e-4."""


@benchmark(
    "SDND101 shock on a wall",
    "code_aster validation manual V5.01.101 (SDND101) and its closed form",
)
def shock_on_wall(rows: Rows) -> None:
    """SDND101: m = 100 kg on k = 1e4 N/m hits a wall of 1e6 N/m at 1 m/s, undamped, no gap.

    With Ω = √((k + K)/m): F = K v₀/Ω, half a period π/Ω in contact, impulse 2 K v₀/Ω², and the
    second contact after half a period of the free mass on k. A step of 1e-5 s has (ΩΔt)² = 1e-6.
    Times of the largest force are those of a step, 6e-4 of the first and 3e-5 of the second; the
    duration is read inside the steps.
    """
    m, k, K, v0 = 100.0, 1e4, 1e6, 1.0
    law = laws.KelvinVoigt(K, 0.0, mass=m)
    first, second = impacts(against_wall(mass_on_spring("m", m, k), law, 0.0, v0, 1e-5, 40001))[:2]
    rows.add("largest force", 9950.3719, first.peak_force, "N", 1e-6)
    rows.add("time of the largest force", 0.0156298, first.peak_time, "s", 7e-4)
    rows.add("duration of contact", 0.0312594, first.duration, "s", 1e-4)
    rows.add("impulse", 198.0198, first.impulse, "N s", 1e-6)
    rows.add("rebound speed", 1.0, first.separation, "m/s", 1e-6)
    rows.add("time of the second largest force", 0.36105, second.peak_time, "s", 3e-5)


@benchmark(source="closed form of the damped half-oscillation (Anagnostopoulos 1988)")
def kelvin_voigt(rows: Rows) -> None:
    """A free floor of 3014 t at 0.163 m/s against a wall with K = 1e11 N/m and ξ = 0.12.

    x = (v₀/Ω_D) exp(-ξΩt) sin Ω_D t; the force at onset is C v₀, at release -C ε v₀. The contact
    begins at a time step: with 4000 steps an impact, duration and restitution are right to
    (π/4000)², 6e-7. Forces are those of a step: the largest one is right to about one part in 4000,
    and the first one is a step after onset, ΩΔt/2ξ = 3.3e-3 above.
    """
    K, xi, v0, steps = 1e11, 0.12, 0.163, 4000
    for m in (3014e3, 1507e3, 787e3):
        law, second = laws.KelvinVoigt(K, xi, mass=m), (np.pi / steps) ** 2
        dt = law.duration(v0) / steps
        response = against_wall(mass_on_spring("m", m, 0.0), law, 0.0, v0, dt, 2 * steps)
        impact = impacts(response)[0]
        omega, omega_d = np.sqrt(K / m), np.sqrt(K / m * (1.0 - xi**2))
        t = np.linspace(0.0, np.pi / omega_d, 2_000_001)
        decay = v0 * np.exp(-xi * omega * t)
        x = decay / omega_d * np.sin(omega_d * t)
        v = decay * (np.cos(omega_d * t) - xi * omega / omega_d * np.sin(omega_d * t))
        F, first = K * x + law.parameters[1] * v, response.force[impact.first, 0]
        rows.name = f"Kelvin-Voigt impact, {m / 1e3:g} t"
        rows.add("largest force", F.max(), impact.peak_force, "N", 2e-4)
        rows.add("duration", t[-1], impact.duration, "s", second)
        rows.add("restitution", -v[-1] / v0, impact.restitution, "-", second)
        rows.add("force at onset", F[0], first, "N", 4e-3)


@benchmark(source="paper, equation 4")
def restitution(rows: Rows) -> None:
    """Restitution requested of the law and obtained by collisions of two floors.

    The gap closes somewhere inside a step, and a law that jumps there is off by a part of that
    step either way: the mean over that phase is compared, at 16 and at 100 steps an impact. The
    lagged force, equation 2 as the paper prints it, acts one step late, which is a negative damping
    -K Δt: the reference is what one expects then, ξ_c less K Δt / (2 √(K m)).
    """
    m1, m2, K = 1574e3, 3014e3, 1e11
    for epsilon in (0.414, 0.687, 0.891):
        for tension in (True, False):
            xi = relation.kelvin_voigt_xi(epsilon, tension=tension)
            law = laws.KelvinVoigt(K, xi, mass=m1 * m2 / (m1 + m2), tension=tension)
            source = rows.source if tension else "Schwager and Pöschel 2007, Granular Matter 9"
            rows.name = f"restitution {'with' if tension else 'without'} tension"
            for steps, tolerance in ((16, 0.01), (100, 5e-4)):
                quantity = f"ε = {epsilon}, mean with {steps} steps an impact"
                found = _mean("restitution", law, m1, m2, law.duration(0.3) / steps)
                rows.add(quantity, epsilon, found, "-", tolerance, source)
    dt, xi = 16.79 / 50_000, 0.12
    late = " with the damping of a force one step late"
    updates: tuple[tuple[Update, str], ...] = (("implicit", ""), ("lagged", late))
    for m1, m2, label in (
        (3014e3, 1e18, "floor of 3014 t against a wall"),
        (3014e3, 3014e3, "two floors of 3014 t"),
        (1574e3, 1574e3, "two floors of 1574 t"),
    ):
        mass = m1 * m2 / (m1 + m2)
        law = laws.KelvinVoigt(K, xi, mass=mass)
        for update, note in updates:
            damping = xi - K * dt / (2.0 * np.sqrt(K * mass)) if note else xi
            rows.name = f"restitution, {update} force"
            quantity = f"{label}, ξ = 0.12, step 0.3358 ms"
            found = _mean("restitution", law, m1, m2, dt, update)
            expected = relation.kelvin_voigt(damping)
            rows.add(quantity, expected, found, "-", 2e-3, rows.source + note)


def _mean(
    what: str, law: Law, m1: float, m2: float, dt: float, update: Update = "implicit"
) -> float:
    """Mean size of a value of the impact at 0.3 m/s, over 32 places of a step where it begins."""
    phases = (np.arange(32) + 0.5) / 32.0
    responses = (collision(law, m1, m2, 0.3, dt, phase=p, update=update) for p in phases)
    return float(np.mean([abs(getattr(impacts(found)[0], what)) for found in responses]))


@benchmark("contact energy defect", "Taylor expansion of the work in the step where the gap closes")
def contact_energy(rows: Rows) -> None:
    """Energy that the time stepping loses or adds in contact: its fitted order in the step.

    An elastic contact leaves ½ K p₁ |p₀| where the gap closes inside a step, second order; the
    force of Kelvin-Voigt jumps there and leaves a part of Δt C v₀², first order. The mean of the
    size is taken over the place in the step where the gap closes.
    """
    m, K = 1507e3, 1e11
    # Not a whole number of steps an impact: its end would fall on the phase of its start.
    counts = np.array([20, 40, 80, 160, 320]) + 1.0 / np.pi
    for xi, expected, label in ((0.0, 2.0, "elastic"), (0.12, 1.0, "Kelvin-Voigt")):
        law = laws.KelvinVoigt(K, xi, mass=m)
        steps = law.duration(0.3) / counts
        defects = [_mean("defect", law, 2.0 * m, 2.0 * m, dt) for dt in steps]
        order = fitted_order(1.0 / counts, defects)
        rows.add(f"fitted order in the step, {label}", expected, order, "-", 0.05, absolute=True)


@benchmark()
def contact_laws(rows: Rows) -> None:
    """Each law's restitution by the program's collision, against the law's own closed relation.

    The published relations of Hertz-damp and Hunt-Crossley hold for ε near 1: at 0.414 they return
    0.70 and 0.63. With the exact relation the collision returns what is requested. Jankowski's
    published relation is right within 0.01.

    At the onset of hertz-damp the speed falls by (Ωt)^2.5, 3e-6 in the 200 steps that are looked
    at, so that its power is known to 1e-5. Jankowski's force has a part p^1.5 and p^0.25:
    (Ωt)^1.25 or some 1e-3 of it. The jump of Kelvin-Voigt is read half of a step back along a
    straight line, (ΩΔt)² = 1e-9.
    """
    K, m1, m2, speed = 2.75e9, 1574e3, 3014e3, 0.3
    mass = m1 * m2 / (m1 + m2)

    def collide(law: Law, quantity: str, reference: float, source: str) -> None:
        dt = law.duration(speed) / STEPS
        found = impacts(collision(law, m1, m2, speed, dt, phase=0.5))[0].restitution
        rows.name = f"restitution, {law.name}"
        rows.add(quantity, reference, found, "-", ALLOWED[law.name], source)

    collide(laws.Hertz(K, mass=mass), "ε = 1", 1.0, "Hertz 1881: no loss")
    closed = "∫ m v dv over F = K p^1.5 (1 + χ v/v₀): ln((1+χ)/(1-χε)) = χ(1+ε)"
    integrated = "integration of x'' = -x^1.5 - 2ξ x^0.25 x' to rest (DOP853)"
    for asked in (0.414, 0.65, 0.687, 0.891):
        for exact in (False, True):
            quantity = f"ε = {asked} requested, {'exact' if exact else 'published'} damping"
            for make, source in (
                (laws.HertzDamp, closed),
                (laws.HuntCrossley, closed),
                (laws.Jankowski, integrated),
            ):
                relation = "exact" if exact else "published"
                law = make(K, asked, relation, mass=mass)
                collide(law, quantity, asked if exact else law.epsilon, source)

    # What happens at onset, from collisions in very short steps; the gap closes half a step early.
    def onset(law: Law) -> Array:
        F = collision(law, m1, m2, speed, 1e-5 * law.duration(speed), phase=0.5).force[:, 0]
        return F[np.flatnonzero(F)[0] :]

    rows.name = "force at onset"
    linear = laws.KelvinVoigt(1e11, 0.12, mass=mass)
    F, jump = onset(linear), 2.0 * 0.12 * np.sqrt(1e11 * mass) * speed
    source = "C v₀ with C = 2 ξ √(K m)"
    rows.add(f"{linear.name}, the jump", jump, 1.5 * F[0] - 0.5 * F[1], "N", 1e-8, source)
    early, late = 20, 200
    source = "no jump: F ~ K p^1.5, or 2 ξ √(K m) p^0.25 v₀, with p = v₀ t"
    for make, power, allowed in ((laws.HertzDamp, 1.5, 1e-5), (laws.Jankowski, 0.25, 5e-3)):
        F = onset(make(K, 0.65, mass=mass))
        growth = np.log(F[late] / F[early]) / np.log((late + 0.5) / (early + 0.5))
        quantity = f"{make(K, 0.65, mass=mass).name}, power of the time with which it grows"
        rows.add(quantity, power, growth, "-", allowed, source)


@benchmark("impacting bar", "closed form of the elastic bar; Siconos, example ImpactingBar")
def impacting_bar(rows: Rows) -> None:
    """A steel bar of 1 m flies at 0.1 m/s against a rigid wall (Siconos' example ImpactingBar).

    A compression wave runs through the bar and back: F = ρ c S v₀ for 2 L / c, impulse 2 m v₀,
    rebound with the full speed. The bar is a stick of 400 segments on its end, tied to the ground
    by nothing that counts; the wall is a stiff elastic contact. The segments spread the front of
    the wave over (1/400)^(2/3) of its way or so, hence 1 %; of the impulse, which the speed
    afterwards counts twice, a half of it.
    """
    E, S, L, rho, v0, n = 210e9, 3.14e-4, 1.0, 7800.0, 0.1, 400
    h, c = L / n, np.sqrt(E / rho)
    section = Section(E, E / 2.6, S, S, S, 1e-8, 1e-8, 1e-8)
    loose = Section(E * 1e-12, E, S * 1e-6, S, S, 1e-8, 1e-8, 1e-8)
    ends = rho * S * h / 2.0
    floors = [
        Floor(k + 1, m, (1e-3,) * 3, h, section if k else loose)
        for k, m in enumerate([ends, *[2.0 * ends] * (n - 1), ends])
    ]
    bar = build_stick("bar", floors)
    law = laws.KelvinVoigt(0.5 * E * S / h, 0.0, mass=ends, tension=False)
    end = End("bar", n, (0.0, 0.0, 0.0), n + 1)
    pair = Pair("wall", end, None, np.array([0.0, 0.0, 1.0]), 1e-7, law)
    dt = 0.25 * h / c
    start = np.zeros(bar.n)
    start[2::6] = v0
    steps = int(1.3 * 2.0 * L / c / dt)
    response = simulate(System((bar,), (pair,)), np.zeros((steps, 3)), dt, v0=start)
    F = response.force[:, 0]
    pushed = np.flatnonzero(F > 0.0)
    duration = float(response.time[pushed[-1]] - response.time[pushed[0]])
    impulse = float(np.sum(F) * dt)
    masses = np.diag(bar.M)[2::6]
    rebound = -float(masses @ response.v[-1, 2::6] / masses.sum())
    rows.add("mean force", rho * c * S * v0, impulse / duration, "N", 0.01)
    rows.add("duration", 2.0 * L / c, duration, "s", 0.01)
    rows.add("impulse", 2.0 * rho * S * L * v0, impulse, "N s", 5e-3)
    rows.add("speed of the mass centre after", v0, rebound, "m/s", 0.01)


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
    law = laws.KelvinVoigt(1e11, 0.12, mass=mass)
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
    pair = Pair("a-b", *ends, Y, gap, laws.KelvinVoigt(K, 0.3, mass=1e5))
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
    law = laws.KelvinVoigt(1e11, 0.0, mass=m / 2.0)
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
        columns = listed.buildings[1:]
        flexibility = [_flexibility(one, one.floors[0].storey_height) for one in columns]
        ω = [(one.floors[0].mass * f) ** -0.5 for one, f in zip(columns, flexibility, strict=True)]
        b, c = (-a / (w**2 - Ω**2) * (np.sin(Ω * time) - Ω / w * np.sin(w * time)) for w in ω)
        if height == z:
            b *= _flexibility(columns[0], z) / flexibility[0]
        quantities = [f"places in no pair, with the pair {word}" for word in ("missing", "listed")]
        places = [len(found), len(facing_floors(listed).pairs)]
        rows.add(quantities, [1, 0], places, "-", 0.0, "the row by construction", absolute=True)
        distance = gap + c - b
        smallest = distance.min()
        rows.add("smallest distance", smallest, nearest.distance, "m", 2e-5, absolute=True)
        rows.add("its time", time[distance.argmin()], nearest.time, "s", 1e-3)


def _row_of_three(height: float, gap: float) -> Case:
    """Three undamped masses on columns, C of a height [m]; A and B, B and C in a pair each."""
    case = load_case(in_source_tree("geometry/row_of_three.toml"))
    size, apart, level = 10.0, (0.5, gap), height == 3.0
    axes = (0.0, size + apart[0], 2.0 * size + sum(apart))
    undamped = RayleighDamping(mass_coefficient=0.0, stiffness_coefficient=0.0)
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
    section, G = floor.section, E / (2.0 * (1.0 + building.material.poisson_ratio))
    EI, GA = E * section["Ix"], G * section["Avy"]
    low = h - building.rigid_below
    if z <= low:
        return (h * z**2 / 2.0 - z**3 / 6.0) / EI + z / GA
    return (h**3 - (h - low) ** 3) / (3.0 * EI) + low / GA


def _tower(name: str, heights: tuple[float, ...], points: tuple[tuple[int, float], ...]) -> Stick:
    section = Section(E=30e9, G=12e9, A=2.0, Avx=1.0, Avy=1.0, Ix=0.5, Iy=0.5, Iz=0.5)
    floors = [
        Floor(k + 1, 3e5, (1e6, 1e6, 2e6), height, section, below=0.2, above=0.2)
        for k, height in enumerate(heights)
    ]
    return build_stick(name, floors, damping=Rayleigh(4.0, 5e-3), storey_points=points)

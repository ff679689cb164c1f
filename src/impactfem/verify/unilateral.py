"""Unilateral contact: bars against a wall and each other, oscillators, a block on its corners."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse

from impactfem.coupling.body import reduced_body
from impactfem.coupling.contact_loop import ContactHistory, Motion
from impactfem.coupling.links import Assembly, Link
from impactfem.coupling.modal_motion import ModalMotion, body_before_walls
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark, fitted_order

E, S, L, RHO, V0 = 210e9, 3.14e-4, 1.0, 7800.0, 0.1
"""Bar of Siconos's example ImpactingBar [Pa, m2, m, kg/m3, m/s]."""
SPEED = math.sqrt(E / RHO)
CONTACT = 2.0 * L / SPEED  # time in which a wave runs through the bar and back [s]
BAR = RHO * S * L  # mass of the bar [kg]
ELEMENTS = 100
COURANT = 0.25  # way of a wave in a step over the distance of two nodes
ELASTIC, DAMPED = 5e-3, 1e-4
"""Error allowed of the impulse. Undamped, the front of the wave is a jump, which the mesh spreads:
of order 2/3 in its size. Damping spreads it over √(β c/2L) of the contact, 200 steps and more, of
which a rule of second order makes an error of (1/200)² or so; ε counts it more than twice."""
DAMPINGS = (0.02, 0.05)  # β over the time of contact of the undamped bar: ε = 0.78 and 0.65
ACARY = "Acary, ZAMM 96 (2016) 585: Moreau's stepping dissipates"

HEAD_ON = (12, 25, 50, 100)  # elements of the shorter one of two bars
OSCILLATORS = np.array([[3.0e6, 1.5e6], [3.0e6 * 11.0**2, 1.5e6 * 8.0**2]])
"""Masses [kg] and stiffnesses [N/m] of two oscillators that hit each other."""
AMPLITUDE, SHAKEN, APART, RESTITUTION = 3.0, 9.0, 0.02, 0.6
"""Ground acceleration [m/s2] and its angular frequency [rad/s]; gap [m]; e."""
OSCILLATORS_END = 3.0

MASS, INERTIA = 2.0, 0.3  # of the block [kg, kg m2]
CORNERS = np.array([[-1.0, -1.0], [0.5, -0.8]])
"""Columns: how far heave y and (small) rotation bring each corner down; distances in m."""
NEAR = np.array([[-1.0, -1.0], [0.15, -0.2]])
"""Corners so near the mass centre that an impulse on one lifts the other, too."""
GRAVITY = 9.81
START = np.array([0.3, 0.05]), np.array([0.0, 0.4])  # height and rotation, and their velocities


@dataclass(frozen=True)
class Impact:
    """Impact of a bar on a wall: time from the first to the last force [s], impulse [N s]."""

    duration: float
    impulse: float

    @property
    def force(self) -> float:
        """Mean force [N]."""
        return self.impulse / self.duration

    @property
    def epsilon(self) -> float:
        """Speed of the mass centre afterwards over that before [-]."""
        return self.impulse / (BAR * V0) - 1.0


@benchmark("unilateral bar", "closed form (d'Alembert); Siconos, example ImpactingBar")
def unilateral_bar(rows: Rows) -> None:
    """The undamped bar: F = ρ c S v₀ for 2L/c, then it flies back with all of its speed.

    Each end of the contact is known to a step: the duration to two of the 1600 steps.
    """
    _impact_rows(rows, 0.0, Impact(CONTACT, 2.0 * BAR * V0), ELASTIC)


@benchmark(source="series of modes of the bar held at the wall, until its force there is zero")
def unilateral_damped_bar(rows: Rows) -> None:
    """Bars with C = β K, against the series of the bar whose end is held while it is in contact.

    The duration is known to two steps, as without damping, and so is the mean force; impulse and ε
    are not counted in steps.
    """
    for share in DAMPINGS:
        rows.name, beta = f"unilateral bar, β c/2L = {share}", share * CONTACT
        _impact_rows(rows, beta, held_bar(beta), DAMPED)


def _impact_rows(rows: Rows, beta: float, exact: Impact, allowed: float) -> None:
    counted = 2.0 * _step(ELEMENTS) / exact.duration
    for solver, run in SOLVERS.items():
        history = run(ELEMENTS, beta)
        found, coarse = impact_of(history), impact_of(run(ELEMENTS // 4, beta))
        better = abs(found.impulse - exact.impulse) / abs(coarse.impulse - exact.impulse)
        pushed = np.flatnonzero(history.impulse[:, 0])
        missing = pushed[-1] - pushed[0] + 1 - pushed.size
        energy, left = history.energy, history.residual.max()
        rows.where = solver
        rows.add("force, mean of the contact", exact.force, found.force, "N", max(allowed, counted))
        rows.add("duration", exact.duration, found.duration, "s", counted)
        rows.add("impulse", exact.impulse, found.impulse, "N s", allowed)
        rows.add("ε by the impulse", exact.epsilon, found.epsilon, "-", allowed)
        coarser = "error of the impulse over that of a mesh and a step four times as coarse"
        rows.add(coarser, 0.0, better, "-", 0.5, "the method converges")
        for quantity, value, most, source in (
            ("steps without a force during the contact", missing, 0.0, "one contact"),
            ("energy gained in contact, over all", energy.gained, 1e-12, ACARY),
            ("residual of the energy identity", energy.residual, 1e-9, "exact for the rule"),
            ("residual of complementarity", left, 1e-9, "exact solution"),
        ):
            rows.add(quantity, 0.0, value, "-", most, source)


def held_bar(beta: float) -> Impact:
    """The impact of a bar with damping.

    Its end stays at the wall until the force is zero. Meanwhile, with κ = (2n − 1) π/2L, ω = c κ
    and the response g of an oscillator ω, βω²/2 to a unit impulse,

        F = 2 E S v₀/L Σ (g + β ġ),   momentum = 2 ρ S v₀/L Σ ġ/κ².
    """
    kappa = (np.arange(1, 3001, dtype=np.float64) - 0.5) * math.pi / L
    omega = SPEED * kappa
    decay = 0.5 * beta * omega**2
    s2 = -decay - np.sqrt(decay**2 - omega**2 + 0j)
    s1 = omega**2 / s2

    def sums(t: float) -> tuple[float, float]:
        e1, e2 = np.exp(s1 * t), np.exp(s2 * t)
        g, rate = (e1 - e2) / (s1 - s2), (s1 * e1 - s2 * e2) / (s1 - s2)
        force = 2.0 * E * S * V0 / L * np.sum(g + beta * rate).real
        return float(force), float(2.0 * RHO * S * V0 / L * np.sum(rate / kappa**2).real)

    # The wave is back a little before or after 2L/c, spread by the damping.
    times = CONTACT * np.linspace(0.05, 1.5, 300)
    negative = next(k for k, t in enumerate(times) if sums(float(t))[0] < 0.0)
    end = scipy.optimize.brentq(lambda t: sums(t)[0], times[negative - 1], times[negative])
    return Impact(float(end), BAR * V0 - sums(float(end))[1])


def bar_matrices(
    elements: int, length: float = L
) -> tuple[scipy.sparse.csr_matrix, scipy.sparse.csr_matrix]:
    """K and M of the bar in quadratic elements; the first node is that at the wall."""
    h = length / elements
    k = E * S / (3.0 * h) * np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]])
    m = RHO * S * h / 30.0 * np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]])
    nodes = 2 * np.arange(elements)[:, None] + np.arange(3)
    rows, columns = np.repeat(nodes, 3, axis=1).ravel(), np.tile(nodes, 3).ravel()
    K, M = (
        scipy.sparse.coo_matrix((np.tile(local.ravel(), elements), (rows, columns))).tocsr()
        for local in (k, m)
    )
    return K, M


def modal_bar(elements: int, beta: float) -> ContactHistory:
    """Compute the impact by all modes of the bar."""
    K, M = (matrix.toarray() for matrix in bar_matrices(elements))
    values, shapes = scipy.linalg.eigh(K, M)
    bar = body_before_walls(np.maximum(values, 0.0), shapes[:1].T, Rayleigh(beta=beta))
    motion = ModalMotion(bar, _step(elements))
    return _flown(motion, elements, V0 * shapes.T @ M.sum(axis=1))


def full_bar(elements: int, beta: float) -> ContactHistory:
    """Compute the impact in full order."""
    from impactfem.verify.full_order import FullMotion

    K, M = bar_matrices(elements)
    n = K.shape[0]
    wall = scipy.sparse.csr_matrix(([1.0], ([0], [0])), shape=(n, 1))
    with FullMotion(K, M, wall, _step(elements), damping=Rayleigh(beta=beta)) as motion:
        return _flown(motion, elements, np.full(n, V0))


SOLVERS: dict[str, Callable[[int, float], ContactHistory]] = {"modal": modal_bar, "full": full_bar}


def impact_of(history: ContactHistory) -> Impact:
    """Return the impact of a history, from its first force to its last."""
    impulse = history.impulse[:, 0]
    pushed = np.flatnonzero(impulse)
    step = history.time[1] - history.time[0]
    return Impact(float((pushed[-1] - pushed[0] + 1) * step), float(impulse.sum()))


def _step(elements: int) -> float:
    return COURANT * L / (2 * elements) / SPEED


def _flown(motion: Motion, elements: int, velocity: Array) -> ContactHistory:
    """Compute the impact; the bar meets the wall inside a step, not at its end."""
    step = _step(elements)
    gap, steps = 3.3 * V0 * step, round(1.5 * CONTACT / step)
    return unilateral_response(motion, gap, steps, velocity=velocity)


@benchmark("bars head-on", "St Venant, J. Math. Pures Appl. 12 (1867) 237: d'Alembert's waves")
def bars_head_on(rows: Rows) -> None:
    """A bar hits one at rest, as long as it or twice as long: F = ρ c S v₀/2 for 2L/c.

    The waves stop the first bar, and the second one has all of its momentum: the restitution of
    the mass centres is the ratio of the lengths, though nothing is lost.
    """
    for ratio in (1, 2):
        rows.name = f"bars head-on, lengths 1 : {ratio}"
        errors = []
        for elements in HEAD_ON:
            impact, after, history = head_on(elements, ratio)
            errors.append(abs(impact.impulse / (BAR * V0) - 1.0))
        # The front reaches over two nodes.
        counted = 2.0 / COURANT * _step(elements) / CONTACT
        rows.add("force, mean of the contact", 0.5 * BAR * V0 / L * SPEED, impact.force, "N", 0.01)
        rows.add("duration", CONTACT, impact.duration, "s", counted)
        rows.add("impulse", BAR * V0, impact.impulse, "N s", ELASTIC)
        speeds = ["speed afterwards of the first bar, over v₀", "of the second bar"]
        rows.add(speeds, [0.0, 1.0 / ratio], after / V0, "-", ELASTIC, absolute=True)
        restitution = (after[1] - after[0]) / V0
        rows.add("restitution of the mass centres", 1.0 / ratio, restitution, "-", 2.0 * ELASTIC)
        order = fitted_order(1.0 / np.array(HEAD_ON), errors)
        source = "the front of a jump spreads over the power 2/3 of the mesh"
        rows.add("fitted order of the impulse", 2.0 / 3.0, order, "-", 0.4, source, absolute=True)
        lost = after[0] + ratio * after[1] - V0
        rows.add("momentum lost, over m v₀", 0.0, lost / V0, "-", 1e-10, "action and reaction")
        energy = history.energy
        rows.add("energy gained in contact, over all", 0.0, energy.gained, "-", 1e-12, ACARY)
        rows.add("residual of the energy identity", 0.0, energy.residual, "-", 1e-9, "exact")
        _, swapped, _ = head_on(elements, ratio, swapped=True)
        apart = np.abs(swapped + after).max() / V0
        rows.add("the same with both bars swapped", 0.0, apart, "-", 1e-10, "symmetry")


def head_on(
    elements: int, ratio: int, *, swapped: bool = False
) -> tuple[Impact, Array, ContactHistory]:
    """A bar flies against one of `ratio` times its length at rest, or the same the other way.

    Gives the impact, whose force is at least half of the exact one, and the speeds of the mass
    centres afterwards: of the first bar, then of the second.
    """
    bodies, start, centre = [], [], []
    order = (("second", ratio), ("first", 1)) if swapped else (("first", 1), ("second", ratio))
    for name, factor in order:
        K, M = (A.toarray() for A in bar_matrices(factor * elements, factor * L))
        values, shapes = scipy.linalg.eigh(K, M)
        # The first node is the end that meets the other bar.
        ports = {"end": shapes[:1]}
        bodies.append(reduced_body(name, np.maximum(values, 0.0), Rayleigh(), ports))
        centre.append(shapes.T @ M.sum(axis=1) / (factor * BAR))
        start.append((-V0 if swapped else V0) * (name == "first") * factor * BAR * centre[-1])
    ends = [(name, "end") for name, _ in order]
    link = Link("bars", ends[0], ends[1], np.ones(1), 3.3 * V0 * _step(elements))
    step, probes = _step(elements), scipy.linalg.block_diag(*(c[:, None] for c in centre))
    motion = ModalMotion(Assembly(bodies, [link]), step, probes=probes)
    steps, v0 = round((1.5 + ratio) * CONTACT / step), np.concatenate(start)
    history = unilateral_response(motion, link.gap, steps, velocity=v0)
    pushed = np.flatnonzero(history.force[:, 0] > 0.25 * BAR * V0 / L * SPEED)
    impact = Impact(float(pushed[-1] - pushed[0] + 1) * step, float(history.impulse.sum()))
    return impact, history.velocity[-1, ::-1] if swapped else history.velocity[-1], history


@benchmark("oscillators against each other", "free flights in closed form, Newton's impacts")
def colliding_oscillators(rows: Rows) -> None:
    """Two oscillators on shaking ground, 2 cm apart, that bounce off each other with e = 0.6."""
    u, v, count = collided(OSCILLATORS_END, RESTITUTION)
    found = [_colliding(steps) for steps in (2000, 16000)]
    errors = np.zeros(len(found))
    for k, (what, exact) in enumerate((("displacement", u), ("velocity", v))):
        size = np.abs(exact).max()
        quantities = [f"{what} of mass {i} after {count} impacts, over the larger" for i in (1, 2)]
        rows.add(quantities, exact / size, found[-1][k] / size, "-", 5e-3, absolute=True)
        errors += [np.abs(one[k] - exact).max() / size for one in found]
    better = "errors over those with steps eight times as long"
    rows.add(better, 0.0, errors[1] / errors[0], "-", 0.5, "the instant is known to a step")


def collided(end: float, e: float) -> tuple[Array, Array, int]:
    """Displacements and velocities at the end, and the number of impacts, from flight to flight.

    Between impacts u = a cos ωt + b sin ωt − A/(ω² − Ω²) sin Ωt, from rest.
    """
    omega, forced = np.sqrt(OSCILLATORS[1] / OSCILLATORS[0]), AMPLITUDE
    particular = -forced / (omega**2 - SHAKEN**2)
    m, u, v, now, count = OSCILLATORS[0], np.zeros(2), np.zeros(2), 0.0, 0

    def state(t: float) -> tuple[Array, Array]:
        a = u - particular * np.sin(SHAKEN * now)
        b = (v - particular * SHAKEN * np.cos(SHAKEN * now)) / omega
        c, s = np.cos(omega * (t - now)), np.sin(omega * (t - now))
        return (
            a * c + b * s + particular * np.sin(SHAKEN * t),
            omega * (b * c - a * s) + particular * SHAKEN * np.cos(SHAKEN * t),
        )

    def opening(t: float) -> float:
        x, _ = state(t)
        return float(APART + x[1] - x[0])

    while True:
        times = np.linspace(now, end, 20001)[1:]
        closed = [k for k, t in enumerate(times) if opening(t) < 0.0]
        if not closed:
            return *state(end), count
        before = times[closed[0] - 1] if closed[0] else now + 1e-9
        hit = float(scipy.optimize.brentq(opening, before, times[closed[0]], xtol=1e-14))
        u, v = state(hit)
        impulse = (1.0 + e) * (v[0] - v[1]) / np.sum(1.0 / m)
        u, v, now, count = u, v + np.array([-impulse, impulse]) / m, hit, count + 1


def _colliding(steps: int) -> tuple[Array, Array]:
    """Return displacements and velocities at the end by Moreau's stepping."""
    m, k = OSCILLATORS
    names, root = ("left", "right"), np.sqrt(m)
    bodies = [
        reduced_body(name, k[i : i + 1] / m[i], Rayleigh(), {"mass": np.array([[1.0 / root[i]]])})
        for i, name in enumerate(names)
    ]
    link = Link("both", ("left", "mass"), ("right", "mass"), np.ones(1), APART)
    both, load, probes = Assembly(bodies, [link]), -root[:, None], np.diag(1.0 / root)
    motion = ModalMotion(both, OSCILLATORS_END / steps, load=load, probes=probes)
    time = np.linspace(0.0, OSCILLATORS_END, steps + 1)
    ground = AMPLITUDE * np.sin(SHAKEN * time)[:, None]
    history = unilateral_response(motion, APART, steps, amplitudes=ground, restitution=RESTITUTION)
    return history.displacement[-1], history.velocity[-1]


@benchmark("landing block", "momentum of a rigid body, all sets of corners compared")
def landing_block(rows: Rows) -> None:
    """Impulses and velocities of landings at once on both corners, and a series of bounces."""
    inverse = np.diag([1.0 / MASS, 1.0 / INERTIA])
    for name, corners, v0 in (
        ("flat on near corners", NEAR, np.array([-1.0, 0.0])),
        ("turning fast on near corners", NEAR, np.array([-1.0, 4.0])),
        ("turning on far corners", CORNERS, np.array([-1.0, -1.0])),
    ):
        # Nothing bounces. The impulses stop some corners; of the four sets, it is the one in which
        # they push and the other corners go up.
        for some in ([], [0], [1], [0, 1]):
            G, impulse = corners[:, some], np.zeros(2)
            impulse[some] = np.linalg.solve(G.T @ inverse @ G, G.T @ v0) if some else 0.0
            v1 = v0 - inverse @ corners @ impulse
            if np.all(impulse >= 0.0) and np.all(corners.T @ v1 <= 1e-14):
                break
        history = unilateral_response(_block(corners, 1e-3), 0.0, 10, velocity=_modal(v0))
        for what, unit, exact, computed in (
            ("impulse on corner", "N s", impulse, history.impulse.sum(axis=0)),
            ("velocity afterwards", "m/s, rad/s", v1, history.velocity[-1]),
        ):
            quantities = [f"{name}: {what} {k}" for k in (1, 2)]
            rows.add(quantities, exact, computed, unit, 1e-10, absolute=True)
    end, e = 0.6, 0.8
    x, _, count = bounced(end, e)
    # The same, step by step, from a tilted start above the ground.
    steps, (x0, v0) = 12000, map(_modal, START)
    block, gravity = _block(CORNERS, end / steps), np.ones((steps + 1, 1))
    found = unilateral_response(
        block, 0.0, steps, displacement=x0, velocity=v0, amplitudes=gravity, restitution=e
    )
    after = f"after {count} bounces with e = {e:g} under gravity"
    source = "flights and impacts in turn, each in closed form"
    for k, (what, unit) in enumerate((("height", "m"), ("rotation", "rad"))):
        rows.add(f"{what} {after}", x[k], found.displacement[-1, k], unit, 0.005, source)


def bounced(end: float, e: float) -> tuple[Array, Array, int]:
    """Bounces from impact to impact: position and velocity at the end, and their number.

    The end must come before the bounces, shorter and shorter, do.
    """
    x, v = (part.copy() for part in START)
    time, count = 0.0, 0
    inverse = np.array([1.0 / MASS, 1.0 / INERTIA])
    while True:
        # Room of each corner after t: room + rate t - g t²/2.
        room, rate = -CORNERS.T @ x, -CORNERS.T @ v
        flight = (rate + np.sqrt(rate**2 + 2.0 * GRAVITY * np.maximum(room, 0.0))) / GRAVITY
        corner = int(np.argmin(flight))
        t = min(float(flight[corner]), end - time)
        x = x + v * t - np.array([0.5 * GRAVITY * t**2, 0.0])
        v = v - np.array([GRAVITY * t, 0.0])
        time += t
        if time >= end:
            return x, v, count
        g = CORNERS[:, corner]
        v = v - inverse * g * (1.0 + e) * (g @ v) / (g @ (inverse * g))
        x = x - g * (g @ x) / (g @ g)
        count += 1


def _block(corners: Array, step: float) -> ModalMotion:
    """The block's two modes, both free: y and rotation, each of unit modal mass."""
    root = np.sqrt([[MASS], [INERTIA]])
    load, probes = np.array([[-MASS * GRAVITY], [0.0]]) / root, np.diag(1.0 / root[:, 0])
    block = body_before_walls(np.zeros(2), corners / root)
    return ModalMotion(block, step, load=load, probes=probes)


def _modal(x: Array) -> Array:
    return np.asarray(np.sqrt([MASS, INERTIA]) * x, dtype=np.float64)

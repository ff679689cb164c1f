"""Bars that fly against a rigid wall by unilateral contact, with and without damping."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse
from numpy.typing import NDArray

from impactfem.coupling.contact_history import ContactHistory
from impactfem.coupling.unilateral import unilateral_response
from impactfem.coupling.unilateral_modal import ModalMotion
from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.row import Row

Array = NDArray[np.float64]

E, S, L, RHO, V0 = 210e9, 3.14e-4, 1.0, 7800.0, 0.1
"""Bar of Siconos's example ImpactingBar [Pa, m2, m, kg/m3, m/s]."""
SPEED = math.sqrt(E / RHO)
CONTACT = 2.0 * L / SPEED
"""Time in which a wave runs through the bar and back [s]."""
MASS = RHO * S * L
ELEMENTS = 100
COURANT = 0.25
"""Way of a wave in a step over the distance of two nodes."""
ELASTIC, DAMPED = 5e-3, 1e-4
"""Error allowed of the impulse. Undamped, the front of the wave is a jump, which the mesh spreads:
of order 2/3 in its size. Damping spreads it over √(β c/2L) of the contact, 200 steps and more, of
which a rule of second order makes an error of (1/200)² or so; ε counts it more than twice."""
DAMPINGS = (0.02, 0.05)
"""β over the time of contact of the undamped bar: ε = 0.78 and 0.65."""
TERMS = 3000


@dataclass(frozen=True)
class Impact:
    """What a bar and its wall exchange.

    Args:
        duration: From the first force to the last [s].
        impulse: Of the wall on the bar [N s].
    """

    duration: float
    impulse: float

    @property
    def force(self) -> float:
        """Mean force [N]."""
        return self.impulse / self.duration

    @property
    def epsilon(self) -> float:
        """Speed of the mass centre afterwards over that before [-]."""
        return self.impulse / (MASS * V0) - 1.0


def elastic_bar() -> list[Row]:
    """The undamped bar: F = ρ c S v₀ for 2L/c, then it flies back with all of its speed.

    Each end of the contact is known to a step: the duration to two of the 1600 steps.
    """
    exact = Impact(CONTACT, 2.0 * MASS * V0)
    source = "closed form (d'Alembert); Siconos, example ImpactingBar"
    return _rows("unilateral bar", 0.0, exact, ELASTIC, source)


def damped_bar() -> list[Row]:
    """Bars with C = β K, against the series of the bar whose end is held while it is in contact.

    The duration is known to two steps, as without damping, and so is the mean force; impulse and ε
    are not counted in steps.
    """
    rows = []
    for share in DAMPINGS:
        beta = share * CONTACT
        source = "series of modes of the bar held at the wall, until its force there is zero"
        rows += _rows(f"unilateral bar, β c/2L = {share}", beta, held_bar(beta), DAMPED, source)
    return rows


def held_bar(beta: float) -> Impact:
    """The impact of a bar with damping.

    Its end stays at the wall until the force is zero. Meanwhile, with κ = (2n − 1) π/2L, ω = c κ
    and the response g of an oscillator ω, βω²/2 to a unit impulse,

        F = 2 E S v₀/L Σ (g + β ġ),   momentum = 2 ρ S v₀/L Σ ġ/κ².
    """
    kappa = (np.arange(1, TERMS + 1, dtype=np.float64) - 0.5) * math.pi / L
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
    return Impact(float(end), MASS * V0 - sums(float(end))[1])


def bar_matrices(elements: int) -> tuple[scipy.sparse.csr_matrix, scipy.sparse.csr_matrix]:
    """K and M of the bar in quadratic elements; the first node is that at the wall."""
    h = L / elements
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
    """The impact by all modes of the bar."""
    K, M = bar_matrices(elements)
    values, shapes = scipy.linalg.eigh(K.toarray(), M.toarray())
    momentum = shapes.T @ (M @ np.ones(len(values)))
    motion = ModalMotion(
        np.maximum(values, 0.0), shapes[:1].T, _step(elements), damping=Rayleigh(beta=beta)
    )
    gap, steps = _gap(elements), _steps(elements)
    return unilateral_response(motion, gap, steps, velocity=V0 * momentum)


def full_bar(elements: int, beta: float) -> ContactHistory:
    """The impact in full order."""
    from petsc4py import PETSc

    from impactfem.stages.calibrate.unilateral_full import FullMotion

    K, M = (
        PETSc.Mat().createAIJ(A.shape, csr=(A.indptr, A.indices, A.data), comm=PETSc.COMM_SELF)
        for A in bar_matrices(elements)
    )
    n = K.getSize()[0]
    wall = scipy.sparse.csr_matrix(([1.0], ([0], [0])), shape=(n, 1))
    with FullMotion(K, M, wall, _step(elements), damping=Rayleigh(beta=beta)) as motion:
        history = unilateral_response(
            motion, _gap(elements), _steps(elements), velocity=np.full(n, V0)
        )
    K.destroy()
    M.destroy()
    return history


SOLVERS: dict[str, Callable[[int, float], ContactHistory]] = {"modal": modal_bar, "full": full_bar}


def impact_of(history: ContactHistory) -> Impact:
    """The impact that a history holds, from its first force to its last."""
    impulse = history.impulse[:, 0]
    pushed = np.flatnonzero(impulse)
    step = history.time[1] - history.time[0]
    return Impact(float((pushed[-1] - pushed[0] + 1) * step), float(impulse.sum()))


def _step(elements: int) -> float:
    return COURANT * L / (2 * elements) / SPEED


def _gap(elements: int) -> float:
    # The end meets the wall inside a step, not at its end.
    return 3.3 * V0 * _step(elements)


def _steps(elements: int) -> int:
    return round(1.5 * CONTACT / _step(elements))


def _rows(name: str, beta: float, exact: Impact, allowed: float, source: str) -> list[Row]:
    rows = []
    counted = 2.0 * _step(ELEMENTS) / exact.duration
    tolerances = {"force": max(allowed, counted), "duration": counted, "impulse": allowed}
    for solver, run in SOLVERS.items():
        history = run(ELEMENTS, beta)
        found, coarse = impact_of(history), impact_of(run(ELEMENTS // 4, beta))
        for quantity, unit in (("force", "N"), ("duration", "s"), ("impulse", "N s")):
            tolerance = tolerances[quantity]
            what = f"{quantity}, mean of the contact" if quantity == "force" else quantity
            pair = getattr(exact, quantity), getattr(found, quantity)
            rows.append(Row(name, f"{what}, {solver}", *pair, unit, tolerance, source))
        rows.append(
            Row(
                name,
                f"ε by the impulse, {solver}",
                exact.epsilon,
                found.epsilon,
                "-",
                allowed,
                source,
            )
        )
        impulse = history.impulse[:, 0]
        pushed = np.flatnonzero(impulse)
        worse = abs(coarse.impulse - exact.impulse)
        for what, value, most, why in (
            (
                "error of the impulse over that of a mesh and a step four times as coarse",
                abs(found.impulse - exact.impulse) / worse,
                0.5,
                "the method converges",
            ),
            (
                "steps without a force during the contact",
                float(pushed[-1] - pushed[0] + 1 - pushed.size),
                0.0,
                "one contact",
            ),
            (
                "energy gained in contact, over all",
                history.energy.gained,
                1e-12,
                "Acary, ZAMM 96 (2016) 585: Moreau's stepping dissipates",
            ),
            (
                "residual of the energy identity",
                history.energy.residual,
                1e-9,
                "exact for the rule",
            ),
            ("residual of complementarity", float(history.residual.max()), 1e-9, "exact solution"),
        ):
            rows.append(Row(name, f"{what}, {solver}", 0.0, value, "-", most, why, absolute=True))
    return rows

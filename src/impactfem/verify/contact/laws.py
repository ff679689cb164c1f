"""Contact laws: restitution asked and obtained, and the impacting bar made of many segments."""

from __future__ import annotations

import numpy as np

from impactfem.coupling.contact import (
    Law,
    hertz,
    hertz_damp,
    hunt_crossley,
    jankowski,
    kelvin_voigt,
)
from impactfem.coupling.impacts import impacts
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, build_stick
from impactfem.verify.contact.models import collision
from impactfem.verify.row import Row

ASKED = (0.414, 0.65, 0.687, 0.891)
STEPS = 800
"""Time steps of an impact."""
ALLOWED = {
    "hertz": 1e-9,
    "hertz-damp": (np.pi / STEPS) ** 2,
    "hunt-crossley": (np.pi / STEPS) ** 2,
    "jankowski": 2e-4,
}
"""Error of the restitution. The force of Hertz, with or without damping by p^1.5, begins smoothly:
second order, (π/800)² = 1.5e-5. Without damping nothing is lost but by terms of fourth order,
(π/800)⁴ = 2e-10. Jankowski's begins as p^0.25: order 1.25, 800^-1.25 = 2e-4."""


def restitution_tables() -> list[Row]:
    """Each law's restitution by the program's collision, against the law's own closed relation.

    The published relations of Hertz-damp and Hunt-Crossley hold for ε near 1: at 0.414 they return
    0.70 and 0.63. With the exact relation the collision returns what is asked. Jankowski's
    published relation is right within 0.01.

    At the onset of hertz-damp the speed falls by (Ωt)^2.5, 3e-6 in the 200 steps that are looked
    at, so that its power is known to 1e-5. Jankowski's force has, beside p^0.25, a part p^1.5:
    (Ωt)^1.25 or some 1e-3 of it. The jump of Kelvin-Voigt is read half of a step back along a
    straight line, (ΩΔt)² = 1e-9.
    """
    K, m1, m2, speed = 2.75e9, 1574e3, 3014e3, 0.3
    mass = m1 * m2 / (m1 + m2)
    undamped = hertz(K, mass)
    rows = [_row(undamped, "ε = 1", 1.0, _collided(undamped, m1, m2, speed), "Hertz 1881: no loss")]
    for asked in ASKED:
        for exact in (False, True):
            relation = "exact" if exact else "published"
            damped = "∫ m v dv over F = K p^1.5 (1 + χ v/v₀): ln((1+χ)/(1-χε)) = χ(1+ε)"
            for law, source in (
                (hertz_damp(K, asked, mass, exact=exact), damped),
                (hunt_crossley(K, asked, mass, exact=exact), damped),
                (
                    jankowski(K, asked, mass, exact=exact),
                    "integration of x'' = -x^1.5 - 2ξ x^0.25 x' to rest (DOP853)",
                ),
            ):
                rows.append(
                    _row(
                        law,
                        f"ε = {asked} asked, {relation} damping",
                        asked if exact else law.epsilon,
                        _collided(law, m1, m2, speed),
                        source,
                    )
                )
    # What happens at onset, from collisions in very short steps; the gap closes half a step early.
    early, late = 20, 200
    for law, power, allowed in (
        (kelvin_voigt(1e11, 0.12, mass), None, 1e-8),
        (hertz_damp(K, 0.65, mass), 1.5, 1e-5),
        (jankowski(K, 0.65, mass), 0.25, 5e-3),
    ):
        F = collision(law, m1, m2, speed, 1e-5 * law.duration(speed), phase=0.5).force[:, 0]
        F = F[np.flatnonzero(F)[0] :]
        if power is None:
            jump = float(2.0 * 0.12 * np.sqrt(1e11 * mass) * speed)
            found = float(1.5 * F[0] - 0.5 * F[1])
            row = ("the jump", jump, found, "N", allowed, "C v₀ with C = 2 ξ √(K m)")
        else:
            growth = np.log(F[late] / F[early]) / np.log((late + 0.5) / (early + 0.5))
            source = "no jump: F ~ K p^1.5, or 2 ξ √(K m) p^0.25 v₀, with p = v₀ t"
            what = "power of the time with which it grows"
            row = (what, power, float(growth), "-", allowed, source)
        rows.append(Row("force at onset", f"{law.name}, {row[0]}", *row[1:]))
    return rows


def impacting_bar() -> list[Row]:
    """A steel bar of 1 m flies at 0.1 m/s against a rigid wall (Siconos' example ImpactingBar).

    A compression wave runs through the bar and back: F = ρ c S v₀ for 2 L / c, impulse 2 m v₀,
    rebound with the full speed. The bar is a stick of 400 segments on its end, tied to the ground
    by nothing that counts; the wall is a stiff elastic contact. The segments spread the front of
    the wave over (1/400)^(2/3) of its way or so, hence 1 %; of the impulse, which the speed
    afterwards counts twice, a half of it.
    """
    E, S, L, rho, v0, n = 210e9, 3.14e-4, 1.0, 7800.0, 0.1, 400
    h = L / n
    c = np.sqrt(E / rho)
    section = Section(E, E / 2.6, S, S, S, 1e-8, 1e-8, 1e-8)
    loose = Section(E * 1e-12, E, S * 1e-6, S, S, 1e-8, 1e-8, 1e-8)
    none = Rayleigh(0.0, 0.0)
    ends = rho * S * h / 2.0
    floors = [
        Floor(k + 1, ends if k in (0, n) else 2.0 * ends, (1e-3,) * 3, h, section, none)
        for k in range(n + 1)
    ]
    floors[0] = Floor(1, ends, (1e-3,) * 3, h, loose, none)
    bar = build_stick("bar", floors)
    K = 0.5 * E * S / h
    pair = Pair(
        "wall",
        End("bar", n, (0.0, 0.0, 0.0), n + 1),
        None,
        np.array([0.0, 0.0, 1.0]),
        1e-7,
        kelvin_voigt(K, 0.0, ends, tension=False),
    )
    dt = 0.25 * h / c
    start = np.zeros(bar.n)
    start[2::6] = v0
    end = 1.3 * 2.0 * L / c
    response = simulate(System((bar,), (pair,)), np.zeros((int(end / dt), 3)), dt, v0=start)
    F = response.force[:, 0]
    pushed = np.flatnonzero(F > 0.0)
    duration = float(response.time[pushed[-1]] - response.time[pushed[0]])
    impulse = float(np.sum(F) * dt)
    masses = np.diag(bar.M)[2::6]
    rebound = -float(masses @ response.v[-1, 2::6] / masses.sum())
    source = "closed form of the elastic bar; Siconos, example ImpactingBar"
    force = rho * c * S * v0
    return [
        Row("impacting bar", "mean force", float(force), impulse / duration, "N", 0.01, source),
        Row("impacting bar", "duration", float(2.0 * L / c), duration, "s", 0.01, source),
        Row("impacting bar", "impulse", 2.0 * rho * S * L * v0, impulse, "N s", 5e-3, source),
        Row("impacting bar", "speed of the mass centre after", v0, rebound, "m/s", 0.01, source),
    ]


def _collided(law: Law, m1: float, m2: float, speed: float) -> float:
    dt = law.duration(speed) / STEPS
    return impacts(collision(law, m1, m2, speed, dt, phase=0.5))[0].restitution


def _row(law: Law, quantity: str, reference: float, computed: float, source: str) -> Row:
    name, allowed = f"restitution, {law.name}", ALLOWED[law.name]
    return Row(name, quantity, reference, computed, "-", allowed, source)

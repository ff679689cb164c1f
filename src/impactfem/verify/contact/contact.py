"""Contact: a shock on a wall, the Kelvin-Voigt closed forms, restitution asked and obtained."""

from __future__ import annotations

import numpy as np

from impactfem.coupling import restitution
from impactfem.coupling.contact import Law, kelvin_voigt
from impactfem.coupling.impacts import impacts
from impactfem.coupling.pounding import Update
from impactfem.sticks.stick import mass_on_spring
from impactfem.verify.contact.models import against_wall, collision, fitted_order
from impactfem.verify.row import Row


def shock_on_wall() -> list[Row]:
    """SDND101: m = 100 kg on k = 1e4 N/m hits a wall of 1e6 N/m at 1 m/s, undamped, no gap.

    With Ω = √((k + K)/m): F = K v₀/Ω, half a period π/Ω in contact, impulse 2 K v₀/Ω², and the
    second contact after half a period of the free mass on k. A step of 1e-5 s has (ΩΔt)² = 1e-6.
    Times of the largest force are those of a step, 6e-4 of the first and 3e-5 of the second; the
    duration is read inside the steps.
    """
    m, k, K, v0 = 100.0, 1e4, 1e6, 1.0
    response = against_wall(
        mass_on_spring("m", m, k), kelvin_voigt(K, 0.0, m), 0.0, v0, 1e-5, 40001
    )
    first, second = impacts(response)[:2]
    source = "code_aster validation manual V5.01.101 (SDND101) and its closed form"
    rows = (
        ("largest force", 9950.3719, first.peak_force, "N", 1e-6),
        ("time of the largest force", 0.0156298, first.peak_time, "s", 7e-4),
        ("duration of contact", 0.0312594, first.duration, "s", 1e-4),
        ("impulse", 198.0198, first.impulse, "N s", 1e-6),
        ("rebound speed", 1.0, first.separation, "m/s", 1e-6),
        ("time of the second largest force", 0.36105, second.peak_time, "s", 3e-5),
    )
    return [
        Row("SDND101 shock on a wall", quantity, reference, computed, unit, tolerance, source)
        for quantity, reference, computed, unit, tolerance in rows
    ]


def kelvin_voigt_closed_forms() -> list[Row]:
    """A free floor of 3014 t at 0.163 m/s against a wall with K = 1e11 N/m and ξ = 0.12.

    x = (v₀/Ω_D) exp(-ξΩt) sin Ω_D t; the force at onset is C v₀, at release -C ε v₀. The contact
    begins at a time step: with 4000 steps an impact, duration and restitution are right to
    (π/4000)², 6e-7. Forces are those of a step: the largest one is right to about one part in 4000,
    and the first one is a step after onset, ΩΔt/2ξ = 3.3e-3 above.
    """
    K, xi, v0 = 1e11, 0.12, 0.163
    rows = []
    source = "closed form of the damped half-oscillation (Anagnostopoulos 1988)"
    for m, label in ((3014e3, "3014 t"), (1507e3, "1507 t"), (787e3, "787 t")):
        law = kelvin_voigt(K, xi, m)
        steps = 4000
        dt, second = law.duration(v0) / steps, (np.pi / steps) ** 2
        response = against_wall(mass_on_spring("m", m, 0.0), law, 0.0, v0, dt, 2 * steps)
        impact = impacts(response)[0]
        omega = np.sqrt(K / m)
        omega_d = omega * np.sqrt(1.0 - xi**2)
        t = np.linspace(0.0, np.pi / omega_d, 2_000_001)
        decay = v0 * np.exp(-xi * omega * t)
        x = decay / omega_d * np.sin(omega_d * t)
        v = decay * (np.cos(omega_d * t) - xi * omega / omega_d * np.sin(omega_d * t))
        F = K * x + law.parameters[1] * v
        name = f"Kelvin-Voigt impact, {label}"
        rows += [
            Row(name, "largest force", float(F.max()), impact.peak_force, "N", 2e-4, source),
            Row(name, "duration", float(t[-1]), impact.duration, "s", second, source),
            Row(name, "restitution", float(-v[-1] / v0), impact.restitution, "-", second, source),
            Row(
                name,
                "force at onset",
                float(F[0]),
                float(response.force[impact.first, 0]),
                "N",
                4e-3,
                source,
            ),
        ]
    return rows


def restitution_obtained() -> list[Row]:
    """Restitution asked of the law and obtained by collisions of two floors.

    The gap closes somewhere inside a step, and a law that jumps there is off by a part of that
    step either way: the mean over that phase is compared, at 16 and at 100 steps an impact. The
    lagged force, equation 2 as the paper prints it, acts one step late, which is a negative damping
    -K Δt: the reference is what one expects then, ξ_c less K Δt / (2 √(K m)).
    """
    m1, m2, K = 1574e3, 3014e3, 1e11
    mass = m1 * m2 / (m1 + m2)
    rows = []
    for epsilon in (0.414, 0.687, 0.891):
        for tension in (True, False):
            law = kelvin_voigt(
                K, restitution.kelvin_voigt_xi(epsilon, tension=tension), mass, tension=tension
            )
            source = (
                "paper, equation 4" if tension else "Schwager and Pöschel 2007, Granular Matter 9"
            )
            for steps, tolerance in ((16, 0.01), (100, 5e-4)):
                rows.append(
                    Row(
                        f"restitution {'with' if tension else 'without'} tension",
                        f"ε = {epsilon}, mean with {steps} steps an impact",
                        epsilon,
                        _mean_restitution(law, m1, m2, law.duration(0.3) / steps, "implicit"),
                        "-",
                        tolerance,
                        source,
                    )
                )
    dt, xi = 16.79 / 50_000, 0.12
    for m1, m2, label in (
        (3014e3, 1e18, "floor of 3014 t against a wall"),
        (3014e3, 3014e3, "two floors of 3014 t"),
        (1574e3, 1574e3, "two floors of 1574 t"),
    ):
        mass = m1 * m2 / (m1 + m2)
        law = kelvin_voigt(K, xi, mass)
        late = xi - K * dt / (2.0 * np.sqrt(K * mass))
        cases: tuple[tuple[Update, float], ...] = (("implicit", xi), ("lagged", late))
        for update, asked in cases:
            rows.append(
                Row(
                    f"restitution, {update} force",
                    f"{label}, ξ = 0.12, step 0.3358 ms",
                    restitution.kelvin_voigt(asked),
                    _mean_restitution(law, m1, m2, dt, update),
                    "-",
                    2e-3,
                    "paper, equation 4"
                    + (
                        "" if update == "implicit" else " with the damping of a force one step late"
                    ),
                )
            )
    return rows


def _mean_restitution(law: Law, m1: float, m2: float, dt: float, update: Update) -> float:
    """Mean over 32 places of the step where the gap closes."""
    found = [
        impacts(collision(law, m1, m2, 0.3, dt, phase=phase, update=update))[0].restitution
        for phase in (np.arange(32) + 0.5) / 32.0
    ]
    return float(np.mean(found))


def contact_energy_order() -> list[Row]:
    """Energy that the time stepping loses or adds in contact: its fitted order in the step.

    An elastic contact leaves ½ K p₁ |p₀| where the gap closes inside a step, second order; the
    force of Kelvin-Voigt jumps there and leaves a part of Δt C v₀², first order. The mean of the
    size is taken over the place in the step where the gap closes.
    """
    m, K, v0 = 1507e3, 1e11, 0.3
    rows = []
    for xi, expected, label in ((0.0, 2.0, "elastic"), (0.12, 1.0, "Kelvin-Voigt")):
        law = kelvin_voigt(K, xi, m)
        # Not a whole number of steps an impact: its end would fall on the phase of its start.
        counts = np.array([20, 40, 80, 160, 320]) + 1.0 / np.pi
        defects = []
        for count in counts:
            dt = law.duration(v0) / count
            found = [
                abs(impacts(collision(law, 2.0 * m, 2.0 * m, v0, dt, phase=phase))[0].defect)
                for phase in (np.arange(32) + 0.5) / 32.0
            ]
            defects.append(np.mean(found) / (0.5 * m * v0**2))
        rows.append(
            Row(
                "contact energy defect",
                f"fitted order in the step, {label}",
                expected,
                fitted_order(np.asarray(1.0 / counts, dtype=float), np.array(defects)),
                "-",
                0.05,
                "Taylor expansion of the work in the step where the gap closes",
                absolute=True,
            )
        )
    return rows

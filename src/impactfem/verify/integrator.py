"""The time integration: order 2, and the discrete energy identity."""

from __future__ import annotations

import numpy as np

from impactfem.coupling.contact import effective_mass, kelvin_voigt
from impactfem.coupling.energy import energy_balance
from impactfem.coupling.pounding import End, Load, Pair, System, simulate
from impactfem.sticks.stick import mass_on_spring
from impactfem.verify.contact.models import Y, fitted_order
from impactfem.verify.row import Row


def order() -> list[Row]:
    """An oscillator of 2 Hz and 5 % on ground that moves with 1.3 Hz, from rest.

    Exact: the steady state a₀ / (ω² - Ω² + 2iξωΩ) and the free vibration that cancels it at t = 0.
    With the longest step (ωΔt)² = 0.06, which changes the fitted order by less than 0.02.
    """
    omega, xi, drive, a0 = 4.0 * np.pi, 0.05, 2.6 * np.pi, 1.0
    stick = mass_on_spring("m", 1.0, omega**2, dashpot=2.0 * xi * omega)
    omega_d = omega * np.sqrt(1.0 - xi**2)
    # Ground a₀ sin(Ω t): relative displacement Im(X exp(iΩt)) + free part.
    X = -a0 / (omega**2 - drive**2 + 2j * xi * omega * drive)
    x0, v0 = X.imag, (1j * drive * X).imag
    end = 3.0
    free = np.exp(-xi * omega * end) * (
        -x0 * np.cos(omega_d * end) - (v0 + xi * omega * x0) / omega_d * np.sin(omega_d * end)
    )
    exact = float((X * np.exp(1j * drive * end)).imag + free)
    counts = np.array([150, 300, 600, 1200, 2400])
    errors = []
    for count in counts:
        ground = np.zeros((count + 1, 3))
        ground[:, 1] = a0 * np.sin(drive * np.linspace(0.0, end, count + 1))
        response = simulate(System((stick,), ()), ground, end / count)
        computed = float(response.u[-1, 1])
        errors.append(abs(computed - exact))
    return [
        Row(
            "Newmark, average acceleration",
            "fitted order in the step",
            2.0,
            fitted_order(1.0 / counts, np.array(errors)),
            "-",
            0.02,
            "Newmark 1959; closed form of the harmonic oscillator",
            absolute=True,
        ),
        Row(
            "Newmark, average acceleration",
            "relative displacement after 3 s in 2400 steps",
            exact,
            computed,
            "m",
            2e-4,
            "closed form of the harmonic oscillator",
        ),
    ]


def pulse() -> list[Row]:
    """A force of half a sine on an undamped oscillator, of 2/5 and of 3/2 of its period T.

    With r = T/(2 t_d) = Ω/ω, u k/P₀ = (sin Ωt − r sin ωt)/(1 − r²) while it lasts, and then a free
    vibration of the amplitude 2 r |cos(π/(2 r))| / |1 − r²|. During a pulse of 3/2 T the largest
    response is at Ωt = 2π Ω/(Ω + ω), 1.5 for r = 1/3.
    """
    mass, f, force, dt = 2e3, 5.0, 1e4, 1e-5
    stick = mass_on_spring("m", mass, frequency=f)
    omega = 2.0 * np.pi * f
    time = dt * np.arange(round(0.6 / dt) + 1)
    rows = []
    for periods in (0.4, 1.5):
        lasts = periods / f
        r = 0.5 / periods
        shape = np.where(time <= lasts, np.sin(np.pi * time / lasts), 0.0)
        load = Load(End.of_floor(stick, 1), Y, force * shape)
        system = System((stick,), ())
        found = simulate(system, np.zeros((len(time), 3)), dt, loads=[load]).u[:, 1]
        factor = found * mass * omega**2 / force
        exact = (np.sin(r * omega * time) - r * np.sin(omega * time)) / (1.0 - r**2)
        during = time <= lasts
        after = 2.0 * r * abs(np.cos(np.pi / (2.0 * r))) / abs(1.0 - r**2)
        name, source = "half-sine pulse", "Chopra, Dynamics of Structures, section 4.8"
        away = float(np.abs(factor[during] - exact[during]).max())
        what = f"pulse of {periods:g} periods"
        rows += [
            Row(
                name,
                f"largest difference of the dynamic factor, {what}",
                0.0,
                away,
                "-",
                1e-5,
                source,
                absolute=True,
            ),
            Row(
                name,
                f"largest dynamic factor after it, {what}",
                after,
                float(np.abs(factor[~during]).max()),
                "-",
                1e-5,
                source,
                absolute=True,
            ),
        ]
    peak = float(factor[during].max())
    rows.append(
        Row(name, f"largest dynamic factor during it, {what}", 1.5, peak, "-", 1e-5, source)
    )
    return rows


def energy_identity() -> list[Row]:
    """Two damped oscillators that pound under random ground motion: the identity step by step."""
    rng = np.random.default_rng(7)
    ground = np.zeros((5001, 3))
    ground[:, 1] = np.cumsum(rng.standard_normal(5001)) * 0.1
    m1, m2 = 3014e3, 1574e3
    sticks = (
        mass_on_spring("1", m1, m1 * 11.0**2, dashpot=0.1 * m1),
        mass_on_spring("2", m2, m2 * 8.0**2, dashpot=0.1 * m2),
    )
    law = kelvin_voigt(1e11, 0.12, effective_mass(m1, m2))
    ends = [End(name, 0, (0.0, 0.0, 0.0), 1) for name in "12"]
    system = System(sticks, (Pair("1-2", ends[0], ends[1], Y, 0.01, law),))
    response = simulate(system, ground, 3e-4)
    return [
        Row(
            "energy identity",
            "residual over the largest energy, with impacts",
            0.0,
            energy_balance(response).residual,
            "-",
            1e-9,
            "average acceleration conserves the discrete balance (Hughes 1983)",
            absolute=True,
        ),
        Row(
            "energy identity",
            "impacts happened (at least one)",
            1.0,
            float(bool(response.force.any())),
            "-",
            0.0,
            "the row above would be empty without",
        ),
    ]

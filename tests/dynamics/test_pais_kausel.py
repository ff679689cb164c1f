"""Rectangular rafts on soil: damping of each component, and resonances of tall buildings.

The formulas of Pais and Kausel are written anew here, from tables 2-2 and 2-3 of NIST GCR
12-917-21, and are taken at each frequency as they are.
"""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.impedance import hysteresis
from impactfem.dynamics.soil import HalfSpace, raft_mass, soil_of
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, build_stick

DENSITY = 1900.0


def formulas(length, width, embedment, speed, poisson, omega):
    """Dynamic stiffness of the six components, shape (6, n)."""
    B, r = min(length, width) / 2.0, max(length, width) / min(length, width)
    a, d, ν = omega * B / speed, embedment / B, poisson
    ψ = min(np.sqrt(2.0 * (1.0 - ν) / (1.0 - 2.0 * ν)), 2.5)
    sway = 1.0 + (0.33 + 1.34 / (1.0 + r)) * d**0.8
    K = np.array(
        [
            (6.8 * r**0.65 + 2.4) / (2.0 - ν) * sway,
            (6.8 * r**0.65 + 0.8 * r + 1.6) / (2.0 - ν) * sway,
            (3.1 * r**0.75 + 1.6) / (1.0 - ν) * (1.0 + (0.25 + 0.25 / r) * d**0.8),
            (3.2 * r + 0.8) / (1.0 - ν) * (1.0 + d + 1.6 / (0.35 + r) * d**2),
            (3.73 * r**2.4 + 0.27) / (1.0 - ν) * (1.0 + d + 1.6 / (0.35 + r**4) * d**2),
            (4.25 * r**2.45 + 4.06) * (1.0 + (1.3 + 1.32 / r) * d**0.9),
        ]
    )
    p = [
        0.0,
        0.0,
        0.4 + 0.2 / r,
        0.55 + 0.01 * np.sqrt(r - 1.0),
        0.55,
        0.33 - 0.03 * np.sqrt(r - 1),
    ]
    q = [1.0, 1.0, 10.0 / (1.0 + 3.0 * (r - 1.0)), 2.4 - 0.4 / r**3, 0.6 + 1.4 / r**3]
    q = [*q, 0.8 / (1.0 + 0.33 * (r - 1.0))]
    k = np.array([1.0 - one * a**2 / (other + a**2) for one, other in zip(p, q, strict=True)])
    b_y = 1.8 / (1.0 + 1.75 * (r - 1.0))
    b_x = b_y if d > 0.0 else 2.2 - 0.4 / r**3
    twist = 3.0 * r * d + ψ * r**3 * d + 3.0 * r**2 * d + ψ * d + r**3 + r
    rising = [
        (d + d**3 + ψ * r * d**3 + 3.0 * d * r + ψ * r, b_x, (ψ * r + 1.0) * d**3),
        (r**3 * d + ψ * d**3 * r + d**3 + 3.0 * d * r**2 + ψ * r**3, b_y, (r + ψ) * d**3),
        (twist, 1.4 / (1.0 + 3.0 * (r - 1.0) ** 0.7), 0.0),
    ]
    straight = [r + d * (ψ + r), r + d * (1.0 + ψ * r), ψ * r + d * (1.0 + r)]
    dashpots = [4.0 * one + 0.0 * a for one in straight]
    dashpots += [4.0 / 3.0 * (c * a**2 / (b + a**2) + rest) for c, b, rest in rising]
    size = DENSITY * speed**2 * np.array([B] * 3 + [B**3] * 3)
    S = size[:, None] * (K[:, None] * k + 1j * a * np.array(dashpots))
    return S if length >= width else S[[1, 0, 2, 4, 3, 5]]


SHAPES = [
    (20.0, 20.0, 0.0),
    (40.0, 20.0, 0.0),
    (20.0, 30.0, 0.0),
    (20.0, 20.0, 5.0),
    (100.0, 20.0, 0.0),
    (60.0, 20.0, 8.0),
]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("poisson", [0.25, 0.35, 0.45])
def test_errors_of_stiffness_and_damping(shape, poisson):
    """Those that the soil states are those against the formulas; of 2:1 they are small.

    Up to a₀ = 0.8, where tall buildings have their first modes.
    """
    speed, B = 250.0, 10.0
    components, curves = HalfSpace(speed, DENSITY, poisson).rectangle(*shape)
    ω = np.geomspace(0.05, 0.8, 200) * speed / B
    exact = formulas(*shape, speed, poisson, ω)
    found = np.array([one.at(ω) for one in components])
    floor = 0.01 * np.abs(exact)
    stiffness = (np.abs((found - exact).real) / np.abs(exact)).max(axis=1)
    damping = (np.abs((found - exact).imag) / np.maximum(exact.imag, floor)).max(axis=1)
    stated = soil_of(components, np.zeros((6, 6)), curves).errors(ω[0], ω[-1])
    assert stated == pytest.approx(np.array([stiffness, damping]).T, rel=0.05, abs=1e-3)
    if shape[2] == 0.0 and shape[0] < 50.0:
        assert stiffness.max() < 0.03 and damping.max() < 0.1
    # At rest both have the same stiffness; the damping of rocking begins with the same power.
    slow = np.array([1e-4, 1e-3]) * speed / B
    exact, found = (
        formulas(*shape, speed, poisson, slow),
        np.array([one.at(slow) for one in components]),
    )
    assert found.real == pytest.approx(exact.real, rel=1e-5)
    power = np.log10(found.imag[:, 1] / found.imag[:, 0])
    assert power == pytest.approx(np.log10(exact.imag[:, 1] / exact.imag[:, 0]), abs=0.01)


def tower(height, length, width, soil, frequency):
    """Floors of 0.3 t/m3, that shear as a column with this first frequency [Hz] on a clamped base.

    Rayleigh damping of 3 % at this and at three times this frequency.
    """
    n = round(height / 3.0)
    mass = length * width * 3.0 * 300.0
    k = mass * (2.0 * np.pi * frequency * 2.0 * n / np.pi) ** 2
    section = Section(
        E=30e9, G=12.5e9, A=20 * k * 3 / 12.5e9, Avx=k * 3 / 12.5e9, Avy=k * 3 / 12.5e9,
        Ix=2e3, Iy=2e3, Iz=2e3,
    )  # fmt: skip
    inertia = tuple(mass / 12.0 * x for x in (width**2, length**2, length**2 + width**2))
    floors = [Floor(j + 1, mass, inertia, 3.0, section) for j in range(n)]
    plain = build_stick("a", floors)
    ω = np.sqrt(scipy.linalg.eigh(plain.K, plain.M, eigvals_only=True)[0])
    damping = Rayleigh(2.0 * 0.03 * 0.75 * ω, 2.0 * 0.03 / (4.0 * ω))
    return build_stick("a", floors, damping=damping, soil=soil), ω


def transfer(stick, S, omega, axis):
    """Acceleration of the roof over that of the ground along an axis, by S of shape (n, 6, 6)."""
    R, M, r = stick.rigid_body(), stick.M, np.eye(6)[:, axis]
    heavy = R.T @ M @ R + stick.soil.raft
    roof = []
    for ω, below in zip(omega, S, strict=True):
        own = stick.K + 1j * ω * stick.C - ω**2 * M
        whole = np.block([[own, -(ω**2) * M @ R], [-(ω**2) * R.T @ M, below - ω**2 * heavy]])
        x = np.linalg.solve(whole, -np.concatenate([M @ R @ r, heavy @ r]))
        roof.append(1.0 - ω**2 * (x[: stick.n] + R @ x[stick.n :])[axis - 6])
    return np.abs(roof)


def resonances(height, plan, speed, poisson=0.35, embedment=0.0, ratio=0.0, altered=lambda m: m):
    """Transfer functions by the model and by the formulas, up to twice the first frequency.

    Along x and y, shape (2, 2, n).
    """
    components, curves = HalfSpace(speed, DENSITY, poisson).rectangle(*plan, embedment)
    x, y = plan
    raft = raft_mass(x * y * 3750.0, 1.5, (y**2 / 12.0, x**2 / 12.0))
    soil = soil_of(altered(components), raft, curves, ratio)
    stick, first = tower(height, *plan, soil, 46.0 / height)
    ω = np.linspace(0.3, 2.0, 240) * first
    exact = formulas(*plan, embedment, speed, poisson, ω)
    if ratio > 0.0:
        # The causal damping of the material that the model has.
        material = hysteresis(ratio, 2.0 * np.pi, 40.0 * np.pi).at(ω)
        exact = exact + np.array([[one.stiffness] for one in components]) * material
    exact = np.array([np.diag(S) for S in exact.T])
    model = soil.impedance(ω)
    return np.array([[transfer(stick, S, ω, k) for k in (0, 1)] for S in (model, exact)])


@pytest.mark.parametrize("height", [30.0, 45.0])
@pytest.mark.parametrize(
    ("speed", "poisson", "ratio"),
    [(150.0, 0.35, 0.0), (150.0, 0.25, 0.0), (250.0, 0.45, 0.0), (400.0, 0.35, 0.0),
     (200.0, 0.35, 0.03)],
)  # fmt: skip
def test_a_tall_building_on_a_square_raft(height, speed, poisson, ratio):
    model, exact = resonances(height, (20.0, 20.0), speed, poisson, ratio=ratio)
    assert np.abs(model / exact - 1.0).max() < 0.02


@pytest.mark.parametrize("height", [30.0, 45.0])
@pytest.mark.parametrize(
    ("plan", "embedment"),
    [((40.0, 20.0), 0.0), ((20.0, 60.0), 0.0), ((20.0, 20.0), 5.0), ((40.0, 20.0), 5.0)],
)
def test_resonances_on_other_rafts(height, plan, embedment):
    """Their height, on soil as soft as is usual."""
    model, exact = resonances(height, plan, 150.0, embedment=embedment)
    assert model.max(axis=-1) == pytest.approx(exact.max(axis=-1), rel=0.02)


def test_a_spring_and_dashpot_in_series_are_seen():
    """A spring k with a dashpot in series adds damping that begins with ω, not with ω³.

    Of 2 % of K it is 1 % of the modulus, and the resonance is lower by 5 % or more.
    """

    def altered(components):
        rate = 0.3 * 150.0 / 10.0
        rocking = (replace(m, branches=((0.02 * m.stiffness, rate),)) for m in components[3:5])
        return [*components[:3], *rocking, components[5]]

    model, exact = resonances(45.0, (20.0, 20.0), 150.0, altered=altered)
    assert (model.max(axis=-1) < 0.95 * exact.max(axis=-1)).all()
    components, curves = HalfSpace(150.0, DENSITY, 0.35).rectangle(20.0, 20.0)
    ω = np.array([0.3, 0.8]) * 150.0 / 10.0
    assert np.abs(altered(components)[3].at(ω) / components[3].at(ω) - 1.0).max() < 0.03
    errors = soil_of(altered(components), np.zeros((6, 6)), curves).errors(*ω)
    assert (errors[3:5, 1] > 0.5).all() and (errors[3:5, 0] < 0.03).all()

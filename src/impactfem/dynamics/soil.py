"""A rigid raft and the soil under it.

The half-space has the shear-wave speed c_s, the density ρ, Poisson's ratio ν and G = ρ c_s². There
is no kinematic interaction: under waves that come up vertically a raft on the surface moves as the
free field does, and an embedded one is taken to.

**Rectangles**, half-length L along the longer side, half-width B, depth D of the underside, a₀ =
ω B/c_s: Pais and Kausel, Approximate formulas for dynamic stiffnesses of rigid foundations, Soil
Dynamics and Earthquake Engineering 7 (1988) 213, as in tables 2-2 and 2-3 of NIST GCR 12-917-21
(2012). Sway and rocking are not coupled. The real and the imaginary parts do not belong to one
causal model. A stable model is fitted to them for 0.02 ≤ a₀ ≤ 4
(:mod:`impactfem.dynamics.impedance`), with their static stiffness, and in rotation with their
dashpot at rest.

**Disks**, and rafts of the same area or moments of inertia: the cones of Wolf, Foundation Vibration
Analysis Using Simple Physical Models (1994), table 2-3A, exactly (1) of that module.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from impactfem.dynamics.impedance import Curve, Impedance, Misfit, assembled, fitted, hysteresis
from impactfem.system.arrays import Array, Complex

LOWEST, HIGHEST = 0.02, 4.0  # a₀ of the fit to the formulas of Pais and Kausel
BAND = (0.5, 50.0)  # frequencies that a table of impedances has at the least [Hz]
MATERIAL = (1.0, 20.0)  # frequencies between which the damping of the material is constant [Hz]
MOST_DAMPED = 0.2
"""Largest damping ratio of the material. At 0.27 nothing would hold the building at rest, and from
0.1 on its softness below 5 Hz is more than a fifth; US NRC SRP 3.7.2 allows 0.15."""
SPEEDS = 2.5  # largest ratio ψ of the speed of Lysmer's analogue to c_s


@dataclass(frozen=True, eq=False)
class Soil:
    """Matrices of raft and soil about the base of a building, without the building.

    The first six rows are the motion of the base relative to the free field, x, y, z, rx, ry, rz;
    the others are degrees of freedom in the soil.
    """

    raft: Array  #: mass of the raft, shape (6, 6) [kg, kg m, kg m2]
    M: Array  #: mass of soil that moves with the raft, or on its own, shape (n, n)
    C: Array  #: all dashpots, shape (n, n) [N s/m, N s, N m s]
    K: Array  #: stiffness, shape (n, n) [N/m, N, N m]
    material: Array  #: part of C by the damping of the material, the rest radiates, shape (n, n)
    #: Errors of the model against the formulas or the table, by component; empty: it is exact.
    misfits: tuple[Misfit, ...] = ()

    def __len__(self) -> int:
        return len(self.M)

    def moved(self, T: Array) -> "Soil":
        """About another point, whose motion gives that of this one by T, shape (6, 6)."""
        whole = np.eye(len(self))
        whole[:6, :6] = T
        M, C, K, material = (
            whole.T @ matrix @ whole for matrix in (self.M, self.C, self.K, self.material)
        )
        return replace(self, raft=T.T @ self.raft @ T, M=M, C=C, K=K, material=material)

    @property
    def static(self) -> Array:
        """Stiffness at rest, shape (6, 6) [N/m, N, N m]."""
        # What a dashpot alone holds does not resist at rest.
        inner = np.linalg.pinv(self.K[6:, 6:], hermitian=True)
        return np.asarray(self.K[:6, :6] - self.K[:6, 6:] @ inner @ self.K[6:, :6])

    def errors(self, low: float = 0.0, high: float = np.inf) -> Array:
        """Return the largest errors in a band [rad/s]: stiffness and damping, shape (6, 2) [-]."""
        return np.array([one.largest(low, high) for one in self.misfits] or np.zeros((6, 2)))

    def impedance(self, omega: Array) -> Complex:
        """S(ω) without the raft's mass, shape (n_f, 6, 6), at ω of shape (n_f,) [rad/s]."""
        found = np.empty((len(omega), 6, 6), dtype=np.complex128)
        for k, w in enumerate(omega):
            S = self.K + 1j * w * self.C - w**2 * self.M
            found[k] = S[:6, :6]
            if len(S) > 6:
                found[k] -= S[:6, 6:] @ np.linalg.solve(S[6:, 6:], S[6:, :6])
        return found


@dataclass(frozen=True)
class HalfSpace:
    """A uniform half-space."""

    shear_velocity: float  #: c_s [m/s]
    density: float  #: ρ [kg/m3]
    poisson_ratio: float  #: ν [-]

    @property
    def shear_modulus(self) -> float:
        """G [Pa]."""
        return self.density * self.shear_velocity**2

    def rectangle(
        self, length: float, width: float, embedment: float = 0.0
    ) -> tuple[list[Impedance], list[Curve]]:
        """Of a raft of length along x and width along y, by Pais and Kausel.

        Models of the six components, and the formulas that they were fitted to.
        """
        B, long = 0.5 * min(length, width), length >= width
        found = _pais_kausel(max(length, width) / 2.0 / B, embedment / B, self.poisson_ratio)
        # Along the longer side, across it, and the rotations about these; else x and y swap.
        order = [0, 1, 2, 3, 4, 5] if long else [1, 0, 2, 4, 3, 5]
        G, rate = self.shear_modulus, self.shear_velocity / B
        force = [G * (B if k < 3 else B**3) for k in order]
        models = [found[k][0].scaled(size, rate) for k, size in zip(order, force, strict=True)]
        curves = [found[k][1].scaled(size, rate) for k, size in zip(order, force, strict=True)]
        return models, curves

    def cones(self, area: float, inertia: tuple[float, float]) -> list[Impedance]:
        """Of a raft by its area [m2] and second moments about x and y [m4], by Wolf's cones."""
        ρ, ν, c_s = self.density, self.poisson_ratio, self.shear_velocity
        squeezed = max(ν - 1.0 / 3.0, 0.0)
        # Above ν = 1/3 the speed is held, and a mass of soil moves with the raft.
        c = 2.0 * c_s if squeezed else c_s * math.sqrt(2.0 * (1.0 - ν) / (1.0 - 2.0 * ν))
        r = math.sqrt(area / math.pi)

        def translation(z: float, speed: float, mass: float) -> Impedance:
            return Impedance(ρ * speed**2 * area / z, ρ * speed * area, mass)

        def rotation(J: float, z: float, speed: float, mass: float) -> Impedance:
            # S = K (1 − b²/3/(1 + b²) + i b/3 b²/(1 + b²)) with b = ω z/c and K = 3 ρ c² J/z.
            return Impedance(3.0 * ρ * speed**2 * J / z, 0.0, mass, ((ρ * J * z, speed / z),))

        across = translation(math.pi / 8.0 * (2.0 - ν) * r, c_s, 0.0)
        rocking = []
        for J in inertia:
            r_J = (4.0 * J / math.pi) ** 0.25
            z = 9.0 * math.pi / 32.0 * (1.0 - ν) * (c / c_s) ** 2 * r_J
            rocking.append(rotation(J, z, c, 1.2 * squeezed * ρ * r_J**5))
        upright = math.pi / 4.0 * (1.0 - ν) * (c / c_s) ** 2 * r
        polar = sum(inertia)
        twist = 9.0 * math.pi / 32.0 * (2.0 * polar / math.pi) ** 0.25
        return [
            across,
            across,
            translation(upright, c, 2.4 * squeezed * ρ * area * r),
            *rocking,
            rotation(polar, twist, c_s, 0.0),
        ]


def soil_of(
    components: list[Impedance],
    raft: Array,
    curves: Sequence[Curve] = (),
    ratio: float = 0.0,
) -> Soil:
    """Soil of six impedances, a raft's mass about the same point, and a damping of the material.

    The curves are what the impedances were fitted to; without, they are exact.
    """
    M, C, K = assembled(components)
    material = np.zeros_like(C)
    low, high = (2.0 * math.pi * f for f in MATERIAL)
    if ratio > 0.0:
        unit, ω = hysteresis(ratio, low, high), np.geomspace(low, high, 60)
        added = [unit.scaled(one.stiffness, 1.0) for one in components]
        exact = curves or [Curve(ω, one.at(ω)) for one in components]
        # K + 2iζ K in place of K.
        curves = [
            Curve(curve.omega, curve.S + 2.0j * ratio * one.stiffness)
            for curve, one in zip(exact, components, strict=True)
        ]
        _, C_m, K_m = assembled(added)
        n, extra = len(M), len(C_m) - 6
        at = [*range(6), *range(n, n + extra)]
        M, C, K, material = (np.pad(one, (0, extra)) for one in (M, C, K, material))
        material[np.ix_(at, at)] = C_m
        C = C + material
        K[np.ix_(at, at)] += K_m
    else:
        added = [Impedance(0.0)] * len(components)
    misfits = tuple(
        curve.misfit(one.at(curve.omega) + own.at(curve.omega))
        for curve, one, own in zip(curves, components, added, strict=False)
    )
    return Soil(raft, M, C, K, material, misfits)


def raft_mass(mass: float, thickness: float, gyration: tuple[float, float]) -> Array:
    """Mass of a raft about the middle of its top, shape (6, 6) [kg, kg m, kg m2].

    By mass [kg], thickness [m] and squares of the radii of gyration of its plan about x and y [m2].
    """
    (x, y), z = gyration, -0.5 * thickness
    up = thickness**2 / 12.0 + z**2
    M = mass * np.diag([1.0, 1.0, 1.0, x + up, y + up, x + y])
    # The centre moves by θ × (0, 0, z).
    M[0, 4] = M[4, 0] = mass * z
    M[1, 3] = M[3, 1] = -mass * z
    return M


@lru_cache(maxsize=32)
def _pais_kausel(r: float, d: float, ν: float) -> tuple[tuple[Impedance, Curve], ...]:
    """Impedances in G B and G B³ at a₀, by L/B and D/B, and what they are fitted to."""
    ψ = min(math.sqrt(2.0 * (1.0 - ν) / (1.0 - 2.0 * ν)), SPEEDS)
    sway, pitch = 1.0 + (0.33 + 1.34 / (1.0 + r)) * d**0.8, 1.0 + d
    # Static stiffness of the raft on the surface (table 2-2a) and embedded (table 2-2b).
    K_x = (6.8 * r**0.65 + 2.4) / (2.0 - ν) * sway
    K_y = (6.8 * r**0.65 + 0.8 * r + 1.6) / (2.0 - ν) * sway
    K_z = (3.1 * r**0.75 + 1.6) / (1.0 - ν) * (1.0 + (0.25 + 0.25 / r) * d**0.8)
    K_xx = (3.2 * r + 0.8) / (1.0 - ν) * (pitch + 1.6 / (0.35 + r) * d**2)
    K_yy = (3.73 * r**2.4 + 0.27) / (1.0 - ν) * (pitch + 1.6 / (0.35 + r**4) * d**2)
    K_zz = (4.25 * r**2.45 + 4.06) * (1.0 + (1.3 + 1.32 / r) * d**0.9)
    a = np.geomspace(LOWEST, HIGHEST, 60)
    # Falling stiffness, 1 − p a²/(q + a²), and rising dashpots, c a²/(b + a²) (tables 2-3a and b).
    falls = {
        "z": (0.4 + 0.2 / r, 10.0 / (1.0 + 3.0 * (r - 1.0))),
        "xx": (0.55 + 0.01 * math.sqrt(r - 1.0), 2.4 - 0.4 / r**3),
        "yy": (0.55, 0.6 + 1.4 / r**3),
        "zz": (0.33 - 0.03 * math.sqrt(r - 1.0), 0.8 / (1.0 + 0.33 * (r - 1.0))),
    }
    b_y = 1.8 / (1.0 + 1.75 * (r - 1.0))
    b_x = b_y if d > 0.0 else 2.2 - 0.4 / r**3
    walls_x = d + d**3 + ψ * r * d**3 + 3.0 * d * r
    walls_y = r**3 * d + ψ * d**3 * r + d**3 + 3.0 * d * r**2
    walls_z = 3.0 * r * d + ψ * r**3 * d + 3.0 * r**2 * d + ψ * d
    rises = {
        "xx": (4.0 / 3.0 * (walls_x + ψ * r), b_x, 4.0 / 3.0 * (ψ * r + 1.0) * d**3),
        "yy": (4.0 / 3.0 * (walls_y + ψ * r**3), b_y, 4.0 / 3.0 * (r + ψ) * d**3),
        "zz": (4.0 / 3.0 * (walls_z + r**3 + r), 1.4 / (1.0 + 3.0 * (r - 1.0) ** 0.7), 0.0),
    }

    def fit(K: float, name: str) -> tuple[Impedance, Curve]:
        p, q = falls[name]
        if name == "z":
            dashpot, at_rest = np.full_like(a, 4.0 * (ψ * r + d * (1.0 + r))), None
        else:
            c, b, at_rest = rises[name]
            dashpot = c * a**2 / (b + a**2) + at_rest
        curve = Curve(a, K * (1.0 - p * a**2 / (q + a**2)) + 1j * a * dashpot)
        return fitted(curve, stiffness=K, dashpot=at_rest, mass=False), curve

    x = Impedance(K_x, 4.0 * (r + d * (ψ + r)))
    y = Impedance(K_y, 4.0 * (r + d * (1.0 + ψ * r)))
    return (
        *((one, Curve(a, one.at(a))) for one in (x, y)),
        *(fit(K, name) for K, name in ((K_z, "z"), (K_xx, "xx"), (K_yy, "yy"), (K_zz, "zz"))),
    )

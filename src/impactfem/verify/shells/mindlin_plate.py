"""Frequencies of a simply supported plate, from thick to thin, against Mindlin's theory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.verify.row import Row, order_at_least
from impactfem.verify.shells.shell_meshes import flat, panel

Array = NDArray[np.float64]

STEEL = Material(E=200e9, nu=0.3, rho=8000.0)
LENGTH = 10.0
SHEAR = 5.0 / 6.0
COUNT = 6
RATIOS = (0.1, 0.01, 0.001)
"""Thickness over length."""
ALLOWED = 1e-5
"""Error of the frequencies on 32 cells a side."""


def simply_supported() -> list[Row]:
    """Hard supports (w and the tangential rotation) on meshes of 8, 16 and 32 cells a side.

    Frequencies of quadratic elements have the order 4; fitted over these meshes 0.2 may be missing.
    """
    return _rows((8, 16, 32), ALLOWED)


def simply_supported_fine() -> list[Row]:
    """The same on 16, 32 and 64 cells a side: an 8th of the error."""
    return _rows((16, 32, 64), ALLOWED / 8.0)


def exact(thickness: float, count: int = COUNT) -> Array:
    """Lowest frequencies of Mindlin's plate, w ~ sin(m π x / L) sin(n π y / L) [Hz].

    With k² = (m² + n²) π² / L², S = κ G t and I = ρ t³ / 12, ω² is the smaller root of
    (S k² − ρ t ω²) (D k² + S − I ω²) = S² k².
    """
    E, nu, rho, t = STEEL.E, STEEL.nu, STEEL.rho, thickness
    D, S = E * t**3 / (12.0 * (1.0 - nu**2)), SHEAR * STEEL.G * t
    mass, rotary = rho * t, rho * t**3 / 12.0
    waves = np.arange(1, 7)
    k2 = np.sort(np.add.outer(waves**2, waves**2).ravel())[:count] * (np.pi / LENGTH) ** 2
    a, b, c = mass * rotary, mass * (D * k2 + S) + rotary * S * k2, S * D * k2**2
    # The smaller root, without the loss of digits of b − √(b² − 4 a c).
    return np.asarray(np.sqrt(2.0 * c / (b + np.sqrt(b**2 - 4.0 * a * c))) / (2.0 * np.pi))


def _rows(cells: tuple[int, ...], allowed: float) -> list[Row]:
    rows = []
    for ratio in RATIOS:
        reference = exact(ratio * LENGTH)
        found = [_frequencies(ratio * LENGTH, n) for n in cells]
        source = "Mindlin 1951, closed form for hard simple supports, κ = 5/6"
        rows += [
            Row(
                f"simply supported plate, t/L = {ratio:g}",
                f"frequency {k + 1}, {cells[-1]} cells a side",
                float(reference[k]),
                float(found[-1][k]),
                "Hz",
                allowed * (1.0 if k < 3 else 2.0),
                source,
            )
            for k in range(COUNT)
        ]
        errors = np.array([abs(f[0] / reference[0] - 1.0) for f in found])
        rows.append(
            order_at_least(
                f"simply supported plate, t/L = {ratio:g}",
                "frequency 1",
                4.0,
                1.0 / np.array(cells),
                errors,
                "twice the order 2 of the strains of quadratic elements",
                0.2,
            )
        )
    return rows


def _frequencies(thickness: float, cells: int) -> Array:
    nodes, triangles = panel(cells, cells, flat((LENGTH, 0.0, 0.0), (0.0, LENGTH, 0.0)), 0.15)
    model = shell_model(nodes, Shells(triangles, thickness, STEEL))
    x, y = nodes[:, 0], nodes[:, 1]
    at_x = (x == 0.0) | (x == LENGTH)
    at_y = (y == 0.0) | (y == LENGTH)
    held = model.hold(x >= 0.0, UX, UY, RZ).hold(at_x, UZ, RX).hold(at_y, UZ, RY)
    return held.modes(COUNT)[0]

"""A device on two supports that move independently: published values, and harmonic motion."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from impactfem.device.anchor_force import anchor_force
from impactfem.device.device import Device
from impactfem.device.from_matrices import from_matrices
from impactfem.device.quantity import Quantities, anchor_forces
from impactfem.device.rules import Rules
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.verify.row import Row

Array = npt.NDArray[np.float64]

SDLD30_SOURCE = "code_aster validation manual V2.01.030 (SDLD30), analytical"
SDLD30_FREQUENCY = (2.18815, 5.30485)  # Hz, of the modes, at which its spectra are given
SDLD30_SPECTRA = ((7.0, 5.0), (12.0, 6.0))  # m/s2, of the supports NO1 and NO4
SDLD30_SHIFTS = (0.04, 0.06)  # m, of the two supports
SDLD30_TABLE = (
    # Quantity, part of the inertia, part of the supports' displacements, both.
    ("displacement of NO2", "m", 0.0412562, 0.0354306, 0.054382),
    ("displacement of NO3", "m", 6.60152e-3, 0.0571746, 0.0575544),
    ("reaction at NO1", "N", 41.2562, 34.3386, 53.6769),
    ("reaction at NO4", "N", 66.0152, 34.3386, 74.412),
)
PRINTED = 1e-5
"""What the digits of the reference are worth."""


def sdld30_device() -> Device:
    """Two masses of 10 kg between two supports, on springs of 1000, 1000 and 10000 N/m."""
    k = (1000.0, 1000.0, 10000.0)
    K = np.zeros((4, 4))
    for i, one in enumerate(k):
        K[i : i + 2, i : i + 2] += one * np.array([[1.0, -1.0], [-1.0, 1.0]])
    M = np.diag([0.0, 10.0, 10.0, 0.0])
    names = ("NO2 x", "NO3 x")
    return from_matrices("SDLD30", M, K, {0: 0, 3: 6}, 0.05, anchors=2, motions=names)


def sdld30() -> list[Row]:
    """SDLD30: two masses and three springs between two supports with spectra of their own.

    The modes, the supports, and the displacements of the supports each by the root of the sum of
    squares.
    """
    device = sdld30_device()
    spectra = [
        AnchorSpectrum(
            "x",
            np.array(SDLD30_FREQUENCY),
            np.array([0.05]),
            np.array([psa]),
            psa[-1],
            anchor,
            shift,
        )
        for anchor, (psa, shift) in enumerate(zip(SDLD30_SPECTRA, SDLD30_SHIFTS, strict=True), 1)
    ]
    zero = np.zeros((2, 12))
    names = tuple(name for name, *_ in SDLD30_TABLE[:2])
    moved = Quantities(names, ("m", "m"), np.eye(2), zero, device.r)
    wanted = moved + anchor_forces(device)
    found = spectrum_analysis(device, spectra, Rules(modes="srss"), wanted)
    where = (*names, "force x at anchor 1", "force x at anchor 2")
    return [
        Row("SDLD30 as a device", f"{name}, {part}", reference, value, unit, PRINTED, SDLD30_SOURCE)
        for (name, unit, *references), own in zip(SDLD30_TABLE, where, strict=True)
        for part, reference, value in zip(
            ("inertia", "supports apart", "both"),
            references,
            (
                float(values[wanted.names.index(own)])
                for values in (found.inertial, found.displacement, found.total)
            ),
            strict=True,
        )
    ]


def harmonic_supports() -> list[Row]:
    """A mass on two springs whose ends move as u₁ sin Ω t and u₂ sin (Ω t + φ).

    With the springs' share Y = (k₁ U₁ + k₂ U₂) / (k₁ + k₂) of the complex amplitudes U, the mass
    moves against Y by X = Ω² Y / (ω² - Ω² + 2 j ξ ω Ω), and the device pulls at its anchor i with
    k_i (Y + X - U_i) + 2 j ξ ω Ω m X k_i / (k₁ + k₂). The motion begins slowly; it is read once
    what this sets free has died away.
    """
    m, k, damping = 400.0, np.array([5.0e6, 2.0e6]), 0.05
    U, phase, drive = np.array([0.002, 0.003]), 1.1, 2.0 * math.pi * 15.0
    K = np.array([[k[0], -k[0], 0.0], [-k[0], k.sum(), -k[1]], [0.0, -k[1], k[1]]])
    M = np.diag([0.0, m, 0.0])
    device = from_matrices("mass", M, K, {0: 1, 2: 7}, damping, anchors=2, motions=("mass y",))
    dt, cycles = 2e-4, 60
    t = np.arange(0.0, cycles * 2.0 * math.pi / drive, dt)
    # A smooth start over 20 cycles, in displacement; its second derivative by the product rule.
    s = np.minimum(t * drive / (40.0 * math.pi), 1.0)
    rate = drive / (40.0 * math.pi)
    rise = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    slope = np.where(s < 1.0, 30.0 * s**2 * (1.0 - s) ** 2 * rate, 0.0)
    bend = np.where(s < 1.0, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * rate**2, 0.0)
    a, u = np.zeros((2, 12, t.size))
    for row, size, lag in ((1, U[0], 0.0), (7, U[1], phase)):
        angle = drive * t + lag
        u[row] = size * rise * np.sin(angle)
        a[row] = size * (
            (bend - rise * drive**2) * np.sin(angle) + 2.0 * slope * drive * np.cos(angle)
        )
    force = anchor_force(device, a, dt, displacement=u).force
    steady = t > 45.0 * 2.0 * math.pi / drive
    both = U * np.exp(1j * np.array([0.0, phase]))
    # The damper acts on the motion against where the anchors carry the mass.
    carried = k @ both / k.sum()
    omega = math.sqrt(k.sum() / m)
    x = drive**2 * carried / (omega**2 - drive**2 + 2j * damping * omega * drive)
    pull = k * (carried + x - both) + (k / k.sum()) * 2j * damping * omega * m * drive * x
    return [
        Row(
            "mass on two shaken supports",
            f"largest force at support {i + 1}",
            float(abs(pull[i])),
            float(np.max(np.abs(force[row, steady]))),
            "N",
            2e-4,
            "closed form: steady state of an oscillator on two springs, 15 Hz, 63 degrees apart",
        )
        for i, row in enumerate((1, 7))
    ]

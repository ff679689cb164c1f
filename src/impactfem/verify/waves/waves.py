"""Waves in a bare slab: the two speeds at which a shock may cross it.

In the plane of a wide slab a plane wave along x is either a shear wave, with displacements along
y, c_T = √(G/ρ), or a plate wave, with displacements along x, c_P = √(E/(ρ (1 − ν²))). Equation 8
of Bodnar et al. 2022 is the first one: 2345 m/s with ρ = 2500 kg/m3, and 6.7 ms for the 15.6 m of
the slab. Their impact is normal to the slab's edge and makes the second, in bare concrete 3708 m/s
and 4.2 ms. Their floor 8 is not bare: with its beams and all that it carries a wave normal to the
edge has √(EA'/m') = 1972 m/s and takes 7.9 ms, which `floor_bar` measures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.verify.row import Row, fitted_order
from impactfem.verify.shells import flat, panel

Array = NDArray[np.float64]

CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
THICKNESS = 0.3
LENGTH, WIDTH, SIZE = 24.0, 1.2, 0.3
FIRST, SECOND = 3.0, 18.6
"""The stations of a pulse, 15.6 m apart: as the edges of the paper's slab."""
PULSE = 6.0
"""Length of the pulse: 20 elements. Its end has passed the second station when its reflection at
the strip's end comes back."""
STEPS = 100
"""Time steps in the time that the pulse takes to pass a point. Average acceleration slows a wave of
that period down by (2π/100)²/12, 0.03 %."""
FORCE = 1e6
PAPER = "Bodnar et al. 2022, equation 8"


@dataclass(frozen=True)
class Wave:
    """A plane wave along x.

    Args:
        name: What it is.
        speed: Exact speed [m/s].
        component: Component of the displacement, UX or UY.
    """

    name: str
    speed: float
    component: int

    @property
    def restrained(self) -> int:
        """The other in-plane component."""
        return UX + UY - self.component


SHEAR = Wave("in-plane shear pulse", math.sqrt(CONCRETE.G / CONCRETE.rho), UY)
PLATE = Wave(
    "edge-normal pulse", math.sqrt(CONCRETE.E / (CONCRETE.rho * (1.0 - CONCRETE.nu**2))), UX
)


def slab_pulses() -> list[Row]:
    """Pulses in a strip of 24 m by 1.2 m of a slab, 30 cm thick, on a distorted mesh.

    A force F(t), half of F₀ (1 − cos 2πt/T), spread over the edge x = 0, sends a pulse of velocity
    F(t − x/c)/(ρ c A). Along the long edges the displacement that the wave has not is restrained:
    u_x for the shear wave, u_y for the plate wave. So the strip is cut from a slab without end;
    with free long edges it would bend, or stretch as a bar at √(E/ρ). Drilling rotations follow
    the shear wave, θ = ½ u_y,x; their inertia slows a wave of the wavelength λ down by
    (2π t/λ)²/96, 0.1 % here, and average acceleration slows both down by 0.03 %. So 0.1 % is
    allowed of the plate wave, 0.5 % of the shear wave, whose pulse changes its shape a little, and
    1 % beside the two digits of the paper's 6.7 ms.

    The speed is the stations' distance over the delay of largest correlation.
    """
    shear, plate = (_pulse(wave) for wave in (SHEAR, PLATE))
    distance = SECOND - FIRST
    rows = []
    for wave, (delay, peak), allowed in ((SHEAR, shear, 5e-3), (PLATE, plate, 1e-3)):
        formula = "√(G/ρ)" if wave is SHEAR else "√(E/(ρ (1 − ν²)))"
        rows += [
            Row(
                "slab strip",
                f"speed, {wave.name}",
                wave.speed,
                distance / delay,
                "m/s",
                allowed,
                f"closed form: {formula}",
            ),
            Row(
                "slab strip",
                f"peak velocity, {wave.name}",
                FORCE / (CONCRETE.rho * wave.speed * THICKNESS * WIDTH),
                peak,
                "m/s",
                allowed,
                "closed form: F/(ρ c A)",
            ),
        ]
    rows += [
        Row(
            "slab strip",
            f"time to cross 15.6 m, {SHEAR.name}",
            6.7e-3,
            shear[0],
            "s",
            0.01,
            f"{PAPER}: T = 15.6 m/c_T. This is the paper's crossing",
        ),
        Row(
            "slab strip",
            f"time to cross 15.6 m, {PLATE.name}",
            distance / PLATE.speed,
            plate[0],
            "s",
            1e-3,
            "closed form, bare concrete; the paper's floor 8, with what it carries, takes 7.9 ms",
        ),
    ]
    return rows


def wave_speed_order() -> list[Row]:
    """Speed of standing plate waves in a strip of 6 m, one wavelength long, on three meshes.

    Held at its ends, the strip has the frequency c/λ with λ = 6 m.
    """
    counts = np.array([4, 6, 8])
    speeds = np.array([PULSE * _standing(int(count)) for count in counts])
    return [
        Row(
            "slab strip",
            "speed, standing plate wave, 8 elements a wavelength",
            PLATE.speed,
            float(speeds[-1]),
            "m/s",
            1e-3,
            "closed form: √(E/(ρ (1 − ν²)))",
        ),
        Row(
            "slab strip",
            "order of the speed's error in the element's size",
            4.0,
            fitted_order(PULSE / counts, np.abs(speeds / PLATE.speed - 1.0)),
            "-",
            0.05,
            "quadratic elements: twice their degree",
        ),
    ]


def _pulse(wave: Wave) -> tuple[float, float]:
    """Delay [s] between the stations, and the largest velocity [m/s] at the second one."""
    strip = flat((LENGTH, 0.0, 0.0), (0.0, WIDTH, 0.0))
    nodes, triangles = panel(round(LENGTH / SIZE), round(WIDTH / SIZE), strip, 0.2)
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    model = model.hold(x >= 0.0, UZ, RX, RY)  # a flat slab does not leave its plane
    model = model.hold((y == 0.0) | (y == y.max()), wave.restrained)
    along = np.eye(3)[wave.component]
    load = model.edge_load(x == 0.0, (FORCE * along[0], FORCE * along[1], 0.0))
    duration = PULSE / wave.speed
    dt = duration / STEPS
    time = dt * np.arange(math.ceil((SECOND + PULSE + SIZE) / wave.speed / dt))
    amplitude = np.where(time < duration, 0.5 - 0.5 * np.cos(2.0 * np.pi * time / duration), 0.0)
    stations = [int(np.argmin(np.abs(x - s) + y)) for s in (FIRST, SECOND)]
    probes = model.rows(stations, wave.component)
    history = model.transient(load, amplitude, dt, probes=probes)
    velocity = history.motion["velocity"]
    return dt * _lag(*velocity.T), float(velocity[:, 1].max())


def _lag(first: Array, second: Array) -> float:
    """Delay of the second signal in steps, where the parabola through the correlations peaks."""
    correlation = np.correlate(second, first, mode="full")
    k = int(np.argmax(correlation))
    before, at, after = correlation[k - 1 : k + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return k + float(shift) - (len(first) - 1)


def _standing(columns: int) -> float:
    """Frequency of the standing plate wave of one wavelength [Hz]."""
    nodes, triangles = panel(columns, 1, flat((PULSE, 0.0, 0.0), (0.0, WIDTH, 0.0)))
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x = nodes[:, 0]
    model = model.hold(x >= 0.0, UY, UZ, RX, RY, RZ).hold((x == 0.0) | (x == x.max()), UX)
    return float(model.modes(2)[0][1])  # after the one of half a wavelength

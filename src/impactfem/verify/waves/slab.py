"""Waves in a slab, a strip of it hit on its edge, and a bar that meets a wall.

In the plane of a wide slab a plane wave along x is either a shear wave, with displacements along
y, c_T = √(G/ρ), or a plate wave, with displacements along x, c_P = √(E/(ρ (1 − ν²))). Equation 8
of Bodnar et al. 2022 is the first one: 2345 m/s with ρ = 2500 kg/m3, and 6.7 ms for the 15.6 m of
the slab. Their impact is normal to the slab's edge and makes the second, in bare concrete 3708 m/s
and 4.2 ms. Their floor 8 is not bare: with its beams and all that it carries a wave normal to the
edge has √(EA'/m') = 1972 m/s and takes 7.9 ms (docs/theory/transient.md).
"""

import math
from dataclasses import dataclass

import numpy as np

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import UNDAMPED
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark, fitted_order
from impactfem.verify.shells import CONCRETE, rectangle, straight_beam
from impactfem.verify.waves import KRYLOV, MovingModel, apart, peak

THICKNESS = 0.3
LENGTH, WIDTH, SIZE = 24.0, 1.2, 0.3
FIRST, SECOND = 3.0, 18.6  # the stations of a pulse, 15.6 m apart: as the edges of the paper's slab
PULSE = 6.0
"""Length of the pulse: 20 elements. Its end has passed the second station when its reflection at
the strip's end comes back."""
STEPS = 100
"""Time steps in the time that the pulse takes to pass a point. Average acceleration slows a wave of
that period down by (2π/100)²/12, 0.03 %."""
FORCE = 1e6
PAPER = "Bodnar et al. 2022, equation 8"

STRIP, WIDE, FINE = 15.6, 0.6, 0.2
"""Length, width and size of the elements of the strip that is hit [m]."""
HALF_SINE = 6e-3  # duration of the force on it [s], in which a wave crosses 1.4 times
STEP, CROSSINGS = 2e-5, 6


@dataclass(frozen=True)
class Wave:
    """A plane wave along x: its exact speed [m/s], and its displacement, UX or UY."""

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


@benchmark("slab strip")
def slab_pulses(rows: Rows) -> None:
    """Pulses in a strip of 24 m by 1.2 m of a slab, 30 cm thick, on a distorted mesh.

    A force F(t), half of F₀ (1 − cos 2πt/T), spread over the edge x = 0, sends a pulse of velocity
    F(t − x/c)/(ρ c A). Along the long edges the displacement that the wave has not is restrained:
    u_x for the shear wave, u_y for the plate wave. So the strip is cut from a slab without end;
    with free long edges it would bend, or stretch as a bar at √(E/ρ). Drilling rotations follow
    the shear wave, θ = ½ u_y,x; their inertia slows a wave of the wavelength λ down by
    (2π t/λ)²/96, 0.1 % here, and average acceleration slows both down by 0.03 %. So 0.1 % is
    allowed of the plate wave, 0.5 % of the shear wave, whose pulse changes its shape a little, and
    1 % compared with the two digits of the paper's 6.7 ms.

    The speed is the stations' distance over the delay of largest correlation.
    """
    shear, plate = (_pulse(wave) for wave in (SHEAR, PLATE))
    distance = SECOND - FIRST
    for wave, (delay, largest), allowed in ((SHEAR, shear, 5e-3), (PLATE, plate, 1e-3)):
        formula = "√(G/ρ)" if wave is SHEAR else "√(E/(ρ (1 − ν²)))"
        source = f"closed form: {formula}"
        rows.add(f"speed, {wave.name}", wave.speed, distance / delay, "m/s", allowed, source)
        velocity = FORCE / (CONCRETE.rho * wave.speed * THICKNESS * WIDTH)
        source = "closed form: F/(ρ c A)"
        rows.add(f"peak velocity, {wave.name}", velocity, largest, "m/s", allowed, source)
    source = f"{PAPER}: T = 15.6 m/c_T. This is the paper's crossing"
    rows.add(f"time to cross 15.6 m, {SHEAR.name}", 6.7e-3, shear[0], "s", 0.01, source)
    source = "closed form, bare concrete; the paper's floor 8, with what it carries, takes 7.9 ms"
    exact = distance / PLATE.speed
    rows.add(f"time to cross 15.6 m, {PLATE.name}", exact, plate[0], "s", 1e-3, source)


@benchmark("slab strip", "closed form: √(E/(ρ (1 − ν²)))")
def wave_speed_order(rows: Rows) -> None:
    """Speed of standing plate waves in a strip of 6 m, one wavelength long, on three meshes.

    Held at its ends, the strip has the frequency c/λ with λ = 6 m.
    """
    counts, found = np.array([4, 6, 8]), []
    for columns in counts:
        nodes, triangles = rectangle(PULSE, WIDTH, int(columns), 1)
        x, model = nodes[:, 0], shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
        model = model.hold(x >= 0.0, UY, UZ, RX, RY, RZ).hold((x == 0.0) | (x == x.max()), UX)
        found.append(model.modes(2)[0][1])  # after the one of half a wavelength
    speeds = PULSE * np.array(found)
    quantity = "speed, standing plate wave, 8 elements a wavelength"
    rows.add(quantity, PLATE.speed, speeds[-1], "m/s", 1e-3)
    order = fitted_order(PULSE / counts, np.abs(speeds / PLATE.speed - 1.0))
    quantity = "order of the speed's error in the element's size"
    rows.add(quantity, 4.0, order, "-", 0.05, "quadratic elements: twice their degree")


def _pulse(wave: Wave) -> tuple[float, float]:
    """Delay [s] between the stations, and the largest velocity [m/s] at the second one."""
    nodes, triangles = rectangle(LENGTH, WIDTH, round(LENGTH / SIZE), round(WIDTH / SIZE), 0.2)
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
    first, second = history.motion["velocity"].T
    lags = dt * np.arange(1 - len(first), len(second))
    delay, _ = peak(lags, np.correlate(second, first, mode="full"))
    return delay, float(second.max())


@benchmark(
    "slab strip hit on its edge", "d'Alembert's solution with the reflections at both free edges"
)
def slab_strip_impact(rows: Rows) -> None:
    """A strip of 15.6 m, as the paper's slab is wide, with its four edges free to move along x.

    Held across, it is a bar with c = √(E/(ρ (1 − ν²))). The force F(t) = F₀ sin(πt/T), t < T, on
    the edge x = 0 sends a wave of velocity F/(ρ c A), which free edges send back upright: there
    the velocity is twice the wave's,

        v(0, t) = (F(t) + 2 Σ F(t − 2kL/c))/(ρ c A),   v(L, t) = 2 Σ F(t − (2k − 1)L/c)/(ρ c A),

    k = 1, 2, ... The strip is free: its mean velocity at the end is 2 F₀ T/(π ρ A L). The half
    sine's kinks ring in the velocity, 2 % where they pass; its peak is smooth, a tenth of that, and
    the displacement, its integral, is right to 5e-4 at any time.
    """
    nodes, triangles = rectangle(STRIP, WIDE, round(STRIP / FINE), round(WIDE / FINE), 0.2)
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    load = model.edge_load(x == 0.0, (FORCE, 0.0, 0.0)).reshape(-1, 1)
    probes = np.concatenate([model.rows((x == end) & (y == 0.0), UX) for end in (0.0, STRIP)])
    model = model.hold(x >= 0.0, UZ, RX, RY).hold((y == 0.0) | (y == WIDE), UY)
    moving = MovingModel(model, load, probes)
    time = STEP * np.arange(round(CROSSINGS * STRIP / PLATE.speed / STEP) + 1, dtype=np.float64)
    force = _half_sine(time)[:, None]
    full = moving.full(force, STEP, UNDAMPED).motion
    basis = moving.reduced(shift=120.0, vectors=120)
    newmark, exact = (
        basis.motion(force, STEP, UNDAMPED, scheme) for scheme in ("newmark", "exact")
    )
    wave = FORCE / (CONCRETE.rho * PLATE.speed * THICKNESS * WIDE)
    crossing = STRIP / PLATE.speed
    for label, motion in (("full", full), ("reduced", exact)):
        rows.where = label
        for column, edge in enumerate(("edge that is hit", "far edge")):
            first = np.arange(column, CROSSINGS + 1, 2)
            weight = np.where(first == 0, 1.0, 2.0) * wave
            ago = time[:, None] - crossing * first
            velocity, displacement = _half_sine(ago) @ weight, _integral(ago) @ weight
            for name, closed, allowed in (
                ("velocity", velocity, 0.02),
                ("displacement", displacement, 5e-4),
            ):
                quantity = f"largest difference of the {name} over its peak, {edge}"
                rows.add(quantity, 0.0, apart(motion[name][:, column], closed), "-", allowed)
        first_peak = motion["velocity"][time < 2.0 * crossing, 1].max() / wave
        quantity = "first peak of the velocity, far edge over the wave's"
        source = "d'Alembert: a free end doubles the velocity"
        rows.add(quantity, 2.0, first_peak, "-", 2e-3, source)
        end = motion["displacement"][-1, 1]
        rows.add("displacement of the far edge at the end", displacement[-1], end, "m", 5e-4)
    # The kinks of the half sine send short waves on their way, which the basis does not have all.
    rows.where = "reduced model from the full one, both by Newmark"
    for name, allowed in (("displacement", 1e-4), ("velocity", 0.01)):
        rows.add(name, 0.0, apart(newmark[name], full[name]), "-", allowed, KRYLOV)


def _half_sine(time: Array) -> Array:
    return np.where((time > 0.0) & (time < HALF_SINE), np.sin(np.pi * time / HALF_SINE), 0.0)


def _integral(time: Array) -> Array:
    """∫ of the half sine up to each time [s]."""
    return np.asarray(
        HALF_SINE / np.pi * (1.0 - np.cos(np.pi * np.clip(time / HALF_SINE, 0.0, 1.0)))
    )


@benchmark("bar against a wall", "Siconos's impacting bar, closed form")
def bar_against_wall(rows: Rows) -> None:
    """Siconos's bar meets a rigid wall at 0.1 m/s, seen from the bar's own frame.

    The wall's force is F = ρ c S v₀ until the wave is back from the free end, 2L/c, and zero then.
    In that time the end at the wall has moved by v₀ 2L/c towards the bar: it stays at the wall.
    Afterwards the bar moves off as a rigid body, by 2 v₀ in its frame: nothing vibrates. Its
    momentum is the force's impulse in the time stepping, too, to rounding.
    """
    E, S, L, rho, v0 = 210e9, 3.14e-4, 1.0, 7800.0, 0.1
    c = np.sqrt(E / rho)
    force, contact = rho * c * S * v0, 2.0 * L / c
    elements, steps = 100, 800
    section = BeamSection.rectangle(np.sqrt(S), np.sqrt(S))
    model = shell_model(*straight_beam(L, elements, section, Material(E, 0.3, rho)))
    model = model.hold(model.nodes[:, 0] >= 0.0, UY, UZ, RX, RY, RZ)
    every = model.rows(model.nodes[:, 0] >= 0.0, UX)
    # Straight between the times, the force ends half of a step after the last one that it has.
    dt = contact / (steps + 0.5)
    amplitude = (np.arange(2 * steps + 1) <= steps).astype(float)
    load = model.nodal_load(0, (force, 0.0, 0.0))
    history = model.transient(load, amplitude, dt, probes=every)
    u, v = history.motion["displacement"], history.motion["velocity"]
    mass = model.M[every][:, every]
    mean = float((mass @ v[-1]).sum() / mass.sum())
    touching = history.time < (steps + 0.5) * dt
    way = u[touching, 0] - v0 * history.time[touching]
    energy = history.energy.kinetic[-1] + history.energy.elastic[-1]
    vibrating = 1.0 - 0.5 * rho * S * L * mean**2 / energy
    rows.add("impulse", 0.489840, mean * rho * S * L, "N s", 1e-8)
    rows.add("velocity afterwards over that before", 1.0, mean / v0 - 1.0, "-", 1e-8)
    found = np.interp(contact, history.time, u[:, 0])
    rows.add("way of the end at the wall during the contact", v0 * contact, found, "m", 5e-3)
    quantity = "largest distance of that end from the wall over v₀ 2L/c"
    rows.add(quantity, 0.0, np.abs(way).max() / (v0 * contact), "-", 5e-3)
    rows.add("vibrating part of the energy afterwards", 0.0, vibrating, "-", 0.01)

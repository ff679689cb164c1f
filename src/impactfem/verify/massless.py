"""Contact points without mass: two strips head-on, and a bar that bounces under gravity."""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from impactfem.coupling.body import Body, reduced_body
from impactfem.coupling.links import Assembly, Link
from impactfem.coupling.massless import MasslessHistory, MasslessPoints, massless_response
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.dynamics.damping import UNDAMPED
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark


@dataclass(frozen=True)
class Rod:
    """A uniform rod in linear elements."""

    E: float  #: Young's modulus [Pa]
    density: float  #: [kg/m3]
    section: float  #: cross-section [m2]
    length: float  #: [m]

    @property
    def speed(self) -> float:
        """Speed of its waves [m/s]."""
        return math.sqrt(self.E / self.density)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.section * self.length

    def body(self, name: str, elements: int, end: int) -> tuple[Body, Array]:
        """Return all its modes with a port at an end, and those of a unit translation, (r,)."""
        h, n = self.length / elements, elements + 1
        K, M = np.zeros((2, n, n))
        for k in range(elements):
            K[k : k + 2, k : k + 2] += self.E * self.section / h * np.array([[1.0, -1], [-1, 1]])
            M[k : k + 2, k : k + 2] += self.density * self.section * h / 6 * (1.0 + np.eye(2))
        values, shapes = scipy.linalg.eigh(K, M)
        values[0] = 0.0
        made = reduced_body(name, values, UNDAMPED, {"end": shapes[[end]]})
        return made, shapes.T @ M.sum(axis=1)

    def shift(self, elements: int) -> float:
        """σ of a layer without mass as long as an element, (c / element)² [1/s2]."""
        return (self.speed * elements / self.length) ** 2


FIRST = Rod(33e9, 2400.0, 46.2 * 0.3, 15.6)
SECOND = Rod(33e9, 2400.0, 46.2 * 0.3, 23.4)
"""Strips of a slab of 46.2 m by 0.3 m."""
V0 = 0.36  # speed of the first one [m/s]
EXACT = 0.5 * FIRST.density * FIRST.speed * FIRST.section * V0  # St Venant: 22.2 MN
STEPS = (0.336e-3, 0.168e-3, 0.084e-3, 0.042e-3, 0.021e-3)  # [s]
ELEMENTS = 32  # of the first strip, 0.49 m each
MESHES = (16, 32, 64)
AVERAGED = 1e-3  # time over which forces are averaged [s]
LASTS = 0.03

BOUNCING = Rod(900.0, 1.0, 1.0, 10.0)
HEIGHT, GRAVITY = 5.0, 10.0
"""Bar of Doyen, Ern and Piperno, its height above the wall [m] and gravity [m/s2]."""
PERIODS, BOUNCING_ELEMENTS = 10, 100
ST_VENANT = "St Venant, J. Math. Pures Appl. 12 (1867) 237: ρ c S v₀/2 for 2L/c"
DOYEN = "Doyen, Ern, Piperno, SIAM J. Sci. Comput. 33 (2011) 223; d'Alembert's waves"


def strips(elements: int) -> tuple[Assembly, dict[str, float], Array]:
    """Two strips, the first one about to hit: with their shifts, and velocities, shape (r,)."""
    first, moving = FIRST.body("first", elements, -1)
    second, resting = SECOND.body("second", 3 * elements // 2, 0)
    link = Link("strips", ("first", "end"), ("second", "end"), np.ones(1), 1.7e-5)
    shifts = dict.fromkeys(("first", "second"), FIRST.shift(elements))
    return Assembly([first, second], [link]), shifts, np.concatenate([V0 * moving, 0.0 * resting])


def massless_strips(elements: int, step: float) -> MasslessHistory:
    """Compute the impact of two strips without mass at their contact points."""
    assembly, shifts, velocity = strips(elements)
    points = MasslessPoints.of(assembly, shifts)
    motion = ModalMotion(points.assembly, step)
    return massless_response(points, motion, round(LASTS / step), velocity=velocity)


def largest_mean(history: MasslessHistory) -> float:
    """Largest mean of the force over `AVERAGED` [N]."""
    time, impulse = history.time, np.cumsum(history.impulse[:, 0])
    begin = np.linspace(0.0, time[-1] - AVERAGED, 20_000)
    means = np.interp(begin + AVERAGED, time, impulse) - np.interp(begin, time, impulse)
    return float(means.max()) / AVERAGED


@benchmark("strips head-on, contact points without mass", ST_VENANT)
def massless_strips_head_on(rows: Rows) -> None:
    """Two strips of slabs, 15.6 m and 23.4 m: the force does not depend on the step.

    The layer without mass is an element long. A force without a lag at low frequencies overshoots
    its step: 1.29 times the exact force for a layer of any length.
    """
    histories = [massless_strips(ELEMENTS, step) for step in STEPS]
    peaks = np.array([float(one.largest.max()) for one in histories])
    for step, peak, one in zip(STEPS, peaks, histories, strict=True):
        rows.where = f"step {1e3 * step:g} ms"
        rows.add("largest force above the exact one, over it", 0.0, peak / EXACT - 1.0, "-", 0.35)
        rows.add("largest mean over 1 ms", EXACT, largest_mean(one), "N", 0.07)
        rows.add("impulse", FIRST.mass * V0, float(one.impulse.sum()), "N s", 0.01)
    rows.where = "all steps"
    rows.add(
        "spread of the largest force, over the exact one", 0.0, np.ptp(peaks) / EXACT, "-", 0.02
    )
    energies = [one.energy for one in histories]
    for quantity, values, most, source in (
        ("residual of the energy identity", [e.residual for e in energies], 1e-10, "exact"),
        (
            "energy lost by the scheme, over all",
            [-e.contact[-1] / e.scale for e in energies],
            2e-3,
            "elastic",
        ),
        ("residual of complementarity", [one.residual.max() for one in histories], 1e-10, "exact"),
    ):
        rows.add(quantity, 0.0, float(np.abs(values).max()), "-", most, source)
    rows.where = ""
    means, impulses = [], []
    for elements in MESHES:
        one = massless_strips(elements, STEPS[1] * MESHES[0] / elements)
        means.append(abs(largest_mean(one) / EXACT - 1.0))
        impulses.append(abs(float(one.impulse.sum()) / (FIRST.mass * V0) - 1.0))
    sizes = FIRST.length / np.array(MESHES)
    source = "the front of a jump spreads over the power 2/3 of the mesh"
    rows.order("the largest mean over 1 ms", 2.0 / 3.0, sizes, means, source)
    rows.order("the impulse", 2.0 / 3.0, sizes, impulses, source)


def bouncing_bar(elements: int, step: float, periods: int) -> MasslessHistory:
    """Drop a bar on a rigid wall, and let it bounce."""
    bar, moving = BOUNCING.body("bar", elements, 0)
    wall = Link("wall", ("bar", "end"), None, -np.ones(1), HEIGHT)
    points = MasslessPoints.of(Assembly([bar], [wall]), {"bar": BOUNCING.shift(elements)})
    steps = round(periods * period() / step)
    motion = ModalMotion(points.assembly, step, load=-GRAVITY * moving[:, None])
    return massless_response(points, motion, steps, amplitudes=np.ones((steps + 1, 1)))


def period() -> float:
    """Time from a largest height to the next one: fall, contact for 2L/c, rise [s]."""
    return 2.0 * math.sqrt(2.0 * HEIGHT / GRAVITY) + 2.0 * BOUNCING.length / BOUNCING.speed


@benchmark("bouncing bar, contact point without mass", DOYEN)
def massless_bouncing_bar(rows: Rows) -> None:
    """A bar falls on a wall and bounces for ten periods: F = ρ c S (v₀ + g t) for 2L/c at first."""
    step = 0.25 * BOUNCING.length / BOUNCING_ELEMENTS / BOUNCING.speed
    history = bouncing_bar(BOUNCING_ELEMENTS, step, PERIODS)
    v0, lasts = math.sqrt(2.0 * GRAVITY * HEIGHT), 2.0 * BOUNCING.length / BOUNCING.speed
    impedance = BOUNCING.density * BOUNCING.speed * BOUNCING.section
    first = history.time <= period()
    exact = impedance * (v0 * lasts + 0.5 * GRAVITY * lasts**2)
    rows.add("impulse of the first bounce", exact, float(history.impulse[first].sum()), "N s", 0.01)
    energy = BOUNCING.mass * GRAVITY * HEIGHT
    ends = period() * np.arange(PERIODS + 1)
    drift = np.diff(np.interp(ends, history.time, history.energy.contact)) / energy
    rows.add("largest change of the energy in a period", 0.0, np.abs(drift).max(), "-", 1e-3)
    rows.add("residual of the energy identity", 0.0, history.energy.residual, "-", 1e-10, "exact")
    rows.add("residual of complementarity", 0.0, history.residual.max(), "-", 1e-10, "exact")

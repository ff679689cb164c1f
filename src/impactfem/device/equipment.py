"""Items of equipment without effect on the building: oscillators on a point of a floor.

An item with the mass m, and the mass centre at the height h above its anchors, is an oscillator
along each axis, or rigid. With the absolute acceleration a of its mass, the force and moment on the
floor at the anchors are

    F = -m (a_x, a_y, a_z + g),    M = (0, 0, h) × F = (-h F_y, h F_x, 0)                   (1)

The force of the damper is part of it. Rotations of the floor and the force of the item on the
building are left out: US NRC SRP 3.7.2, II.3.B, allows it up to a mass ratio of 1 %.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import signal

from impactfem.device.bolts import BoltDemand, BoltGroup, bolt_demand
from impactfem.spectra.oscillator import step_coefficients
from impactfem.system.arrays import Array, Index

G = 9.80665
"""Standard acceleration of gravity [m/s2]."""
STEP = 1e-3
"""Step to which vertical forces are rounded up, of the largest one: fewer instants govern."""
LIGHT = 0.01
"""Largest ratio of the mass of an item to that of its floor."""


def absolute_acceleration(
    motion: Array, time_step: float, frequencies: tuple[float, ...], damping: float
) -> Array:
    """Return the absolute acceleration of the mass of an item along each axis.

    Each step is exact for a motion that is linear in it (`impactfem.spectra.oscillator`).

    Args:
        motion: Acceleration of the floor along x, y and z, from rest, shape (3, n_t) [m/s2].
        time_step: Its step [s].
        frequencies: Natural frequencies along the axes, infinite where the item is rigid [Hz].
        damping: Damping ratio.

    Returns:
        Shape (3, n_t) [m/s2].
    """
    found = motion.copy()
    for k, frequency in enumerate(frequencies):
        if math.isinf(frequency):
            continue
        step = step_coefficients(time_step, [frequency], [damping])
        # (4) of the oscillator is a filter with one complex pole; (2) gives the state.
        start = -step.feedthrough * motion[k, 0]
        pole, gain = [1.0, -step.propagator[0]], [0.0, step.input_gain[0]]
        shifted, _ = signal.lfilter(gain, pole, motion[k].astype(complex), zi=start)
        state = shifted + step.feedthrough * motion[k]
        found[k] = (step.acceleration_gain * state).real
    return np.asarray(found)


def force_on_floor(acceleration: Array, mass: float, height: float) -> Array:
    """Return force and moment on the floor at the anchors by (1), weight included.

    Args:
        acceleration: Of the mass, shape (3, n_t) [m/s2].
        mass: m [kg].
        height: h [m].

    Returns:
        x, y, z, rx, ry, rz, shape (6, n_t) [N, N m].
    """
    x, y, z = -mass * acceleration
    z = z - mass * G
    return np.stack([x, y, z, -height * y, height * x, np.zeros_like(x)])


def governing_instants(force: Array) -> tuple[Index, Array]:
    """Return the instants that may govern the bolts of an item, and their vertical forces.

    By (1) the moment is the arm times the horizontal force, at a right angle to it, and the
    critical direction is searched over all angles. So two numbers describe an instant: the size
    of the horizontal force, and the vertical force. Tension and shear grow with both, so that only
    instants count for which no other one has more of both. The vertical force is rounded up to
    `STEP` of its largest value, which leaves few instants and is on the safe side.

    Args:
        force: By (1), shape (6, n_t) [N, N m].

    Returns:
        Instants in order, shape (n,), and their vertical forces, shape (n,) [N].
    """
    horizontal, step = np.hypot(force[0], force[1]), STEP * np.abs(force[2]).max()
    vertical = np.ceil(force[2] / step) * step
    order = np.lexsort((-vertical, -horizontal))
    highest = np.maximum.accumulate(vertical[order])
    front = np.concatenate([[True], vertical[order][1:] > highest[:-1]])
    kept = np.sort(order[front])
    return kept, vertical[kept]


def item_bolt_demand(group: BoltGroup, force: Array, time: Array) -> BoltDemand:
    """Return the largest demand on the bolts of an item, by its governing instants.

    Args:
        group: The bolts.
        force: By (1), shape (6, n_t) [N, N m].
        time: Of the samples, shape (n_t,) [s].

    Raises:
        SolutionError: No equilibrium was found.
    """
    kept, vertical = governing_instants(force)
    governing = force[:, kept]
    governing[2] = vertical
    return bolt_demand(group, governing, time[kept])

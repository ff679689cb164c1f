"""Bars in impact against d'Alembert: a slab strip hit on its edge, and a bar that meets a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import UNDAMPED
from impactfem.verify.row import Row
from impactfem.verify.shells import flat, panel, straight_beam
from impactfem.verify.waves.shell_motion import Motion, MovingModel, apart
from impactfem.verify.waves.waves import CONCRETE, PLATE

Array = NDArray[np.float64]

STRIP = "slab strip hit on its edge"
LENGTH, WIDTH, THICKNESS, SIZE = 15.6, 0.6, 0.3, 0.2
FORCE, PULSE = 1e6, 6e-3
"""Half a sine: its largest force [N], and its duration [s], in which a wave crosses 1.4 times."""
STEP, CROSSINGS = 2e-5, 6
SHIFT, VECTORS = 120.0, 120
DALEMBERT = "d'Alembert's solution with the reflections at both free edges"


def strip_impact() -> list[Row]:
    """A strip of 15.6 m, as the paper's slab is wide, with its four edges free to move along x.

    Held across, it is a bar with c = √(E/(ρ (1 − ν²))). The force F(t) = F₀ sin(πt/T), t < T, on
    the edge x = 0 sends a wave of velocity F/(ρ c A), which free edges send back upright: there
    the velocity is twice the wave's,

        v(0, t) = (F(t) + 2 Σ F(t − 2kL/c))/(ρ c A),   v(L, t) = 2 Σ F(t − (2k − 1)L/c)/(ρ c A),

    k = 1, 2, ... The strip is free: its mean velocity at the end is 2 F₀ T/(π ρ A L). The half
    sine's kinks ring in the velocity, 2 % where they pass; its peak is smooth, a tenth of that, and
    the displacement, its integral, is right to 5e-4 at any time.
    """
    moving = _strip()
    crossing = LENGTH / PLATE.speed
    time = STEP * np.arange(round(CROSSINGS * crossing / STEP) + 1, dtype=np.float64)
    force = _half_sine(time)[:, None]
    full = moving.full(force, STEP, UNDAMPED)
    basis = moving.reduced(SHIFT, VECTORS)
    newmark, exact = (
        basis.motion(force, STEP, UNDAMPED, scheme) for scheme in ("newmark", "exact")
    )
    rows = []
    for solver, motion in (("full", full.motion), ("reduced", exact)):
        rows += _strip_rows(solver, motion, time)
    # The kinks of the half sine send short waves on their way, which the basis does not have all.
    for name, allowed in (("displacement", 1e-4), ("velocity", 0.01)):
        what = f"{name}, reduced model from the full one, both by Newmark"
        difference = apart(newmark[name], full.motion[name])
        source = "the same equations in a Krylov space"
        rows.append(Row(STRIP, what, 0.0, difference, "-", allowed, source, absolute=True))
    return rows


def bar_against_wall() -> list[Row]:
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
    name, source = "bar against a wall", "Siconos's impacting bar, closed form"
    vibrating = 1.0 - 0.5 * rho * S * L * mean**2 / (
        history.energy.kinetic[-1] + history.energy.elastic[-1]
    )
    return [
        Row(name, "impulse", 0.489840, mean * rho * S * L, "N s", 1e-8, source),
        Row(name, "velocity afterwards over that before", 1.0, mean / v0 - 1.0, "-", 1e-8, source),
        Row(
            name,
            "way of the end at the wall during the contact",
            v0 * contact,
            float(np.interp(contact, history.time, u[:, 0])),
            "m",
            5e-3,
            source,
        ),
        Row(
            name,
            "largest distance of that end from the wall over v₀ 2L/c",
            0.0,
            float(np.abs(way).max() / (v0 * contact)),
            "-",
            5e-3,
            source,
            absolute=True,
        ),
        Row(
            name,
            "vibrating part of the energy afterwards",
            0.0,
            float(vibrating),
            "-",
            0.01,
            source,
            absolute=True,
        ),
    ]


def _strip() -> MovingModel:
    place = flat((LENGTH, 0.0, 0.0), (0.0, WIDTH, 0.0))
    nodes, triangles = panel(round(LENGTH / SIZE), round(WIDTH / SIZE), place, 0.2)
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    load = np.zeros((6 * len(nodes), 1))
    load[:, 0] = model.edge_load(x == 0.0, (FORCE, 0.0, 0.0)).ravel()
    probes = np.concatenate([model.rows((x == end) & (y == 0.0), UX) for end in (0.0, LENGTH)])
    model = model.hold(x >= 0.0, UZ, RX, RY).hold((y == 0.0) | (y == WIDTH), UY)
    return MovingModel(model, load, probes)


def _strip_rows(solver: str, motion: Motion, time: Array) -> list[Row]:
    scale = CONCRETE.rho * PLATE.speed * THICKNESS * WIDTH
    crossing = LENGTH / PLATE.speed
    rows = []
    for column, edge in enumerate(("edge that is hit", "far edge")):
        first = np.arange(column, CROSSINGS + 1, 2)
        weight = np.where(first == 0, 1.0, 2.0) * FORCE / scale
        ago = time[:, None] - crossing * first
        velocity, displacement = _half_sine(ago) @ weight, _integral(ago) @ weight
        for name, exact, allowed in (
            ("velocity", velocity, 0.02),
            ("displacement", displacement, 5e-4),
        ):
            what = f"largest difference of the {name} over its peak, {edge}, {solver}"
            difference = apart(motion[name][:, column], exact)
            rows.append(Row(STRIP, what, 0.0, difference, "-", allowed, DALEMBERT, absolute=True))
    wave = FORCE / scale
    before = time < 2.0 * crossing
    rows += [
        Row(
            STRIP,
            f"first peak of the velocity, far edge over the wave's, {solver}",
            2.0,
            float(motion["velocity"][before, 1].max() / wave),
            "-",
            2e-3,
            "d'Alembert: a free end doubles the velocity",
        ),
        Row(
            STRIP,
            f"displacement of the far edge at the end, {solver}",
            float(displacement[-1]),
            float(motion["displacement"][-1, 1]),
            "m",
            5e-4,
            DALEMBERT,
        ),
    ]
    return rows


def _half_sine(time: Array) -> Array:
    return np.where((time > 0.0) & (time < PULSE), np.sin(np.pi * time / PULSE), 0.0)


def _integral(time: Array) -> Array:
    """∫ of the half sine up to each time [s]."""
    return np.asarray(PULSE / np.pi * (1.0 - np.cos(np.pi * np.clip(time / PULSE, 0.0, 1.0))))

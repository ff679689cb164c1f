"""A rigid block that lands on its corners, against its equations solved by hand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.contact_history import ContactHistory
from impactfem.coupling.unilateral import unilateral_response
from impactfem.coupling.unilateral_modal import ModalMotion
from impactfem.verify.row import Row

Array = NDArray[np.float64]

MASS, INERTIA = 2.0, 0.3
LEFT, RIGHT = 0.5, 0.8
"""Distances of the mass centre from the corners [m]."""
CORNERS = np.array([[-1.0, -1.0], [LEFT, -RIGHT]])
"""Columns: how far heave y and (small) rotation bring each corner down."""
GRAVITY = 9.81
NEAR = np.array([[-1.0, -1.0], [0.15, -0.2]])
"""Corners so near the mass centre that an impulse on one lifts the other, too."""


def landing_block() -> list[Row]:
    """Impulses and velocities of landings at once on both corners, and a series of bounces."""
    rows = []
    for name, corners, v0 in (
        ("flat on near corners", NEAR, np.array([-1.0, 0.0])),
        ("turning fast on near corners", NEAR, np.array([-1.0, 4.0])),
        ("turning on far corners", CORNERS, np.array([-1.0, -1.0])),
    ):
        impulse, v1 = plastic_landing(corners, v0)
        history = landed(corners, v0)
        found = history.impulse.sum(axis=0), history.velocity[-1]
        for what, unit, exact, computed in (
            ("impulse on corner", "N s", impulse, found[0]),
            ("velocity afterwards", "m/s, rad/s", v1, found[1]),
        ):
            for k in range(2):
                rows.append(
                    Row(
                        "landing block",
                        f"{name}: {what} {k + 1}",
                        float(exact[k]),
                        float(computed[k]),
                        unit,
                        1e-10,
                        "momentum of a rigid body, all sets of corners tried",
                        absolute=True,
                    )
                )
    end, e = 0.6, 0.8
    x, _, count = bounced(end, e)
    bouncing = stepped(end, e, 12000)
    for what, unit, k in (("height", "m", 0), ("rotation", "rad", 1)):
        rows.append(
            Row(
                "landing block",
                f"{what} after {count} bounces with e = {e:g} under gravity",
                float(x[k]),
                float(bouncing.displacement[-1, k]),
                unit,
                0.005,
                "flights and impacts in turn, each in closed form",
            )
        )
    return rows


def plastic_landing(corners: Array, v0: Array) -> tuple[Array, Array]:
    """Impulses and velocities when both corners touch the ground at once and do not bounce.

    The impulses stop some corners; of the four sets, it is the one in which they push and the
    other corners go up.
    """
    inverse = np.diag([1.0 / MASS, 1.0 / INERTIA])
    for some in ([], [0], [1], [0, 1]):
        G = corners[:, some]
        P = np.zeros(2)
        P[some] = np.linalg.solve(G.T @ inverse @ G, G.T @ v0) if some else 0.0
        v1 = v0 - inverse @ corners @ P
        if np.all(P >= 0.0) and np.all(corners.T @ v1 <= 1e-14):
            break
    return P, v1


def landed(corners: Array, v0: Array) -> ContactHistory:
    """The same by unilateral contact: ten steps from the ground."""
    return unilateral_response(_motion(corners, 1e-3), 0.0, 10, velocity=_modal(v0))


def stepped(end: float, e: float, steps: int) -> ContactHistory:
    """Bounces on the corners from a tilted start above the ground, step by step."""
    motion = _motion(CORNERS, end / steps)
    weight = np.ones((steps + 1, 1))
    start, v0 = START
    return unilateral_response(
        motion,
        0.0,
        steps,
        displacement=_modal(start),
        velocity=_modal(v0),
        amplitudes=weight,
        restitution=e,
    )


START = np.array([0.3, 0.05]), np.array([0.0, 0.4])
"""Height and rotation, and their velocities."""


def bounced(end: float, e: float) -> tuple[Array, Array, int]:
    """The same from impact to impact: position and velocity at the end, number of bounces.

    The end must come before the bounces, shorter and shorter, do.
    """
    x, v = (part.copy() for part in START)
    time, count = 0.0, 0
    inverse = np.array([1.0 / MASS, 1.0 / INERTIA])
    while True:
        # Room of each corner after t: room + rate t - g t²/2.
        room, rate = -CORNERS.T @ x, -CORNERS.T @ v
        flight = (rate + np.sqrt(rate**2 + 2.0 * GRAVITY * np.maximum(room, 0.0))) / GRAVITY
        corner = int(np.argmin(flight))
        t = min(float(flight[corner]), end - time)
        x = x + v * t - np.array([0.5 * GRAVITY * t**2, 0.0])
        v = v - np.array([GRAVITY * t, 0.0])
        time += t
        if time >= end:
            return x, v, count
        g = CORNERS[:, corner]
        v = v - inverse * g * (1.0 + e) * (g @ v) / (g @ (inverse * g))
        x = x - g * (g @ x) / (g @ g)
        count += 1


def _motion(corners: Array, step: float) -> ModalMotion:
    """The block's two modes, both free: y and rotation, each of unit modal mass."""
    root = np.sqrt([MASS, INERTIA])
    load = np.array([[-MASS * GRAVITY], [0.0]]) / root[:, None]
    return ModalMotion(
        np.zeros(2), corners / root[:, None], step, load=load, probes=np.diag(1.0 / root)
    )


def _modal(x: Array) -> Array:
    return np.asarray(np.sqrt([MASS, INERTIA]) * x, dtype=np.float64)

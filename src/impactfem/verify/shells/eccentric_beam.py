"""A beam below a slab strip, eccentric to its nodes, against the theory of composed sections."""

from __future__ import annotations

import numpy as np

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import UZ, Beams, Shells, shell_model
from impactfem.verify.row import Row
from impactfem.verify.shells.shell_meshes import flat, joined, lines_at, panel

CONCRETE = Material(E=30e9, nu=0.0, rho=2500.0)
SHEAR = 5.0 / 6.0
FORCE = 1e3


def eccentric_beam() -> list[Row]:
    """A cantilever: a slab strip (1), and below its middle line a beam (2) that shares its nodes.

    Tip force P on the beam, distance e of the axes, z = e A_2 / (A_1 + A_2) from the slab's
    mid-plane to the common centroid: P (L³/3EI + L c),
    I = I_1 + I_2 + e² A_1 A_2 / (A_1 + A_2). Shear: the strip carries the force of its own
    bending moment, P I_1 / I, the beam the rest; in the strip's plane the flow that the beam
    hands over, P A_1 z / I, fades evenly to the edges.
    """
    length, b, t, width, depth = 12.0, 1.0, 0.2, 0.3, 0.6
    E, G = CONCRETE.E, CONCRETE.G
    e = 0.5 * (t + depth)
    A1, A2, I1, I2 = b * t, width * depth, b * t**3 / 12.0, width * depth**3 / 12.0
    Ic = I1 + I2 + e**2 * A1 * A2 / (A1 + A2)
    z = e * A2 / (A1 + A2)
    across = ((I1 / Ic) ** 2 / A1 + (1.0 - I1 / Ic) ** 2 / A2) / (SHEAR * G)
    in_plane = (A1 * z / Ic) ** 2 * b / (12.0 * G * t)
    exact = FORCE * (length**3 / (3.0 * E * Ic) + length * (across + in_plane))

    halves = [
        panel(48, 4, flat((length, 0.0, 0.0), (0.0, y, 0.0)), 0.2) for y in (0.5 * b, -0.5 * b)
    ]
    nodes, triangles, _ = joined(halves)
    lines = lines_at(triangles, nodes[:, 1] == 0.0)
    section = BeamSection.beam(width, depth, offset=-e)
    model = shell_model(nodes, Shells(triangles, t, CONCRETE), Beams(lines, section, CONCRETE))
    tip = int(np.argmax(nodes[:, 0] - np.abs(nodes[:, 1])))
    load = model.nodal_load(tip, (0.0, 0.0, FORCE))
    moved = model.hold(nodes[:, 0] == 0.0).static(load)
    return [
        Row(
            "eccentric beam under a slab",
            "tip deflection",
            exact,
            float(moved[tip, UZ]),
            "m",
            2e-3,
            "closed form of the composed section with shear",
        )
    ]

"""Shell elements: patch tests, rigid-body motions without energy, and no others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray
from scipy.special import roots_legendre

from impactfem.building.mesh import rigid_body
from impactfem.building.section import BeamSection
from impactfem.building.shell_model import Beams, ShellModel, Shells, shell_model
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.shells import (
    CONCRETE,
    ROTATION,
    SHEAR,
    Ints,
    flat,
    joined,
    lines_at,
    panel,
    rectangle,
)

Array = NDArray[np.float64]

STATES = {"xx": (1.0, 0.0, 0.0), "yy": (0.0, 1.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""Components (xx, yy, xy) of a constant strain or curvature, the last one as tensor component."""
LENGTH, WIDTH = 6.0, 4.0
ZERO = 1e-11
"""An eigenvalue below this part of the largest one is zero; the next ones are above 1e-9."""


@benchmark("rigid-body modes")
def shell_rigid_body(rows: Rows) -> None:
    """Free parts in no special direction, far from the origin, on distorted meshes.

    For each unit motion r of the six: |rᵀ K r| over the norm of K. Then the number of zero
    eigenvalues of K: six, so that no other motion is free, either. Last, the drilling energy is
    there: a turn φ about the normal with the rotations turned the wrong way, θ = −φ n, costs
    ½ c μ t (2 φ)² A.
    """
    for label, model in _parts().items():
        rigid_body_rows(rows, label, model)
    length, width, t, phi = 6.0, 4.0, 0.3, 1e-3
    nodes, triangles = rectangle(length, width, 4, 3, 0.3)
    model = shell_model(nodes @ ROTATION.T, Shells(triangles, t, CONCRETE))
    normal = ROTATION[:, 2]
    motion = np.zeros((len(nodes), 6))
    motion[:, :3] = phi * np.cross(normal, model.nodes)
    motion[:, 3:] = -phi * normal
    energy = 0.5 * motion.ravel() @ (model.K @ motion.ravel())
    exact = 0.5 * CONCRETE.G * t * (2.0 * phi) ** 2 * length * width
    source = "the element's drilling energy (Hughes and Brezzi 1989), closed form"
    rows.add("energy of rotations against the turn of a plate", exact, energy, "J", 1e-10, source)


@benchmark(source="closed form; patch test of Irons")
def shell_patch(rows: Rows) -> None:
    """Constant membrane strains, constant curvatures without shear, and constant shear.

    The boundary nodes are given all six components of the exact state; what the inner nodes do,
    and the energy, are compared with it. Linear displacements with the in-plane rotation as
    drilling rotation, and quadratic deflections with θ such that γ = 0, both lie in the element's
    space and meet its shear and drilling energies with none, so both are exact to rounding.
    With a constant shear the curvature is linear and the deflection cubic, which no element holds;
    its nodes are where they should be all the same, and so is the energy.
    """
    for t in (0.06, 0.6):
        # A distorted rectangle, turned.
        place, triangles = rectangle(LENGTH, WIDTH, 4, 4, 0.35)
        model = shell_model(place @ ROTATION.T, Shells(triangles, t, CONCRETE))
        x, y, _ = place.T
        boundary = (np.minimum(x, LENGTH - x) < 1e-9) | (np.minimum(y, WIDTH - y) < 1e-9)
        bent = t**3 / 12.0
        tests = {
            "membrane": [(membrane_state(place, s), _energy(t, s)) for s in STATES.values()],
            "bending": [(bending_state(place, s), _energy(bent, s)) for s in STATES.values()],
            "shear": [shear_state(place, t, (p, 3 - p)) for p in range(4)],
        }
        rows.where = f"size over thickness {1.5 / t:.3g}"
        for kind, states in tests.items():
            off, energies = [], []
            for state, exact_energy in states:
                exact = np.hstack([state[:, :3] @ ROTATION.T, state[:, 3:] @ ROTATION.T]).ravel()
                found = model.prescribed(exact, model.rows(boundary))
                away = np.abs(found - exact).reshape(-1, 2, 3).max(axis=(0, 2))
                size = np.abs(exact).reshape(-1, 2, 3).max(axis=(0, 2))
                off.append((away[size > 0.0] / size[size > 0.0]).max())
                energy = 0.5 * found @ (model.K @ found)
                energies.append(abs(energy / exact_energy - 1.0))
            rows.name = f"{kind} patch test"
            rows.add("largest error of the displacement or rotation", 0.0, max(off), "-", 1e-9)
            rows.add("largest error of the energy", 0.0, max(energies), "-", 1e-9)


def membrane_state(place: Array, strain: tuple[float, float, float]) -> Array:
    """Displacement and rotation of a constant strain, with a turn in the plane, shape (n, 6)."""
    xx, yy, xy = strain
    turn = 0.7
    gradient = np.array([[xx, xy - turn], [xy + turn, yy]])
    state = np.zeros((len(place), 6))
    state[:, :2] = place[:, :2] @ gradient.T
    state[:, 5] = turn
    return state


def bending_state(place: Array, curvature: tuple[float, float, float]) -> Array:
    """Deflection and rotation of a constant curvature κ = sym ∇β, β = −∇w, shape (n, 6)."""
    xx, yy, xy = curvature
    x, y = place[:, 0], place[:, 1]
    state = np.zeros((len(place), 6))
    state[:, 2] = -(0.5 * xx * x**2 + 0.5 * yy * y**2 + xy * x * y)
    state[:, 4] = xx * x + xy * y  # β_x
    state[:, 3] = -(xy * x + yy * y)  # −β_y
    return state


def shear_state(place: Array, t: float, powers: tuple[int, int]) -> tuple[Array, float]:
    """Constant shear Q = div M: β = −∇φ and w = φ + γ·x with φ = x^p y^q of degree 3, and Q = k γ.

    Returns:
        Displacement and rotation, shape (n, 6), and the energy of the rectangle.
    """
    p, q = powers

    def at(x: Any, y: Any, dx: int, dy: int) -> Array:
        """A derivative of φ."""
        factor = math.perm(p, dx) * math.perm(q, dy)
        return np.asarray(factor * x ** max(p - dx, 0) * y ** max(q - dy, 0))

    x, y = place[:, 0], place[:, 1]
    rigidity = CONCRETE.E * t**3 / (12.0 * (1.0 - CONCRETE.nu**2))
    laplacian = [at(0.0, 0.0, 2 + a, b) + at(0.0, 0.0, a, 2 + b) for a, b in ((1, 0), (0, 1))]
    shear = -rigidity * np.array(laplacian)
    gamma = shear / (SHEAR * CONCRETE.G * t)
    state = np.zeros((len(place), 6))
    state[:, 2] = at(x, y, 0, 0) + gamma[0] * x + gamma[1] * y
    state[:, 4] = -at(x, y, 1, 0)  # β_x
    state[:, 3] = at(x, y, 0, 1)  # −β_y
    # The energy of bending is quadratic over the rectangle: 3 by 3 points of Gauss are enough.
    s, weights = roots_legendre(3)
    xs, ys = LENGTH * 0.5 * (1.0 + s[:, None]), WIDTH * 0.5 * (1.0 + s)
    bending = _energy(t**3 / 12.0, [-at(xs, ys, a, b) for a, b in ((2, 0), (0, 2), (1, 1))])
    mean = 0.25 * float(weights @ bending @ weights)
    return state, mean + 0.5 * LENGTH * WIDTH * float(shear @ gamma)


def _energy(depth: float, strain: Sequence[Any]) -> Any:
    """½ A D(ε):ε times the depth: t for strains, t³/12 for curvatures."""
    xx, yy, xy = strain
    E, nu = CONCRETE.E, CONCRETE.nu
    density = E / (1.0 - nu**2) * (xx**2 + yy**2 + 2.0 * nu * xx * yy + 2.0 * (1.0 - nu) * xy**2)
    return 0.5 * LENGTH * WIDTH * density * depth


def _parts() -> dict[str, ShellModel]:
    skew = panel(4, 3, flat((6.0, 1.0, 0.0), (1.5, 4.0, 0.0)), 0.3)
    roof = panel(4, 3, lambda a, b: (5.0 * np.sin(a), 5.0 * np.cos(a), 4.0 * b), 0.3)
    wings = ((0.0, 0.0, -2.0), (0.0, 2.0, 0.0), (0.0, -2.0, 0.0))
    nodes, triangles, _ = joined([panel(3, 2, flat((6.0, 0.0, 0.0), wing)) for wing in wings])
    lines = lines_at(triangles, (nodes[:, 1] == 0.0) & (nodes[:, 2] == 0.0))
    section = BeamSection.rectangle(0.4, 0.7, reference=(0.3, 0.2, 0.9), offset=(0.1, 0.2, -0.5))
    meshes: dict[str, tuple[tuple[Array, Ints], float, list[Beams]]] = {
        "thin skew plate": (skew, 0.06, []),
        "thick skew plate": (skew, 0.9, []),
        "curved panel": (roof, 0.3, []),
        "T-joint with an eccentric beam": (
            (nodes, triangles),
            0.3,
            [Beams(lines, section, CONCRETE)],
        ),
    }
    return {
        label: shell_model(
            nodes @ ROTATION.T + [40.0, -25.0, 30.0], Shells(triangles, t, CONCRETE), *beams
        )
        for label, ((nodes, triangles), t, beams) in meshes.items()
    }


def rigid_body_rows(rows: Rows, label: str, model: ShellModel) -> None:
    """|rᵀ K r| over the norm of K for unit rigid motions r, and the zero eigenvalues of K."""
    r = rigid_body(model.nodes, model.nodes.mean(axis=0))
    r /= np.linalg.norm(r, axis=0)
    energy = np.abs(r.T @ (model.K @ r)).max() / scipy.sparse.linalg.norm(model.K)
    values = scipy.linalg.eigvalsh(model.K.toarray())
    zeros = np.count_nonzero(np.abs(values) < ZERO * values[-1])
    source = "rigid motions strain nothing"
    rows.add(f"largest energy over the norm of K, {label}", 0.0, energy, "-", 1e-15, source)
    rows.add(f"zero eigenvalues, {label}", 6.0, zeros, "-", 0.0, "a free body has six")

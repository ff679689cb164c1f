"""Beam parts: cantilevers in any direction, their frequencies, and motions without energy."""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import RX, RZ, UX, UY, Beams, ShellModel, shell_model
from impactfem.verify.row import Row, fitted_order
from impactfem.verify.shells.rigid_body_rows import rigid_body_rows

Array = NDArray[np.float64]

CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
SHEAR = 5.0 / 6.0
FORCE = 1e6
_ROOT = math.sqrt(13.0)
# Direction of the beam, then n1 along the width and n2 along the depth, by hand.
DIRECTIONS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "horizontal": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "oblique": (
        (2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0),
        (-3.0 / _ROOT, 2.0 / _ROOT, 0.0),
        (-12.0 / (7.0 * _ROOT), -18.0 / (7.0 * _ROOT), 13.0 / (7.0 * _ROOT)),
    ),
    "vertical": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
}


def cantilevers() -> list[Row]:
    """Tip loads on a transverse beam, 75 by 85 cm, and on a column of 80 by 120 cm.

    Across, P L³/(3 E I) + P L/(k G A) with k = 5/6 and I = h b³/12 for a move along the width b,
    b h³/12 along the depth h; along, P L/(E A); twist T L/(G J). With the axis at the distance e
    from the nodes, across the force: e² P L/(G J) more. J itself against a table.
    """
    rows = []
    for label, (t, n1, n2) in DIRECTIONS.items():
        column = label == "vertical"
        b, h, length = (0.8, 1.2, 4.5) if column else (0.75, 0.85, 7.8)
        section = BeamSection.column(b, h) if column else BeamSection.beam(b, h)
        E, G, A, J = CONCRETE.E, CONCRETE.G, b * h, section.J
        shear = FORCE * length / (SHEAR * G * A)
        cases = (
            ("along the width", n1, 0, FORCE * length**3 / (3.0 * E * h * b**3 / 12.0) + shear),
            ("along the depth", n2, 0, FORCE * length**3 / (3.0 * E * b * h**3 / 12.0) + shear),
            ("along the axis", t, 0, FORCE * length / (E * A)),
            ("twist", t, RX, FORCE * length / (G * J)),
        )
        model = _cantilever(np.array(t), length, section)
        part = "column 80 x 120 cm, vertical" if column else f"beam 75 x 85 cm, {label}"
        rows += [
            _tip_row(f"{quantity}, {part}", model, direction, first, exact)
            for quantity, direction, first, exact in cases
        ]
    e, length = 0.4, 7.8
    section = BeamSection.rectangle(0.75, 0.85, offset=(0.0, e, 0.0))
    exact = FORCE * (
        length**3 / (3.0 * CONCRETE.E * section.I1)
        + length / (SHEAR * CONCRETE.G * section.A)
        + e**2 * length / (CONCRETE.G * section.J)
    )
    model = _cantilever(np.array([1.0, 0.0, 0.0]), length, section)
    rows.append(_tip_row("beside its axis, beam 75 x 85 cm", model, (0.0, 0.0, 1.0), 0, exact))
    rows.append(
        Row(
            "beam cantilever",
            "torsion constant of the column 80 x 120 cm over a³ b",
            0.196,
            BeamSection.column(0.8, 1.2).J / (0.8**3 * 1.2),
            "-",
            3e-3,
            "Timoshenko and Goodier, Theory of Elasticity, section 109: table for b/a = 1.5",
        )
    )
    return rows


def frequencies() -> list[Row]:
    """Bending frequencies of a cantilever, 6 m and 0.8 m deep, by Timoshenko's equations.

    The state (w, φ, M, V) along the beam obeys w' = φ + V/(k G A), φ' = M/(E I),
    M' = -V - ρ I ω² φ, V' = -ρ A ω² w. Frequencies are those where a state with w = φ = 0 at the
    foot can have M = V = 0 at the tip. The order is that of the first one's error over four
    meshes.
    """
    section = BeamSection.beam(0.5, 0.8)
    exact = timoshenko_frequencies(section, CONCRETE, 6.0, 3)
    found = {n: _bending(section, 6.0, n) for n in (2, 3, 4, 6, 20)}
    rows = [
        Row(
            "Timoshenko cantilever",
            f"frequency {k + 1}, 20 elements",
            exact[k],
            float(found[20][k]),
            "Hz",
            1e-6 * 10.0**k,
            "Timoshenko 1921: exact solution of the beam with shear and rotary inertia",
        )
        for k in range(3)
    ]
    counts = np.array([2, 3, 4, 6])
    errors = np.array([abs(found[n][0] / exact[0] - 1.0) for n in counts])
    rows.append(
        Row(
            "Timoshenko cantilever",
            "order of the first frequency's error",
            4.0,
            fitted_order(6.0 / counts, errors),
            "-",
            0.05,
            "quadratic elements: twice their degree",
        )
    )
    return rows


def rigid_body_modes() -> list[Row]:
    """Free beams in no special direction, far from the origin, with eccentric axes.

    For each unit motion r of the six: |rᵀ K r| over the norm of K. Then the number of zero
    eigenvalues of K. Last, the energy of a turn φ about a direction across the beam without the
    nodes' rotations: all of it shear, ½ k G A φ² L.
    """
    rng = np.random.default_rng(8)
    points = np.array([40.0, -25.0, 30.0]) + rng.normal(scale=4.0, size=(5, 3))
    star = [(points[0], point) for point in points[1:]]
    rows = []
    for label, paths in (("one beam", star[:1]), ("four beams that meet", star)):
        section = BeamSection.rectangle(
            0.4, 0.7, reference=(0.3, 0.2, 0.9), offset=(0.15, 0.25, -0.5)
        )
        model = _beams(paths, 3, section)
        rows += rigid_body_rows("rigid-body modes of beams", label, model)
    return [*rows, _without_rotations()]


def timoshenko_frequencies(
    section: BeamSection, material: Material, length: float, count: int
) -> list[float]:
    """Lowest bending frequencies of a cantilever that moves along its depth [Hz].

    Args:
        section: Its section.
        material: Its material.
        length: Its length [m].
        count: How many.
    """
    EI, kGA = material.E * section.I1, section.k2 * material.G * section.A
    # Lengths over L, forces over EI/L²: the determinant has no large numbers.
    shear = EI / (kGA * length**2)
    mass = material.rho * section.A * length**4 / EI
    rotary = material.rho * section.I1 * length**2 / EI

    def free_at_tip(omega: float) -> float:
        along = np.zeros((4, 4))
        along[0, 1], along[0, 3], along[1, 2] = 1.0, shear, 1.0
        along[2, 3], along[2, 1] = -1.0, -rotary * omega**2
        along[3, 0] = -mass * omega**2
        return float(np.linalg.det(scipy.linalg.expm(along)[2:, 2:]))

    # A twentieth of Euler's first frequency: no two roots are as close.
    step = 0.05 * 3.5 / math.sqrt(mass)
    found: list[float] = []
    omega = step
    while len(found) < count:
        if free_at_tip(omega) * free_at_tip(omega + step) < 0.0:
            root = scipy.optimize.brentq(free_at_tip, omega, omega + step, xtol=1e-12 * omega)
            found.append(float(root) / (2.0 * math.pi))
        omega += step
    return found


def _bending(section: BeamSection, length: float, elements: int) -> Array:
    model = _cantilever(np.array([1.0, 0.0, 0.0]), length, section, elements)
    x = model.nodes[:, 0]
    # It moves along z and turns about y.
    return model.hold(x >= 0.0, UX, UY, RX, RZ).hold(x == 0.0).modes(3)[0]


def _without_rotations() -> Row:
    length, phi = 5.0, 1e-3
    t, n1, _ = (np.array(v) for v in DIRECTIONS["oblique"])
    section = BeamSection.beam(0.4, 0.7, offset=-0.5)
    model = _beams([(np.zeros(3), length * t)], 3, section)
    motion = np.zeros((len(model.nodes), 6))
    motion[:, :3] = phi * np.cross(n1, model.nodes)
    energy = 0.5 * motion.ravel() @ (model.K @ motion.ravel())
    return Row(
        "rigid-body modes of beams",
        "energy of a turn without the nodes' rotations",
        0.5 * SHEAR * CONCRETE.G * section.A * phi**2 * length,
        float(energy),
        "J",
        1e-10,
        "closed form",
    )


def _tip_row(
    quantity: str, model: ShellModel, direction: tuple[float, ...], first: int, exact: float
) -> Row:
    """Displacement, or rotation with `first` = RX, of the tip along its load."""
    load = np.zeros((len(model.nodes), 6))
    load[-1, first : first + 3] = FORCE * np.array(direction)
    moved = float(np.dot(model.hold(0).static(load)[-1, first : first + 3], direction))
    unit = "rad" if first == RX else "m"
    source = "closed form of the Timoshenko cantilever"
    return Row("beam cantilever", f"tip {quantity}", exact, moved, unit, 1e-9, source)


def _cantilever(t: Array, length: float, section: BeamSection, elements: int = 3) -> ShellModel:
    """A beam from the origin: its foot is the first node, its tip the last one."""
    return _beams([(np.zeros(3), length * t)], elements, section)


def _beams(paths: list[tuple[Array, Array]], elements: int, section: BeamSection) -> ShellModel:
    """Straight beams of some elements each, that share the nodes at the same place."""
    s = np.linspace(0.0, 1.0, 2 * elements + 1)[:, None]
    points = np.concatenate([start + s * (end - start) for start, end in paths])
    _, first, same = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    # Nodes stay in the order in which they come.
    order = np.sort(first)
    number = np.searchsorted(order, first[same.ravel()]).reshape(len(paths), -1)
    lines = np.stack([number[:, :-2:2], number[:, 2::2], number[:, 1::2]], axis=2).reshape(-1, 3)
    return shell_model(points[order], Beams(lines, section, CONCRETE))

"""Beams: cantilevers in any direction, frequencies; beams and plates that meet."""

import math

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray
from scipy.special import roots_legendre

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import (
    RX,
    RZ,
    UX,
    UY,
    UZ,
    Beams,
    ShellModel,
    Shells,
    line_load,
    shell_model,
)
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark, fitted_order
from impactfem.verify.shells import CONCRETE, SHEAR, flat, joined, lines_at, panel
from impactfem.verify.shells.plates import rigid_body_rows

NARROW = Material(E=30e9, nu=0.0, rho=2500.0)
"""Without Poisson's ratio a narrow plate bends as a beam does."""
FORCE, TIP = 1e6, 1e3  # on the tips of beams, and of plates with beams [N]
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


@benchmark("L-frame of two plates")
def l_frame(rows: Rows, drilling: float = 1.0) -> None:
    """A vertical plate, clamped at its foot, and an arm of the same section at its top.

    With height h, arm a, width b, thickness t, S = b t, A_s = 5/6 S, I = b t³/12, I_b = t b³/12,
    the tip moves under a force P along the arm by P (h³/3EI + h/GA_s + a/ES), downwards by
    P (a³/3EI + a²h/EI + a/GA_s + h/ES), and across by
    P (a³/3EI_b + h³/3EI_b + (a + h)/GA_s + a² h'/GJ). In the last term the arm, which turns in
    its plane, twists the vertical plate: J is that of a strip of a shear-flexible plate,
    b t³/3 (1 − tanh(q)/q), q = √10 b / (2 t), and h' = h − λ with λ = √(E t³b³ / (144 G J)), as
    the foot cannot warp (Vlasov). What torsion does at the joint is not in it: there the factor of
    the drilling stiffness, which is free, moves the tip by 0.2 % between 0.01 and 100, and half the
    element size by 0.2 %. Hence 0.5 % across; that one mesh is much nearer is chance.
    """
    a, h, b, t = 6.0, 5.0, 0.4, 0.1
    E, G = NARROW.E, NARROW.G
    S, In, Ib = b * t, b * t**3 / 12.0, t * b**3 / 12.0
    q = np.sqrt(12.0 * SHEAR) * b / (2.0 * t)
    J = b * t**3 / 3.0 * (1.0 - np.tanh(q) / q)
    twisted = h - np.sqrt(E * (b * t) ** 3 / (144.0 * G * J))
    along = h**3 / (3.0 * E * In) + h / (SHEAR * G * S) + a / (E * S)
    across = (a**3 + h**3) / (3.0 * E * Ib) + (a + h) / (SHEAR * G * S) + a**2 * twisted / (G * J)
    down = a**3 / (3.0 * E * In) + a**2 * h / (E * In) + a / (SHEAR * G * S) + h / (E * S)
    plates = [
        panel(60, 6, flat((0.0, 0.0, h), (0.0, b, 0.0)), 0.2),
        panel(60, 6, flat((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, h)), 0.2),
    ]
    nodes, triangles, _ = joined(plates)
    model = shell_model(nodes, Shells(triangles, t, NARROW), drilling=drilling)
    foot, tip = nodes[:, 2] == 0.0, nodes[:, 0] == a
    rows.source = "closed form of the Timoshenko frame, torsion by Saint-Venant and Vlasov"
    for label, axis, exact, allowed in (
        ("along the arm", UX, along, 1e-4),
        ("across the frame", UY, across, 5e-3),
        ("downwards", UZ, down, 1e-4),
    ):
        found = _at_tip(model, line_load(nodes, lines_at(triangles, tip)), foot, axis)
        rows.add(f"tip displacement, force {label}", TIP * exact, found, "m", allowed)


@benchmark(
    "T-beam of plates", "closed form: composed section, shear by the shear flow of thin walls"
)
def t_beam(rows: Rows) -> None:
    """A cantilever of a web below a flange, both plates, that meet in the flange's mid-plane.

    Tip force P: P (L³/3EI + L c), with the section composed of the two rectangles and
    c = ∫ (S/I)² / (G t) ds from the shear flow P S / I in the web and in the flange.
    """
    length, h, t_w, b, t_f = 6.0, 1.0, 0.12, 1.2, 0.15
    E, G = NARROW.E, NARROW.G
    A_w, A_f = h * t_w, b * t_f
    c_w = 0.5 * h * A_w / (A_w + A_f)  # centroid below the flange
    Ic = (t_w * h**3 + b * t_f**3) / 12.0 + A_w * (0.5 * h - c_w) ** 2 + A_f * c_w**2
    # Web: S = t_w ((h − c)² − s²)/2 at s below the centroid; flange: c t_f times the way from its
    # edge.
    s, weights = roots_legendre(4)
    s, weights = 0.5 * h * (s + 1.0) - c_w, 0.5 * h * weights
    web = float(weights @ (0.5 * t_w * ((h - c_w) ** 2 - s**2)) ** 2) / (G * t_w)
    flange = 2.0 * (c_w * t_f) ** 2 * (0.5 * b) ** 3 / 3.0 / (G * t_f)
    bending, shear = length**3 / (3.0 * E * Ic), length * (web + flange) / Ic**2

    along = (length, 0.0, 0.0)
    plates = [
        panel(48, 8, flat(along, (0.0, 0.0, -h)), 0.2),
        panel(48, 6, flat(along, (0.0, 0.5 * b, 0.0)), 0.2),
        panel(48, 6, flat(along, (0.0, -0.5 * b, 0.0)), 0.2),
    ]
    nodes, triangles, of = joined(plates)
    parts = (Shells(triangles[of == 0], t_w, NARROW), Shells(triangles[of > 0], t_f, NARROW))
    model = shell_model(nodes, *parts)
    root, tip = nodes[:, 0] == 0.0, (nodes[:, 0] == length) & (nodes[:, 1] == 0.0)
    found = _at_tip(model, line_load(nodes, lines_at(triangles, tip)), root, UZ)
    quantity = f"tip deflection, {100.0 * shear / (bending + shear):.1f} % of it by shear"
    rows.add(quantity, TIP * (bending + shear), found, "m", 2e-3)


@benchmark("eccentric beam under a slab", "closed form of the composed section with shear")
def eccentric_beam(rows: Rows) -> None:
    """A cantilever: a slab strip (1), and below its middle line a beam (2) that shares its nodes.

    Tip force P on the beam, distance e of the axes, z = e A_2 / (A_1 + A_2) from the slab's
    mid-plane to the common centroid: P (L³/3EI + L c),
    I = I_1 + I_2 + e² A_1 A_2 / (A_1 + A_2). Shear: the strip carries the force of its
    bending moment, P I_1 / I, the beam the rest; in the strip's plane the flow that the beam
    hands over, P A_1 z / I, fades evenly to the edges.
    """
    length, b, t, width, depth = 12.0, 1.0, 0.2, 0.3, 0.6
    E, G = NARROW.E, NARROW.G
    e = 0.5 * (t + depth)
    A1, A2, I1, I2 = b * t, width * depth, b * t**3 / 12.0, width * depth**3 / 12.0
    Ic = I1 + I2 + e**2 * A1 * A2 / (A1 + A2)
    z = e * A2 / (A1 + A2)
    across = ((I1 / Ic) ** 2 / A1 + (1.0 - I1 / Ic) ** 2 / A2) / (SHEAR * G)
    in_plane = (A1 * z / Ic) ** 2 * b / (12.0 * G * t)
    exact = TIP * (length**3 / (3.0 * E * Ic) + length * (across + in_plane))

    halves = [
        panel(48, 4, flat((length, 0.0, 0.0), (0.0, y, 0.0)), 0.2) for y in (0.5 * b, -0.5 * b)
    ]
    nodes, triangles, _ = joined(halves)
    lines = lines_at(triangles, nodes[:, 1] == 0.0)
    section = BeamSection.beam(width, depth, offset=-e)
    model = shell_model(nodes, Shells(triangles, t, NARROW), Beams(lines, section, NARROW))
    tip = int(np.argmax(nodes[:, 0] - np.abs(nodes[:, 1])))
    moved = model.hold(nodes[:, 0] == 0.0).static(model.nodal_load(tip, (0.0, 0.0, TIP)))
    rows.add("tip deflection", exact, moved[tip, UZ], "m", 2e-3)


@benchmark("beam cantilever", "closed form of the Timoshenko cantilever")
def beam_cantilevers(rows: Rows) -> None:
    """Tip loads on a transverse beam, 75 by 85 cm, and on a column of 80 by 120 cm.

    Across, P L³/(3 E I) + P L/(k G A) with k = 5/6 and I = h b³/12 for a move along the width b,
    b h³/12 along the depth h; along, P L/(E A); twist T L/(G J). With the axis at the distance e
    from the nodes, across the force: e² P L/(G J) more. J itself against a table.
    """
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
        for quantity, direction, first, exact in cases:
            moved, unit = _tip(model, direction, first), "rad" if first == RX else "m"
            rows.add(f"tip {quantity}, {part}", exact, moved, unit, 1e-9)
    e, length = 0.4, 7.8
    section = BeamSection.rectangle(0.75, 0.85, offset=(0.0, e, 0.0))
    bending = length**3 / (3.0 * CONCRETE.E * section.I1)
    twist = e**2 * length / (CONCRETE.G * section.J)
    exact = FORCE * (bending + length / (SHEAR * CONCRETE.G * section.A) + twist)
    model = _cantilever(np.array([1.0, 0.0, 0.0]), length, section)
    moved = _tip(model, (0.0, 0.0, 1.0), 0)
    rows.add("tip next to its axis, beam 75 x 85 cm", exact, moved, "m", 1e-9)
    source = "Timoshenko and Goodier, Theory of Elasticity, section 109: table for b/a = 1.5"
    quantity = "torsion constant of the column 80 x 120 cm over a³ b"
    J = BeamSection.column(0.8, 1.2).J
    rows.add(quantity, 0.196, J / (0.8**3 * 1.2), "-", 3e-3, source)


@benchmark(
    "Timoshenko cantilever",
    "Timoshenko 1921: exact solution of the beam with shear and rotary inertia",
)
def beam_frequencies(rows: Rows) -> None:
    """Bending frequencies of a cantilever, 6 m and 0.8 m deep, by Timoshenko's equations.

    The state (w, φ, M, V) along the beam obeys w' = φ + V/(k G A), φ' = M/(E I),
    M' = -V - ρ I ω² φ, V' = -ρ A ω² w. Frequencies are those where a state with w = φ = 0 at the
    foot can have M = V = 0 at the tip. The order is that of the first one's error over four
    meshes.
    """
    section = BeamSection.beam(0.5, 0.8)
    exact = timoshenko_frequencies(section, CONCRETE, 6.0, 3)
    counts, found = np.array([2, 3, 4, 6, 20]), []
    for n in counts:
        model = _cantilever(np.array([1.0, 0.0, 0.0]), 6.0, section, n)
        # It moves along z and turns about y.
        model = model.hold(model.nodes[:, 0] >= 0.0, UX, UY, RX, RZ).hold(0)
        found.append(model.modes(3)[0])
    quantities = [f"frequency {k}, 20 elements" for k in (1, 2, 3)]
    rows.add(quantities, exact, found[-1], "Hz", 1e-6 * 10.0 ** np.arange(3))
    sizes, errors = 6.0 / counts[:-1], [abs(f[0] / exact[0] - 1.0) for f in found[:-1]]
    source = "quadratic elements: twice their degree"
    quantity = "order of the first frequency's error"
    rows.add(quantity, 4.0, fitted_order(sizes, errors), "-", 0.05, source)
    rows.fitted_to(sizes, errors)


@benchmark("rigid-body modes of beams")
def beam_rigid_body(rows: Rows) -> None:
    """Free beams in no special direction, far from the origin, with eccentric axes.

    For each unit motion r of the six: |rᵀ K r| over the norm of K. Then the number of zero
    eigenvalues of K. Last, the energy of a turn φ about a direction across the beam without the
    nodes' rotations: all of it shear, ½ k G A φ² L.
    """
    rng = np.random.default_rng(8)
    points = np.array([40.0, -25.0, 30.0]) + rng.normal(scale=4.0, size=(5, 3))
    star = [(points[0], point) for point in points[1:]]
    section = BeamSection.rectangle(0.4, 0.7, reference=(0.3, 0.2, 0.9), offset=(0.15, 0.25, -0.5))
    for label, paths in (("one beam", star[:1]), ("four beams that meet", star)):
        rigid_body_rows(rows, label, _beams(paths, 3, section))
    length, phi = 5.0, 1e-3
    t, n1, _ = (np.array(v) for v in DIRECTIONS["oblique"])
    section = BeamSection.beam(0.4, 0.7, offset=-0.5)
    model = _beams([(np.zeros(3), length * t)], 3, section)
    motion = np.zeros((len(model.nodes), 6))
    motion[:, :3] = phi * np.cross(n1, model.nodes)
    energy = 0.5 * motion.ravel() @ (model.K @ motion.ravel())
    exact = 0.5 * SHEAR * CONCRETE.G * section.A * phi**2 * length
    quantity = "energy of a turn without the nodes' rotations"
    rows.add(quantity, exact, energy, "J", 1e-10, "closed form")


def timoshenko_frequencies(
    section: BeamSection, material: Material, length: float, count: int
) -> list[float]:
    """Lowest bending frequencies of a cantilever that moves along its depth [Hz]."""
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


def _tip(model: ShellModel, direction: tuple[float, ...], first: int) -> float:
    """Displacement, or rotation with `first` = RX, of the tip along its load."""
    load = np.zeros((len(model.nodes), 6))
    load[-1, first : first + 3] = FORCE * np.array(direction)
    return float(np.dot(model.hold(0).static(load)[-1, first : first + 3], direction))


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


def _at_tip(model: ShellModel, share: Array, clamped: NDArray[np.bool_], axis: int) -> float:
    """Mean displacement, weighted as the load, under the force along an axis [m]."""
    load = np.zeros((len(model.nodes), 6))
    load[:, axis] = TIP * share
    moved = model.hold(clamped).static(load)
    return float(share @ moved[:, axis])

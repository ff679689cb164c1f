"""Frames of shells against beam theory: two plates at a right angle, and a T-beam.

Without Poisson's ratio a narrow plate bends as a beam does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_legendre

from impactfem.building.section import Material
from impactfem.building.shell_model import UX, UY, UZ, ShellModel, Shells, line_load, shell_model
from impactfem.verify.row import Row
from impactfem.verify.shells.shell_meshes import flat, joined, lines_at, panel

CONCRETE = Material(E=30e9, nu=0.0, rho=2500.0)
SHEAR = 5.0 / 6.0
FORCE = 1e3
AXES = {"along the arm": UX, "across the frame": UY, "downwards": UZ}


def l_frame(drilling: float = 1.0) -> list[Row]:
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

    Args:
        drilling: Factor of the drilling stiffness.
    """
    a, h, b, t = 6.0, 5.0, 0.4, 0.1
    E, G = CONCRETE.E, CONCRETE.G
    S, In, Ib = b * t, b * t**3 / 12.0, t * b**3 / 12.0
    q = np.sqrt(12.0 * SHEAR) * b / (2.0 * t)
    J = b * t**3 / 3.0 * (1.0 - np.tanh(q) / q)
    twisted = h - np.sqrt(E * (b * t) ** 3 / (144.0 * G * J))
    exact = {
        UX: h**3 / (3.0 * E * In) + h / (SHEAR * G * S) + a / (E * S),
        UY: (a**3 + h**3) / (3.0 * E * Ib) + (a + h) / (SHEAR * G * S) + a**2 * twisted / (G * J),
        UZ: a**3 / (3.0 * E * In) + a**2 * h / (E * In) + a / (SHEAR * G * S) + h / (E * S),
    }
    allowed = {UX: 1e-4, UY: 5e-3, UZ: 1e-4}

    plates = [
        panel(60, 6, flat((0.0, 0.0, h), (0.0, b, 0.0)), 0.2),
        panel(60, 6, flat((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, h)), 0.2),
    ]
    nodes, triangles, _ = joined(plates)
    model = shell_model(nodes, Shells(triangles, t, CONCRETE), drilling=drilling)
    foot, tip = nodes[:, 2] == 0.0, nodes[:, 0] == a
    return [
        Row(
            "L-frame of two plates",
            f"tip displacement, force {label}",
            float(FORCE * exact[axis]),
            _at_tip(model, line_load(nodes, lines_at(triangles, tip)), foot, axis),
            "m",
            allowed[axis],
            "closed form of the Timoshenko frame, torsion by Saint-Venant and Vlasov",
        )
        for label, axis in AXES.items()
    ]


def t_beam() -> list[Row]:
    """A cantilever of a web below a flange, both plates, that meet in the flange's mid-plane.

    Tip force P: P (L³/3EI + L c), with the section composed of the two rectangles and
    c = ∫ (S/I)² / (G t) ds from the shear flow P S / I in the web and in the flange.
    """
    length, h, t_w, b, t_f = 6.0, 1.0, 0.12, 1.2, 0.15
    E, G = CONCRETE.E, CONCRETE.G
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
    web_and_flange = [
        Shells(triangles[own], t, CONCRETE) for own, t in ((of == 0, t_w), (of > 0, t_f))
    ]
    model = shell_model(nodes, *web_and_flange)
    root, tip = nodes[:, 0] == 0.0, (nodes[:, 0] == length) & (nodes[:, 1] == 0.0)
    return [
        Row(
            "T-beam of plates",
            f"tip deflection, {100.0 * shear / (bending + shear):.1f} % of it by shear",
            float(FORCE * (bending + shear)),
            _at_tip(model, line_load(nodes, lines_at(triangles, tip)), root, UZ),
            "m",
            2e-3,
            "closed form: composed section, shear by the shear flow of thin walls",
        )
    ]


def _at_tip(
    model: ShellModel, share: NDArray[np.float64], clamped: NDArray[np.bool_], axis: int
) -> float:
    """Mean displacement, weighted as the load, under the force along an axis [m]."""
    load = np.zeros((len(model.nodes), 6))
    load[:, axis] = FORCE * share
    moved = model.hold(clamped).static(load)
    return float(share @ moved[:, axis])

"""Sketches of the theory pages; of the case file they are in `sketches_case`.

``python docs/_ext/sketches.py FOLDER`` writes them as SVG, by default into
``docs/figures/sketches``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import sketches_case  # noqa: F401
from sketch_pen import ACCENT, GREY, INK, LIGHT, SKETCHES, STYLE, Pen, sketch

FOLDER = Path(__file__).parents[1] / "figures" / "sketches"


@sketch(3.6)
def theory_motion(pen: Pen) -> None:
    """Draw a synthetic motion with its envelope, and its spectrum with the target."""
    pen.frame((0.5, 1.7), 4.4, 1.6, "t", "a(t)")
    t = np.linspace(0.0, 1.0, 500)
    envelope = np.minimum(1.0, np.minimum(t / 0.2, (1.0 - t) / 0.35)) * 1.05
    phases = np.random.default_rng(4).uniform(0, 2 * np.pi, 12)
    a = sum(np.cos(2 * np.pi * (k + 8) * t + p) for k, p in enumerate(phases))
    a = a / np.abs(a).max()
    pen.curve(0.5 + 4.1 * t, 1.7 + envelope * a, lw=1.0)
    for sign in (1, -1):
        pen.curve(0.5 + 4.1 * t, 1.7 + sign * envelope, color=INK, ls="--", lw=1.0)
    pen.text((4.3, 2.95), "e(t)")
    pen.text((2.6, 0.3), "motion under its envelope", size=9)
    pen.frame((5.7, 0.9), 4.0, 2.4, "f", "S(f)")
    f = np.linspace(0.0, 1.0, 300)
    target = np.interp(f, [0, 0.25, 0.55, 1.0], [0.3, 1.9, 1.9, 0.7])
    pen.curve(5.8 + 3.6 * f, 0.9 + target, color=INK, ls="--", lw=1.2)
    pen.curve(5.8 + 3.6 * f, 0.9 + target * (1 + 0.07 * np.sin(60 * f) * np.sin(17 * f)))
    pen.text((8.6, 2.95), "$S_{target}$", ha="left")
    pen.text((7.7, 0.3), "its response spectrum", size=9)


@sketch(5.0)
def theory_sticks(pen: Pen) -> None:
    """Draw a building and its stick."""
    pen.ground((0.3, 9.7), 0.5)
    for x in (0.7, 2.0, 3.3):
        pen.line((x, 0.5), (x, 4.2), lw=1.4)
    for z in (1.9, 4.2):
        pen.box((0.5, z - 0.15), 3.0, 0.3)
    pen.text((2.7, 3.1), "storey", size=9)
    pen.text((2.65, 4.62), "floor = slab + beams", size=9)
    x = 6.2
    pen.line((x, 0.5), (x, 4.45), lw=1.6, color=ACCENT)
    for z in (1.9, 4.2):
        pen.line((x, z - 0.35), (x, z + 0.35), lw=5.0)
        pen.ball((x, z), 0.22)
    pen.text((6.6, 4.2), "$M,\\ J_x,\\ J_y,\\ J_z$", ha="left")
    pen.text((6.6, 1.9), "mass centre, rigid zone", ha="left", size=9)
    pen.measure((5.6, 2.25), (5.6, 3.85), "L", at=(-0.25, 0))
    pen.thin((5.5, 2.25), (6.1, 2.25))
    pen.thin((5.5, 3.85), (6.1, 3.85))
    pen.text((6.6, 3.05), "$EI,\\ GA_v,\\ EA,\\ GI_z$", ACCENT, ha="left")
    pen.arrow((7.9, 0.85), (9.1, 0.85), "$a_g$", at=(0.85, 0.0))


@sketch(4.4)
def theory_bodies_and_links(pen: Pen) -> None:
    """Draw two bodies, their ports, a link, a device and the ground."""
    pen.ground((0.3, 9.7), 0.5)
    pen.box((0.8, 0.9), 2.6, 2.0, "body $a$\n$\\mathbf{z}_a$")
    pen.box((6.6, 0.9), 2.6, 2.0, "body $b$\n$\\mathbf{z}_b$")
    for x in (2.1, 7.9):
        pen.line((x, 0.5), (x, 0.9), lw=2.5)
    pen.spring((3.4, 2.3), (5.5, 2.3), color=ACCENT)
    pen.line((5.5, 2.0), (5.5, 2.6), color=ACCENT, lw=2.0)
    pen.dot((3.4, 2.3), (6.6, 2.3), (2.1, 2.9), size=6)
    pen.measure((5.5, 1.75), (6.6, 1.75), "$\\delta$", at=(0, -0.3))
    pen.thin((6.6, 1.75), (6.6, 2.3))
    pen.text((4.5, 2.9), "link: force $F$", ACCENT)
    pen.text((4.55, 1.75), "port $p$", size=9)
    pen.line((4.0, 1.85), (3.5, 2.2), lw=0.8)
    pen.box((1.4, 3.3), 1.4, 0.7, "device", fill="white")
    pen.line((2.1, 2.9), (2.1, 3.3), lw=2.5)
    pen.arrow((3.7, 0.85), (5.1, 0.85), "$\\ddot{\\mathbf{u}}_{base}$", at=(1.3, 0.05))


@sketch(5.0)
def theory_soil(pen: Pen) -> None:
    """Draw the raft with the six coordinates of the base, and one component of the soil."""
    pen.box((1.3, 3.4), 1.9, 1.3, "body")
    pen.line((0.6, 2.9), (3.9, 2.9), (3.9, 3.4), (0.6, 3.4), fill=GREY)
    pen.text((2.25, 3.15), "rigid raft", size=9)
    pen.line((0.1, 2.9), (0.6, 2.9), lw=1.4)
    pen.line((3.9, 2.9), (4.4, 2.9), lw=1.4)
    pen.dot((2.25, 2.9), size=4)
    pen.arrow((2.25, 1.5), (3.5, 1.5), "$b_x$", at=(0.9, 0))
    pen.arrow((2.25, 1.5), (2.25, 2.7))
    pen.text((2.6, 2.5), "$b_z$", ACCENT)
    pen.turn((2.25, 1.5), 0.6, 200, 20)
    pen.text((1.25, 1.9), "$b_{ry}$", ACCENT)
    pen.text((2.25, 0.5), "half-space: $\\rho,\\ c_s,\\ \\nu,\\ \\zeta$")
    pen.text((7.4, 4.75), "one component $b$ of the base", size=9)
    pen.line((4.9, 4.2), (9.9, 4.2), lw=2.5)
    pen.arrow((9.5, 3.4), (9.5, 4.1), "$b$", at=(0.25, 0))
    pen.spring((5.2, 4.2), (5.2, 0.6))
    pen.text((5.68, 1.1), "$K$")
    pen.dashpot((6.2, 0.6), (6.2, 4.2))
    pen.text((6.6, 1.1), "$C$")
    pen.box((6.75, 3.55), 0.6, 0.45, "$m$")
    pen.line((7.05, 4.0), (7.05, 4.2))
    pen.dashpot((7.7, 2.4), (7.7, 4.2))
    pen.box((7.3, 1.75), 0.85, 0.65, "$m_j$")
    pen.text((7.35, 2.75), "$m_j r_j$", size=9, ha="right")
    pen.spring((8.75, 4.2), (8.75, 2.4))
    pen.text((9.1, 2.75), "$k_j$")
    pen.dashpot((8.75, 0.6), (8.75, 2.4))
    pen.text((9.0, 1.4), "$k_j/r_j$", size=9, ha="left")
    pen.ground((4.9, 9.9), 0.6)


@sketch(4.2)
def theory_contact(pen: Pen) -> None:
    """Draw two floors with the gap and the law between them, and the law's force."""
    pen.box((0.3, 1.6), 1.5, 1.2, "$m_1$")
    pen.box((4.6, 1.6), 1.5, 1.2, "$m_2$")
    pen.dot((1.8, 2.2), (4.6, 2.2))
    pen.text((1.95, 3.1), "$a$")
    pen.text((4.45, 3.1), "$b$")
    pen.line((1.8, 2.2), (2.1, 2.2))
    pen.line((2.1, 1.9), (2.1, 2.5))
    pen.spring((2.1, 2.5), (3.7, 2.5), coils=3, size=0.17)
    pen.dashpot((2.1, 1.9), (3.7, 1.9))
    pen.line((3.7, 1.75), (3.7, 2.65), lw=2.0)
    pen.text((2.9, 2.95), "$K$")
    pen.text((2.9, 1.45), "$C$")
    pen.measure((3.7, 1.3), (4.6, 1.3), "$\\delta$", at=(0, -0.32))
    pen.thin((4.6, 1.3), (4.6, 2.2))
    pen.thin((3.7, 1.3), (3.7, 1.9))
    pen.arrow((2.5, 3.55), (3.7, 3.55), "$\\mathbf{n}$", at=(0.85, 0))
    pen.text((3.2, 0.4), "$\\delta = g + \\mathbf{n} \\cdot (\\mathbf{u}_b - \\mathbf{u}_a)$")
    pen.frame((6.9, 1.0), 2.8, 2.8, "$p = -\\delta$", "$F$")
    p = np.sin(np.linspace(0, np.pi, 80))
    v = np.cos(np.linspace(0, np.pi, 80))
    force = 1.6 * (p + 0.3 * v)
    pen.curve(6.9 + 2.0 * p, 1.0 + force, color=INK)
    hertz = 2.0 * p**1.5 * (1 + 0.3 * v)
    pen.curve(6.9 + 2.0 * p, 1.0 + hertz)
    pen.text((7.0, 2.75), "Kelvin-\nVoigt", ha="left", size=9)
    pen.text((9.85, 1.7), "Hertz,\ndamped", ACCENT, ha="right", size=9)


@sketch(4.6)
def theory_pounding_3d(pen: Pen) -> None:
    """Draw two floors in plan that face each other along a line, with the hats of its points."""
    pen.box((0.4, 0.5), 3.6, 3.6)
    pen.text((1.7, 2.3), "floor of $a$")
    pen.line((5.6, 0.9), (9.6, 0.9), (9.6, 4.1), (5.9, 4.1), fill=LIGHT)
    pen.text((7.9, 2.5), "floor of $b$")
    s = np.linspace(0.9, 4.1, 5)
    for k, y in enumerate(s):
        low, high = max(y - 0.8, 0.9), min(y + 0.8, 4.1)
        pen.thin((4.0, low), (4.55, y), (4.0, high), ls="-")
        if k == 2:
            pen.line((4.0, low), (4.55, y), (4.0, high), color=ACCENT)
    pen.dot(*((4.0, y) for y in s), size=4)
    pen.arrow((3.7, 0.9), (3.7, 1.9), "$s$", at=(-0.25, 0.1))
    pen.text((4.75, 2.9), "$N_i$", ACCENT)
    pen.arrow((4.7, 2.5), (5.55, 2.5), "$\\mathbf{n}$", at=(-0.05, -0.3))
    pen.measure((4.0, 3.45), (5.81, 3.45), "$g(s)$", at=(0.2, 0.28))
    pen.arrow((3.0, 2.5), (3.95, 2.5))
    pen.text((3.3, 2.85), "$F_i$", ACCENT)
    pen.thin((3.2, 0.9), (4.0, 0.9))
    pen.text((5.0, 0.25), "plan at the level of the floors", size=9)


@sketch(4.4)
def theory_massless(pen: Pen) -> None:
    """Draw two strips with layers without mass between them, and the force by both schemes."""
    for left, right, name in ((0.3, 2.0, "$a$"), (2.9, 4.6, "$b$")):
        pen.line((left, 2.4), (right, 2.4), (right, 3.3), (left, 3.3), fill=LIGHT)
        pen.text(((left + right) / 2, 2.85), f"{name}, mass")
    pen.box((2.0, 2.4), 0.4, 0.9)
    pen.box((2.5, 2.4), 0.4, 0.9)
    pen.measure((2.0, 2.1), (2.4, 2.1), "$c/\\omega_c$", at=(0.0, -0.35))
    pen.arrow((2.2, 3.8), (2.2, 3.1))
    pen.arrow((2.7, 3.8), (2.7, 3.1))
    pen.text((2.45, 4.0), "layers $\\mathbf{R}$ without mass", size=9)
    pen.arrow((0.6, 1.4), (1.5, 1.4), "$v_0$", at=(-0.45, -0.3))
    pen.frame((5.4, 0.7), 4.3, 3.2, "t", "force $F$")
    t = np.linspace(0.0, 3.4, 400)
    x = 3.0 * t
    root = np.sqrt(0.75)
    rise = 1.0 - np.exp(-x / 2) * (np.cos(root * x) - np.sin(root * x) / (2 * root))
    pen.curve(5.6 + t, 0.7 + 1.2 * rise, color=ACCENT)
    pen.line((5.6, 0.7), (5.6, 1.9), (9.3, 1.9), ls="--", lw=1.0)
    pen.curve(
        5.6 + np.array([0.0, 0.0, 0.12, 0.12]), 0.7 + np.array([0.0, 2.9, 2.9, 1.2]), color=INK
    )
    pen.text((5.95, 3.35), "Moreau: $m v / 2h$", ha="left", size=9)
    pen.text((6.6, 2.55), "without mass", ACCENT, ha="left", size=9)
    pen.text((8.3, 1.6), "exact", size=9)


@sketch(5.2)
def theory_wall(pen: Pen) -> None:
    """Draw the building with its displaced floor before the rigid wall."""
    pen.ground((0.6, 8.4), 0.6)
    z = np.array([0.6, 1.9, 3.2, 4.5])
    shift = np.array([0.0, 0.1, 0.32, 0.7])
    for left in (3.2, 5.6):
        pen.curve(np.full(4, left), z, color=GREY, ls="--", lw=1.0)
        fine = np.linspace(0.6, 4.5, 60)
        pen.curve(left - np.interp(fine, z, shift), fine, color=INK)
    for k in (1, 2, 3):
        pen.box((3.2 - shift[k], z[k] - 0.12), 2.4, 0.24, fill=LIGHT if k < 3 else ACCENT)
    pen.wall(6.5, (0.6, 5.0))
    pen.measure((5.6, 1.25), (6.5, 1.25), "$g$", at=(0, 0.28))
    pen.thin((5.6, 4.5), (5.6, 4.95))
    pen.measure((4.9, 4.85), (5.6, 4.85), "$d$", at=(-0.6, 0))
    pen.text((7.0, 3.6), "rigid wall", ha="left")
    pen.text((7.0, 3.05), "impulse $P = \\int F\\,dt$", ha="left", size=9)
    pen.arrow((6.45, 3.2), (5.75, 3.2), "$F$", at=(0.0, 0.3))
    pen.arrow((1.9, 4.5), (2.45, 4.5))
    pen.text((1.8, 4.5), "$\\dot u^-$", ACCENT, ha="right")
    pen.text((0.5, 3.2), "floor\nof mass $M$", ha="left", size=9)


@sketch(4.4)
def theory_shells_and_beams(pen: Pen) -> None:
    """Draw a triangle of six nodes with its frame, and a beam of three nodes."""
    a, b, c = (0.6, 0.9), (4.2, 0.6), (2.8, 3.0)
    middles = [((p[0] + q[0]) / 2, (p[1] + q[1]) / 2) for p, q in ((a, b), (b, c), (c, a))]
    pen.line(a, b, c, fill=LIGHT)
    pen.dot(a, b, c, *middles)
    o = (2.45, 1.55)
    pen.arrow(o, (3.35, 1.5), "")
    pen.arrow(o, (2.75, 2.2), "")
    pen.arrow(o, (2.0, 2.55), "")
    pen.text((3.3, 1.2), "$\\mathbf{e}_1$", ACCENT)
    pen.text((3.0, 2.05), "$\\mathbf{e}_2$", ACCENT)
    pen.text((1.3, 2.65), "$\\mathbf{e}_3,\\ \\zeta$", ACCENT)
    pen.text((0.3, 0.35), "shell of thickness $t$", ha="left", size=9)
    pen.arrow(c, (3.7, 3.3), "$\\mathbf{u}$", at=(0.65, 0.15))
    pen.turn(c, 0.5, 40, 190)
    pen.text((2.3, 3.75), "$\\theta$", ACCENT)
    pen.line((5.6, 1.0), (9.4, 1.0), lw=1.0, ls="--")
    pen.text((7.5, 0.35), "axis of the beam", size=9)
    pen.line((5.6, 2.4), (9.4, 2.4))
    pen.dot((5.6, 2.4), (7.5, 2.4), (9.4, 2.4))
    pen.line((5.6, 0.7), (9.4, 0.7), (9.4, 1.3), (5.6, 1.3), lw=0.8, fill="none")
    pen.arrow((5.6, 2.4), (5.6, 1.05), "$\\mathbf{e}$", at=(-0.25, 0.1))
    pen.arrow((7.5, 2.4), (8.5, 2.4), "$\\mathbf{t}$", at=(0.25, 0.3))
    pen.arrow((7.5, 2.4), (7.5, 3.4), "$\\mathbf{n}_2$", at=(0.35, 0.3))
    pen.arrow((7.5, 2.4), (6.9, 1.85), "$\\mathbf{n}_1$", at=(-0.35, 0.0))
    pen.text((7.5, 4.0), "beam: one line of nodes", size=9)


@sketch(3.8)
def theory_newmark(pen: Pen) -> None:
    """Draw the average acceleration in a step, and Rayleigh damping over the frequency."""
    pen.frame((0.6, 0.9), 3.7, 2.5, "t", "acceleration")
    pen.dot((1.3, 1.6), (3.3, 2.7), color=ACCENT)
    pen.thin((1.3, 0.9), (1.3, 1.6))
    pen.thin((3.3, 0.9), (3.3, 2.7))
    pen.line((1.3, 2.15), (3.3, 2.15), color=ACCENT, lw=1.8)
    pen.text((0.95, 1.6), "$\\mathbf{a}_0$", ACCENT)
    pen.text((3.7, 2.7), "$\\mathbf{a}_1$", ACCENT)
    pen.text((2.2, 1.75), "mean", ACCENT, size=9)
    pen.measure((1.3, 0.55), (3.3, 0.55), "$\\Delta t$", at=(0, -0.3))
    pen.frame((5.5, 0.9), 4.2, 2.5, "f", "damping ratio $\\xi(f)$")
    f = np.linspace(0.25, 4.0, 200)
    xi = 0.5 * (0.55 / f + 0.55 * f)
    pen.curve(5.5 + f, 0.9 + xi)
    pen.curve(5.5 + f, 0.9 + 0.275 / f, color=GREY, ls="--", lw=1.0)
    pen.curve(5.5 + f, 0.9 + 0.275 * f, color=GREY, ls="--", lw=1.0)
    one, two = 0.5, 2.0
    level = 0.275 / one + 0.275 * one
    for at, name in ((one, "$f_1$"), (two, "$f_2$")):
        pen.thin((5.5 + at, 0.9), (5.5 + at, 0.9 + level))
        pen.dot((5.5 + at, 0.9 + level), color=ACCENT, size=4)
        pen.text((5.5 + at, 0.6), name)
    pen.text((8.9, 1.4), "$\\beta\\omega/2$", size=9)
    pen.text((9.9, 2.6), "both", ACCENT, ha="right", size=9)


@sketch(3.8)
def theory_reduced_basis(pen: Pen) -> None:
    """Draw a response outside the space of the basis, and the error band of a spectrum."""
    pen.line((0.3, 0.7), (3.6, 0.7), (4.6, 1.9), (1.3, 1.9), fill=LIGHT)
    pen.text((0.8, 0.35), "span of $\\mathbf{V}$", ha="left")
    pen.arrow((1.3, 1.0), (3.5, 1.55), "")
    pen.text((2.6, 1.0), "$\\Phi \\mathbf{z}$", ACCENT)
    pen.arrow((1.3, 1.0), (3.5, 2.9), "$\\mathbf{x}$", at=(-0.3, 0.25), color=INK)
    pen.line((3.5, 1.55), (3.5, 2.9), ls="--", lw=1.0)
    pen.text((3.65, 2.45), "error", ha="left", size=9)
    pen.frame((5.6, 0.8), 4.1, 2.6, "f", "$|y|$")
    f = np.linspace(0.0, 1.0, 200)
    y = 0.5 + 1.3 / (1 + ((f - 0.35) / 0.06) ** 2) + 0.7 / (1 + ((f - 0.7) / 0.05) ** 2)
    band = 0.04 + 0.22 * f**3
    pen.axes.fill_between(
        5.7 + 3.6 * f, 0.8 + y - band, 0.8 + y + band, color=ACCENT, alpha=0.25, lw=0
    )
    pen.curve(5.7 + 3.6 * f, 0.8 + y)
    pen.text((9.2, 2.3), "$|y| \\pm |\\Delta y|$", ACCENT)


@sketch(4.6)
def theory_transient(pen: Pen) -> None:
    """Draw a floor in plan, the line load of an eccentric force along its side, and the wave."""
    pen.box((3.6, 0.5), 5.2, 3.6)
    x, base = 3.6, np.array([0.5, 4.1])
    q = np.array([0.25, 1.75])
    pen.line(
        (x, base[0]),
        (x - q[0], base[0]),
        (x - q[1], base[1]),
        (x, base[1]),
        color=ACCENT,
        fill="#d7e6f3",
    )
    for y in np.linspace(0.9, 3.7, 5):
        pen.arrow((x - np.interp(y, base, q), y), (x, y))
    pen.text((2.35, 2.05), "$q(s)$", ACCENT, ha="right")
    pen.arrow((0.3, 2.75), (1.5, 2.75), "$F$", at=(0.0, 0.3), color=INK)
    pen.thin((3.6, 2.3), (8.8, 2.3), ls="-.")
    pen.thin((3.6, 2.75), (4.6, 2.75))
    pen.measure((4.3, 2.3), (4.3, 2.75), "$e$", at=(0.15, 0.0), ha="left")
    pen.measure((9.2, 0.5), (9.2, 4.1), "$\\ell$", at=(0.3, 0))
    pen.arrow((3.85, 3.1), (3.85, 3.9), "$s$", at=(0.3, 0.1), color=INK)
    pen.text((7.9, 2.55), "$s_0$", ha="left")
    for k in range(3):
        pen.curve([5.2 + 0.35 * k] * 2, [0.75, 1.85], lw=1.6 - 0.4 * k)
    pen.arrow((6.15, 1.3), (7.5, 1.3), "$c$", at=(0.9, 0))
    pen.text((7.1, 3.75), "floor in plan", size=9)


@sketch(4.2)
def theory_spectra(pen: Pen) -> None:
    """Draw oscillators on a floor, and their largest responses over the frequency."""
    pen.box((0.3, 0.9), 4.2, 0.35)
    for k, (x, height, size) in enumerate(((1.0, 2.2, 0.32), (2.3, 1.7, 0.26), (3.5, 1.2, 0.2))):
        lean = 0.3 if k == 0 else 0.0
        pen.curve(
            [x, x + 0.1 * lean, x + lean], [1.25, 1.25 + height / 2, 1.25 + height], color=INK
        )
        pen.ball((x + lean, 1.25 + height), size)
    pen.thin((1.0, 1.25), (1.0, 3.95))
    pen.arrow((1.0, 3.95), (1.35, 3.95), "$x$", at=(0.4, 0))
    pen.text((2.6, 3.6), "$\\omega,\\ \\xi$", ha="left")
    pen.arrow((1.4, 0.45), (2.6, 0.45), "$a(t)$ of the floor", at=(1.9, 0))
    pen.frame((5.7, 0.9), 4.0, 2.9, "f", "$S_a$")
    f = np.linspace(0.02, 1.0, 400)
    s = 0.75 * (1 - np.exp(-7 * f)) + 1.35 * np.exp(-(((f - 0.42) / 0.05) ** 2))
    pen.curve(5.8 + 3.7 * f, 0.9 + s)
    wide = np.array([s[(f >= v / 1.15) & (f <= v / 0.85)].max() for v in f])
    pen.curve(5.8 + 3.7 * f, 0.93 + wide, color=INK, ls="--", lw=1.0)
    pen.text((8.15, 2.85), "broadened", ha="left", size=9)
    pen.text((9.6, 2.0), "ZPA", ha="right", size=9)


@sketch(4.8)
def theory_devices(pen: Pen) -> None:
    """Draw a device on its springs, the forces on its anchor, and the circle of anchors."""
    pen.box((0.2, 0.5), 4.7, 0.4, "slab")
    pen.line((1.3, 0.9), (3.9, 0.9), lw=4.5)
    for x in (1.7, 3.5):
        pen.spring((x, 0.9), (x, 2.0), coils=3, size=0.16)
    pen.box((1.4, 2.0), 2.4, 2.0)
    pen.dot((2.6, 3.0))
    pen.text((2.6, 3.45), "$\\mathbf{M}$, mass centre", size=9)
    pen.arrow((3.8, 3.7), (4.7, 3.7), "$\\mathbf{x}$", at=(0.25, 0.28))
    pen.arrow((3.95, 1.15), (4.9, 1.15), "$\\mathbf{a}$", at=(0.2, 0.3))
    pen.text((2.6, 1.45), "$\\mathbf{K},\\ \\mathbf{C}$")
    pen.text((0.05, 1.45), "base\nplate", ha="left", size=9)
    pen.text((7.6, 4.45), "anchor from above", size=9)
    pen.ring((7.4, 2.5), 1.3)
    for k in range(8):
        angle = np.pi / 4 * k + np.pi / 8
        pen.dot((7.4 + 1.3 * np.cos(angle), 2.5 + 1.3 * np.sin(angle)), color=ACCENT)
    pen.line((7.4, 2.5), (7.4 + 1.3 * np.cos(2.75), 2.5 + 1.3 * np.sin(2.75)), lw=0.9)
    pen.text((6.9, 2.95), "$r$")
    pen.arrow((7.4, 2.5), (8.55, 2.5), "$M$", at=(-0.1, 0.28))
    pen.ring((7.4, 2.5), 0.13, color=ACCENT, fill="white")
    pen.dot((7.4, 2.5), color=ACCENT, size=2)
    pen.text((7.4, 2.1), "$N$", ACCENT)
    pen.text((7.6, 0.6), "$T = N + 2M/r$,  each: $T/n$")


@sketch(4.0)
def theory_ensemble(pen: Pen) -> None:
    """Draw sorted values over their positions, with the 84th percentile."""
    pen.frame((1.2, 0.9), 8.2, 2.8, "$p$", "")
    pen.text((1.4, 3.65), "value $S_{(k)}$, sorted", ha="left")
    values = np.array([0.35, 0.5, 0.62, 0.75, 0.85, 1.05, 1.3, 1.9])
    p = (np.arange(1, 9) - 0.5) / 8
    x, y = 1.2 + 7.4 * p, 0.9 + 1.3 * values
    pen.curve(x, y)
    pen.dot(*zip(x, y, strict=True), color=ACCENT)
    for v, name in ((0.0, "0"), (0.5, "median"), (0.84, "0.84"), (1.0, "1")):
        pen.text((1.2 + 7.4 * v, 0.5), name, size=9)
        pen.line((1.2 + 7.4 * v, 0.82), (1.2 + 7.4 * v, 0.98), lw=1.0)
    for v in (0.5, 0.84):
        at = 0.9 + 1.3 * float(np.interp(v, p, values))
        pen.thin((1.2 + 7.4 * v, 0.9), (1.2 + 7.4 * v, at), (1.2, at))
    pen.text((0.65, 0.9 + 1.3 * float(np.interp(0.84, p, values))), "$S_{84}$")
    pen.text((0.65, 0.9 + 1.3 * float(np.interp(0.5, p, values))), "$S_{50}$")
    pen.text((4.0, 3.1), "$p_k = (k - 1/2)/n$", ha="left")


@sketch(4.0)
def theory_model_updating(pen: Pen) -> None:
    """Draw the misfit over one key, with two minima and the limit of the interval."""
    pen.frame((0.9, 0.9), 8.6, 2.8, "key $u$", "$\\chi^2(u)$")
    u = np.linspace(0.05, 0.97, 300)
    wells = 30 * (u - 0.3) ** 2, 33 * (u - 0.75) ** 2 + 0.24
    misfit = 0.55 - np.log(np.exp(-5 * wells[0]) + np.exp(-5 * wells[1])) / 5
    keep = misfit < 2.2
    pen.curve(0.9 + 8.2 * u[keep], 0.9 + misfit[keep])
    pen.line((1.0, 2.05), (9.2, 2.05), ls="--", lw=1.0)
    pen.measure((9.3, 1.45), (9.3, 2.05), "$q$", at=(0.25, 0))
    pen.thin((3.36, 1.45), (9.4, 1.45))
    pen.dot((0.9 + 8.2 * 0.3, 1.45), (0.9 + 8.2 * 0.75, 1.69), color=ACCENT)
    pen.text((3.36, 1.15), "$u_1$, best")
    pen.text((7.05, 1.15), "$u_2$, second solution")
    edge = 0.6 / 30
    left, right = 0.3 - np.sqrt(edge), 0.3 + np.sqrt(edge)
    pen.measure((0.9 + 8.2 * left, 2.35), (0.9 + 8.2 * right, 2.35), "interval", at=(0, 0.28))


def write(folder: Path) -> list[Path]:
    """Write all sketches into a folder, and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    with mpl.rc_context(STYLE):
        for name, (draw, height) in SKETCHES.items():
            pen = Pen(height)
            draw(pen)
            files.append(folder / f"{name}.svg")
            pen.figure.savefig(files[-1], metadata={"Date": None, "Creator": None})
    return files


if __name__ == "__main__":
    for file in write(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER):
        print(file)

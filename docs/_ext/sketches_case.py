"""Sketches of the sections of the case file; `sketches` writes them."""

from __future__ import annotations

import numpy as np
from sketch_pen import ACCENT, GREY, INK, LIGHT, Pen, sketch


@sketch(4.8)
def case_buildings(pen: Pen) -> None:
    """Draw two buildings in plan with the axes, the position of an axis, length and width."""
    pen.arrow((0.6, 0.6), (1.8, 0.6), color=INK)
    pen.arrow((0.6, 0.6), (0.6, 1.8), color=INK)
    pen.text((2.0, 0.6), "$x$")
    pen.text((0.6, 2.05), "$y$")
    pen.text((0.35, 0.3), "0", size=9)
    for x, name in ((2.3, "B1"), (6.4, "B2")):
        pen.box((x, 1.5), 3.2, 2.4)
        pen.line(
            (x + 0.3, 1.8),
            (x + 2.9, 1.8),
            (x + 2.9, 3.6),
            (x + 0.3, 3.6),
            (x + 0.3, 1.8),
            color=GREY,
            ls="--",
            lw=1.0,
        )
        pen.text((x + 0.75, 3.25), name)
        pen.line((x + 1.5, 2.7), (x + 1.7, 2.7), lw=1.2)
        pen.line((x + 1.6, 2.6), (x + 1.6, 2.8), lw=1.2)
    pen.arrow((0.6, 0.6), (3.85, 2.65))
    pen.text((3.0, 1.05), "axis = (x, y)", ACCENT, ha="left")
    pen.measure((2.3, 4.2), (5.5, 4.2), "length")
    pen.measure((9.8, 1.5), (9.8, 3.9), "", at=(0, 0))
    pen.text((9.35, 4.2), "width")
    pen.measure((9.3, 2.3), (9.6, 2.3), "")
    pen.text((9.2, 2.3), "setback", ha="right", size=9)
    pen.text((7.0, 0.75), "dashed: columns and walls", size=9)


@sketch(5.6)
def case_floors(pen: Pen) -> None:
    """Draw levels, storeys and rigid zones of a stick beside the building."""
    pen.ground((0.3, 9.7), 0.6)
    z = (0.6, 2.4, 4.4)
    for x in (0.6, 2.8):
        pen.line((x, 0.6), (x, 4.4))
    for k in (1, 2):
        low = z[k] - 0.4
        pen.line((0.6, low), (2.8, low), (2.8, z[k]), (0.6, z[k]), lw=1.0, fill="white")
        pen.box((0.4, z[k] - 0.05), 2.6, 0.25)
        pen.text((4.2, z[k] + 0.22), f"floor {k}", size=9)
        pen.text((1.7, z[k] - 1.0), f"storey {k}", size=9)
    x = 5.6
    pen.line((x, 0.6), (x, 4.75), color=ACCENT, lw=1.6)
    for k in (1, 2):
        pen.thin((3.1, z[k]), (8.4, z[k]))
        pen.line((x, z[k] - 0.4), (x, z[k] + 0.3), lw=5.0)
        pen.ball((x, z[k]), 0.2)
    pen.measure((8.2, 0.6), (8.2, 2.4), "storey_\nheight", at=(0.15, 0.0), ha="left")
    pen.measure((8.2, 2.4), (8.2, 4.4), "storey_\nheight", at=(0.15, 0.0), ha="left")
    for low, high, name, y in ((4.4, 4.7, "rigid_above", 4.75), (4.0, 4.4, "rigid_below", 3.85)):
        pen.measure((6.0, low), (6.0, high), "")
        pen.text((6.15, y), name, ha="left", size=9)
    pen.text((5.6, 5.25), "mass, Jx, Jy, Jz at the mass centre", size=9)
    pen.text((5.3, 3.2), "A, Avy, Avx,\nIx, Iy, Iz", ACCENT, size=9, ha="right")
    pen.text((9.6, 0.9), "base", ha="right", size=9)


@sketch(4.6)
def case_contacts(pen: Pen) -> None:
    """Draw a contact pair with its points, gap and normal, and the sides of a law's force."""
    pen.ground((0.3, 9.7), 0.5)
    for x in (1.0, 3.2):
        pen.line((x, 0.5), (x, 3.4))
    for x in (6.4, 8.8):
        pen.line((x, 0.5), (x, 3.4))
    pen.box((0.7, 3.2), 2.9, 0.35)
    pen.box((5.9, 3.2), 3.3, 0.35)
    pen.text((2.1, 2.3), "building\nof a", size=9)
    pen.text((7.6, 2.3), "building\nof b", size=9)
    pen.dot((3.6, 3.37), (5.9, 3.37), color=ACCENT, size=6)
    pen.text((3.6, 3.9), "a", ACCENT)
    pen.text((5.9, 3.9), "b", ACCENT)
    pen.arrow((3.75, 3.37), (4.9, 3.37), "normal", at=(0.35, 0.35))
    pen.measure((3.6, 2.7), (5.9, 2.7), "gap", at=(0, -0.3))
    pen.thin((3.6, 2.6), (3.6, 3.3))
    pen.thin((5.9, 2.6), (5.9, 3.3))
    pen.arrow((2.4, 4.3), (1.2, 4.3), color=INK)
    pen.text((2.6, 4.3), "$-F\\,\\mathbf{n}$ on a", ha="left", size=9)
    pen.arrow((8.0, 4.3), (9.2, 4.3), color=INK)
    pen.text((7.8, 4.3), "$+F\\,\\mathbf{n}$ on b", ha="right", size=9)


@sketch(5.2)
def case_contact_point(pen: Pen) -> None:
    """Draw a floor that faces a storey: the height in its flexible part, and the patch."""
    pen.ground((0.2, 9.8), 0.4)
    pen.box((0.3, 2.55), 2.2, 0.35)
    pen.text((1.2, 2.2), "floor of b", size=9)
    pen.line((3.7, 0.4), (3.7, 4.5))
    for z in (0.9, 4.3):
        pen.line((3.7, z - 0.4), (6.6, z - 0.4), (6.6, z), (3.7, z), lw=1.0, fill="white")
        pen.box((3.5, z - 0.1), 3.1, 0.25)
    pen.line((3.7, 2.25), (3.7, 3.2), lw=5.0, color=ACCENT)
    pen.dot((2.5, 2.72), color=ACCENT, size=6)
    pen.measure((2.5, 3.6), (3.7, 3.6), "gap")
    pen.thin((2.5, 3.7), (2.5, 2.8))
    pen.thin((3.8, 2.72), (7.4, 2.72))
    for y in (1.05, 3.9):
        pen.thin((6.7, y), (8.9, y))
    pen.measure((7.2, 1.05), (7.2, 2.72), "relative_\nheight", at=(0.1, -0.1), ha="left")
    pen.measure((8.75, 1.05), (8.75, 3.9), "1", at=(0.25, 0.6))
    pen.text((9.9, 4.2), "flexible part", ha="right", size=9)
    pen.text((3.95, 3.2), "patch_width", ACCENT, ha="left", size=9)
    pen.line((6.4, 0.4), (6.4, 4.75), ls="-.", lw=1.0)
    pen.arrow((6.4, 1.9), (3.75, 1.9), "offset", at=(0.0, -0.3))
    pen.text((6.4, 4.95), "axis of the stick of a", size=9)


@sketch(5.0)
def case_devices(pen: Pen) -> None:
    """Draw a device on one anchor, and one on two supports."""
    pen.box((0.2, 0.9), 9.6, 0.4)
    pen.text((1.0, 1.1), "floor", size=9)
    pen.line((1.5, 1.3), (3.7, 1.3), lw=4.5)
    pen.dot((2.6, 1.3), color=ACCENT, size=6)
    for x in (1.9, 3.3):
        pen.spring((x, 1.35), (x, 2.2), coils=3, size=0.15)
    pen.box((1.6, 2.2), 2.0, 2.0)
    pen.dot((2.6, 3.2))
    pen.text((2.6, 3.65), "mass, inertia", size=9)
    pen.measure((4.1, 1.3), (4.1, 3.2), "mass_height", at=(0.15, 0.3), ha="left")
    pen.thin((2.6, 3.2), (4.2, 3.2))
    pen.measure((2.6, 0.65), (3.7, 0.65), "radius", at=(0, -0.3))
    pen.thin((2.6, 0.55), (2.6, 1.3))
    pen.thin((3.7, 0.55), (3.7, 1.3))
    pen.text((2.35, 0.6), "point", ACCENT, ha="right")
    pen.text((1.5, 1.75), "stiffness", ha="right", size=9)
    pen.text((2.6, 4.6), "one anchor")
    for x, name in ((6.4, "1"), (9.0, "2")):
        pen.line((x - 0.4, 1.3), (x + 0.4, 1.3), lw=4.5)
        pen.dot((x, 1.3), color=ACCENT, size=6)
        pen.line((x, 1.3), (x, 2.9))
        pen.text((x, 0.6), f"support {name}", ACCENT, size=9)
    pen.box((6.0, 2.9), 3.4, 0.7, "matrices")
    pen.text((7.7, 4.6), "several supports")


@sketch(4.6)
def case_device_beam(pen: Pen) -> None:
    """Draw springs, beam and body of a device, one on the other."""
    pen.box((0.8, 0.4), 4.4, 0.35, "floor")
    pen.line((2.0, 0.75), (4.0, 0.75), lw=4.5)
    for x in (2.3, 3.7):
        pen.spring((x, 0.8), (x, 1.6), coils=3, size=0.15)
    pen.box((1.9, 1.6), 2.2, 0.3)
    pen.line((3.0, 1.9), (3.0, 3.1), lw=3.5, color=ACCENT)
    pen.box((2.2, 3.1), 1.6, 1.1, "body")
    pen.text((4.4, 1.2), "stiffness: x, y, z, rx, ry, rz", ha="left")
    pen.text((4.4, 1.75), "base", ha="left")
    pen.text((4.4, 2.35), "beam: bending, shear, mass", ACCENT, ha="left")
    pen.measure((1.5, 1.9), (1.5, 3.1), "length", at=(-0.15, 0), ha="right")
    pen.text((4.4, 3.65), "mass, inertia or shape", ha="left")


@sketch(4.6)
def case_motions(pen: Pen) -> None:
    """Draw the components of the ground motion under two buildings."""

    def cube(x: float, y: float, w: float, h: float) -> None:
        d = (0.7, 0.4)
        pen.line((x, y), (x + w, y), (x + w, y + h), (x, y + h), fill=LIGHT)
        pen.line(
            (x, y + h),
            (x + d[0], y + h + d[1]),
            (x + w + d[0], y + h + d[1]),
            (x + w, y + h),
            fill="white",
        )
        pen.line(
            (x + w, y),
            (x + w + d[0], y + d[1]),
            (x + w + d[0], y + h + d[1]),
            (x + w, y + h),
            fill="white",
        )

    cube(1.0, 1.3, 1.9, 2.2)
    cube(4.2, 1.3, 1.6, 2.6)
    pen.line((0.3, 0.9), (6.6, 0.9), lw=1.0)
    o = (7.4, 2.0)
    pen.arrow(o, (9.0, 2.0), "x", at=(1.0, 0))
    pen.arrow(o, (8.3, 2.75), "y", at=(0.65, 0.5))
    pen.arrow(o, (7.4, 3.5), "z", at=(0.0, 1.0))
    pen.text((7.2, 1.35), "one motion\na direction", ha="left", size=9)
    pen.arrow((2.6, 0.45), (4.2, 0.45), "", color=ACCENT)
    pen.text((4.5, 0.45), "acceleration of the ground", ACCENT, ha="left", size=9)


@sketch(4.2)
def case_soil(pen: Pen) -> None:
    """Draw a raft in the ground, with its size and embedment."""
    pen.line((0.2, 2.4), (3.0, 2.4), lw=1.8)
    pen.line((7.2, 2.4), (9.8, 2.4), lw=1.8)
    pen.line((3.0, 2.4), (3.0, 1.3), (7.2, 1.3), (7.2, 2.4), lw=1.0, ls="--")
    pen.box((3.0, 1.3), 4.2, 0.6, "", fill=GREY)
    pen.box((3.6, 1.9), 3.0, 1.7)
    pen.text((4.3, 3.2), "building", size=9)
    pen.text((4.3, 1.6), "raft", size=9)
    pen.thin((5.1, 3.6), (5.1, 1.3), ls="-.")
    pen.measure((2.6, 1.3), (2.6, 1.9), "thickness", at=(-0.15, 0), ha="right")
    pen.thin((2.5, 1.9), (3.0, 1.9))
    pen.thin((2.5, 1.3), (8.0, 1.3))
    pen.measure((7.7, 1.3), (7.7, 2.4), "embedment", at=(0.15, 0), ha="left")
    pen.measure((3.0, 0.95), (7.2, 0.95), "length (along x)", at=(0, -0.32))
    pen.text((0.3, 0.45), "shear_velocity,\ndensity, ν, ζ", ha="left", size=9)
    pen.text((6.8, 2.75), "base = top of the raft", ha="left", size=9)
    pen.line((6.75, 2.65), (6.3, 1.95), lw=0.7)
    pen.text((5.1, 3.9), "axis", size=9)


@sketch(4.4)
def case_wave_passage(pen: Pen) -> None:
    """Draw wave fronts that reach two buildings in plan one after the other."""
    angle = np.radians(25)
    d = np.array([np.cos(angle), np.sin(angle)])
    n = np.array([-d[1], d[0]])
    for k in range(3):
        a = np.array([1.1, 2.2]) + 0.75 * k * d
        ends = a - 1.4 * n, a + 1.4 * n
        pen.curve(*np.array(ends).T, color=ACCENT if k == 2 else GREY)
    pen.arrow((2.9, 1.1), tuple(np.array([2.9, 1.1]) + 1.6 * d), "direction", at=(1.2, -0.35))
    pen.box((4.2, 2.0), 2.0, 1.5)
    pen.box((7.4, 2.0), 2.0, 1.5)
    pen.dot((5.2, 2.75), (8.4, 2.75))
    pen.text((5.2, 3.2), "B1", size=9)
    pen.text((8.4, 3.2), "B2", size=9)
    pen.text((5.2, 2.3), "$a_g(t)$", ACCENT)
    pen.text((8.4, 2.3), "$a_g(t-\\tau)$", ACCENT)
    pen.text((6.6, 0.45), "$\\tau$ = distance along direction / apparent_velocity", size=9)
    pen.text((6.8, 4.0), "plan; dots: axes", size=9)


@sketch(5.0)
def case_wall_impact(pen: Pen) -> None:
    """Draw the floor that is displaced and released before the rigid wall."""
    pen.ground((0.5, 9.0), 0.5)
    z = np.array([0.5, 1.7, 2.9, 4.1])
    shift = np.array([0.0, 0.1, 0.3, 0.7])
    for left in (3.6, 6.0):
        pen.curve(np.full(4, left), z, color=GREY, ls="--", lw=1.0)
        fine = np.linspace(0.5, 4.1, 50)
        pen.curve(left - np.interp(fine, z, shift), fine, color=INK)
    for k in (1, 2, 3):
        pen.box((3.6 - shift[k], z[k] - 0.12), 2.4, 0.24, fill=ACCENT if k == 3 else LIGHT)
    pen.wall(7.0, (0.5, 4.6))
    pen.measure((6.0, 1.05), (7.0, 1.05), "gap", at=(0, 0.28))
    pen.thin((6.0, 4.1), (6.0, 4.6))
    pen.thin((5.3, 4.1), (5.3, 4.6))
    pen.measure((5.3, 4.5), (6.0, 4.5), "displacement", at=(-1.6, 0.1))
    pen.text((2.7, 4.1), "displaced_floor", ACCENT, ha="right", size=9)
    pen.text((7.4, 2.9), "rigid wall", ha="left", size=9)
    pen.text((7.4, 2.4), "no ground motion", ha="left", size=9)


@sketch(5.4)
def case_mesh(pen: Pen) -> None:
    """Draw the plan of a generated mesh: corner, walls, beam, column and impact edge."""
    pen.box((1.5, 0.9), 6.2, 3.7)
    for wall in (((1.8, 1.2), (1.8, 4.3)), ((4.8, 2.3), (4.8, 4.3)), ((1.8, 4.3), (7.4, 4.3))):
        pen.line(*wall, lw=3.5)
    pen.line((4.8, 2.3), (7.4, 2.3), lw=1.0, ls="--")
    for x in (6.0, 7.3):
        pen.box((x - 0.12, 1.2), 0.24, 0.24, fill=INK)
    pen.dot((1.5, 0.9), color=ACCENT, size=6)
    pen.arrow((1.5, 0.9), (2.6, 0.9))
    pen.arrow((1.5, 0.9), (1.5, 2.0))
    pen.text((2.8, 0.6), "x", ACCENT)
    pen.text((1.25, 1.9), "y", ACCENT)
    pen.text((1.5, 0.4), "corner: (0, 0)", ACCENT, size=9)
    pen.text((2.05, 3.7), "wall", ha="left", size=9)
    pen.text((6.2, 2.55), "beam", size=9)
    pen.text((6.0, 1.75), "column", size=9)
    pen.line((7.7, 0.9), (7.7, 4.6), color=ACCENT, lw=4.0)
    pen.text((7.9, 3.4), 'impact_edge\n= "x+"', ACCENT, ha="left", size=9)
    pen.measure((1.5, 4.95), (7.7, 4.95), "length", at=(0, 0.25))
    pen.measure((0.9, 0.9), (0.9, 4.6), "")
    pen.text((0.75, 4.85), "width")
    pen.measure((1.5, 2.9), (1.8, 2.9), "")
    pen.text((2.05, 2.9), "wall_setback", ha="left", size=9)


@sketch(4.6)
def case_bays(pen: Pen) -> None:
    """Draw a wall of a storey with an opening: centre, sill, width and height."""
    pen.line((0.9, 0.9), (8.7, 0.9), (8.7, 4.0), (0.9, 4.0), fill=LIGHT)
    pen.line((0.5, 0.9), (9.1, 0.9), lw=4.0)
    pen.line((0.5, 4.0), (9.1, 4.0), lw=4.0)
    pen.line((4.4, 1.8), (6.6, 1.8), (6.6, 3.3), (4.4, 3.3), fill="white")
    pen.dot((0.9, 0.9), (8.7, 0.9), color=ACCENT)
    pen.text((0.9, 0.35), "(x1, y1)", ACCENT)
    pen.text((8.7, 0.35), "(x2, y2)", ACCENT)
    pen.measure((0.9, 2.3), (5.5, 2.3), "centre", at=(-0.9, 0.28))
    pen.thin((5.5, 1.8), (5.5, 3.3))
    pen.measure((4.4, 3.6), (6.6, 3.6), "", at=(0, 0))
    pen.text((6.8, 3.62), "width", ha="left", size=9)
    pen.measure((6.9, 1.8), (6.9, 3.3), "height", at=(0.15, 0), ha="left")
    pen.measure((5.0, 0.95), (5.0, 1.8), "sill", at=(0.15, 0), ha="left")
    pen.text((2.2, 1.3), "wall of one storey", size=9)
    pen.text((5.0, 4.4), "floor above", size=9)
    pen.text((5.0, 0.5), "floor below", size=9)


@sketch(3.8)
def case_beams(pen: Pen) -> None:
    """Draw the section of a beam below its slab, with the offset of its axis."""
    pen.box((0.8, 2.3), 7.2, 0.6, "", fill=LIGHT)
    pen.thin((0.4, 2.6), (8.3, 2.6), ls="-.")
    pen.text((8.4, 2.6), "mid-plane", ha="left", size=9)
    pen.box((3.6, 0.5), 1.6, 1.8, fill="white")
    pen.dot((4.4, 1.4), color=ACCENT)
    pen.thin((4.4, 1.4), (7.0, 1.4))
    pen.measure((6.8, 1.4), (6.8, 2.6), "offset (negative)", at=(0.15, -0.35), ha="left")
    pen.measure((3.6, 0.25), (5.2, 0.25), "width", at=(1.35, 0.0))
    pen.measure((3.2, 0.5), (3.2, 2.3), "depth", at=(-0.15, 0), ha="right")
    pen.text((1.3, 3.2), "slab", size=9)
    pen.text((4.4, 3.3), "line of nodes", size=9)
    pen.line((4.4, 3.1), (4.4, 2.7), lw=0.8)
    pen.dot((4.4, 2.6))


@sketch(5.0)
def case_transient(pen: Pen) -> None:
    """Draw a floor in plan with its probes, and the line load of a pair on its side."""
    pen.box((2.6, 0.7), 5.6, 3.6)
    pen.line((2.6, 0.7), (2.6, 4.3), color=ACCENT, lw=4.0)
    pen.dot(*((x, 2.5) for x in np.linspace(2.6, 8.2, 6)), size=4)
    pen.dot((5.4, 3.3), color=ACCENT, size=6)
    pen.text((5.4, 3.7), "centre_8, mass centre", size=9)
    pen.text((2.85, 2.85), "edge_8", ha="left", size=9)
    pen.text((5.4, 2.1), "line_1, line_2, ... across the floor", size=9)
    for y in np.linspace(0.9, 4.1, 6):
        pen.arrow((1.8, y), (2.5, y))
    pen.text((1.6, 0.9), "spread:\nuniform", ACCENT, ha="right", size=9)
    pen.measure((1.3, 3.0), (1.3, 4.0), "patch_\nwidth", at=(-0.15, 0), ha="right")
    pen.thin((1.2, 4.0), (2.6, 4.0))
    pen.thin((1.2, 3.0), (2.6, 3.0))
    pen.text((5.4, 4.65), "floor 8 in plan", size=9)
    pen.text((2.9, 1.1), "impact edge", ACCENT, ha="left", size=9)


@sketch(3.8)
def case_damping(pen: Pen) -> None:
    """Draw the damping ratio of three laws over the frequency."""
    pen.frame((0.8, 0.8), 8.6, 2.7, "f", "damping ratio $\\xi$")
    f = np.linspace(0.35, 8.2, 300)
    one, two = 1.2, 4.8
    rayleigh = 1.0 * one * two / (one + two) / f + 1.0 * f / (one + two)
    keep = rayleigh < 2.5
    pen.curve(0.8 + f[keep], 0.8 + rayleigh[keep])
    pen.line((0.8, 1.8), (9.0, 1.8), ls="--", lw=1.2)
    points = ((1.5, 1.15), (3.6, 1.35), (7.4, 1.6), (9.0, 1.6))
    pen.line((0.8, 1.15), *points, color=GREY)
    for at, name in ((one, "$f_1$"), (two, "$f_2$")):
        pen.thin((0.8 + at, 0.8), (0.8 + at, 1.8))
        pen.dot((0.8 + at, 1.8), color=ACCENT, size=4)
        pen.text((0.8 + at, 0.45), name)
    pen.text((9.3, 2.65), "rayleigh", ACCENT, ha="right")
    pen.text((3.6, 2.1), "constant", ha="left")
    pen.text((8.0, 1.2), "table", GREY, ha="left")


@sketch(4.0)
def case_contact_laws(pen: Pen) -> None:
    """Draw force over penetration of three laws."""
    angle = np.linspace(0, np.pi, 120)
    p, v = np.sin(angle), np.cos(angle)
    for x, force, name in (
        (0.6, 1.55 * (p + 0.3 * v), "kelvin-voigt"),
        (3.9, 2.1 * p**1.5, "hertz"),
        (7.2, 2.0 * p**1.5 * (1 + 0.3 * v), "hertz-damp,\nhunt-crossley"),
    ):
        pen.frame((x, 1.3), 2.5, 2.3, "p", "F")
        pen.curve(x + 1.9 * p, 1.3 + force)
        pen.text((x + 1.1, 0.5), name, size=9)
    pen.text((1.1, 1.0), "tension", size=9, ha="left")


@sketch(3.9)
def case_design_spectrum(pen: Pen) -> None:
    """Draw the elastic spectrum with its level, amplification and corner periods."""
    pen.frame((1.4, 0.9), 8.0, 2.7, "T", "$S_e$")
    T = np.linspace(0.0, 3.0, 400)
    B, C, D = 0.3, 0.9, 2.2
    S = np.select([T < B, T < C, T < D], [1 + 1.5 * T / B, 2.5, 2.5 * C / np.maximum(T, C)], 0)
    S = np.where(T >= D, 2.5 * C * D / np.maximum(T, D) ** 2, S)
    x, y = 1.4 + 2.5 * T, 0.9 + 0.85 * S
    pen.curve(x, y)
    for at, name in ((B, "$T_B$"), (C, "$T_C$"), (D, "$T_D$")):
        pen.thin((1.4 + 2.5 * at, 0.9), (1.4 + 2.5 * at, 0.9 + 0.85 * float(np.interp(at, T, S))))
        pen.text((1.4 + 2.5 * at, 0.55), name)
    pen.text((1.3, 1.75), "level", ha="right", size=9)
    pen.text((4.0, 3.05), "level × amplification (5 % damping)", ha="left", size=9)


@sketch(3.6)
def case_pounding(pen: Pen) -> None:
    """Draw an impact force with its time steps."""
    pen.frame((0.8, 0.9), 8.6, 2.4, "t", "F")
    t = np.linspace(0, 1, 18)
    fine = np.linspace(0, 1, 200)
    x0, w = 2.4, 4.6
    pen.curve(x0 + w * fine, 0.9 + 1.9 * np.sin(np.pi * fine))
    pen.dot(*zip(x0 + w * t, 0.9 + 1.9 * np.sin(np.pi * t), strict=True), size=4)
    pen.measure((x0, 0.5), (x0 + w, 0.5), "", at=(0, 0))
    pen.text((x0 + w / 2, 0.2), "at least points_per_impact steps", size=9)
    pen.text((7.2, 2.0), "time_step:\nfrom point to point", ha="left", size=9)


@sketch(4.0)
def case_added_mass(pen: Pen) -> None:
    """Draw the strips of a slab that carry the added mass."""
    pen.box((2.0, 0.9), 6.0, 2.4)
    for x, w in ((2.0, 0.6), (4.7, 0.6), (7.4, 0.6)):
        pen.line((x, 0.9), (x + w, 0.9), (x + w, 3.3), (x, 3.3), fill="#bcd4ea")
    pen.text((2.3, 3.65), "edges / 2", ACCENT)
    pen.text((5.0, 3.65), "middle", ACCENT)
    pen.text((7.7, 3.65), "edges / 2", ACCENT)
    pen.measure((4.7, 0.6), (5.3, 0.6), "strip", at=(0, -0.3))
    pen.arrow((8.5, 1.2), (9.4, 1.2), "across", at=(0, 0.3), color=INK)
    pen.text((3.65, 2.1), "rest:\neven", size=9)

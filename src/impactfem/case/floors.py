"""Materials, and the floor table of a building: one row a floor with the storey below it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import ValidationInfo, model_validator

from impactfem.case.base import Section, refuse, rule
from impactfem.case.damping import RayleighDamping
from impactfem.case.leaf import MOST_FLOORS, NameOf, Whole
from impactfem.case.quantity import (
    Density,
    Inertia,
    Mass,
    PositiveFactor,
    PositiveLength,
    Si,
    Stress,
)
from impactfem.case.reading import reading_of
from impactfem.case.table import Table, read_table
from impactfem.system.errors import Fault


class Material(Section):
    """An isotropic, linear elastic material."""

    young_modulus: Stress
    """Young's modulus E."""
    poisson_ratio: Annotated[float, Si("-", ge=0, lt=0.5)]
    """Poisson's ratio ν."""
    density: Density | None = None
    """Mass density of the 3D model; sticks use the floor table."""
    compressive_strength: Stress | None = None
    """Compressive strength, compared with the mean bearing pressure of an impact."""


UNKNOWN_MATERIAL = Material(young_modulus=1e9, poisson_ratio=0.2, density=1e3)
UNKNOWN_DAMPING = RayleighDamping(ratio=0.05, frequencies=(1.0, 20.0))
"""Stand for those that have faults, where only the other faults of a case are looked for."""


@dataclass(frozen=True)
class MaterialOf(NameOf):
    """The name of a material, which must have a density where ``dense``; held as the material."""

    group: str = "materials"
    word: str = "material"
    dense: bool = False

    def check(self, value: Any, info: ValidationInfo) -> Any:
        """Take the material of the name."""
        if isinstance(value, Material):
            return value
        name = super().check(value, info)
        if info.context is None:
            raise refuse("expected a material")
        raw = info.context.value("materials", name)
        if self.dense and isinstance(raw, dict) and "density" not in raw:
            raise refuse(
                f"expected a material with a density, which is missing in [materials.{name}]",
                kind="no_density",
            )
        return info.context.values.get("materials", {}).get(name, UNKNOWN_MATERIAL)


FLOORS = "a floor table (CSV)"


SECTION = ("Ix", "Iy", "Iz", "A", "Avx", "Avy")
"""Columns of a floor table with the section of the storey."""


class Floor(Section):
    """A floor and the storey below it: one row of the floor table, bottom to top.

    The axes are those of the case: z is vertical and the stick's axis. A storey of the flexible
    height L deforms by V L/(G A_v) under a shear force V: ``Avx`` is for a force along x, ``Avy``
    for one along y. In the paper's Appendix A ``A_vz`` is the one along x, and ``I_z`` is close to
    I_x + I_y and so polar.
    """

    TOGETHER: ClassVar = (("Jx", "Jy", "Jz"), SECTION, ("kx", "ky"))

    floor: Annotated[int, Whole(1)]
    """Number of the floor, increasing upwards."""
    mass: Mass
    """Mass of the floor, lumped at its mass centre."""
    Jx: Inertia = math.nan
    """Moment of inertia of the floor's mass about x; default, with Jy and Jz, that of a uniform
    plate with the plan of the floor."""
    Jy: Inertia = math.nan
    """Moment of inertia of the floor's mass about y."""
    Jz: Inertia = math.nan
    """Moment of inertia of the floor's mass about z."""
    kx: Annotated[float | None, Si("N/m", gt=0)] = None
    """Stiffness of the storey along x, storey shear over storey drift, in place of areas and second
    moments: a shear building, whose floors stay level."""
    ky: Annotated[float | None, Si("N/m", gt=0)] = None
    """Stiffness of the storey along y."""
    kt: Annotated[float | None, Si("N m/rad", gt=0)] = None
    """Torsional stiffness of the storey about the axis; default (kx Jx + ky Jy)/mass, that of a
    stiffness spread over the plan as the mass."""
    Ix: Annotated[float | None, Si("m4", gt=0)] = None
    """Second moment of area of the storey, bending about x."""
    Iy: Annotated[float | None, Si("m4", gt=0)] = None
    """Second moment of area of the storey, bending about y."""
    Iz: Annotated[float | None, Si("m4", gt=0)] = None
    """Torsion constant of the storey about z."""
    A: Annotated[float | None, Si("m2", gt=0)] = None
    """Area of the storey's cross-section."""
    Avy: Annotated[float | None, Si("m2", gt=0)] = None
    """Shear area of the storey for a force along y."""
    Avx: Annotated[float | None, Si("m2", gt=0)] = None
    """Shear area of the storey for a force along x."""
    storey_height: PositiveLength
    """Height of the storey between mass centres; of the lowest one from the base."""
    storey_height_min: PositiveLength = math.nan
    """Lower bound of the height in the calibration; default the height itself."""
    storey_height_max: PositiveLength = math.nan
    """Upper bound of the height in the calibration; default the height itself."""
    storey_stiffness_factor: PositiveFactor = 1.0
    """Factor on all stiffnesses of this storey, besides the building's."""
    length: Annotated[float | None, Si("m", gt=0)] = None
    """Length of this floor along x; default that of the building."""
    width: Annotated[float | None, Si("m", gt=0)] = None
    """Width of this floor along y; default that of the building."""

    @property
    def gyration(self) -> tuple[float, float, float]:
        """Radii of gyration about x, y and z, √(J/mass) [m]."""
        x, y, z = (math.sqrt(J / self.mass) for J in (self.Jx, self.Jy, self.Jz))
        return x, y, z

    @property
    def inertia_share(self) -> float:
        """Largest moment of inertia over the sum of the other two."""
        J = (self.Jx, self.Jy, self.Jz)
        return max(J) / (sum(J) - max(J))

    @property
    def section(self) -> dict[str, float]:
        """The columns `SECTION` in SI; empty for a storey by its stiffness."""
        given = {key: getattr(self, key) for key in SECTION}
        return {} if None in given.values() else given

    @property
    def has_stiffness(self) -> bool:
        """Whether the row gives the stiffness of the storey, by its section or by springs."""
        return bool(self.section) or self.kx is not None

    @property
    def shear_share(self) -> float | None:
        """Largest shear area over the area; None for a storey by its stiffness."""
        given = self.section
        return max(given["Avy"], given["Avx"]) / given["A"] if given else None

    @model_validator(mode="before")
    @classmethod
    def _fixed_height(cls, data: Any) -> Any:
        """A height without bounds is fixed: both bounds are the height."""
        if isinstance(data, dict) and "storey_height" in data:
            height = data["storey_height"]
            return {"storey_height_min": height, "storey_height_max": height} | data
        return data

    @rule("storey_height_max", "storey_height", "storey_height_min")
    @staticmethod
    def _ordered_bounds(high: float, height: float, low: float) -> Iterator[str]:
        if low > high:
            yield f"expected bounds in order: storey_height_min is {low:g} m"
        if not low <= height <= high:
            yield f"expected bounds around storey_height, which is {height:g} m"


def read_floors(path: Path, faults: list[Fault]) -> Table[Floor] | None:
    """Read a floor table."""

    def bottom_to_top(table: Table[Floor]) -> Iterator[Fault]:
        highest = 0
        for k, (line, row) in enumerate(table):
            if row.floor < highest and all(row.floor != above.floor for above in table.rows[:k]):
                expected = f"expected floors from bottom to top, above {highest}"
                yield table.fault(line, "floor", row.floor, expected)
            highest = max(highest, row.floor)

    def one_stiffness(table: Table[Floor]) -> Iterator[Fault]:
        springs = [key for key in ("kx", "kt") if key in table.headers]
        if springs and ("A" in table.headers or "kx" not in springs):
            expected = "expected either kx, ky and kt, or areas and second moments, not both"
            if "A" not in table.headers:
                expected = "expected kx and ky with kt"
            yield table.fault(table.lines[0], springs[0], None, expected)

    checks = bottom_to_top, one_stiffness
    return read_table(path, Floor, faults, *checks, once=("floor",), most=MOST_FLOORS)


def entry_of(building: Any, info: ValidationInfo) -> dict[str, Any]:
    """The table of a building in the case file that is read; empty where none, or two, are it."""
    tables = [] if info.context is None else info.context.tables("buildings")
    found = [entry for _, entry in tables if entry.get("name") == building]
    return found[0] if len(found) == 1 else {}


def floors_of(building: Any, info: ValidationInfo) -> tuple[Floor, ...]:
    """The floors of a building in the case file that is read; none where they are not known."""
    entry = entry_of(building, info)
    if not entry:
        return ()
    return reading_of(info).table(entry.get("floors"), FLOORS, read_floors) or ()

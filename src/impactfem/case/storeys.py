"""Storey stiffness and moments of inertia of a building that its floor table leaves out.

A floor of the mass m and the plan area A has the moments of inertia of a uniform plate,

    J_x = m/A ∫ y² dA,  J_y = m/A ∫ x² dA,  J_z = J_x + J_y,                             (1)

about the centroid of its plan. A shear building with the masses m_j vibrates in the shape φ with
the circular frequency ω if its storeys have the stiffness

    k_i = ω² Σ_{j ≥ i} m_j φ_j / (φ_i − φ_{i−1}),  φ_0 = 0.                              (2)

The shapes are those of a modal table, for torsion with J_z in place of m, or φ_j = z_j, the height
above the base, where only periods are given. The torsional stiffness is by default that of a
stiffness spread over the plan as the mass,

    k_t = (k_x J_x + k_y J_y) / m.                                                        (3)
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field

from impactfem.case.base import Section, rule
from impactfem.case.floors import Floor
from impactfem.case.leaf import Whole
from impactfem.case.plan import Polygon, second_moments
from impactfem.case.quantity import Number, PositiveTime, Si
from impactfem.case.reading import TableFile
from impactfem.case.table import Table, read_table
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, ImpactfemError

Participation = Annotated[float, Si("-", ge=0, le=1)]
DIRECTIONS = {"UX": "kx", "UY": "ky", "RZ": "kt"}
"""Columns of a modal table, and the storey stiffness that the modes along each determine."""
LEAST = 0.1
"""Least participating mass of the mode that determines the stiffness along a direction."""
MASSES = 0.05
"""Largest difference of the participating mass of a mode by the shapes from that of its table."""


class Periods(Section):
    """First periods of the stick on a clamped base; each scales the storey stiffness along it."""

    x: PositiveTime | None = None
    """First period along x."""
    y: PositiveTime | None = Field(default=None, validate_default=True)
    """First period along y."""

    @rule("y", "x")
    @staticmethod
    def _one_or_both(y: float | None, x: float | None) -> Iterator[str]:
        if x is None and y is None:
            yield 'expected x, y or both, for example { x = "0.9 s", y = "1.1 s" }'


class ModeRow(Section):
    """A mode of a modal table: ETABS and SAP2000, Modal Participating Mass Ratios."""

    model_config = ConfigDict(extra="ignore")

    mode: Annotated[int, Whole(1)]
    """Number of the mode."""
    period: PositiveTime
    """Natural period."""
    UX: Participation
    """Participating mass along x, a part of the total mass."""
    UY: Participation
    """Participating mass along y."""
    RZ: Participation
    """Participating rotational inertia about z."""


class ShapeRow(Section):
    """A floor in a mode: displacements of its mass centre.

    ETABS: Diaphragm Center of Mass Displacements; SAP2000: Joint Displacements (U1, U2, R3).
    """

    model_config = ConfigDict(extra="ignore")

    mode: Annotated[int, Whole(1)]
    """Number of the mode."""
    floor: Annotated[int, Whole(1)]
    """Number of the floor."""
    UX: Number
    """Displacement along x, of any scale."""
    UY: Number
    """Displacement along y."""
    RZ: Number
    """Rotation about z."""


def read_modes(path: Path, faults: list[Fault]) -> Table[ModeRow] | None:
    """Read the periods and participating masses of a modal table."""
    return read_table(path, ModeRow, faults, once=("mode",))


def read_shapes(path: Path, faults: list[Fault]) -> Table[ShapeRow] | None:
    """Read the displacements of the floors in the modes."""
    return read_table(path, ShapeRow, faults, once=("floor", "mode"))


class ModalTable(Section):
    """Modes of a building from another program, which define the stiffness of its storeys."""

    modes: Annotated[tuple[ModeRow, ...], TableFile("a table of modes (CSV)", read_modes)]
    """Periods and participating masses: a CSV file, one row a mode."""
    shapes: Annotated[tuple[ShapeRow, ...], TableFile("a table of shapes (CSV)", read_shapes)]
    """Displacements of the mass centres: a CSV file, one row a mode and floor."""


def with_inertia(floors: Sequence[Floor], plans: Sequence[Polygon | None]) -> tuple[Floor, ...]:
    """Complete the moments of inertia of floors by equation (1).

    ImpactfemError where the plan of a floor is not known.
    """
    found = []
    for floor, plan in zip(floors, plans, strict=True):
        if not math.isnan(floor.Jx):
            found.append(floor)
            continue
        if plan is None:
            raise ImpactfemError(
                "missing; expected the plan of the floors, from which moments of inertia without a "
                'column are computed: type length = "24 m" and width = "15 m", or plan; or give '
                "the floor table Jx, Jy and Jz"
            )
        area, ix, iy = second_moments(plan)
        x, y = floor.mass * ix / area, floor.mass * iy / area
        found.append(floor.model_copy(update={"Jx": x, "Jy": y, "Jz": x + y}))
    return tuple(found)


def with_stiffness(
    floors: Sequence[Floor], periods: Periods | None, table: ModalTable | None
) -> tuple[Floor, ...]:
    """Complete the storey stiffness of floors by equations (2) and (3).

    ImpactfemError where the table and the building do not fit, or nothing gives the stiffness.
    """
    if table is not None:
        update = _by_modes(floors, table)
    elif floors[0].section:
        return tuple(floors)
    elif floors[0].kx is not None:
        update = {}
    elif periods is not None and periods.x is not None and periods.y is not None:
        masses, z = _column(floors, "mass"), np.cumsum(_column(floors, "storey_height"))
        update = {
            key: chain(masses, z, period) for key, period in (("kx", periods.x), ("ky", periods.y))
        }
    else:
        raise ImpactfemError(
            "the stiffness of the storeys is missing; type one of: columns kx [kN/mm] and ky "
            "[kN/mm], or Ix, Iy, Iz, A, Avx and Avy in the floor table; "
            'periods = { x = "0.9 s", y = "1.1 s" }; modal_table = { modes = "modes.csv", '
            'shapes = "shapes.csv" }'
        )
    found = []
    for i, floor in enumerate(floors):
        row = floor.model_copy(update={key: float(k[i]) for key, k in update.items()})
        if row.kt is None and row.kx is not None and row.ky is not None:
            kt = (row.kx * row.Jx + row.ky * row.Jy) / row.mass
            row = row.model_copy(update={"kt": kt})
        found.append(row)
    return tuple(found)


def chain(masses: Array, shape: Array, period: float) -> Array:
    """Return the storey stiffness of a shear building with a mode, equation (2).

    Args:
        masses: Masses or moments of inertia of the floors, shape (n,) [kg, kg m2].
        shape: The mode, shape (n,).
        period: Its period [s].

    ImpactfemError where a storey does not deform along its shear.
    """
    drift = np.diff(shape, prepend=0.0)
    inertia = np.cumsum((masses * shape)[::-1])[::-1]
    wrong = np.flatnonzero(~(inertia * drift > 0.0))
    if wrong.size:
        raise ImpactfemError(
            f"storey {wrong[0] + 1} from the base has a drift of {drift[wrong[0]]:.3g} against its "
            "shear: expected the first mode of a shear building, whose drifts have the sign of the "
            "storey shears"
        )
    return np.asarray((2.0 * math.pi / period) ** 2 * inertia / drift)


def _by_modes(floors: Sequence[Floor], table: ModalTable) -> dict[str, Array]:
    """Storey stiffness by the first mode along each direction of a modal table."""
    found = {}
    for direction, key in DIRECTIONS.items():
        mode = max(table.modes, key=lambda row: getattr(row, direction))
        share = getattr(mode, direction)
        if share < LEAST:
            raise ImpactfemError(
                f"no mode moves the building along {direction}: the largest participation is "
                f"{share:.3g}; expected a mode of at least {LEAST:g}"
            )
        rows = {row.floor: getattr(row, direction) for row in table.shapes if row.mode == mode.mode}
        lacking = [str(floor.floor) for floor in floors if floor.floor not in rows]
        if lacking:
            raise ImpactfemError(
                f"the shapes have no row of mode {mode.mode}, the first one along {direction}, for "
                f"floor {', '.join(lacking)}"
            )
        shape = np.array([rows[floor.floor] for floor in floors])
        masses = _column(floors, "Jz" if direction == "RZ" else "mass")
        whole = float(masses @ shape**2) * masses.sum()
        by_shape = float(masses @ shape) ** 2 / whole if whole > 0.0 else 0.0
        if abs(by_shape - share) > MASSES:
            raise ImpactfemError(
                f"mode {mode.mode} has {share:.1%} of the mass along {direction} by the table of "
                f"modes, and {by_shape:.1%} by its shape and the floor table; expected a "
                f"difference of at most {MASSES:.0%}: correct the masses, or the shapes; a stick "
                "has no mode that couples translation and torsion"
            )
        found[key] = chain(masses, shape, mode.period)
    return found


def _column(floors: Sequence[Floor], key: str) -> Array:
    return np.array([getattr(floor, key) for floor in floors])

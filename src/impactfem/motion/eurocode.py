"""The elastic spectra of EN 1998-1 by type of spectrum and type of ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.system.errors import ImpactfemError

HORIZONTAL_AMPLIFICATION = 2.5  # equations 3.2 to 3.5
VERTICAL_AMPLIFICATION = 3.0  # equations 3.8 to 3.11


@dataclass(frozen=True)
class Shape:
    """A row of the tables: the factor on the ground acceleration and T_B, T_C, T_D [s].

    Args:
        factor: S of a horizontal spectrum, a_vg/a_g of a vertical one [-].
        corner_periods: T_B, T_C, T_D [s].
    """

    factor: float
    corner_periods: tuple[float, float, float]


# EN 1998-1:2004, tables 3.2 (type 1) and 3.3 (type 2), recommended values.
HORIZONTAL = {
    1: {
        "A": Shape(1.0, (0.15, 0.4, 2.0)),
        "B": Shape(1.2, (0.15, 0.5, 2.0)),
        "C": Shape(1.15, (0.20, 0.6, 2.0)),
        "D": Shape(1.35, (0.20, 0.8, 2.0)),
        "E": Shape(1.4, (0.15, 0.5, 2.0)),
    },
    2: {
        "A": Shape(1.0, (0.05, 0.25, 1.2)),
        "B": Shape(1.35, (0.05, 0.25, 1.2)),
        "C": Shape(1.5, (0.10, 0.25, 1.2)),
        "D": Shape(1.8, (0.10, 0.30, 1.2)),
        "E": Shape(1.6, (0.05, 0.25, 1.2)),
    },
}
# EN 1998-1:2004, table 3.4, recommended values; the same for all grounds.
VERTICAL = {1: Shape(0.90, (0.05, 0.15, 1.0)), 2: Shape(0.45, (0.05, 0.15, 1.0))}


def eurocode_spectrum(
    spectrum_type: int,
    ground: str,
    reference_acceleration: float,
    *,
    importance_factor: float = 1.0,
    vertical: bool = False,
    damping: float = 0.05,
) -> DesignSpectrum:
    """Give the elastic spectrum of EN 1998-1:2004, 3.2.2.2 (horizontal) or 3.2.2.3 (vertical).

    With the ground acceleration a_g = γ_I a_gR, the level is a_g S and the amplification 2.5 for a
    horizontal spectrum, a_vg = (a_vg/a_g) a_g and 3.0 for a vertical one, where the ground has no
    say. Values of the tables are those the standard recommends; a national annex may have others.

    Args:
        spectrum_type: 1, or 2 where earthquakes have surface-wave magnitudes up to 5.5.
        ground: Type of ground, "A" to "E".
        reference_acceleration: a_gR on ground A [m/s2].
        importance_factor: γ_I [-].
        vertical: Whether the vertical spectrum is wanted.
        damping: Ratio ξ [-].

    Raises:
        ImpactfemError: There is no such type or ground, or a value is out of range.
    """
    if spectrum_type not in HORIZONTAL:
        raise ImpactfemError(f"the type of an EN 1998-1 spectrum is 1 or 2, got {spectrum_type!r}")
    shape = VERTICAL[spectrum_type] if vertical else ground_shape(HORIZONTAL[spectrum_type], ground)
    return shaped(shape, reference_acceleration, importance_factor, vertical, damping)


def ground_shape(shapes: dict[str, Shape], ground: str) -> Shape:
    """Look a type of ground up.

    Raises:
        ImpactfemError: There is no such ground.
    """
    if ground not in shapes:
        raise ImpactfemError(f"the type of ground is one of {', '.join(shapes)}, got {ground!r}")
    return shapes[ground]


def shaped(
    shape: Shape,
    reference_acceleration: float,
    importance_factor: float,
    vertical: bool,
    damping: float,
) -> DesignSpectrum:
    """Make the spectrum of a row of the tables.

    Args:
        shape: The row.
        reference_acceleration: a_gR [m/s2].
        importance_factor: γ_I [-].
        vertical: Whether the row is of a vertical spectrum.
        damping: Ratio ξ [-].

    Raises:
        ImpactfemError: A value is out of range.
    """
    for name, value in (
        ("reference acceleration", reference_acceleration),
        ("importance factor", importance_factor),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ImpactfemError(f"the {name} must be positive, got {value!r}")
    return DesignSpectrum(
        ground_acceleration=shape.factor * importance_factor * reference_acceleration,
        corner_periods=shape.corner_periods,
        amplification=VERTICAL_AMPLIFICATION if vertical else HORIZONTAL_AMPLIFICATION,
        damping=damping,
    )

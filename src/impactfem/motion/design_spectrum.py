"""Design spectra: by corner periods, of EN 1998-1, of the French decrees, by a table.

A further one is a class or a function here, its section in :mod:`impactfem.case.design_spectrum`,
and its line in :func:`design_spectrum`.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from impactfem.case import design_spectrum as sections
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, ImpactfemError, InputError

HORIZONTAL_AMPLIFICATION = 2.5  # EN 1998-1, equations 3.2 to 3.5
VERTICAL_AMPLIFICATION = 3.0  # EN 1998-1, equations 3.8 to 3.11


class Target(Protocol):
    """A pseudo-acceleration spectrum that a motion is matched to or judged by."""

    @property
    def damping(self) -> float:
        """Damping ratio ξ [-]."""

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> Array:
        """Its ordinates [m/s2] at positive frequencies of any shape [Hz]."""


@dataclass(frozen=True)
class DesignSpectrum:
    """Elastic response spectrum of EN 1998-1:2004, 3.2.2.2, equations 3.2 to 3.6.

    With A = a_g S, F = amplification, and T = 1/f:

        0   <= T <= T_B   S_e = A [1 + T/T_B (η F - 1)]                                  (3.2)
        T_B <= T <= T_C   S_e = A η F                                                    (3.3)
        T_C <= T <= T_D   S_e = A η F T_C / T                                            (3.4)
        T_D <= T          S_e = A η F T_C T_D / T²                                       (3.5)
        η = √(10 / (5 + 100 ξ)) >= 0.55                                                  (3.6)

    The standard ends (3.5) at 4 s; here it goes on, at constant displacement. Values out of range,
    and periods that do not ascend, are refused.
    """

    ground_acceleration: float  #: A, soil factor included: that at zero period [m/s2]
    corner_periods: tuple[float, float, float]  #: T_B, T_C, T_D [s]
    amplification: float = 2.5  #: F of the plateau at 5 % damping
    damping: float = 0.05  #: ξ

    def __post_init__(self) -> None:
        if not 0.0 < self.ground_acceleration < math.inf:
            raise ImpactfemError(
                f"the ground acceleration must be positive, got {self.ground_acceleration!r} m/s2"
            )
        periods = self.corner_periods
        if not (len(periods) == 3 and 0.0 < periods[0] <= periods[1] <= periods[2] < math.inf):
            raise ImpactfemError(
                f"the corner periods must be 0 < T_B <= T_C <= T_D, got {periods!r} s"
            )
        if not 1.0 <= self.amplification < math.inf:
            raise ImpactfemError(
                f"the amplification must be at least 1, got {self.amplification!r}"
            )
        _check_damping(self.damping)

    @property
    def damping_correction(self) -> float:
        """η of (3.6) [-]."""
        return max(0.55, math.sqrt(10.0 / (5.0 + 100.0 * self.damping)))

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> Array:
        """S_e [m/s2] at positive frequencies of any shape [Hz]; inf gives that at zero period."""
        f = _positive(frequency)
        T = 1.0 / f  # 0 for f = inf, which (3.2) takes to A
        T_B, T_C, T_D = self.corner_periods
        plateau = self.damping_correction * self.amplification
        rising = 1.0 + T / T_B * (plateau - 1.0)
        # (3.3) to (3.5) in one: either factor is 1 before its corner, and falls as 1/T behind it.
        falling = plateau * (T_C / np.maximum(T, T_C)) * (T_D / np.maximum(T, T_D))
        return np.asarray(self.ground_acceleration * np.where(T < T_B, rising, falling))


@dataclass(frozen=True, eq=False)
class TableSpectrum:
    """Pseudo-acceleration at given frequencies, straight between them on logarithmic axes.

    Above the last frequency the acceleration stays (zero-period acceleration), below the first
    the displacement does, S_a ~ f². Neither is part of the table: `range` says where it holds.
    Values that are not positive, and frequencies that do not ascend, are refused.
    """

    frequency: Array  #: (n,), n >= 2 [Hz]
    acceleration: Array  #: (n,) [m/s2]
    damping: float = 0.05  #: ξ that the table was made for

    def __post_init__(self) -> None:
        f = np.array(self.frequency, dtype=np.float64)
        a = np.array(self.acceleration, dtype=np.float64)
        if f.ndim != 1 or f.shape != a.shape or f.size < 2:
            raise ImpactfemError(
                f"a table spectrum needs at least 2 points, got shapes {f.shape} and {a.shape}"
            )
        if not (np.all(np.isfinite(f)) and f[0] > 0.0 and np.all(np.diff(f) > 0.0)):
            raise ImpactfemError("the frequencies of a table spectrum must be positive and ascend")
        if not (np.all(np.isfinite(a)) and np.all(a > 0.0)):
            raise ImpactfemError("the accelerations of a table spectrum must be positive")
        _check_damping(self.damping)
        for name, values in (("frequency", f), ("acceleration", a)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest frequency of the table [Hz]."""
        return float(self.frequency[0]), float(self.frequency[-1])

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> Array:
        """Its ordinates [m/s2] at positive frequencies [Hz]; inf gives that at zero period."""
        f = _positive(frequency)
        inside = np.exp(np.interp(np.log(f), np.log(self.frequency), np.log(self.acceleration)))
        return np.asarray(inside * np.minimum(f / self.frequency[0], 1.0) ** 2)


# A row of the standards' tables: the factor on the ground acceleration (S of a horizontal
# spectrum, a_vg/a_g of a vertical one) [-], and T_B, T_C, T_D [s].
Row = tuple[float, tuple[float, float, float]]

# EN 1998-1:2004, tables 3.2 (type 1) and 3.3 (type 2), recommended values.
HORIZONTAL: dict[int, dict[str, Row]] = {
    1: {
        "A": (1.0, (0.15, 0.4, 2.0)),
        "B": (1.2, (0.15, 0.5, 2.0)),
        "C": (1.15, (0.20, 0.6, 2.0)),
        "D": (1.35, (0.20, 0.8, 2.0)),
        "E": (1.4, (0.15, 0.5, 2.0)),
    },
    2: {
        "A": (1.0, (0.05, 0.25, 1.2)),
        "B": (1.35, (0.05, 0.25, 1.2)),
        "C": (1.5, (0.10, 0.25, 1.2)),
        "D": (1.8, (0.10, 0.30, 1.2)),
        "E": (1.6, (0.05, 0.25, 1.2)),
    },
}
# EN 1998-1:2004, table 3.4, recommended values; the same for all grounds.
VERTICAL: dict[int, Row] = {1: (0.90, (0.05, 0.15, 1.0)), 2: (0.45, (0.05, 0.15, 1.0))}


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
    horizontal spectrum, a_vg = (a_vg/a_g) a_g and 3.0 for a vertical one, whatever the
    ground. Values of the tables are those the standard recommends; a national annex may have
    others. Type 2 is for surface-wave magnitudes up to 5.5, grounds are "A" to "E", and a_gR is
    the reference acceleration on ground A [m/s2].

    Raises:
        ImpactfemError: There is no such type or ground, or a value is out of range.
    """
    if spectrum_type not in HORIZONTAL:
        raise ImpactfemError(f"the type of an EN 1998-1 spectrum is 1 or 2, got {spectrum_type!r}")
    row = VERTICAL[spectrum_type] if vertical else _row(HORIZONTAL[spectrum_type], ground)
    return _spectrum_of(row, reference_acceleration, importance_factor, vertical, damping)


# Arrêté of 22 October 2010, article 4: a_gr by zone of seismicity [m/s2].
REFERENCE_ACCELERATION = {1: 0.4, 2: 0.7, 3: 1.1, 4: 1.6, 5: 3.0}

# The first set of article 4, for zones 1 to 4, and the second, for zone 5: type 1 of EN 1998-1.
_MODERATE: dict[str, Row] = {
    "A": (1.0, (0.03, 0.20, 2.5)),
    "B": (1.35, (0.05, 0.25, 2.5)),
    "C": (1.5, (0.06, 0.40, 2.0)),
    "D": (1.6, (0.10, 0.60, 1.5)),
    "E": (1.8, (0.08, 0.45, 1.25)),
}
_STRONG = HORIZONTAL[1]
_MODERATE_VERTICAL: Row = (0.8, (0.03, 0.20, 2.5))
_STRONG_VERTICAL: Row = (0.9, (0.15, 0.40, 2.0))
_FIRST_STRONG_ZONE = {"ordinary": 5, "special": 4}


def decree_spectrum(
    zone: int,
    ground: str,
    *,
    importance_factor: float = 1.0,
    text: str = "ordinary",
    vertical: bool = False,
    damping: float = 0.05,
) -> DesignSpectrum:
    """Give the elastic spectrum of the French decrees, in the form of EN 1998-1.

    The arrêté of 22 October 2010 (ordinary risk) has one set of soil factors and corner periods
    for zones 1 to 4 and another, that of type 1 of the Eurocode, for zone 5; the arrêté of
    4 October 2010 (special risk, article 12-3) takes the second from zone 4 on. The level is
    γ_I a_gr S, or γ_I a_gr (a_vg/a_g) for the vertical spectrum; the accelerations of the
    special-risk text are its own, so γ_I stands for their ratio to a_gr. Zones are 1 to 5, grounds
    "A" to "E", which the vertical spectrum does not depend on.

    Raises:
        ImpactfemError: There is no such zone, ground or text, or a value is out of range.
    """
    if zone not in REFERENCE_ACCELERATION:
        raise ImpactfemError(f"the zone of seismicity is 1 to 5, got {zone!r}")
    if text not in _FIRST_STRONG_ZONE:
        raise ImpactfemError(f"the text is 'ordinary' or 'special', got {text!r}")
    strong = zone >= _FIRST_STRONG_ZONE[text]
    if vertical:
        row = _STRONG_VERTICAL if strong else _MODERATE_VERTICAL
    else:
        row = _row(_STRONG if strong else _MODERATE, ground)
    level = REFERENCE_ACCELERATION[zone]
    return _spectrum_of(row, level, importance_factor, vertical, damping)


def design_spectrum(section: sections.Spectrum, damping: float) -> DesignSpectrum | TableSpectrum:
    """Give the spectrum of a section of the case file at a damping ratio.

    Raises:
        InputError: The table of the spectrum is not usable, or does not have this damping.
    """
    match section:
        case sections.EurocodeSpectrum():
            return eurocode_spectrum(**section.model_dump(exclude={"type"}), damping=damping)
        case sections.DecreeSpectrum():
            return decree_spectrum(**section.model_dump(exclude={"type"}), damping=damping)
        case sections.TableSpectrum():
            faults: list[Fault] = []
            table = sections.read_spectrum(section.file, faults)
            points = table.at(damping) if table is not None else None
            if points is None:
                expected = "the table does not have this damping"
                raise InputError(faults or [Fault(section.file, "damping", damping, expected)])
            return TableSpectrum(np.array(points[0]), np.array(points[1]), damping)
        case sections.DesignSpectrum():
            return DesignSpectrum(**section.model_dump(exclude={"type"}), damping=damping)


def _positive(frequency: npt.ArrayLike) -> Array:
    f = np.asarray(frequency, dtype=np.float64)
    if not np.all(f > 0.0):
        raise ImpactfemError("the frequencies of a design spectrum must be positive")
    return f


def _check_damping(ratio: float) -> None:
    if not 0.0 <= ratio < 1.0:
        raise ImpactfemError(f"the damping must be 0 <= ratio < 1 (5 % is 0.05), got {ratio!r}")


def _row(rows: dict[str, Row], ground: str) -> Row:
    if ground not in rows:
        raise ImpactfemError(f"the type of ground is one of {', '.join(rows)}, got {ground!r}")
    return rows[ground]


def _spectrum_of(
    row: Row,
    reference_acceleration: float,
    importance_factor: float,
    vertical: bool,
    damping: float,
) -> DesignSpectrum:
    """The spectrum of a row of the tables, at the level γ_I a_gR times the row's factor."""
    for name, value in (
        ("reference acceleration", reference_acceleration),
        ("importance factor", importance_factor),
    ):
        if not 0.0 < value < math.inf:
            raise ImpactfemError(f"the {name} must be positive, got {value!r}")
    factor, corner_periods = row
    return DesignSpectrum(
        ground_acceleration=factor * importance_factor * reference_acceleration,
        corner_periods=corner_periods,
        amplification=VERTICAL_AMPLIFICATION if vertical else HORIZONTAL_AMPLIFICATION,
        damping=damping,
    )

"""Design spectra that a synthetic motion is matched to: by corner periods, standard, or table."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, StrictBool, Tag, ValidationInfo, field_validator

from impactfem.case.base import Section, ascending, refuse
from impactfem.case.leaf import Whole
from impactfem.case.quantity import Acceleration, Frequency, PositiveFactor, PositiveTime, Si
from impactfem.case.reading import TableFile
from impactfem.case.table import MOST_POINTS, Table, read_table
from impactfem.system.errors import Fault

Ground = Literal["A", "B", "C", "D", "E"]
TABLE = "a table of a design spectrum (CSV)"

_SAME_DAMPING = 1e-6


class DesignSpectrum(Section):
    """Elastic design spectrum in the form of Eurocode 8, given by its level and corner periods."""

    ground_acceleration: Acceleration
    """Level of the spectrum at zero period: a_g S, the ground acceleration on the soil of the
    site."""
    amplification: Annotated[float, Si("-", ge=1)] = 2.5
    """Ratio of the plateau to the level, at 5 % damping."""
    corner_periods: tuple[PositiveTime, PositiveTime, PositiveTime]
    """Corner periods T_B < T_C < T_D: the plateau lies between the first two, constant velocity
    between the last two."""
    type: Literal["corner-periods"] = "corner-periods"
    """Given by its level and corner periods."""

    _increasing = ascending("corner_periods", "expected increasing corner periods T_B < T_C < T_D")


class EurocodeSpectrum(Section):
    """Elastic spectrum of EN 1998-1:2004 with the values that the standard recommends."""

    type: Literal["ec8"]
    """Spectrum of EN 1998-1."""
    spectrum_type: Annotated[int, Whole(1, 2)]
    """Type of spectrum: 2 if the governing surface-wave magnitude is at most 5.5, else 1."""
    ground: Ground
    """Type of ground, table 3.1; without influence on the vertical spectrum."""
    reference_acceleration: Acceleration
    """Reference peak ground acceleration a_gR on ground A."""
    importance_factor: PositiveFactor = 1.0
    """Importance factor γ_I on the reference acceleration."""
    vertical: StrictBool = False
    """true gives the vertical spectrum, 3.2.2.3."""


class DecreeSpectrum(Section):
    """Elastic spectrum of the French decrees: zones of seismicity 1 to 5."""

    type: Literal["french-decree"]
    """Spectrum of the French decrees."""
    text: Literal["ordinary", "special"] = "ordinary"
    """The text: 'ordinary' risk, arrêté of 22 October 2010, or 'special' risk, arrêté of 4 October
    2010, article 12-3."""
    zone: Annotated[int, Whole(1, 5)]
    """Zone of seismicity."""
    ground: Ground
    """Type of ground; without influence on the vertical spectrum."""
    importance_factor: PositiveFactor | None = Field(default=None, validate_default=True)
    """Importance factor γ_I, default 1; required with text 'special': the acceleration of that text
    over a_gr of the zone (0.4, 0.7, 1.1, 1.6, 3.0 m/s2)."""
    vertical: StrictBool = False
    """true gives the vertical spectrum."""

    @field_validator("importance_factor")
    @classmethod
    def _of_the_text(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None and info.data.get("text") == "special":
            expected = "the acceleration of the special-risk text over the zone's a_gr"
            raise refuse(f"missing; expected {expected}", kind="missing")
        return 1.0 if value is None else value


class SpectrumPoint(Section):
    """One row of the table of a design spectrum."""

    frequency: Frequency = math.nan
    """Frequency; the table has this column or the next."""
    period: PositiveTime = math.nan
    """Period; the table has this column or the one before."""
    acceleration: Acceleration
    """Pseudo-acceleration there."""
    damping: Annotated[float | None, Si("-", ge=0, lt=1)] = None
    """Damping ratio it holds for; without this column, that of the motion."""


@dataclass(frozen=True)
class SpectrumTable:
    """The points of a table by damping."""

    #: Frequencies [Hz], ascending, and pseudo-accelerations [m/s2] by damping ratio; the key is
    #: None in a table without dampings.
    points: dict[float | None, tuple[tuple[float, ...], tuple[float, ...]]]

    def at(self, damping: float) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """The points that hold for a damping ratio; None when there are none."""
        for known, points in self.points.items():
            if known is None or abs(known - damping) <= _SAME_DAMPING:
                return points
        return None

    @property
    def dampings(self) -> str:
        """The dampings of the table, for a message."""
        return ", ".join(f"{100.0 * known:g} %" for known in self.points if known is not None)


def read_spectrum(path: Path, faults: list[Fault]) -> SpectrumTable | None:
    """Read the table of a design spectrum: `SpectrumPoint`, by either frequency or period.

    The frequencies or periods of each damping ascend or descend.
    """

    def one_abscissa(table: Table[SpectrumPoint]) -> Iterator[Fault]:
        columns = [name for name in ("frequency", "period") if name in table.headers]
        if len(columns) != 1:
            found = "both" if columns else "none of them"
            expected = "expected either a column frequency [Hz] or a column period [s], found "
            yield Fault(table.path, "header", None, f"{expected}{found}")
            return
        yield from table.disorder(columns[0], "damping", "damping")
        for line, row in table:
            value = getattr(row, columns[0])
            if math.isinf(1.0 / value):
                expected = "expected a period with a finite frequency"
                yield table.fault(line, columns[0], value, expected)

    table = read_table(path, SpectrumPoint, faults, one_abscissa, most=MOST_POINTS)
    if table is None:
        return None
    column = "frequency" if "frequency" in table.headers else "period"
    points = {}
    for (damping,), curve in table.curves(column, "acceleration", "damping").items():
        pairs = sorted((x if column == "frequency" else 1.0 / x, S) for x, S in curve)
        points[damping] = (tuple(f for f, _ in pairs), tuple(S for _, S in pairs))
    return SpectrumTable(points)


class TableSpectrum(Section):
    """Spectrum given by points, straight between them on logarithmic axes."""

    type: Literal["table"]
    """Read from a table."""
    file: Annotated[Path, TableFile(TABLE, read_spectrum, as_path=True)]
    """The table (CSV): frequency or period, acceleration, and the damping where the table has
    several."""


Spectrum = DesignSpectrum | EurocodeSpectrum | DecreeSpectrum | TableSpectrum
SpectrumEntry = Annotated[
    Annotated[DesignSpectrum, Tag("corner-periods")]
    | Annotated[EurocodeSpectrum, Tag("ec8")]
    | Annotated[DecreeSpectrum, Tag("french-decree")]
    | Annotated[TableSpectrum, Tag("table")],
    # Without a type it is given by its corner periods.
    Discriminator(
        lambda value: str(
            value.get("type", "corner-periods")
            if isinstance(value, Mapping)
            else getattr(value, "type", "corner-periods")
        )
    ),
]

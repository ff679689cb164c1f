"""Capacities of equipment and limits of buildings, which results are compared with."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
)
from pydantic_core import CoreSchema, core_schema

from impactfem.case.base import Section, rule
from impactfem.case.leaf import Whole, Words
from impactfem.case.quantity import (
    Acceleration,
    Area,
    Frequency,
    Length,
    PositiveFactor,
    PositiveLength,
    Si,
)
from impactfem.case.reading import TableFile
from impactfem.case.table import MOST_POINTS, Table, read_table
from impactfem.system.errors import Fault

MOST_BOLTS = 1000
"""Largest number of bolts of a base plate."""
APART = 1e-3
"""Least distance of two bolts [m]."""
ON_EDGE = 1e-9
"""Distance by which a bolt may lie beyond the edge of its plate: rounding [m]."""
CAPACITIES = ("anchors", "required_spectrum", "test_spectrum", "zpa_limit")
"""Keys of a device that change no response: results are compared with them."""


class BoltPosition(Section):
    """Place of a bolt of a base plate, from the anchor point of the device."""

    x: Length
    """Distance from the anchor point along x."""
    y: Length
    """Distance from the anchor point along y."""


@dataclass(frozen=True)
class TableOrList(TableFile):
    """A table in a file, by its name, or the same rows in the case file."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_wrap_validator_function(self._read, handler(source))

    def _read(self, value: Any, rows: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        return self.check(value, info) if isinstance(value, str) else rows(value)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [self.schema(), handler(schema)]}


BOLTS_FILE = TableOrList(
    "a table of bolt positions (CSV)",
    lambda path, faults: read_table(path, BoltPosition, faults, most=MOST_BOLTS),
)


class AnchorBolts(Section):
    """The anchors of a device: bolts of a rigid base plate, evenly on a circle or by a table.

    A device with several supports has the same bolts at each. Capacities are design values of one
    bolt: the lowest of all failure modes of steel and concrete.
    """

    count: Annotated[int | None, Whole(2, MOST_BOLTS)] = None
    """Number of bolts evenly on a circle about the anchor point."""
    circle: PositiveLength | None = None
    """Diameter of this circle; default twice the radius of the device."""
    first_angle: Annotated[float, Si("rad")] = 0.0
    """Angle of the first bolt from x towards y."""
    positions: Annotated[tuple[BoltPosition, ...], BOLTS_FILE] | None = Field(
        default=None, validate_default=True
    )
    """In place of count and circle: positions of the bolts, a table (CSV) with the columns x and y,
    or a list of {x = ..., y = ...}."""
    plate: Annotated[tuple[PositiveLength, ...], Field(max_length=2)] | None = None
    """Sides of a rectangular base plate along x and y, centred on the anchor point; default a round
    plate with the radius of the device."""
    area: Area
    """Tensile stress area of a bolt: 245 mm2 of M20 (ISO 898-1)."""
    modular_ratio: PositiveFactor = 7.0
    """Young's modulus of the bolts over that of the concrete under the plate: 210 GPa / 30 GPa
    (EN 1992-4, 6.2.1)."""
    tension: Annotated[float, Si("N", gt=0)]
    """Design capacity of a bolt in tension."""
    shear: Annotated[float, Si("N", gt=0)]
    """Design capacity of a bolt in shear."""
    exponent: Annotated[float, Si("-", ge=1, le=2, percent=False)] = 1.5
    """k of the interaction (T/T_R)^k + (V/V_R)^k <= 1: 1.5 where the concrete governs, 2 where the
    steel governs both (EN 1992-4, table 7.3); 1 is linear."""

    @rule("positions", "count")
    @staticmethod
    def _count_or_positions(positions: Any, count: int | None) -> Iterator[str]:
        if (positions is None) == (count is None):
            missing = "" if count else "missing; "
            yield f"{missing}expected either count or positions{', not both' if count else ''}"

    @rule("positions", "circle")
    @staticmethod
    def _no_circle(positions: Any, circle: float | None) -> Iterator[str]:
        if positions is not None and circle is not None:
            yield "cannot be combined with `circle`"

    @rule("positions")
    @staticmethod
    def _apart(positions: Sequence[BoltPosition] | None) -> Iterator[str]:
        if positions is not None and len(positions) < 2:
            yield "expected at least 2 bolts: one bolt cannot carry torsion"
        for one, other in itertools.combinations(positions or (), 2):
            if math.hypot(one.x - other.x, one.y - other.y) < APART:
                yield f"expected different positions, found two at ({one.x:g}, {one.y:g}) m"

    @rule("plate")
    @staticmethod
    def _two_sides(plate: tuple[float, ...] | None) -> Iterator[str]:
        if plate is not None and len(plate) != 2:
            yield "expected two sides: ['80 cm', '60 cm']"

    def places(self, radius: float) -> tuple[tuple[float, float], ...]:
        """Return the places (x, y) of all bolts from the anchor point [m].

        Args:
            radius: Radius of the device [m].
        """
        if self.positions is not None:
            return tuple((one.x, one.y) for one in self.positions)
        count = self.count or 0
        r = radius if self.circle is None else 0.5 * self.circle
        turns = [self.first_angle + 2.0 * math.pi * k / count for k in range(count)]
        return tuple((r * math.cos(angle), r * math.sin(angle)) for angle in turns)

    def outside(self, radius: float) -> Iterator[str]:
        """Return the bolts that are not on the plate of a device with a radius [m], in words."""
        for x, y in self.places(radius):
            if self.plate is None:
                beyond = math.hypot(x, y) - radius
                size = f"a round base plate of radius {radius:g} m (radius of the device)"
            else:
                beyond = max(abs(x) - 0.5 * self.plate[0], abs(y) - 0.5 * self.plate[1])
                size = f"a base plate of {self.plate[0]:g} m x {self.plate[1]:g} m"
            if beyond > ON_EDGE:
                yield f"expected bolts within {size}, found one at ({x:.4g}, {y:.4g}) m"
                return


Axes = Annotated[
    str, Words("axes that the spectrum holds for: 'x', 'xy' or 'xyz', in this order", "x?y?z?")
]


class QualificationPoint(Section):
    """One row of a qualification spectrum: a point of the spectrum of some axes."""

    frequency: Frequency
    """Frequency, ascending or descending."""
    acceleration: Acceleration
    """Pseudo-acceleration at this frequency."""
    axes: Axes = "xyz"
    """Axes that the spectrum holds for: 'x', 'y', 'z' or several, 'xy'; without this column all."""


class QualificationCurve(Section):
    """The spectrum that a device is qualified for along some axes, ascending in frequency."""

    axes: str
    frequency: tuple[float, ...]
    acceleration: tuple[float, ...]


def read_qualification(path: Path, faults: list[Fault]) -> tuple[QualificationCurve, ...] | None:
    """Read a table of `QualificationPoint`; None with faults."""

    def in_order(table: Table[Any]) -> Iterator[Fault]:
        return table.disorder("frequency", "spectrum", "axes")

    def of_one_spectrum(table: Table[Any]) -> Iterator[Fault]:
        known: dict[str, str] = {}
        for line, row in table:
            if any(known.setdefault(axis, row.axes) != row.axes for axis in row.axes):
                expected = "expected one spectrum for each axis"
                yield table.fault(line, "axes", row.axes, expected)
                return

    table = read_table(
        path, QualificationPoint, faults, in_order, of_one_spectrum, most=MOST_POINTS
    )
    if table is None:
        return None
    curves = []
    for (axes,), points in table.curves("frequency", "acceleration", "axes").items():
        frequency, acceleration = zip(*sorted(points), strict=True)
        curves.append(QualificationCurve(axes=axes, frequency=frequency, acceleration=acceleration))
    return tuple(curves)


QUALIFICATION_FILE = TableFile("a qualification spectrum (CSV)", read_qualification)


class QualificationSpectrum(Section):
    """A spectrum that the floor spectrum at the device must not exceed."""

    file: Annotated[tuple[QualificationCurve, ...], QUALIFICATION_FILE]
    """Table (CSV) with the columns frequency, acceleration and, where they differ by axis, axes.
    Straight lines on logarithmic axes connect its points; beyond them nothing is compared."""
    damping: Annotated[float, Si("-", gt=0, lt=1)]
    """Damping ratio of the spectrum; the floor spectrum is computed for it."""


GapRule = Literal["en1998", "asce7"]


class Limits(Section):
    """Limits that the buildings are compared with; they change no response."""

    gap: GapRule | None = None
    """Rule for the gap of the code, from the largest displacements without contact: 'en1998', root
    of the sum of their squares, times 0.7 where all floors are level (EN 1998-1, 4.4.2.7);
    'asce7', the same root without this factor (ASCE 7, 12.12.3, with the elastic displacements of
    the time history as maximum inelastic ones)."""
    floor_acceleration: Acceleration | None = None
    """Largest zero-period acceleration of a floor along an axis."""
    storey_drift: Annotated[float | None, Si("-", gt=0, lt=1)] = None
    """Largest horizontal displacement between two floors over the height of the storey."""


def on_plate(anchors: AnchorBolts | None, radii: Sequence[float]) -> Iterator[str]:
    """Return the bolts of a device outside of its base plates with these radii [m], in words."""
    if anchors is not None:
        for radius in radii:
            found = next(anchors.outside(radius), None)
            if found is not None:
                yield found
                return

"""The equipment list: items on floors of sticks and 3D models, one row of a table each."""

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import ValidationInfo

from impactfem.case.base import Section
from impactfem.case.capacities import (
    QUALIFICATION_FILE,
    AnchorBolts,
    BoltPosition,
    QualificationSpectrum,
)
from impactfem.case.leaf import LONGEST_NAME, Whole, Words
from impactfem.case.quantity import Length, Si
from impactfem.case.reading import TableFile, reading_of
from impactfem.case.table import Table, read_table
from impactfem.system.errors import Fault
from impactfem.system.files import LARGEST

MOST_ITEMS = 5000
"""Largest number of items of an equipment list."""
_Positive = Annotated[float | None, Si("m", gt=0)]
_Stiffness = Annotated[float | None, Si("N/m", gt=0)]
_Frequency = Annotated[float | None, Si("Hz", gt=0)]
_Force = Annotated[float | None, Si("N", gt=0)]


class EquipmentRow(Section):
    """One item of the equipment list: an oscillator along each axis on a point of a floor.

    An axis without frequency and stiffness is rigid.
    """

    tag: Annotated[str, Words("the tag of the item", longest=LONGEST_NAME)]
    """Tag of the item, unique in the list."""
    building: Annotated[str, Words("the name of a building of this case")]
    """Building that it stands in, with a stick or a 3D model."""
    floor: Annotated[int, Whole(1)]
    """Floor that it stands on."""
    x: Length
    """Place along x in the plan of the case, as `axis` of the building."""
    y: Length
    """Place along y in the plan of the case."""
    mass: Annotated[float, Si("kg", gt=0)]
    """Mass."""
    mass_height: Annotated[float, Si("m", ge=0)]
    """Height of the mass centre above the anchors."""
    fx: _Frequency = None
    """Natural frequency along x; with neither fx nor kx it is rigid along x."""
    fy: _Frequency = None
    """Natural frequency along y."""
    fz: _Frequency = None
    """Natural frequency along z."""
    kx: _Stiffness = None
    """Stiffness along x, in place of fx."""
    ky: _Stiffness = None
    """Stiffness along y, in place of fy."""
    kz: _Stiffness = None
    """Stiffness along z, in place of fz."""
    damping: Annotated[float | None, Si("-", gt=0, lt=1)] = None
    """Damping ratio of the item; required with a frequency or stiffness."""
    anchors: Annotated[int | None, Whole(2, 1000)] = None
    """Number of bolts; without it the bolts are not checked."""
    circle: _Positive = None
    """Diameter of the circle of bolts, which is also the edge of the round base plate."""
    spacing_x: _Positive = None
    """Spacing along x of four bolts at the corners of a rectangular base plate, in place of the
    circle."""
    spacing_y: _Positive = None
    """Spacing along y of these four bolts."""
    bolt_area: Annotated[float | None, Si("m2", gt=0)] = None
    """Tensile stress area of a bolt."""
    tension: _Force = None
    """Design capacity of a bolt in tension."""
    shear: _Force = None
    """Design capacity of a bolt in shear."""
    exponent: Annotated[float, Si("-", ge=1, le=2, percent=False)] = 1.5
    """k of the interaction (T/T_R)^k + (V/V_R)^k <= 1."""
    required_spectrum: Annotated[str | None, Words("the name of a CSV file")] = None
    """Required response spectrum: a table as `file` of [devices.required_spectrum]; relative to the
    folder of the list."""
    spectrum_damping: Annotated[float | None, Si("-", gt=0, lt=1)] = None
    """Damping ratio of the required spectrum."""
    zpa_limit: Annotated[float | None, Si("m/s2", gt=0)] = None
    """Largest zero-period acceleration that the item withstands along any axis."""

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Return contradictory cells: the column, and the expected content."""
        for axis in "xyz":
            f, k = getattr(self, f"f{axis}"), getattr(self, f"k{axis}")
            if f is not None and k is not None:
                yield f"k{axis}", f"expected f{axis} or k{axis}, not both; empty one of the cells"
        if self.damping is None and min(self.frequencies) < math.inf:
            yield "damping", "missing; expected the damping ratio of the item, 5 under damping [%]"
        if (self.spectrum_damping is None) != (self.required_spectrum is None):
            expected = "expected required_spectrum and spectrum_damping together"
            yield "spectrum_damping", expected
        if self.anchors is None:
            return
        missing = [
            name for name in ("bolt_area", "tension", "shear") if getattr(self, name) is None
        ]
        if missing:
            yield missing[0], f"missing; expected {', '.join(missing)} of an item with anchors"
        sides = self.spacing_x, self.spacing_y
        if (self.circle is None) == (None in sides) or (self.circle and any(sides)):
            yield "circle", "expected circle, or both spacing_x and spacing_y, with anchors"
        elif self.circle is None and self.anchors != 4:
            yield "anchors", "expected 4 with spacing_x and spacing_y: the corners of a rectangle"

    @property
    def frequencies(self) -> tuple[float, float, float]:
        """Natural frequencies along x, y and z, infinite where it is rigid [Hz]."""
        found = []
        for axis in "xyz":
            f, k = getattr(self, f"f{axis}"), getattr(self, f"k{axis}")
            if k is not None:
                f = math.sqrt(k / self.mass) / (2.0 * math.pi)
            found.append(math.inf if f is None else f)
        return found[0], found[1], found[2]

    @property
    def bolts(self) -> AnchorBolts | None:
        """Its bolts and their capacities; None without them."""
        if None in (self.anchors, self.bolt_area, self.tension, self.shear):
            return None
        capacity: dict[str, Any] = {
            "area": self.bolt_area,
            "tension": self.tension,
            "shear": self.shear,
            "exponent": self.exponent,
        }
        if self.spacing_x is None or self.spacing_y is None:
            return AnchorBolts(count=self.anchors, circle=self.circle, **capacity)
        a, b = 0.5 * self.spacing_x, 0.5 * self.spacing_y
        corners = tuple(BoltPosition(x=x, y=y) for x in (-a, a) for y in (-b, b))
        return AnchorBolts(positions=corners, plate=(self.spacing_x, self.spacing_y), **capacity)


EquipmentRow.MAY_BE_EMPTY = tuple(
    name for name, info in EquipmentRow.model_fields.items() if not info.is_required()
)


class Equipment(EquipmentRow):
    """An item of the list with its required spectrum."""

    spectrum: QualificationSpectrum | None = None
    """The required spectrum that is in its file."""


def _read_equipment(
    path: Path, faults: list[Fault], info: ValidationInfo
) -> tuple[Equipment, ...] | None:
    """Read an equipment list and the spectra that it names; None with faults."""
    reading = reading_of(info)
    levels = {one.name: one.levels for one in reading.values["buildings"]}
    named = reading.names("buildings")

    def whole(table: Table[EquipmentRow]) -> Iterator[Fault]:
        for line, row in table:
            for column, expected in row.contradictions():
                yield table.fault(line, column, getattr(row, column), expected)
            if named is not None and row.building not in named:
                expected = f"expected a building of this case: {', '.join(named)}"
                yield table.fault(line, "building", row.building, expected)
            elif (known := levels.get(row.building)) and row.floor not in known:
                expected = f"expected a floor of {row.building}: {', '.join(map(str, known))}"
                yield table.fault(line, "floor", row.floor, expected)

    found = read_table(path, EquipmentRow, faults, whole, once=("tag",), most=MOST_ITEMS)
    if found is None:
        return None
    items = []
    for line, row in found:
        spectrum, name = None, row.required_spectrum
        if name is not None and row.spectrum_damping is not None:
            # As names in the case file: relative to its folder.
            file = os.path.relpath(path.parent / name, reading.source.path.parent)
            curves = reading.table(file, QUALIFICATION_FILE.what, QUALIFICATION_FILE.read)
            if curves is None:
                if wrong := reading.fetch(file, QUALIFICATION_FILE.what, LARGEST):
                    faults.append(found.fault(line, "required_spectrum", name, wrong))
                continue
            spectrum = QualificationSpectrum.model_construct(
                file=curves, damping=row.spectrum_damping
            )
        items.append(Equipment.model_construct(**dict(row), spectrum=spectrum))
    return tuple(items) if len(items) == len(found.rows) else None


EQUIPMENT_FILE = TableFile("an equipment list (CSV)", _read_equipment, sited=True)

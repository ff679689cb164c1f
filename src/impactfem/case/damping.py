"""Damping: of buildings, of parts of a 3D model, and further ones for all buildings."""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo

from impactfem.case.base import Section, ascending, rule, together
from impactfem.case.leaf import Name, Text
from impactfem.case.quantity import CalibratedRestitution, Frequency, Rate, Si
from impactfem.dynamics.damping import Caughey, DampingLaw, ModeRatios, RatioTable, Rayleigh
from impactfem.system.errors import ImpactfemError

Ratio = Annotated[float, Si("-", gt=0, lt=1)]
ModalRatio = Annotated[float, Si("-", ge=0, lt=1)]
CurveRatio = Annotated[float, Si("-", ge=0)]
BAND = np.geomspace(1.0, 20.0, 14)
"""Frequencies at which buildings answer to earthquakes [Hz]."""


class _Damping(Section, ABC):
    @property
    @abstractmethod
    def law(self) -> DampingLaw:
        """The law, for the modes of a building or a device."""

    @property
    def rayleigh(self) -> Rayleigh:
        """The coefficients α_R and β_R; ValueError where the law has none."""
        return self.law.rayleigh

    @property
    def largest_ratio(self) -> float:
        """Largest damping ratio in `BAND`."""
        return float(self.law.ratio(BAND).max())


class _TwoCoefficients(_Damping):
    ratio: Ratio | None = None
    """Damping ratio ξ at both frequencies."""
    frequencies: tuple[Frequency, Frequency] | None = Field(default=None, validate_default=True)
    """The two frequencies f_1 < f_2 of the ratio."""
    mass_coefficient: Rate | None = Field(default=None, validate_default=True)
    """Coefficient α_R of the mass matrix."""
    stiffness_coefficient: Annotated[float, Si("s", ge=0)] | None = Field(
        default=None, validate_default=True
    )
    """Coefficient β_R of the stiffness matrix."""

    _in_order = ascending("frequencies", "expected two different frequencies, the lower one first")
    _with_ratio = together("ratio", "frequencies")

    @rule("mass_coefficient", sited=True)
    @staticmethod
    def _one_way(coefficient: float | None, info: ValidationInfo) -> Iterator[str]:
        # An invalid ratio is given as well.
        if coefficient is not None and info.data.get("ratio", "at fault") is not None:
            yield "expected either ratio and frequencies or the two coefficients, not both"

    _both = together("mass_coefficient", "stiffness_coefficient")

    @rule("stiffness_coefficient", "ratio", "frequencies", "mass_coefficient")
    @staticmethod
    def _one_of_them(*given: Any) -> Iterator[str]:
        if all(value is None for value in given):
            yield "expected ratio and frequencies, or mass_coefficient and stiffness_coefficient"

    @property
    def law(self) -> DampingLaw:
        """The law with the two coefficients."""
        if self.mass_coefficient is not None and self.stiffness_coefficient is not None:
            return Rayleigh(self.mass_coefficient, self.stiffness_coefficient)
        if self.ratio is None or self.frequencies is None:
            raise ValueError("this damping was made without validation: it has no coefficients")
        return Rayleigh.through(self.ratio, *self.frequencies)


class RayleighDamping(_TwoCoefficients):
    """Rayleigh damping C = α_R M + β_R K, so that ξ = α_R/2ω + β_R ω/2.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    type: Literal["rayleigh"] = "rayleigh"
    """Proportional to mass and stiffness."""


class ConstantDamping(_Damping):
    """One damping ratio at all frequencies."""

    type: Literal["constant"] = "constant"
    """The same ratio for all modes; the default of a damping with a ratio alone."""
    ratio: Ratio
    """Damping ratio ξ of all modes."""

    @property
    def law(self) -> DampingLaw:
        """The law with one ratio."""
        return RatioTable.constant(self.ratio)


class _Points(_Damping):
    points: tuple[tuple[Frequency, CurveRatio], ...] = Field(min_length=1)
    """Frequencies, ascending, each with its ratio ξ: `[["1 Hz", "4 %"], ["500 Hz", "7 %"]]`."""

    @rule("points")
    @staticmethod
    def _in_order(points: tuple[tuple[float, float], ...]) -> Iterator[str]:
        if any(b <= a for (a, _), (b, _) in itertools.pairwise(points)):
            yield "expected frequencies that ascend"


class TableDamping(_Points):
    """Damping ratios by frequency: linear in log f, and constant outside of the points.

    The points of a building reach up to the highest frequency of [spectra] and [transient].
    """

    type: Literal["table"]
    """Through points."""

    @property
    def law(self) -> DampingLaw:
        """The law through the points."""
        return RatioTable(*zip(*self.points, strict=True))


class CaugheyDamping(_Points):
    """Caughey's series with as many terms as points, which it goes through."""

    type: Literal["caughey"]
    """Caughey's series."""

    @rule("points")
    @staticmethod
    def _not_negative(points: tuple[tuple[float, float], ...]) -> Iterator[str]:
        try:
            Caughey(*zip(*points, strict=True))
        except ImpactfemError as error:
            yield str(error)

    @property
    def law(self) -> DampingLaw:
        """The law through the points."""
        return Caughey(*zip(*self.points, strict=True))


class ModesDamping(_TwoCoefficients):
    """Damping ratios of the first modes, and Rayleigh damping of all others."""

    type: Literal["modes"]
    """A ratio for each of the first modes."""
    ratios: tuple[ModalRatio, ...] = Field(min_length=1)
    """Ratios ξ of the first modes by ascending frequency, of stick and of 3D model. Modes along x,
    along y and of torsion count together: a symmetric plan has two of each frequency."""

    @property
    def law(self) -> DampingLaw:
        """The law with the ratios of the first modes."""
        return ModeRatios(self.ratios, super().law)


def _type(value: Any) -> str:
    """The type of a damping: without one constant for a ratio alone, else Rayleigh damping."""
    given = value.get("type") if isinstance(value, Mapping) else getattr(value, "type", None)
    if given is not None:
        return str(given)
    keys = {*value} if isinstance(value, Mapping) else set()
    return "constant" if {"ratio"} <= keys <= {"ratio", "name", "restitution"} else "rayleigh"


DampingEntry = Annotated[
    Annotated[RayleighDamping, Tag("rayleigh")]
    | Annotated[ConstantDamping, Tag("constant")]
    | Annotated[TableDamping, Tag("table")]
    | Annotated[CaugheyDamping, Tag("caughey")]
    | Annotated[ModesDamping, Tag("modes")],
    Discriminator(_type),
]


class Parts(Section):
    """Parts of the 3D model, by patterns of their names."""

    parts: tuple[Text, ...] = Field(min_length=1)
    """Patterns of part names with * and ?: `floor_*`, `column_1_*`. A part matches at most one
    entry, a pattern at least one part."""


# The parts come first in the order of the fields, which is that of the bases from right to left.
class PartDamping(RayleighDamping, Parts):
    """Rayleigh damping C = Σ α_p M_p + β_p K_p of some parts p of the 3D model.

    Parts without an entry have the damping of the building. The mass that is added to a floor
    belongs to the slab that it lies on. Only in full order.
    """


OWN = "own"
"""Name in results of the dampings that the buildings have without a damping case."""


class _Repetition(Section):
    name: Name = Field(description=f"Unique name of the damping case, not '{OWN}'.")
    restitution: CalibratedRestitution = "calibrated"
    """Restitution of the laws of type 'kelvin-voigt' with this damping. 'calibrated': from the
    impact of [wall_impact] with this damping; if some laws state 'calibrated', for those laws
    only. Without [wall_impact] and this key, the laws keep their restitution."""

    @rule("name")
    @staticmethod
    def _another_than_own(name: str) -> Iterator[str]:
        if name == OWN:
            yield f"expected another name: '{OWN}' is the damping of [damping]"


class RayleighCase(RayleighDamping, _Repetition):
    """A further damping of all buildings, for which the study is repeated."""


class ConstantCase(ConstantDamping, _Repetition):
    """A further damping of all buildings, with one ratio at all frequencies."""


class TableCase(TableDamping, _Repetition):
    """A further damping of all buildings, with ratios by frequency."""


class CaugheyCase(CaugheyDamping, _Repetition):
    """A further damping of all buildings, by Caughey's series."""


class ModesCase(ModesDamping, _Repetition):
    """A further damping of all buildings, with ratios of the first modes."""


DampingCase = Annotated[
    Annotated[RayleighCase, Tag("rayleigh")]
    | Annotated[ConstantCase, Tag("constant")]
    | Annotated[TableCase, Tag("table")]
    | Annotated[CaugheyCase, Tag("caughey")]
    | Annotated[ModesCase, Tag("modes")],
    Discriminator(_type),
]

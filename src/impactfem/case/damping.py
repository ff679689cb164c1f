"""Rayleigh damping: of buildings, of parts of a 3D model, and further ones for all buildings."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present, refuse
from impactfem.case.leaf import Name, Text
from impactfem.case.quantity import CalibratedRestitution, Frequency, Quantity, Rate, Ratio
from impactfem.case.unit import TIME
from impactfem.dynamics.damping import Rayleigh


class Damping(Section):
    """Rayleigh damping C = α_R M + β_R K, whose stiffness part acts on the storeys only.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    ratio: Annotated[float, Ratio(above=0, below=1)] | None = None
    """Damping ratio ξ reached at both frequencies."""
    frequencies: tuple[Frequency, Frequency] | None = Field(default=None, validate_default=True)
    """The two frequencies f_1 < f_2 at which the ratio is reached."""
    mass_coefficient: Rate | None = Field(default=None, validate_default=True)
    """Coefficient α_R of the mass matrix."""
    stiffness_coefficient: Annotated[float, Quantity(TIME, at_least=0)] | None = Field(
        default=None, validate_default=True
    )
    """Coefficient β_R of the stiffness matrix."""

    @field_validator("frequencies")
    @classmethod
    def _with_ratio(
        cls, value: tuple[float, float] | None, info: ValidationInfo
    ) -> tuple[float, float] | None:
        if value is not None and value[0] >= value[1]:
            raise refuse("expected two different frequencies, the lower one first")
        if present(info, ["ratio"]) and (info.data["ratio"] is None) != (value is None):
            raise refuse("expected ratio and frequencies together")
        return value

    @field_validator("mass_coefficient")
    @classmethod
    def _one_way(cls, value: float | None, info: ValidationInfo) -> float | None:
        ratio_given = info.data.get("ratio", "broken") is not None
        if value is not None and ratio_given:
            raise refuse("expected either ratio and frequencies or the two coefficients, not both")
        return value

    @field_validator("stiffness_coefficient")
    @classmethod
    def _both(cls, value: float | None, info: ValidationInfo) -> float | None:
        if not present(info, ["mass_coefficient"]):
            return value
        if (info.data["mass_coefficient"] is None) != (value is None):
            raise refuse("expected mass_coefficient and stiffness_coefficient together")
        if value is None and info.data.get("ratio", "broken") is None:
            given = info.data.get("frequencies", "broken") is not None
            if not given:
                raise refuse(
                    "expected ratio and frequencies, or mass_coefficient and stiffness_coefficient"
                )
        return value

    @property
    def rayleigh(self) -> Rayleigh:
        """The damping with the coefficients α_R and β_R."""
        if self.mass_coefficient is not None and self.stiffness_coefficient is not None:
            return Rayleigh(self.mass_coefficient, self.stiffness_coefficient)
        if self.ratio is None or self.frequencies is None:
            raise ValueError("this damping was made without validation: it has no coefficients")
        return Rayleigh.through(self.ratio, *self.frequencies)


class Parts(Section):
    """Parts of the 3D model, by patterns of their names."""

    parts: tuple[Text, ...] = Field(min_length=1)
    """Patterns of the names of its parts, with * and ? as in a shell: `floor_*`, `column_1_*`. Each
    part matches one entry or none, and each pattern a part."""


# The parts come first in the order of the fields, which is that of the bases from right to left.
class PartDamping(Damping, Parts):
    """Rayleigh damping C = Σ α_p M_p + β_p K_p of some parts p of the 3D model.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    Parts without an entry have the damping of the building. The mass that is added to a floor
    belongs to the slab that it lies on. Only in full order.
    """


OWN = "own"
"""Stands in results for the dampings that the buildings have without a damping case."""


class _Named(Section):
    name: Name = Field(description=f"Name of the damping case, each its own; not '{OWN}'.")

    @field_validator("name")
    @classmethod
    def _another_than_own(cls, value: str) -> str:
        if value == OWN:
            raise refuse(f"expected another name: '{OWN}' is the damping of [damping]")
        return value


# The name comes first in the order of the fields, which is that of the bases from right to left.
class DampingCase(Damping, _Named):
    """A further Rayleigh damping of all buildings, for which the study is repeated.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    restitution: CalibratedRestitution = "calibrated"
    """Coefficient of restitution with this damping, of contact laws of type 'kelvin-voigt';
    calibrated by the impact of [wall_impact] with this damping, for those laws that say
    'calibrated' where one does. Left out in a case without [wall_impact], the laws keep theirs."""

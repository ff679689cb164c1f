"""Rayleigh damping, given by a ratio at two frequencies or by its two coefficients."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import Frequency, Quantity, Rate, Ratio, refuse
from impactfem.case.unit import TIME
from impactfem.dynamics.damping import Rayleigh


class Damping(Section):
    """Rayleigh damping C = α_R M + β_R K, whose stiffness part acts on the storeys only.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    ratio: Annotated[float, Ratio(above=0, below=1)] | None = Field(
        default=None, description="Damping ratio ξ reached at both frequencies."
    )
    frequencies: tuple[Frequency, Frequency] | None = Field(
        default=None,
        validate_default=True,
        description="The two frequencies f_1 < f_2 at which the ratio is reached.",
    )
    mass_coefficient: Rate | None = Field(
        default=None, validate_default=True, description="Coefficient α_R of the mass matrix."
    )
    stiffness_coefficient: Annotated[float, Quantity(TIME, at_least=0)] | None = Field(
        default=None, validate_default=True, description="Coefficient β_R of the stiffness matrix."
    )

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

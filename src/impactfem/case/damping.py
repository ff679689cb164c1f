"""Rayleigh damping: of buildings, of parts of a 3D model, and further ones for all buildings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field, ValidationInfo

from impactfem.case.base import Section, ascending, rule, together
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

    _in_order = ascending("frequencies", "expected two different frequencies, the lower one first")
    _with_ratio = together("ratio", "frequencies")
    _both = together("mass_coefficient", "stiffness_coefficient")

    @rule("mass_coefficient", sited=True)
    @staticmethod
    def _one_way(coefficient: float | None, info: ValidationInfo) -> Iterator[str]:
        # A ratio that has a fault of its own is given as well.
        if coefficient is not None and info.data.get("ratio", "at fault") is not None:
            yield "expected either ratio and frequencies or the two coefficients, not both"

    @rule("stiffness_coefficient", "ratio", "frequencies", "mass_coefficient")
    @staticmethod
    def _one_of_them(coefficient: float | None, *others: Any) -> Iterator[str]:
        if coefficient is None and all(other is None for other in others):
            yield "expected ratio and frequencies, or mass_coefficient and stiffness_coefficient"

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

    @rule("name")
    @staticmethod
    def _another_than_own(name: str) -> Iterator[str]:
        if name == OWN:
            yield f"expected another name: '{OWN}' is the damping of [damping]"


# The name comes first in the order of the fields, which is that of the bases from right to left.
class DampingCase(Damping, _Named):
    """A further Rayleigh damping of all buildings, for which the study is repeated.

    Either ``ratio`` and ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``.
    """

    restitution: CalibratedRestitution = "calibrated"
    """Coefficient of restitution with this damping, of contact laws of type 'kelvin-voigt';
    calibrated by the impact of [wall_impact] with this damping, for those laws that say
    'calibrated' where one does. Left out in a case without [wall_impact], the laws keep theirs."""

"""Damping: of buildings, of parts of a 3D model, and further ones for all buildings."""

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, ascending, refuse, rule, together
from impactfem.case.leaf import Name, Text
from impactfem.case.quantity import CalibratedRestitution, Frequency, Rate, Si
from impactfem.dynamics.damping import Caughey, DampingLaw, ModeRatios, RatioTable, Rayleigh
from impactfem.system.errors import ImpactfemError

ModalRatio = Annotated[float, Si("-", ge=0, lt=1)]
CurveRatio = Annotated[float, Si("-", ge=0)]

RAYLEIGH = ("ratio", "frequencies", "mass_coefficient", "stiffness_coefficient")
KEYS = {
    "rayleigh": RAYLEIGH,
    "constant": ("ratio",),
    "table": ("points",),
    "caughey": ("points",),
    "modes": ("ratios", *RAYLEIGH),
}
"""Keys of each type of damping."""
_BY_TYPE = dict.fromkeys(key for keys in KEYS.values() for key in keys)


class Damping(Section):
    """Damping of a building or a device: the ratio ξ of each of its modes, by one of these types.

    - `rayleigh`: C = α_R M + β_R K, so that ξ = α_R/2ω + β_R ω/2. Either ``ratio`` and
      ``frequencies``, or ``mass_coefficient`` and ``stiffness_coefficient``;
    - `constant`: ``ratio`` at all frequencies;
    - `table`: through ``points``, linear in log f, and constant outside of them; those of a
      building reach up to the highest frequency of [spectra] and [transient];
    - `caughey`: Caughey's series with as many terms as ``points``, which it goes through;
    - `modes`: ``ratios`` of the first modes, and Rayleigh damping of all others.
    """

    type: Literal["rayleigh", "constant", "table", "caughey", "modes"] = "rayleigh"
    """The law of the damping."""
    ratio: Annotated[float, Si("-", gt=0, lt=1)] | None = Field(default=None, validate_default=True)
    """Damping ratio ξ at both frequencies, or of all modes."""
    frequencies: tuple[Frequency, Frequency] | None = Field(default=None, validate_default=True)
    """The two frequencies f_1 < f_2 of the ratio."""
    mass_coefficient: Rate | None = Field(default=None, validate_default=True)
    """Coefficient α_R of the mass matrix."""
    stiffness_coefficient: Annotated[float, Si("s", ge=0)] | None = Field(
        default=None, validate_default=True
    )
    """Coefficient β_R of the stiffness matrix."""
    points: tuple[tuple[Frequency, CurveRatio], ...] | None = Field(
        default=None, validate_default=True, min_length=1
    )
    """Frequencies, ascending, each with its ratio ξ: `[["1 Hz", "4 %"], ["500 Hz", "7 %"]]`."""
    ratios: tuple[ModalRatio, ...] | None = Field(default=None, validate_default=True, min_length=1)
    """Ratios ξ of the first modes by ascending frequency, of stick and of 3D model. Modes along x,
    along y and of torsion count together: a symmetric plan has two of each frequency."""

    _in_order = ascending("frequencies", "expected two different frequencies, the lower one first")

    @field_validator(*_BY_TYPE)
    @classmethod
    def _of_the_type(cls, value: Any, info: ValidationInfo) -> Any:
        type_ = info.data.get("type")
        if value is not None and type_ is not None and info.field_name not in KEYS[type_]:
            taken = ", ".join(KEYS[type_])
            raise refuse(f"expected none: damping of type '{type_}' takes {taken}")
        return value

    @rule("ratio", "type")
    @staticmethod
    def _constant(ratio: float | None, type_: str) -> Iterator[str]:
        if ratio is None and type_ == "constant":
            yield "missing; expected the damping ratio of all modes"

    @rule("frequencies", "type", "ratio")
    @staticmethod
    def _with_ratio(frequencies: Any, type_: str, ratio: float | None) -> Iterator[str]:
        if type_ != "constant" and (frequencies is None) != (ratio is None):
            yield "expected ratio and frequencies together"

    @rule("mass_coefficient", "type", sited=True)
    @staticmethod
    def _one_way(coefficient: float | None, _: str, info: ValidationInfo) -> Iterator[str]:
        # A ratio that has a fault of its own is given as well.
        if coefficient is not None and info.data.get("ratio", "at fault") is not None:
            yield "expected either ratio and frequencies or the two coefficients, not both"

    _both = together("mass_coefficient", "stiffness_coefficient", "", "type")

    @rule("stiffness_coefficient", "type", "ratio", "frequencies", "mass_coefficient")
    @staticmethod
    def _one_of_them(coefficient: float | None, type_: str, *others: Any) -> Iterator[str]:
        none = coefficient is None and all(other is None for other in others)
        if none and type_ in ("rayleigh", "modes"):
            yield "expected ratio and frequencies, or mass_coefficient and stiffness_coefficient"

    @rule("points", "type")
    @staticmethod
    def _points(points: tuple[tuple[float, float], ...] | None, type_: str) -> Iterator[str]:
        if points is None and "points" in KEYS[type_]:
            yield "missing; expected frequencies with their ratios"
        if points is not None and any(b <= a for (a, _), (b, _) in itertools.pairwise(points)):
            yield "expected frequencies that ascend"
        if points is not None and type_ == "caughey":
            try:
                Caughey(*zip(*points, strict=True))
            except ImpactfemError as error:
                yield str(error)

    @rule("ratios", "type")
    @staticmethod
    def _ratios(ratios: tuple[float, ...] | None, type_: str) -> Iterator[str]:
        if ratios is None and type_ == "modes":
            yield "missing; expected a ratio of each of the first modes"

    @property
    def law(self) -> DampingLaw:
        """The law, for the modes of a building or a device."""
        if self.type == "modes" and self.ratios is not None:
            return ModeRatios(self.ratios, self.model_copy(update={"type": "rayleigh"}).law)
        if self.type == "constant" and self.ratio is not None:
            return RatioTable.constant(self.ratio)
        if self.points is not None:
            frequency, ratios = zip(*self.points, strict=True)
            return (RatioTable if self.type == "table" else Caughey)(frequency, ratios)
        return self.rayleigh

    @property
    def rayleigh(self) -> Rayleigh:
        """The damping of type 'rayleigh', with the coefficients α_R and β_R."""
        if self.mass_coefficient is not None and self.stiffness_coefficient is not None:
            return Rayleigh(self.mass_coefficient, self.stiffness_coefficient)
        if self.ratio is None or self.frequencies is None:
            raise ValueError("this damping was made without validation: it has no coefficients")
        return Rayleigh.through(self.ratio, *self.frequencies)


class Parts(Section):
    """Parts of the 3D model, by patterns of their names."""

    parts: tuple[Text, ...] = Field(min_length=1)
    """Patterns of part names with * and ?: `floor_*`, `column_1_*`. A part matches at most one
    entry, a pattern at least one part."""


# The parts come first in the order of the fields, which is that of the bases from right to left.
class PartDamping(Damping, Parts):
    """Rayleigh damping C = Σ α_p M_p + β_p K_p of some parts p of the 3D model.

    Of type `rayleigh` only. Parts without an entry have the damping of the building. The mass that
    is added to a floor belongs to the slab that it lies on. Only in full order.
    """

    @rule("type")
    @staticmethod
    def _of_matrices(type_: str) -> Iterator[str]:
        if type_ != "rayleigh":
            yield "expected 'rayleigh': a part has no modes of its own"


OWN = "own"
"""Stands in results for the dampings that the buildings have without a damping case."""


class _Named(Section):
    name: Name = Field(description=f"Unique name of the damping case, not '{OWN}'.")

    @rule("name")
    @staticmethod
    def _another_than_own(name: str) -> Iterator[str]:
        if name == OWN:
            yield f"expected another name: '{OWN}' is the damping of [damping]"


# The name comes first in the order of the fields, which is that of the bases from right to left.
class DampingCase(Damping, _Named):
    """A further damping of all buildings, for which the study is repeated."""

    restitution: CalibratedRestitution = "calibrated"
    """Restitution of the laws of type 'kelvin-voigt' with this damping. 'calibrated': from the
    impact of [wall_impact] with this damping; if some laws state 'calibrated', for those laws
    only. Without [wall_impact] and this key, the laws keep their restitution."""

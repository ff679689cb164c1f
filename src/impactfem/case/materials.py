"""Materials: isotropic and linear elastic."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import Density, Ratio, Stress


class Material(Section):
    """An isotropic, linear elastic material."""

    young_modulus: Stress = Field(description="Young's modulus E.")
    poisson_ratio: Annotated[float, Ratio(at_least=0, below=0.5)] = Field(
        description="Poisson's ratio ν."
    )
    density: Density | None = Field(
        default=None,
        description="Mass density; the sticks take their masses from the floor table instead.",
    )
    compressive_strength: Stress | None = Field(
        default=None,
        description="Compressive strength, which the mean bearing pressure of an impact is "
        "compared with.",
    )

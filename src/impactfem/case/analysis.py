"""Time integration of the pounding, and response spectra of the floors."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Discriminator, Field, StrictBool, Tag

from impactfem.case.base import Section, ascending, once, rule, step_within
from impactfem.case.leaf import Key, Whole
from impactfem.case.quantity import DampingRatio, Duration, Frequency, PositiveLength, TimeStep

RG_1_122_END = 34.0  # Hz
MOST_FREQUENCIES = 100_000


class Pounding(Section):
    """Models that pound, and their integration in time: Newmark, average acceleration."""

    models: dict[Key, Literal["stick", "structure"]] = Field(default={})
    """Model of each building in contact: 'stick', or 'structure', the 3D model of
    [buildings.structure], whose floors touch along their edges. Default 'stick' for all."""
    contact_spacing: PositiveLength | None = None
    """Least distance of two contact points along the edges of 3D models; default every vertex of
    the coarser mesh. Each point adds a vector to the reduced building."""

    duration: Duration | None = None
    """Computed time; default that of the longest motion, with wave passage delay. A longer time
    includes free vibration on ground at rest."""
    time_step: TimeStep
    """Time step."""
    update: Literal["implicit", "lagged"] = "implicit"
    """'implicit' uses the contact force at the new time; 'lagged' at the old time, as in equation 2
    of the paper, which raises the restitution."""
    unilateral_scheme: Literal["massless", "moreau"] = "massless"
    """Scheme of unilateral contact. 'massless': contact points without mass; the force has a limit
    for short steps. 'moreau': impulses on contact points with mass, for comparison; the largest
    force grows as the step becomes shorter."""
    contact_frequency: Frequency | None = None
    """Frequency above which contact points of the scheme 'massless' have no mass. Default 108
    times shift of [transient], 3240 Hz. With 810 Hz spectra at 100 Hz change by up to 6 %. The
    largest force rises with this frequency, forces up to 100 Hz do not."""
    points_per_impact: Annotated[int, Whole(1, 100_000)] = 16
    """Least number of steps in an impact; a check fails with fewer."""

    _step_in_duration = step_within("duration")


class FrequencyGrid(Section):
    """A list of frequencies by rule.

    ``logarithmic`` has equal distances on a logarithmic scale from ``minimum`` to ``maximum``.
    ``rg1.122`` is that of US NRC Regulatory Guide 1.122, 75 frequencies from 0.2 Hz to 34 Hz, and
    goes on logarithmically up to ``maximum`` where one is given: impacts reach higher than
    earthquakes.
    """

    list: Literal["logarithmic", "rg1.122"] = "logarithmic"
    """The rule: 'logarithmic' or 'rg1.122', see above."""
    minimum: Frequency | None = Field(default=None, validate_default=True)
    """Lowest frequency; required by 'logarithmic', fixed in 'rg1.122'."""
    maximum: Frequency | None = Field(default=None, validate_default=True)
    """Highest frequency; required by 'logarithmic', above 34 Hz in 'rg1.122'."""
    per_decade: Annotated[int, Whole(1)] = Field(default=100, validate_default=True)
    """Number of logarithmic frequencies in a decade, at least."""

    @rule("minimum", "list")
    @staticmethod
    def _begins(minimum: float | None, by: str) -> Iterator[str]:
        if by == "logarithmic" and minimum is None:
            yield "missing; expected a frequency, or list = 'rg1.122'"
        if by == "rg1.122" and minimum is not None:
            yield "expected no minimum: the list of Regulatory Guide 1.122 has its own"

    @rule("maximum", "list", "minimum")
    @staticmethod
    def _ordered(maximum: float | None, by: str, minimum: float | None) -> Iterator[str]:
        if maximum is None and by == "logarithmic":
            yield "missing; expected a frequency"
        elif maximum is not None and by == "rg1.122" and maximum <= RG_1_122_END:
            yield (
                f"expected a frequency above the {RG_1_122_END:g} Hz at which the list of "
                "Regulatory Guide 1.122 ends, or no maximum"
            )
        elif maximum is not None and minimum is not None and maximum <= minimum:
            yield f"expected a frequency above minimum, {minimum:g} Hz"

    @rule("per_decade", "list", "minimum", "maximum")
    @staticmethod
    def _not_too_many(
        count: int, by: str, minimum: float | None, maximum: float | None
    ) -> Iterator[str]:
        decades = math.log10(maximum / (minimum or RG_1_122_END)) if maximum is not None else 0.0
        if count * decades > MOST_FREQUENCIES:
            yield (
                f"expected at most {MOST_FREQUENCIES} frequencies, "
                f"not {count} in each of {decades:.3g} decades"
            )

    @property
    def values(self) -> tuple[float, ...]:
        """The frequencies [Hz], ascending."""
        # Imported here: a case that is only read needs no compiled kernels, which load slowly.
        from impactfem.spectra.frequency_list import logarithmic_frequencies, rg_1_122_frequencies

        if self.list == "rg1.122":
            return tuple(map(float, rg_1_122_frequencies(self.maximum, self.per_decade)))
        if self.minimum is None or self.maximum is None:
            raise ValueError("this list was made without validation: it has no ends")
        frequencies = logarithmic_frequencies(self.minimum, self.maximum, self.per_decade)
        return tuple(map(float, frequencies))


class Spectra(Section):
    """Floor response spectra: their dampings, frequencies and accuracy."""

    damping: tuple[DampingRatio, ...] = Field(min_length=1)
    """Damping ratios of the oscillators, each once."""
    frequencies: Annotated[
        Annotated[FrequencyGrid, Tag("grid")]
        | Annotated[tuple[Frequency, ...], Field(min_length=1), Tag("list")],
        Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "grid"),
    ]
    """Frequencies of the oscillators: a list by rule, or the frequencies."""
    points_per_cycle: Annotated[int, Whole(2, 1000)] = 20
    """Least number of samples in a cycle of the highest frequency."""
    method: Literal["upsampled", "in-step"] = "upsampled"
    """'upsampled' refines the history once, band-limited; 'in-step' finds the maximum inside each
    step of linear interpolation."""
    broadening: DampingRatio = 0.15
    """Relative broadening of the design spectra of the floors to either side; 0 for none.
    Regulatory Guide 1.122 requires 15 %, or at least 10 % with a computed uncertainty of the
    frequencies."""
    clipping: StrictBool = False
    """Reduce narrow peaks by 15 % before broadening, at dampings below 10 % (ASCE 4-98, section
    3.4.2.3)."""

    _each_once = once("damping", "damping ratio")
    _increasing = ascending("frequencies", "expected increasing frequencies")

    @property
    def frequency_values(self) -> tuple[float, ...]:
        """The frequencies of the oscillators [Hz], increasing."""
        if isinstance(self.frequencies, FrequencyGrid):
            return self.frequencies.values
        return self.frequencies

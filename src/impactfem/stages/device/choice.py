"""The choices of a response spectrum analysis, which are its labels in `device.nc`."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from impactfem.case.devices import ModeRule, RigidMethod, SupportRule
from impactfem.device.combination import Combination

Source = Literal["computed", "envelope", "envelope-dampings", "given"]
"""Spectra that are the input: of the anchor; their envelope with those of further points; the
envelope of either over all damping cases; or spectra of a file."""
PREFERRED: tuple[Combination, ...] = ("srss", "cqc")
"""Combinations of modes of the headline, in this order."""


@dataclass(frozen=True)
class SpectrumChoice:
    """One way of doing a response spectrum analysis."""

    combination: Combination  #: of the modes
    rotations: bool = False  #: whether the spectra of the anchor's rotations are inputs, too
    broadened: bool = False  #: whether the peaks of the spectra are broadened
    source: Source = "computed"  #: origin of the spectra
    #: combination of several supports, if it is not the one requested first
    supports: SupportRule | None = None
    rigid: RigidMethod = "none"  #: method of the rigid part of the modes

    @property
    def label(self) -> str:
        """The name of the analysis: what differs from the defaults."""
        parts = [
            self.combination,
            self.rigid if self.rigid != "none" else "",
            self.source if self.source != "computed" else "",
            "rotations" * self.rotations,
            "broadened" * self.broadened,
            f"supports {self.supports}" if self.supports else "",
        ]
        return ", ".join(part for part in parts if part)


def headline_of(rules: Iterable[ModeRule]) -> SpectrumChoice:
    """Return the headline: translations, computed spectra, the first rigid method."""
    known = list(rules)
    combinations = [combination for combination, _ in known]
    best = next((one for one in PREFERRED if one in combinations), combinations[0])
    rigid = next(rigid for combination, rigid in known if combination == best)
    return SpectrumChoice(best, rigid=rigid)

"""One way of doing a response spectrum analysis of a device."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from impactfem.case.device_analysis import ModeRule, RigidMethod, SupportRule
from impactfem.device.combination import Combination

Source = Literal["computed", "envelope", "envelope-dampings", "given"]
"""Spectra that are the input: of the anchor; their envelope with those of further points; the
envelope of either over all damping cases; or spectra of a file."""

PREFERRED: tuple[Combination, ...] = ("srss", "cqc")
"""Combinations of modes that stand for the response spectrum analysis, the first that is there."""


@dataclass(frozen=True)
class SpectrumChoice:
    """One way of doing a response spectrum analysis.

    Args:
        combination: Of the modes.
        rotations: Whether the spectra of the anchor's rotations are inputs, too.
        broadened: Whether the peaks of the spectra are broadened.
        source: Where the spectra come from.
        supports: Combination of several supports, where it is not the first that was asked.
        rigid: Method of the rigid part of the modes.
    """

    combination: Combination
    rotations: bool
    broadened: bool
    source: Source = "computed"
    supports: SupportRule | None = None
    rigid: RigidMethod = "none"

    @property
    def label(self) -> str:
        """Its name in results."""
        parts = [
            self.combination,
            self.rigid if self.rigid != "none" else "",
            self.source if self.source != "computed" else "",
            "rotations" * self.rotations,
            "broadened" * self.broadened,
            f"supports-{self.supports}" if self.supports else "",
        ]
        return ".".join(part for part in parts if part)


def headline_of(rules: Iterable[ModeRule]) -> SpectrumChoice:
    """The analysis that stands for all: translations, spectra as computed, the first rigid method.

    Args:
        rules: Of the analyses, in their order.
    """
    known = list(rules)
    combinations = [combination for combination, _ in known]
    best = next((one for one in PREFERRED if one in combinations), combinations[0])
    rigid = next(rigid for combination, rigid in known if combination == best)
    return SpectrumChoice(best, rotations=False, broadened=False, rigid=rigid)

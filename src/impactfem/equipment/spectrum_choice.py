"""One way of doing a response spectrum analysis of a device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from impactfem.case.device_analysis import SupportRule
from impactfem.device.combination import Combination

Source = Literal["computed", "envelope", "envelope-dampings", "given"]
"""Spectra that are the input: of the anchor; their envelope with those of further points; the
envelope of either over all damping cases; or spectra of a file."""


@dataclass(frozen=True)
class SpectrumChoice:
    """One way of doing a response spectrum analysis.

    Args:
        combination: Of the modes.
        rotations: Whether the spectra of the anchor's rotations are inputs, too.
        broadened: Whether the peaks of the spectra are broadened.
        source: Where the spectra come from.
        supports: Combination of several supports, where it is not the first that was asked.
    """

    combination: Combination
    rotations: bool
    broadened: bool
    source: Source = "computed"
    supports: SupportRule | None = None

    @property
    def label(self) -> str:
        """Its name in results."""
        parts = [
            self.combination,
            self.source if self.source != "computed" else "",
            "rotations" * self.rotations,
            "broadened" * self.broadened,
            f"supports-{self.supports}" if self.supports else "",
        ]
        return ".".join(part for part in parts if part)

"""Floor response spectra as a product: what was computed, with its labels, and the design spectra.

The way from one to the other is that of US NRC Regulatory Guide 1.122, revision 1 (1978): a
statistic over the motions (their envelope, their mean or a fractile), the envelope over the points
of a floor, the reduction of narrow peaks where it is requested, and broadening.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from impactfem.spectra.design import (
    LARGEST_DAMPING,
    ClippedPeak,
    Ratio,
    broaden,
    broadening_words,
    clip_peaks,
    corner_frequencies,
    rigid_frequency,
    sides,
)
from impactfem.spectra.frequency_list import checked_frequency, checked_values
from impactfem.spectra.statistics import (
    STATISTICS,
    Statistic,
    combine,
    over_members,
    statistic_words,
)
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

AXES = ("motion", "damping", "station", "direction", "frequency")


@dataclass(frozen=True)
class Station:
    """Where spectra are given: points on a floor."""

    building: str  #: name of the building
    floor: str  #: its number
    points: tuple[str, ...]  #: the points on it in words, at least one
    elevation: float = float("nan")  #: of the points [m]; nan when they differ

    @property
    def label(self) -> str:
        """The floor in words."""
        return f"floor {self.floor}"


@dataclass(frozen=True, eq=False)
class FloorSpectrumSet:
    """Computed floor response spectra with everything that says what they are."""

    frequency: Array  #: ascending, shape (n_f,) [Hz]
    damping: Array  #: damping ratios of the oscillators, shape (n_d,) [-]
    stations: tuple[Station, ...]  #: n_s places
    #: n_x names, "x", "y" or "z"; or "rx", "ry" or "rz", of rotations about these axes
    directions: tuple[str, ...]
    #: pseudo-acceleration, shape (n_m, n_d, n_s, n_x, n_f) [m/s2, rad/s2], one for each motion
    psa: Array
    #: zero-period acceleration, the largest acceleration of the floor, shape (n_m, n_s, n_x)
    #: [m/s2, rad/s2]
    zpa: Array
    motions: tuple[str, ...]  #: names of the n_m motions
    title: str  #: of the case
    method: str  #: how they were computed, in words
    #: where the motion stands for a statistic over several, that in words; else empty
    over: str = ""

    def __post_init__(self) -> None:
        f = checked_frequency(self.frequency)
        checked_values(self.psa, f.size)
        shape = (len(self.motions), len(self.stations), len(self.directions))
        expected = (shape[0], self.damping.size, *shape[1:], f.size)
        if self.psa.shape != expected or self.zpa.shape != shape or 0 in expected:
            raise ImpactfemError(
                f"spectra over {', '.join(AXES)} need shape {expected} and at least one of each, "
                f"got {self.psa.shape} with zero-period accelerations {self.zpa.shape}"
            )
        if len({name.startswith("r") for name in self.directions}) > 1:
            raise ImpactfemError(
                f"spectra of {', '.join(self.directions)}: translations and rotations have units of"
                " their own; expected the ones or the others"
            )

    @property
    def unit(self) -> str:
        """Of the accelerations: m/s2, or rad/s2 of rotations."""
        return "rad/s2" if self.directions[0].startswith("r") else "m/s2"

    def over_motions(self, statistic: Statistic) -> tuple[Array, Array]:
        """Pseudo- and zero-period acceleration of a statistic over the motions [m/s2].

        Their shapes are (n_d, n_s, n_x, n_f) and (n_s, n_x).
        """
        return combine(self.psa, statistic), combine(self.zpa, statistic)

    def of_members(self, name: str) -> FloorSpectrumSet:
        """The spectra of an ensemble with one of `STATISTICS` in place of its motions."""
        words = f"{STATISTICS[name]} of {len(self.motions)} motions"
        return replace(
            self,
            psa=over_members(self.psa, name)[None],
            zpa=over_members(self.zpa, name)[None],
            motions=(words,),
            over=words,
        )

    def design(
        self, broadening: Ratio = 0.15, *, clipping: bool = False, statistic: Statistic = "envelope"
    ) -> DesignFloorSpectra:
        """Make the design spectra of a statistic over the motions.

        Broadened as by :func:`impactfem.spectra.design.broaden`; narrow peaks are reduced before on
        request, at dampings below 10 %.
        """
        raw, zpa = self.over_motions(statistic)
        # A curve with cut peaks has more frequencies than the list; the broadened spectra share one
        # list, which holds the corners of all.
        curves = {
            index: (self.frequency, raw[index], ())
            if not clipping or self.damping[index[0]] >= LARGEST_DAMPING
            else clip_peaks(self.frequency, raw[index], float(zpa[index[1:]]))
            for index in np.ndindex(*raw.shape[:-1])
        }
        listed = corner_frequencies(
            self.frequency, [(f, s) for f, s, _ in curves.values()], broadening
        )
        psa = np.empty((*raw.shape[:-1], listed.size))
        for index, (f, s, _) in curves.items():
            psa[index] = broaden(f, s, broadening, listed)
        lower, upper = sides(broadening)
        return DesignFloorSpectra(
            source=self,
            frequency=listed,
            psa=psa,
            raw=raw,
            zpa=zpa,
            rigid=rigid_frequency(
                self.frequency, raw, np.broadcast_to(zpa, (self.damping.size, *zpa.shape))
            ),
            broadening=(lower, upper),
            clipping=clipping,
            clipped={index: peaks for index, (_, _, peaks) in curves.items() if peaks},
            statistic=statistic,
        )


@dataclass(frozen=True, eq=False)
class DesignFloorSpectra:
    """Design floor response spectra, and the computed ones they were made of."""

    source: FloorSpectrumSet  #: the computed spectra of each motion
    #: ascending, shape (n,) [Hz]: the list of the source, and the corners of plateaus
    frequency: Array
    psa: Array  #: broadened pseudo-acceleration, shape (n_d, n_s, n_x, n) [m/s2]
    #: the statistic over the motions, at the list of the source, shape (n_d, n_s, n_x, n_f) [m/s2]
    raw: Array
    zpa: Array  #: the same statistic of the zero-period acceleration, shape (n_s, n_x) [m/s2]
    #: frequency from which on `raw` stays within 5 % of `zpa`, shape (n_d, n_s, n_x) [Hz]; nan
    #: where the list ends before
    rigid: Array
    broadening: tuple[float, float]  #: l and u [-]
    clipping: bool  #: whether narrow peaks were to be reduced
    #: the peaks that were, by damping, station and direction
    clipped: dict[tuple[int, ...], tuple[ClippedPeak, ...]]
    statistic: Statistic  #: over the motions

    @property
    def motions_text(self) -> str:
        """The motions and what was taken over them, in words."""
        count = len(self.source.motions)
        if self.source.over:
            return self.source.over
        if count == 1:
            return f"1 motion ({self.source.motions[0]})"
        return f"{count} motions, {statistic_words(self.statistic)}"

    @property
    def broadening_text(self) -> str:
        """What was done to the peaks, in words."""
        text = broadening_words(self.broadening)
        if self.clipping:
            count = sum(len(peaks) for peaks in self.clipped.values())
            text += f"; {count} narrow peaks reduced by 15 % before (ASCE 4-98, 3.4.2.3)"
        return text

    @property
    def computed(self) -> Array:
        """``raw`` at the design frequencies, nan at those that were not computed."""
        return self.at_design(self.raw)

    def at_design(self, values: Array) -> Array:
        """Spread values at the list of the source, shape (..., n_f), over the design frequencies.

        The result has shape (..., n), nan at the frequencies that are not in the list of the
        source.
        """
        wide = np.full((*values.shape[:-1], self.frequency.size), np.nan)
        wide[..., np.isin(self.frequency, self.source.frequency)] = values
        return wide

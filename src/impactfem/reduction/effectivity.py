"""How well a band tells an error that is known: their ratio, as maxima within thirds of octaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST, MOST = 1.0, 10.0
"""Between which an effectivity is good."""
NEGLIGIBLE = 1e-4
"""Error over the spectrum, as maxima within a third of an octave, that is not looked at."""


@dataclass(frozen=True, eq=False)
class Effectivity:
    """Band over error, of all spectra and thirds of an octave with an error to speak of."""

    ratio: Array  #: Band over error, shape (n,).
    spectrum: NDArray[np.int64]  #: Number of the spectrum of each, shape (n,).
    frequency: Array  #: Middle of the third of an octave of each, shape (n,) [Hz].

    @property
    def good(self) -> float:
        """Share of the ratios between 1 and 10; 1 where there is no error at all."""
        return _share((self.ratio >= LEAST) & (self.ratio <= MOST))

    @property
    def held(self) -> float:
        """Share of the errors that the band holds."""
        return _share(self.ratio >= LEAST)

    @property
    def misses(self) -> list[tuple[int, float, float]]:
        """Number of the spectrum, frequency [Hz] and ratio where the band is less, least first."""
        order = np.argsort(self.ratio)
        missed = order[self.ratio[order] < LEAST]
        return [
            (int(self.spectrum[k]), float(self.frequency[k]), float(self.ratio[k])) for k in missed
        ]


def effectivity(band: Array, computed: Array, truth: Array, frequency: Array) -> Effectivity:
    """Compare a band with the error of spectra.

    Args:
        band: Half width of the band, shape (n_spectra, n_frequencies).
        computed: The spectra that it is of, same shape.
        truth: What they should be, same shape.
        frequency: Ascending, shape (n_frequencies,) [Hz].
    """
    number = np.round(3.0 * np.log2(np.asarray(frequency) / 1e3))
    thirds = np.unique(number)

    def largest(values: Array) -> Array:
        return np.array([values[:, number == third].max(axis=1) for third in thirds])

    widths, errors, size = (largest(v) for v in (band, np.abs(computed - truth), truth))
    third, spectrum = np.nonzero(errors > NEGLIGIBLE * size)
    return Effectivity(
        ratio=widths[third, spectrum] / errors[third, spectrum],
        spectrum=np.asarray(spectrum, dtype=np.int64),
        frequency=1e3 * 2.0 ** (thirds[third] / 3.0),
    )


def together(parts: Sequence[Effectivity]) -> Effectivity:
    """Those of several cases as one."""
    return Effectivity(
        ratio=np.concatenate([one.ratio for one in parts]),
        spectrum=np.concatenate([one.spectrum for one in parts]),
        frequency=np.concatenate([one.frequency for one in parts]),
    )


def _share(of: NDArray[np.bool_]) -> float:
    return float(np.mean(of)) if of.size else 1.0

"""The error band of the reduced model on spectra and peak accelerations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAFETY = 2.0
"""Factor on the difference of the nested models."""
WIDTH = 1.0 / 3.0
"""Octaves within which the largest difference counts: curves that cross have no error there."""


def spectrum_band(fine: Array, coarse: Array, frequency: Array) -> Array:
    """Half width of the band on spectra by two nested models.

    At each frequency the largest difference within a third of an octave, times a safety factor. An
    estimate, no bound: the finer model is nearer to the truth than the two are to each other, as
    long as the basis converges.

    Args:
        fine: Spectra of the model that is used, shape (..., n_frequencies).
        coarse: Spectra of the model nested in it, same shape.
        frequency: Ascending, shape (n_frequencies,) [Hz].
    """
    difference = np.abs(fine - coarse)
    half = 2.0 ** (0.5 * WIDTH)
    first = np.searchsorted(frequency, frequency / half * (1.0 - 1e-12))
    last = np.searchsorted(frequency, frequency * half * (1.0 + 1e-12))
    band = np.empty_like(difference)
    for k, (low, high) in enumerate(zip(first, last, strict=True)):
        band[..., k] = difference[..., low:high].max(axis=-1)
    band *= SAFETY
    return np.asarray(band, dtype=np.float64)

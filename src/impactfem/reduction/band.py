"""The error band of the reduced model on spectra and peak accelerations.

It comes from larger models that the reduced one is nested in (`larger_models`), or, without the
vectors that these take, from smaller ones (`error_band`): at each frequency the largest difference
within part of an octave, times a safety factor. An estimate, no bound.

Measured against full runs of the paper's building and impacts, 5.6 s by Newmark at 1 ms, 29 points
in three directions, the three dampings of Table 8 with bases for the lightest: maxima of band and
error within thirds of an octave up to 450 Hz, where the error is above 0.01 % of the spectrum.

| building, motion, bases (vectors) | errors | band | 1 to 10 times the error | held | > 10 |
|---|---|---|---|---|---|
| 34,632 dofs, the case's motion: 404, 468, 532 | 3603 | larger | 96.7 % | 99.9 % | 3.2 % |
| | | smaller | 34.6 % | 99.6 % | 65.0 % |
| 59,382 dofs, seed 5, not tuned on: 505, 605 | 3633 | larger | 96.3 % | 99.2 % | 2.9 % |
| | | smaller | 44.9 % | 99.7 % | 54.8 % |

Of the two heavier dampings alone, larger: 96.1 % and 94.1 % of 519 and 903. What is not held is
mostly in directions that hardly move, as along x at low floors: 0.5 to 1 times the error. The
difference from a full run from 10 ms before to 0.4 s after the two largest impacts, times 1.5,
holds 77 % of the first 3603 and is 1 to 10 times 74 %: at many points neither the spectrum nor its
error comes from the main impacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import error_band, larger_models
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import (
    NodeResponse,
    modal_histories,
    node_response,
    node_spectra,
)

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LARGER, SMALLER = "larger", "smaller"
WIDTH = {LARGER: 1.0 / 6.0, SMALLER: 1.0 / 3.0}
"""Octaves within which the largest difference counts: curves that cross have no error there."""
SAFETY = {LARGER: larger_models.SAFETY, SMALLER: error_band.SAFETY}


@dataclass(frozen=True, eq=False)
class Band:
    """Half widths of the error band."""

    psa: Array  #: Of each pseudo-acceleration, shape (n_dampings, 3 n_nodes, n_frequencies) [m/s2].
    #: Of the acceleration at any time, and so of its peak, shape (n_nodes, 3) [m/s2].
    acceleration: Array


def response_band(
    basis: ReducedBasis,
    loads: Loads,
    damping: Rayleigh,
    nodes: Index,
    response: NodeResponse,
    psa: Array,
    shown: Spectra,
    *,
    kind: str = LARGER,
    scheme: str = "exact",
) -> Band:
    """The band of the response at nodes.

    Args:
        basis: The basis; with larger models where the band is to come from these.
        loads: The loads.
        damping: The damping.
        nodes: Nodes that the basis was made for, shape (n,).
        response: Histories there by the model of the basis.
        psa: Their spectra, shape (n_dampings, 3 n, n_frequencies) [m/s2].
        shown: The case's spectra.
        kind: LARGER or SMALLER.
        scheme: "exact" or "newmark", as that of the response.

    Raises:
        ValueError: The basis has no larger models, which are asked for.
    """
    others = basis.larger if kind == LARGER else basis.models[1:]
    if not others:
        raise ValueError(f"a basis without {kind} models")
    spectra, peaks = [], []
    for model in others:
        history = modal_histories(basis, loads, damping, scheme=scheme, model=model)
        other = node_response(basis, history, loads, nodes, model=model)
        peaks.append(other.acceleration)
        spectra.append(node_spectra(other, shown).psa)
    frequency = np.array(shown.frequency_values)
    return Band(
        psa=SAFETY[kind] * spectrum_difference(psa, spectra, frequency, WIDTH[kind]),
        acceleration=SAFETY[kind] * peak_difference(response.acceleration, peaks),
    )


def peak_difference(used: Array, others: Sequence[Array]) -> Array:
    """Largest difference in time from other models.

    Args:
        used: Histories by the model that is used, shape (n_t, ...).
        others: Histories by the others, same shape each.

    Returns:
        Shape (...).
    """
    return np.asarray(np.max([np.abs(used - other).max(axis=0) for other in others], axis=0))


def spectrum_difference(
    used: Array, others: Sequence[Array], frequency: Array, width: float
) -> Array:
    """Largest difference from other models around each frequency.

    Args:
        used: Spectra by the model that is used, shape (..., n_frequencies).
        others: Spectra by the others, same shape each.
        frequency: Ascending, shape (n_frequencies,) [Hz].
        width: Octaves within which the largest difference counts.
    """
    difference = np.max([np.abs(used - other) for other in others], axis=0)
    half = 2.0 ** (0.5 * width)
    first = np.searchsorted(frequency, frequency / half * (1.0 - 1e-12))
    last = np.searchsorted(frequency, frequency * half * (1.0 + 1e-12))
    around = np.empty_like(difference)
    for k, (low, high) in enumerate(zip(first, last, strict=True)):
        around[..., k] = difference[..., low:high].max(axis=-1)
    return np.asarray(around, dtype=np.float64)

"""The response at nodes of the 3D model: histories, spectra, error bands and their peaks."""

from __future__ import annotations

import numpy as np

from impactfem.reduction.response import Band, NodeResponse
from impactfem.spectra import ResponseSpectra
from impactfem.system.arrays import Array
from impactfem.system.quantity import results, si

MOVED = 1e-3
"""Ordinates up to this part of the largest one do not count for the relative error band [-]."""
_HISTORY = "time probe component"
_SPECTRUM = "damping probe component frequency"
_PEAK = "damping probe component"
_PLACE = "probe component"


@results
class NodeResults:
    """Results at n nodes along x, y, z, or of their rotations about these axes (rad for m)."""

    spectra: ResponseSpectra  #: of the accelerations, node by node, x y z each
    time_step: float  #: of the histories [s]
    band_max: float  #: largest half width of an error band over its ordinate, valid range [-]
    displacement: Array = si("m", "relative to the ground", dims=_HISTORY)
    acceleration: Array = si("m/s2", "absolute", dims=_HISTORY)
    psa: Array = si("m/s2", "pseudo-acceleration", dims=_SPECTRUM)
    psa_band: Array = si("m/s2", "half width of the error band of psa", dims=_SPECTRUM)
    psa_peak: Array = si("m/s2", "spectral peak, up to maximum_frequency", dims=_PEAK)
    psa_peak_band: Array = si("m/s2", "band, half width of the band of psa_peak", dims=_PEAK)
    psa_peak_frequency: Array = si("Hz", "at, frequency of psa_peak", dims=_PEAK)
    pfa: Array = si("m/s2", "peak acceleration, at the samples", dims=_PLACE)
    pfa_band: Array = si("m/s2", "band of it, half width of the error band of pfa", dims=_PLACE)
    #: The limit of psa at high frequency.
    pfa_interpolated: Array = si(
        "m/s2", "peak acceleration of the histories that the oscillators saw", dims=_PLACE
    )
    largest_displacement: Array = si(
        "m", "largest displacement, relative to the ground", shown="cm", dims=_PLACE
    )

    @classmethod
    def of(
        cls, response: NodeResponse, spectra: ResponseSpectra, highest: float, band: Band
    ) -> NodeResults:
        """Summarise histories, their spectra and error bands, valid up to `highest` [Hz]."""
        motion = response.acceleration
        valid = spectra.frequency <= highest * (1.0 + 1e-9)
        psa, psa_band = by_node(spectra.psa), by_node(band.psa)
        peak = psa[..., valid].argmax(axis=-1)
        moved = valid & (psa > MOVED * psa.max(initial=0.0))
        return cls(
            spectra=spectra,
            time_step=response.time_step,
            band_max=float((psa_band[moved] / psa[moved]).max(initial=0.0)),
            displacement=response.displacement,
            acceleration=motion,
            psa=psa,
            psa_band=psa_band,
            psa_peak=np.take_along_axis(psa, peak[..., None], -1)[..., 0],
            psa_peak_band=np.take_along_axis(psa_band, peak[..., None], -1)[..., 0],
            psa_peak_frequency=spectra.frequency[peak],
            pfa=np.abs(motion).max(axis=0),
            pfa_band=band.acceleration,
            pfa_interpolated=spectra.zpa_interpolated.reshape(motion.shape[1:]),
            largest_displacement=np.abs(response.displacement).max(axis=0),
        )


@results
class WithoutImpact:
    """Results at n nodes along x, y, z without impact."""

    psa: Array = si("m/s2", "pseudo-acceleration without impact", dims=_SPECTRUM, name="psa_free")
    pfa: Array = si("m/s2", "peak acceleration without impact", dims=_PLACE, name="pfa_free")
    acceleration: Array  #: absolute, shape (n_t, n, 3) [m/s2]

    @classmethod
    def of(cls, response: NodeResponse, spectra: ResponseSpectra) -> WithoutImpact:
        """Summarise histories and their spectra, which are ordered node by node, x y z each."""
        pfa = np.abs(response.acceleration).max(axis=0)
        return cls(by_node(spectra.psa), pfa, response.acceleration)


def by_node(values: Array) -> Array:
    """Return values of spectra as (n_dampings, n, 3, n_frequencies)."""
    return values.reshape(len(values), -1, 3, values.shape[-1])

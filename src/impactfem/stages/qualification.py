"""The floor spectrum at equipment against the spectrum that it is qualified for."""

from __future__ import annotations

import numpy as np

from impactfem.case import Spectra
from impactfem.case.capacities import QualificationSpectrum
from impactfem.spectra import broaden, merged_frequencies, response_spectra
from impactfem.spectra.design import Ratio
from impactfem.system.arrays import Array
from impactfem.system.quantity import results, si


@results
class SpectrumDemand:
    """The ordinate of a floor spectrum with the largest ratio to a qualification spectrum."""

    axis: str = si("", "axis")
    frequency: float = si("Hz", "frequency")
    demand: float = si("m/s2", "floor spectrum")
    capacity: float = si("m/s2", "qualification spectrum")
    first: float = si("Hz", "lowest frequency compared")
    last: float = si("Hz", "highest frequency compared")


def compared(
    motion: Array,
    time_step: float,
    spectrum: QualificationSpectrum,
    spectra: Spectra,
    broadening: Ratio,
    end: float,
) -> SpectrumDemand | None:
    """Compare the spectrum of a motion with a qualification spectrum.

    It has the damping of the qualification spectrum. Compared are the frequencies of the table
    within the resolved band.

    Args:
        motion: Acceleration along x, y and z, shape (3, n_t) [m/s2].
        time_step: Its step [s].
        spectrum: The qualification spectrum.
        spectra: Frequencies and sampling of the floor spectrum.
        broadening: Relative broadening of its peaks.
        end: End of the resolved band [Hz].

    Returns:
        The ordinate with the largest ratio; None if no frequency is common.
    """
    grid = np.asarray(spectra.frequency_values)
    grid = grid[grid <= end * (1.0 + 1e-9)]
    found: list[SpectrumDemand] = []
    for curve in spectrum.file:
        table = np.asarray(curve.frequency)
        frequency = merged_frequencies(grid, table[(table >= grid[0]) & (table <= end)])
        common = frequency[(frequency >= table[0]) & (frequency <= table[-1])]
        if not common.size:
            continue
        psa = response_spectra(
            motion[["xyz".index(axis) for axis in curve.axes]],
            time_step,
            frequency,
            [spectrum.damping],
            points_per_cycle=spectra.points_per_cycle,
            method=spectra.method,
            absolute=False,
        ).psa[0]
        demand = broaden(frequency, psa, broadening, common)
        # Straight on logarithmic axes.
        capacity = np.exp(
            np.interp(np.log(common), np.log(table), np.log(np.asarray(curve.acceleration)))
        )
        i, k = np.unravel_index((demand / capacity).argmax(), demand.shape)
        here = float(common[k]), float(demand[i, k]), float(capacity[k])
        found.append(SpectrumDemand(curve.axes[i], *here, float(common[0]), float(common[-1])))
    return max(found, key=lambda one: one.demand / one.capacity, default=None)

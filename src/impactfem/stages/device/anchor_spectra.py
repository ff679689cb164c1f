"""Spectra of a motion that a device sees, at the frequencies and dampings of its modes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.device.modes import DeviceModes
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.spectra import response_spectra
from impactfem.sticks.element import COMPONENTS

Array = NDArray[np.float64]

STILL = 1e-9
"""A component of an anchor moves if its largest acceleration is above this part of the largest."""


def motion_spectra(
    modes: DeviceModes,
    motion: Array,
    time_step: float,
    settings: Spectra,
    *,
    anchor: int = 1,
    displacement: Array | None = None,
) -> tuple[AnchorSpectrum, ...]:
    """Spectra of the components of a motion that move.

    Args:
        modes: The modes of the device that are used.
        motion: Absolute acceleration, shape (6, n_t) [m/s2, rad/s2].
        time_step: Of its samples [s].
        settings: The case's floor spectra, whose frequencies come to those of the modes.
        anchor: Number of the device's anchor that they are for, from 1.
        displacement: Largest displacement of the anchor against the others, shape (6,) [m, rad].
    """
    frequency = np.concatenate([settings.frequency_values, modes.frequency])
    largest = np.abs(motion).max(axis=1)
    scale = np.where(np.arange(6) < 3, largest[:3].max(), largest[3:].max())
    return tuple(
        AnchorSpectrum.of_motion(
            component,
            motion[k],
            time_step,
            frequency,
            modes.damping,
            anchor=anchor,
            displacement=0.0 if displacement is None else float(displacement[k]),
            points_per_cycle=settings.points_per_cycle,
            method=settings.method,
        )
        for k, component in enumerate(COMPONENTS)
        if largest[k] > STILL * scale[k]
    )


def shown_spectra(damping: float, motion: Array, time_step: float, settings: Spectra) -> Array:
    """Pseudo-acceleration at the frequencies of the case, for figures.

    Args:
        damping: Damping ratio [-].
        motion: Acceleration along x, y, z, shape (3, n_t) [m/s2].
        time_step: Of its samples [s].
        settings: The case's floor spectra.

    Returns:
        Shape (3, n_f) [m/s2].
    """
    found = response_spectra(
        motion,
        time_step,
        np.asarray(settings.frequency_values),
        [damping],
        points_per_cycle=settings.points_per_cycle,
        method=settings.method,
        absolute=False,
    )
    return np.asarray(found.psa[0], dtype=np.float64)

"""Floor spectra that a case file gives, as the spectra of a device's anchors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from impactfem.case.given_spectra import GivenSpectrum
from impactfem.device.device import Device
from impactfem.device.modes import DeviceModes
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import MOVED
from impactfem.spectra import at_common_frequencies, interpolate_frequency
from impactfem.spectra.design import ZPA_TOLERANCE

LAST = "a given spectrum's last ordinate is taken for its zero-period acceleration"
NO_SHIFT = "given spectra say nothing of displacements of the supports against each other"


END = 0.8
"""From this part of its last frequency on a spectrum must be flat that says what lies above it."""


def refuse_open_ends(device: Device, modes: DeviceModes, spectra: Sequence[AnchorSpectrum]) -> None:
    """Refuse given spectra that end before they are flat, below a mode that they move.

    Nothing but its end says whether such a spectrum has come down to its zero-period acceleration.

    Args:
        device: The device.
        modes: Those of its modes that are used.
        spectra: The given spectra.

    Raises:
        ImpactfemError: One ends in the amplified range.
    """
    for one in spectra:
        moved = np.abs(modes.participation[device.column(one.component, one.anchor)])
        moved = moved > MOVED * np.max(moved, initial=0.0)
        beyond = modes.frequency[moved & (modes.frequency > one.frequency[-1] * (1.0 + 1e-9))]
        start = max(END * one.frequency[-1], one.frequency[0])
        before = interpolate_frequency(one.frequency, one.psa, [start])[:, 0]
        last = one.psa[:, -1]
        if beyond.size and np.any(np.abs(before - last) > ZPA_TOLERANCE * last):
            raise device.error(
                f"the {one.label} ends at {one.frequency[-1]:g} Hz, where it is not flat yet, and"
                f" does not reach the mode at {beyond.min():.4g} Hz; expected a spectrum that goes"
                " further, or a maximum frequency of the modes"
            )


def given_spectra(given: Sequence[GivenSpectrum]) -> tuple[AnchorSpectrum, ...]:
    """Put the dampings of each support and direction together.

    The zero-period acceleration is the largest of the ordinates at the last common frequency.

    Args:
        given: The spectra of the case.

    Raises:
        ImpactfemError: The dampings of a direction share no range of frequencies.
    """
    families: dict[tuple[int, str], list[GivenSpectrum]] = {}
    for one in given:
        families.setdefault((one.support, one.direction), []).append(one)
    found = []
    for (support, direction), family in families.items():
        family = sorted(family, key=lambda one: one.damping)
        frequency, psa = at_common_frequencies([(s.frequency, s.acceleration) for s in family])
        found.append(
            AnchorSpectrum(
                component=direction,
                frequency=frequency,
                damping=np.array([one.damping for one in family]),
                psa=psa,
                zpa=float(psa[:, -1].max()),
                anchor=support,
            )
        )
    return tuple(found)

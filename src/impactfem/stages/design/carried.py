"""An ensemble of motions that was carried through the 3D building and the devices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CarriedEnsemble:
    """What the members gave; those that failed are left out of all arrays.

    Args:
        members: Names of the n_m members.
        failed: Name and reason of those that failed.
        psa: Pseudo-acceleration at the probes of `transient.nc`, shape
            (n_m, n_dampings, n_probes, 3, n_frequencies) [m/s2].
        pfa: Peak acceleration at them, shape (n_m, n_probes, 3) [m/s2].
        floor_psa: Envelope of the pseudo-accelerations over the probes of each floor and the
            vertices that govern under the member's motion, shape
            (n_m, n_dampings, n_stations, 3, n_frequencies) [m/s2].
        floor_pfa: The same of the peak accelerations, shape (n_m, n_stations, 3) [m/s2].
        vertices: Number of the vertices that govern, shape (n_m, n_stations, 3).
        floors: Numbers of the floors that contact pairs touch.
        impact_force: Largest force of the sticks on each of them, shape (n_m, n_floors) [N].
        devices: Names of the n_d anchors of the devices: that of a device with one is its own.
        device_force: Largest force of the device on each of them in the 3D model, shape
            (n_m, n_d, 6) [N, N m].
        device_spectrum: The same by response spectrum analysis, same shape.
        analysis: Name of that analysis; empty without devices.
        basis_error: Largest estimated error of the transfer functions of the bases at the probes
            and at the vertices that govern under the case's own motion, shape (n_m,) [-].
    """

    members: tuple[str, ...]
    failed: dict[str, str]
    psa: Array
    pfa: Array
    floor_psa: Array
    floor_pfa: Array
    vertices: NDArray[np.int64]
    floors: tuple[int, ...]
    impact_force: Array
    devices: tuple[str, ...]
    device_force: Array
    device_spectrum: Array
    analysis: str
    basis_error: Array

    @property
    def largest_impact(self) -> Array:
        """Largest force of the sticks on the building, shape (n_m,) [N]; 0 without an impact."""
        return np.asarray(self.impact_force.max(axis=1, initial=0.0), dtype=np.float64)

"""Tables of the power spectral densities of figures 20 and 21."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.plot.table import Table
from impactfem.stages.transient.power import force_spectra, power_spectrum
from impactfem.stages.transient.view import TransientView

Array = NDArray[np.float64]


def density_tables(view: TransientView) -> list[Table]:
    """Densities of the accelerations at the impact edges, and of the main impact forces.

    Those that the case has: none without impact edges, the first alone where nothing is hit.
    """
    tables = []
    if view.edges:
        spectra = [
            power_spectrum(view.acceleration(p), view.time_step) for p in view.edges.values()
        ]
        tables.append(
            _table(
                "transient_edge_density",
                f"One-sided power spectral density of the acceleration along {view.direction} at "
                "the middle of the impact edges (Welch's method, Hann windows)",
                "(m/s2)2/Hz",
                spectra[0][0],
                {floor: density for floor, (_, density) in zip(view.edges, spectra, strict=True)},
            )
        )
    if view.loads:
        forces = force_spectra(view.force[:, list(view.loads.values())], view.time_step)
        tables.append(
            _table(
                "transient_force_density",
                "One-sided power spectral density of the main impact force on each floor, as the "
                f"mean power over {forces.duration:.4g} s",
                "N2/Hz",
                forces.frequency,
                dict(zip(view.loads, forces.density, strict=True)),
            )
        )
    return tables


def _table(name: str, title: str, unit: str, frequency: Array, density: dict[int, Array]) -> Table:
    columns = (("frequency", "Hz"), *((f"floor {floor}", unit) for floor in density))
    rows = np.column_stack([frequency, *density.values()])
    return Table(name, title, columns, tuple(tuple(map(float, row)) for row in rows))

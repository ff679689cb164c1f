"""Tables of the stage `transient`: what each probe sees, and the paper's findings beside ours."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.table import Cell, Table, beside_published
from impactfem.stages.stores import open_store
from impactfem.stages.transient.physics import physics_scalars
from impactfem.stages.transient.power import force_spectra, power_spectrum
from impactfem.stages.transient.view import TransientView
from impactfem.system.log import LOGGER

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


def transient_tables(folder: Path, published: Mapping[str, float]) -> list[Path]:
    """Write the tables of the stage into `tables/` and into the log.

    Args:
        folder: The run's folder, with `transient.nc` and `pounding.nc`.
        published: Published values in SI by the name of the result.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    with (
        open_store(folder / "transient.nc") as store,
        open_store(folder / "pounding.nc") as sticks,
    ):
        view = TransientView(store)
        tables = [_probes(view), _physics(view, sticks, published)]
        densities = density_tables(view)
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
    return [table.write_csv(target) for table in (*tables, *densities)]


def _probes(view: TransientView) -> Table:
    """Peaks at each probe, with the half widths of their error bands."""
    rows: list[tuple[Cell, ...]] = []
    frequency = view.frequency[view.known]
    for probe, name in enumerate(view.names):
        psa, band = view.psa(probe)[view.known], view.band(probe)[view.known]
        k = int(np.argmax(psa))
        x, y, z = (float(value) for value in view.position[probe])
        rows.append(
            (
                name,
                x,
                y,
                z,
                float(psa[k]),
                float(band[k]),
                float(frequency[k]),
                view.pfa(probe),
                view.pfa_band(probe),
                1e2 * float(np.abs(view.displacement(probe)).max()),
            )
        )
    return Table(
        "transient_probes",
        f"Response of the 3D building {view.building} along {view.direction}: peak of the floor "
        f"response spectrum ({100 * view.damping:g} % damping, up to {frequency[-1]:.4g} Hz) and "
        "peak acceleration, with half widths of their error bands",
        (
            ("probe", ""),
            ("x", "m"),
            ("y", "m"),
            ("z", "m"),
            ("spectral peak", "m/s2"),
            ("band", "m/s2"),
            ("at", "Hz"),
            ("peak acceleration", "m/s2"),
            ("band of it", "m/s2"),
            ("largest displacement", "cm"),
        ),
        tuple(rows),
    )


def _physics(view: TransientView, sticks: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Our numbers beside the paper's; of the stage's other scalars those that are published."""
    found = physics_scalars(view, sticks)
    names = {scalar.name for scalar in found}
    shown = [s for s in view.scalars if s.name in published and s.name not in names] + found
    title = f"Waves and amplification in the 3D building {view.building}"
    return beside_published("transient_physics", title, shown, published)

"""Spectra at the points of the floors under the case's own motion.

Those at the probes are read from `transient.nc`; those at the vertices that govern are added.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.stages.design.floor_points import FloorPoints, enveloped, floor_points
from impactfem.stages.design.records import Records, RecordSpectra
from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CaseSpectra:
    """What the stage `transient` found at its probes, and the same at vertices of the floors.

    Args:
        building: Name of the building.
        names: Names of the n_p probes.
        nodes: Their nodes, shape (n_p,).
        floors: The points of each floor.
        elsewhere: Names of the probes that are on no floor.
        frequency: Shape (n_f,) [Hz].
        damping: Of the oscillators, shape (n_d,) [-].
        psa: Pseudo-acceleration along x, y, z, shape (n_d, n_p, 3, n_f) [m/s2].
        pfa: Peak acceleration, shape (n_p, 3) [m/s2].
        maximum_frequency: Up to which the 3D model is meant [Hz].
        vertices: The vertices of the floors that govern; none where the probes stand alone.
        vertex_spectra: Spectra of these n_v records; None without.
    """

    building: str
    names: tuple[str, ...]
    nodes: NDArray[np.int64]
    floors: tuple[FloorPoints, ...]
    elsewhere: tuple[str, ...]
    frequency: Array
    damping: Array
    psa: Array
    pfa: Array
    maximum_frequency: float
    vertices: Records = field(default_factory=Records.none)
    vertex_spectra: RecordSpectra | None = None

    @cached_property
    def probes_psa(self) -> Array:
        """Envelope over the probes of each floor, shape (n_d, n_floors, 3, n_f) [m/s2]."""
        return enveloped(self.psa, self.floors, axis=1)

    @cached_property
    def floor_psa(self) -> Array:
        """Envelope over the points of each floor, shape (n_d, n_floors, 3, n_f) [m/s2]."""
        if self.vertex_spectra is None:
            return self.probes_psa
        return self.vertices.raised(self.probes_psa, self.vertex_spectra.psa, axis=1)

    @cached_property
    def floor_pfa(self) -> Array:
        """Envelope over the points of each floor, shape (n_floors, 3) [m/s2]."""
        at_probes = enveloped(self.pfa, self.floors, axis=0)
        if self.vertex_spectra is None:
            return at_probes
        return self.vertices.raised(at_probes, self.vertex_spectra.pfa, axis=0)

    def with_vertices(self, vertices: Records, spectra: RecordSpectra) -> CaseSpectra:
        """The same with the vertices that govern.

        Args:
            vertices: The vertices.
            spectra: Their spectra, at the same dampings and frequencies.
        """
        return replace(self, vertices=vertices, vertex_spectra=spectra)


def read_case_spectra(path: Path) -> CaseSpectra:
    """Read `transient.nc`.

    Raises:
        ImpactfemError: The file cannot be read, or is no such store.
    """
    try:
        with xr.open_dataset(path, engine="h5netcdf") as store:
            names = tuple(str(name) for name in store["probe"].values)
            position = np.asarray(store["probe_position"].values, dtype=np.float64)
            kinds = zip(store["probe_kind"].values, store["probe_floor"].values, strict=True)
            centres = {int(f): k for k, (kind, f) in enumerate(kinds) if kind == "centre"}
            floors, elsewhere = floor_points(names, position, centres)
            order = ("damping", "probe", "component", "frequency")
            return CaseSpectra(
                building=str(store.attrs["building"]),
                names=names,
                nodes=np.asarray(store["probe_node"].values, dtype=np.int64),
                floors=floors,
                elsewhere=elsewhere,
                frequency=np.asarray(store["frequency"].values, dtype=np.float64),
                damping=np.asarray(store["damping"].values, dtype=np.float64),
                psa=np.asarray(store["psa"].transpose(*order).values, dtype=np.float64),
                pfa=np.asarray(store["pfa"].values, dtype=np.float64),
                maximum_frequency=float(store.attrs["maximum_frequency"]),
            )
    except KeyError as error:
        raise ImpactfemError(f"{path} holds no spectra of probes: {error.args[0]}") from error
    except (OSError, ValueError) as error:
        raise ImpactfemError(f"cannot read spectra of probes from {path}: {error}") from error

"""The stores of the stage: `transient.nc`, and `transient_maps.nc` with the fields.

`transient.nc` has the dimensions `time`, `probe`, `component` (x, y, z), `damping`, `frequency`,
`load`, `edge` (loads on edges) and `transfer_frequency`. Displacements are relative to the ground,
accelerations absolute. `psa_band` and `pfa_band` are half widths of the error band; their `note`
says what tells it and its safety factor.

`transient_maps.nc` has `node` (vertices of the floors), `wave_node` (nodes of the floor with the
line), `wave_triangle`, `snapshot`, and `frame` (times of the animation). All values are SI; each
variable carries its unit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.reduction.band import SAFETY
from impactfem.reduction.transfer import transfer_functions
from impactfem.stages.transient.compute import TransientStudy, by_probe
from impactfem.stages.transient.maps import FloorMaps
from impactfem.stages.transient.scalars import transient_scalars
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

Variables = dict[str, tuple[Any, ...]]
COMPONENTS = ["x", "y", "z"]


def write_transient(path: Path, study: TransientStudy, key: str) -> None:
    """Write `transient.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    main = study.main_impact
    transient = study.case.transient
    dataset = xr.Dataset(
        {**_histories(study), **_spectra(study), **_loads(study), **_transfer(study)},
        coords={
            "probe": ("probe", np.array([p.name for p in study.probes], dtype=object)),
            "component": COMPONENTS,
            "damping": ("damping", study.spectra.damping, {"units": "1"}),
            "frequency": ("frequency", study.spectra.frequency, {"units": "Hz"}),
        },
        attrs={
            "title": study.case.title,
            "inputs": key,
            "case_hash": study.case.content_hash(),
            "building": study.case.structure.building if study.case.structure else "",
            "shown_direction": study.case.shown_direction,
            "solver": transient.solver if transient else "",
            "maximum_frequency": transient.maximum_frequency if transient else 0.0,
            "basis_vectors": len(study.basis.model.eigenvalue) if study.basis else 0,
            "main_impact": list(main) if main else [],
        },
    )
    write_netcdf(path, with_scalars(dataset, transient_scalars(study)))


def write_maps(path: Path, study: TransientStudy, maps: FloorMaps, key: str) -> None:
    """Write `transient_maps.nc`; arguments as `write_transient`."""
    mesh = study.parts.mesh
    wave = ("snapshot", "wave_node", "component")
    xyz = ("node", "xyz")
    edges = mesh.triangles[maps.wave_triangles][:, :6]
    dataset = xr.Dataset(
        {
            "node_number": ("node", maps.nodes, {"note": "number in building.nc"}),
            "node_position": (xyz, mesh.nodes[maps.nodes], {"units": "m"}),
            "pfa": (("node", "component"), maps.pfa, {"units": "m/s2"}),
            "psa": (("node", "component", "frequency"), maps.psa, {"units": "m/s2"}),
            "wave_node_number": ("wave_node", maps.wave_nodes, {}),
            "wave_node_position": (
                ("wave_node", "xyz"),
                mesh.nodes[maps.wave_nodes],
                {"units": "m"},
            ),
            "wave_triangle_node": (
                ("wave_triangle", "triangle_corner"),
                np.searchsorted(maps.wave_nodes, edges),
                {"note": "indices of wave_node"},
            ),
            "wave_displacement": (wave, maps.wave_displacement, {"units": "m"}),
            "wave_acceleration": (wave, maps.wave_acceleration, {"units": "m/s2"}),
            "frame_acceleration": (
                ("frame", "wave_node", "component"),
                maps.frame_acceleration,
                {"units": "m/s2"},
            ),
            "sampling_loss": (
                "frequency",
                maps.sampling_loss,
                {"units": "1", "note": "bound of what psa lacks of a peak between samples"},
            ),
            "membrane_force": (
                ("snapshot", "wave_triangle"),
                maps.membrane_force,
                {"units": "N/m", "note": "normal force along y"},
            ),
        },
        coords={
            "component": COMPONENTS,
            "frequency": ("frequency", maps.frequency, {"units": "Hz"}),
            "snapshot": ("snapshot", maps.wave_times, {"units": "s"}),
            "frame": ("frame", maps.frame_times, {"units": "s"}),
        },
        attrs={
            "title": study.case.title,
            "inputs": key,
            "damping": maps.damping,
            "points_per_cycle": maps.points_per_cycle,
        },
    )
    write_netcdf(path, dataset)


def _histories(study: TransientStudy) -> Variables:
    response = study.response
    dims = ("time", "probe", "component")
    time = response.time_step * np.arange(len(response.acceleration))
    positions = study.parts.mesh.nodes[[probe.node for probe in study.probes]]
    return {
        "time": ("time", time, {"units": "s"}),
        "displacement": (dims, response.displacement, {"units": "m"}),
        "acceleration": (dims, response.acceleration, {"units": "m/s2"}),
        "probe_position": (("probe", "xyz"), positions, {"units": "m"}),
        "probe_node": ("probe", np.array([probe.node for probe in study.probes]), {}),
        "probe_distance": (
            "probe",
            np.array([probe.distance for probe in study.probes]),
            {"units": "m", "note": "from where it was asked for"},
        ),
    }


def _spectra(study: TransientStudy) -> Variables:
    dims = ("damping", "probe", "component", "frequency")
    sd = by_probe(study.spectra.sd, len(study.probes))
    told = {"units": "m/s2"}
    if study.basis is not None and study.case.transient is not None:
        kind = study.case.transient.band
        told["note"] = f"by {kind} bases, safety factor {SAFETY[kind]:g}"
    return {
        "psa": (dims, study.psa, {"units": "m/s2"}),
        "psa_band": (dims, study.band, told),
        "sd": (dims, sd, {"units": "m"}),
        "pfa": (("probe", "component"), study.pfa, {"units": "m/s2"}),
        "pfa_band": (("probe", "component"), study.pfa_band, told),
        "pfa_interpolated": (
            ("probe", "component"),
            study.spectra.zpa_interpolated.reshape(study.pfa.shape),
            {"units": "m/s2", "note": "of the histories as the oscillators saw them"},
        ),
    }


def _loads(study: TransientStudy) -> Variables:
    loads = study.loads
    names = np.array([edge.name for edge in loads.edges], dtype=object)
    return {
        "ground_acceleration": (("time", "component"), loads.ground, {"units": "m/s2"}),
        "edge": ("edge", names, {}),
        "edge_force": (("time", "edge"), loads.force, {"units": "N"}),
    }


def _transfer(study: TransientStudy) -> Variables:
    """Acceleration over the force on each edge, straight from the reduced model."""
    if study.basis is None or study.case.structure is None:
        return {}
    damping = study.case.building(study.case.structure.building).damping.rayleigh
    nodes = np.array([probe.node for probe in study.probes])
    found = transfer_functions(study.basis, nodes, damping, float(study.spectra.frequency[-1]))
    dims = ("transfer_frequency", "transfer_load", "probe", "component")
    return {
        "transfer_frequency": ("transfer_frequency", found.frequency, {"units": "Hz"}),
        "transfer_load": ("transfer_load", np.array(found.loads, dtype=object), {}),
        "transfer_re": (dims, found.value.real, {"units": "1/kg"}),
        "transfer_im": (dims, found.value.imag, {"units": "1/kg"}),
        "transfer_bound": (
            dims,
            found.bound,
            {"units": "1/kg", "note": "rigorous bound on the modulus of the error"},
        ),
    }

"""The stores of the stage: `transient.nc`, and `transient_maps.nc` with the fields.

Displacements are relative to the ground, accelerations absolute.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.reduction.response import SAFETY, transfer_functions
from impactfem.stages.stores import Output, dataset
from impactfem.stages.transient.compute import TransientStudy, by_probe, main_impact
from impactfem.stages.transient.maps import FloorMaps
from impactfem.stages.transient.prepared import transient_of
from impactfem.stages.transient.scalars import transient_scalars
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

AXES = ["x", "y", "z"]
_HISTORY = "time probe component"
_SPECTRUM = "damping probe component frequency"
_TRANSFER = "transfer_frequency transfer_load probe component"
OUTPUTS = {
    "time": Output("time", "s"),
    "component": Output("component"),
    "xyz": Output("xyz"),
    "probe": Output("probe"),
    "probe_kind": Output("probe", "", "centre, edge, line or point", label=True),
    "probe_floor": Output("probe", "", "number of its floor; 0 for a point", label=True),
    "probe_position": Output("probe xyz", "m"),
    "probe_node": Output("probe", "", "number in building.nc"),
    "probe_distance": Output("probe", "m", "from where it was requested"),
    "displacement": Output(_HISTORY, "m", "relative to the ground"),
    "acceleration": Output(_HISTORY, "m/s2", "absolute"),
    "frequency": Output("frequency", "Hz", "of the oscillators"),
    "damping": Output("damping", "-", "of the oscillators"),
    "psa": Output(_SPECTRUM, "m/s2", "pseudo-acceleration"),
    "psa_band": Output(_SPECTRUM, "m/s2", "half width of its error band"),
    "sd": Output(_SPECTRUM, "m", "spectral displacement"),
    "pfa": Output("probe component", "m/s2", "peak acceleration at the samples"),
    "pfa_band": Output("probe component", "m/s2", "half width of its error band"),
    "pfa_interpolated": Output(
        "probe component", "m/s2", "peak acceleration of the histories as the oscillators saw them"
    ),
    "ground_acceleration": Output("time component", "m/s2"),
    "base_plate": Output("base_plate", "", "anchor of a device, whose plate is tied to the floor"),
    "base_plate_floor": Output("base_plate", label=True),
    "base_plate_position": Output("base_plate xyz", "m"),
    "base_plate_radius": Output("base_plate", "m", "within which nodes move as one rigid body"),
    "edge": Output("edge", "", "load on an edge"),
    "edge_floor": Output("edge", label=True),
    "edge_force": Output("time edge", "N", "positive in compression"),
    "transfer_frequency": Output("transfer_frequency", "Hz"),
    "transfer_load": Output("transfer_load", "", "load on an edge"),
    "transfer_load_floor": Output("transfer_load", label=True),
    "transfer_re": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_im": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_bound": Output(_TRANSFER, "1/kg", "rigorous bound on the modulus of the error"),
}
_WAVE = "wave_node component"
MAP_OUTPUTS = {
    "component": Output("component"),
    "xyz": Output("xyz"),
    "node_number": Output("node", "", "number in building.nc", label=True),
    "node_position": Output("node xyz", "m", "vertices of the floors"),
    "floor_triangle_node": Output(
        "floor_triangle vertex", "", "vertices of the slabs, places in node"
    ),
    "floor_triangle_floor": Output("floor_triangle", label=True),
    "frequency": Output("frequency", "Hz"),
    "pfa": Output("node component", "m/s2", "peak acceleration"),
    "psa": Output("node component frequency", "m/s2", "pseudo-acceleration"),
    "sampling_loss": Output("frequency", "-", "bound of what psa lacks of a peak between samples"),
    "wave_node_number": Output("wave_node", "", "number in building.nc", label=True),
    "wave_node_position": Output("wave_node xyz", "m", "nodes of the floor with the line"),
    "wave_triangle_node": Output("wave_triangle triangle_corner", "", "places in wave_node"),
    "snapshot": Output("snapshot", "s"),
    "wave_displacement": Output(f"snapshot {_WAVE}", "m", "relative to the ground"),
    "wave_acceleration": Output(f"snapshot {_WAVE}", "m/s2", "absolute"),
    "membrane_force": Output("snapshot wave_triangle", "N/m", "normal force along y"),
    "frame": Output("frame", "s", "times of the film"),
    "frame_acceleration": Output(f"frame {_WAVE}", "m/s2", "absolute"),
}


def write_stores(folder: Path, study: TransientStudy, key: str) -> list[Path]:
    """Write `transient.nc` and, where there are fields, `transient_maps.nc`.

    Args:
        folder: The run's folder.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    store = _response(study, key)
    maps = None if study.maps is None else _fields(study, study.maps, key)
    files = {"transient.nc": with_scalars(store, transient_scalars(study, store, maps))}
    if maps is not None:
        files["transient_maps.nc"] = maps
    for name, content in files.items():
        write_netcdf(folder / name, content)
    return [folder / name for name in files]


def _response(study: TransientStudy, key: str) -> xr.Dataset:
    case, prepared, spectra = study.case, study.prepared, study.spectra
    transient, nodes = transient_of(case), prepared.parts.mesh.nodes
    probes, plates, loads = prepared.probes, prepared.base_plates, prepared.loads
    response, impact = study.response, main_impact(loads)
    pfa = np.abs(response.acceleration).max(axis=0)
    values: dict[str, Any] = {
        "time": response.time_step * np.arange(len(response.acceleration)),
        "component": AXES,
        "xyz": AXES,
        "probe": [probe.name for probe in probes],
        "probe_kind": [probe.kind for probe in probes],
        "probe_floor": [probe.floor for probe in probes],
        "probe_position": nodes[[probe.node for probe in probes]],
        "probe_node": [probe.node for probe in probes],
        "probe_distance": [probe.distance for probe in probes],
        "displacement": response.displacement,
        "acceleration": response.acceleration,
        "frequency": spectra.frequency,
        "damping": spectra.damping,
        "psa": by_probe(spectra.psa, len(probes)),
        "psa_band": study.band,
        "sd": by_probe(spectra.sd, len(probes)),
        "pfa": pfa,
        "pfa_band": study.pfa_band,
        "pfa_interpolated": spectra.zpa_interpolated.reshape(pfa.shape),
        "ground_acceleration": loads.ground,
        "edge": [edge.name for edge in loads.edges],
        "edge_floor": np.array([edge.floor for edge in loads.edges], dtype=int),
        "edge_force": loads.force,
    }
    if plates:
        away = [np.linalg.norm(nodes[plate.nodes] - plate.point, axis=1) for plate in plates]
        values |= {
            "base_plate": [plate.name for plate in plates],
            "base_plate_floor": [plate.floor for plate in plates],
            "base_plate_position": [plate.point for plate in plates],
            "base_plate_radius": [float(one.max()) for one in away],
        }
    notes = {}
    if study.basis is not None:
        note = f"by {transient.band} bases, safety factor {SAFETY[transient.band]:g}"
        notes = {"psa_band": note, "pfa_band": note}
        highest, at_probes = float(spectra.frequency[-1]), np.array([p.node for p in probes])
        found = transfer_functions(study.basis, at_probes, prepared.damping, highest, loads.names)
        values |= {
            "transfer_frequency": found.frequency,
            "transfer_load": found.loads,
            # A basis keeps the names of its loads alone, "floor 8".
            "transfer_load_floor": np.array([name.split()[-1] for name in found.loads], dtype=int),
            "transfer_re": found.value.real,
            "transfer_im": found.value.imag,
            "transfer_bound": found.bound,
        }
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": case.structure.building if case.structure else "",
        "shown_direction": case.shown_direction,
        "wave_floor": case.wave_floor,
        "solver": transient.solver,
        "maximum_frequency": transient.maximum_frequency,
        "basis_vectors": len(study.basis.model.eigenvalue) if study.basis else 0,
        "main_impact": list(impact) if impact else [],
    }
    return dataset(OUTPUTS, values, attributes=attributes, notes=notes)


def _fields(study: TransientStudy, maps: FloorMaps, key: str) -> xr.Dataset:
    mesh = study.prepared.parts.mesh
    slabs = {floor: mesh.triangles[mesh.slab(floor), :3] for floor in mesh.floors}
    values = {
        "component": AXES,
        "xyz": AXES,
        "node_number": maps.nodes,
        "node_position": mesh.nodes[maps.nodes],
        "floor_triangle_node": np.searchsorted(maps.nodes, np.concatenate(list(slabs.values()))),
        "floor_triangle_floor": np.repeat(list(slabs), [len(slab) for slab in slabs.values()]),
        "frequency": maps.frequency,
        "pfa": maps.pfa,
        "psa": maps.psa,
        "sampling_loss": maps.sampling_loss,
        "wave_node_number": maps.wave_nodes,
        "wave_node_position": mesh.nodes[maps.wave_nodes],
        "wave_triangle_node": np.searchsorted(
            maps.wave_nodes, mesh.triangles[maps.wave_triangles][:, :6]
        ),
        "snapshot": maps.wave_times,
        "wave_displacement": maps.wave_displacement,
        "wave_acceleration": maps.wave_acceleration,
        "membrane_force": maps.membrane_force,
        "frame": maps.frame_times,
        "frame_acceleration": maps.frame_acceleration,
    }
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "damping": maps.damping,
        "points_per_cycle": maps.points_per_cycle,
    }
    return dataset(MAP_OUTPUTS, values, attributes=attributes)

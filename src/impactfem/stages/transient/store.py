"""The stores of the stage: `transient.nc` with its scalars, `transient_maps.nc` with the fields.

Displacements are relative to the ground, accelerations absolute.
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.building.facade import facades
from impactfem.building.floor import floor_bar
from impactfem.building.parts import BuildingParts
from impactfem.reduction.response import SAFETY, Transfer
from impactfem.spectra.resolved import ZPA, ResolvedBand, band_limited_zpa
from impactfem.stages.results import outputs, value
from impactfem.stages.stores import Output, dataset, of_run, open_store
from impactfem.stages.transient.compute import TransientStudy, main_impact
from impactfem.stages.transient.findings import FINDINGS, findings, transient_scalars
from impactfem.stages.transient.node_results import NodeResults, WithoutImpact, by_node
from impactfem.stages.transient.prepared import Prepared, contact_limit
from impactfem.system.arrays import Array
from impactfem.system.files import write_netcdf
from impactfem.system.quantity import results, si
from impactfem.system.scalar import with_scalars

AXES = ["x", "y", "z"]
_TRANSFER = "transfer_frequency transfer_load probe component"


@results
class Quality:
    """Accuracy of the analysis; None for a result of another solver."""

    impulse_error: float = si("-", "largest error of an impulse by resampling, over the largest")
    points_per_cycle: float = si("-", "samples in a cycle of the highest frequency of spectra")
    upsampling_factor: float = si("-", "of the histories, for the spectra")
    basis_vectors: float | None = si("-", "vectors of the reduced model")
    basis_difference: float | None = si("-", "error of transfer functions, by nested models")
    band_max: float | None = si("-", "largest half width of an error band, relative")
    energy_residual: float | None = si("-", "residual of the energy balance, full model")
    reduced_against_full: float | None = si(
        "-", "largest relative difference of a spectrum, reduced from full model, same step"
    )

    @classmethod
    def of(cls, study: TransientStudy) -> "Quality":
        """Read it from the results of the stage."""
        spectra, basis, full = study.probes.spectra, study.basis, study.full
        return cls(
            impulse_error=study.prepared.loads.impulse_error,
            points_per_cycle=spectra.points_per_cycle,
            upsampling_factor=float(spectra.upsampling_factor),
            basis_vectors=float(len(basis.model.eigenvalue)) if basis else None,
            basis_difference=basis.difference if basis else None,
            band_max=study.probes.band_max if basis else None,
            energy_residual=full.energy.residual if full else None,
            reduced_against_full=study.full_error,
        )


def _of_rotations() -> dict[str, Output]:
    """Outputs of rotations: those of displacements at nodes, with other units and dimensions."""
    declared = {}
    for name, one in outputs(NodeResults).items():
        dims = one.dims.replace("probe", "turning").replace("component", "rotation")
        unit = one.unit.replace("m", "rad", 1)
        text = one.long_name.replace("displacement", "rotation")
        declared[f"rotational_{name}"] = replace(
            one, dims=dims, unit=unit, long_name=text, shown=""
        )
    return declared


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
    "frequency": Output("frequency", "Hz", "of the oscillators"),
    "damping": Output("damping", "-", "of the oscillators"),
    **outputs(NodeResults),
    **outputs(WithoutImpact),
    "zpa": Output("probe component", "m/s2", ZPA),
    "zpa_free": Output("probe component", "m/s2", f"{ZPA}, without impact"),
    "sd": Output("damping probe component frequency", "m", "spectral displacement"),
    "rotation": Output("rotation", "", "about x, y, z"),
    "turning": Output("turning", "", "probe whose node's rotations are recorded"),
    "turning_floor": Output("turning", "", "number of its floor; 0 for a point", label=True),
    **_of_rotations(),
    "base_plate": Output("base_plate", "", "anchor of a device, whose plate is tied to the floor"),
    "base_plate_floor": Output("base_plate", label=True),
    "base_plate_position": Output("base_plate xyz", "m"),
    "base_plate_radius": Output("base_plate", "m", "within which nodes move as one rigid body"),
    "edge": Output("edge", "", "side of a floor, or storey, that is struck or loaded"),
    "edge_floor": Output("edge", "", "its floor, or that above the storey", label=True),
    "edge_side": Output("edge", "", "its side: x-, y+; empty for the impact edge", label=True),
    "edge_length": Output("edge", "m", "of the side"),
    "ground_acceleration": Output("time component", "m/s2"),
    "edge_force": Output("time edge", "N", "resultant, positive in compression"),
    "impact_force": Output("time edge", "N", "part of edge_force due to contact, without loads"),
    "edge_moment": Output("time edge", "N m", "edge_force times its distance from the middle"),
    "transfer_frequency": Output("transfer_frequency", "Hz"),
    "transfer_load": Output("transfer_load", "", "load on an edge"),
    "transfer_load_floor": Output("transfer_load", label=True),
    "transfer_re": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_im": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_bound": Output(_TRANSFER, "1/kg", "rigorous bound on the modulus of the error"),
    "impact_edge": Output("impact_edge", "", "number of the floor"),
    "impact_edge_pfa_mean": Output("impact_edge component", "m/s2", "mean of pfa of its vertices"),
    "impact_edge_pfa_max": Output("impact_edge component", "m/s2", "largest pfa of its vertices"),
    "wave_speed": Output("", "m/s", "shear waves of the material (Bodnar et al. 2022, equation 8)"),
    "plate_wave_speed": Output("", "m/s", "waves in a bare plate, normal to its edge"),
    "loaded_wave_speed": Output("", "m/s", "√(EA'/m') of the floor across, with its masses"),
    "loaded_wave_crossing": Output("", "s", "crossing time by loaded_wave_speed"),
    **outputs(Quality),
    **outputs(ResolvedBand),
    **FINDINGS,
}


def write_stores(folder: Path, study: TransientStudy, key: str) -> list[Path]:
    """Write `transient.nc` and, if there are fields, `transient_maps.nc`; return the files."""
    content, notes = _response(study), _notes(study)
    contact = contact_limit(study.prepared, of_run(folder, "pounding.nc"))
    with open_store(of_run(folder, "pounding.nc")) as sticks:
        band = study.band(contact)
        content |= value(band) | _zpa(study, band.frequency)
        attributes = _attributes(study, key) | band.attributes
        store = dataset(OUTPUTS, content, attributes=attributes, notes=notes)
        content |= findings(store, sticks, study.prepared.damping)
    store = dataset(OUTPUTS, content, attributes=attributes, notes=notes)
    files = {"transient.nc": with_scalars(store, transient_scalars(store))}
    if study.maps is not None:
        about = {"title": study.prepared.building.case.title, "inputs": key}
        files["transient_maps.nc"] = study.maps.assign_attrs(about)
    for name, one in files.items():
        write_netcdf(folder / name, one)
    return [folder / name for name in files]


def _response(study: TransientStudy) -> dict[str, Any]:
    """Return the values of `transient.nc` without the findings."""
    prepared, spectra = study.prepared, study.probes.spectra
    mesh, probes, loads = prepared.parts.mesh, prepared.probes, prepared.loads
    count = len(study.probes.acceleration)
    edges = {edge.place: edge for edge in loads.edges}.values()
    content: dict[str, Any] = {
        "time": study.probes.time_step * np.arange(count),
        "component": AXES,
        "xyz": AXES,
        "probe": [probe.name for probe in probes],
        "probe_kind": [probe.kind for probe in probes],
        "probe_floor": [probe.floor for probe in probes],
        "probe_position": mesh.nodes[prepared.probe_nodes],
        "probe_node": prepared.probe_nodes,
        "probe_distance": [probe.distance for probe in probes],
        "frequency": spectra.frequency,
        "damping": spectra.damping,
        **value(study.probes),
        "sd": by_node(spectra.sd),
        "edge": loads.places,
        "edge_floor": np.array([edge.floor for edge in edges], dtype=int),
        "edge_side": [
            edge.side if edge.height is None else f"storey {edge.side}".rstrip() for edge in edges
        ],
        "edge_length": [facades(mesh, edge.floor)[edge.side][0].length for edge in edges],
        "ground_acceleration": loads.ground,
        "edge_force": loads.resultants[0],
        "impact_force": loads.impact_force,
        "edge_moment": loads.resultants[1],
        **_slab_waves(prepared.parts, study.prepared.building.wave_floor),
        **value(Quality.of(study)),
    }
    if study.free is not None:
        content |= value(study.free)
    if study.rotations is not None and study.turning is not None:
        content |= {
            "rotation": [f"r{axis}" for axis in AXES],
            "turning": [probes[k].name for k in study.turning],
            "turning_floor": [probes[k].floor for k in study.turning],
            **value(study.rotations, "rotational_"),
        }
    if plates := prepared.base_plates:
        away = [np.linalg.norm(mesh.nodes[plate.nodes] - plate.point, axis=1) for plate in plates]
        content |= {
            "base_plate": [plate.name for plate in plates],
            "base_plate_floor": [plate.floor for plate in plates],
            "base_plate_position": [plate.point for plate in plates],
            "base_plate_radius": [float(one.max()) for one in away],
        }
    if study.maps is not None:
        content |= _edge_vertices(prepared, study.maps["pfa"])
    return content | _transfer(study)


def _zpa(study: TransientStudy, end: float) -> dict[str, Array]:
    """Return the ZPA at the probes, and that without impact, by the end of the resolved band."""
    step = study.probes.time_step
    found = {"zpa": band_limited_zpa(study.probes.acceleration, step, end)}
    if study.free is not None:
        found["zpa_free"] = band_limited_zpa(study.free.acceleration, step, end)
    return found


def _edge_vertices(prepared: Prepared, pfa: xr.DataArray) -> dict[str, Any]:
    """Return mean and largest peak acceleration of the vertices of each edge with a probe."""
    floors = [probe.floor for probe in prepared.probes if probe.kind == "edge"]
    on_edge = [np.isin(pfa["node_number"], prepared.parts.mesh.edges[floor]) for floor in floors]
    along = [[pfa.sel(component=axis)[here] for axis in AXES] for here in on_edge]
    return {
        "impact_edge": np.array(floors, dtype=int),
        "impact_edge_pfa_mean": np.reshape(
            [[float(p.mean()) for p in of] for of in along], (-1, 3)
        ),
        "impact_edge_pfa_max": np.reshape([[float(p.max()) for p in of] for of in along], (-1, 3)),
    }


def _slab_waves(parts: BuildingParts, floor: int) -> dict[str, float]:
    """Return closed-form wave speeds: of the slab's bare material, and of the floor as a bar."""
    slab = parts.slab_material(floor)
    speeds = {
        "wave_speed": math.sqrt(slab.E / (2.0 * slab.rho * (1.0 + slab.nu))),
        "plate_wave_speed": math.sqrt(slab.E / (slab.rho * (1.0 - slab.nu**2))),
    }
    if floor in parts.mesh.edges:
        bar = floor_bar(parts, floor, 1 - parts.mesh.edge_axis(floor))
        speeds |= {"loaded_wave_speed": bar.speed, "loaded_wave_crossing": bar.crossing}
    return speeds


def _transfer(study: TransientStudy) -> dict[str, Any]:
    """Return the transfer functions from the loads on the edges; none for the full model."""
    if study.basis is None:
        return {}
    prepared, uniform = study.prepared, study.basis.loads
    # Forces without moments; uniform ones on sides whose patterns are in the basis.
    acting = {
        edge.place if edge.place in uniform else edge.name: edge.floor
        for edge in sorted(prepared.loads.edges, key=lambda edge: edge.side != "")
        if edge.resultant != 0.0
    }
    highest = float(study.probes.spectra.frequency[-1])
    transfer = Transfer.of(study.basis, prepared.probe_nodes, prepared.damping, highest, acting)
    return {
        "transfer_frequency": transfer.frequency,
        "transfer_load": transfer.loads,
        "transfer_load_floor": np.array([acting[name] for name in transfer.loads], dtype=int),
        "transfer_re": transfer.value.real,
        "transfer_im": transfer.value.imag,
        "transfer_bound": transfer.bound,
    }


def _notes(study: TransientStudy) -> dict[str, str]:
    """Return the method of the error bands, by variable."""
    band = study.prepared.building.transient.band
    note = f"by {band} bases, safety factor {SAFETY[band]:g}"
    return {} if study.basis is None else {"psa_band": note, "pfa_band": note}


def _attributes(study: TransientStudy, key: str) -> dict[str, Any]:
    """Return what holds for the store as a whole."""
    building = study.prepared.building
    case, transient = building.case, building.transient
    return {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": building.name,
        "shown_direction": case.shown_direction,
        "wave_floor": building.wave_floor,
        "solver": transient.solver,
        "maximum_frequency": transient.maximum_frequency,
        "main_impact": list(main_impact(study.prepared.loads) or ()),
        "spread": "points" if building.pounds else transient.spread,
        "patch_width": transient.patch_width,
    }

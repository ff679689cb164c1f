"""The stores of the stage: `transient.nc` with its scalars, `transient_maps.nc` with the fields.

Displacements are relative to the ground, accelerations absolute.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.building.facade import facades
from impactfem.building.floor import floor_bar
from impactfem.reduction.response import SAFETY, Transfer
from impactfem.stages.check import resolved_frequency
from impactfem.stages.stores import Output, dataset
from impactfem.stages.transient.compute import TransientStudy, by_probe, main_impact
from impactfem.stages.transient.prepared import transient_of
from impactfem.stages.transient.selection import known, of_kind, resolved
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

AXES = ["x", "y", "z"]
_HISTORY = "time probe component"
_SPECTRUM = "damping probe component frequency"
_ROTATION = "time turning rotation"
_ROTATIONAL = "damping turning rotation frequency"
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
    "rotation": Output("rotation", "", "about x, y, z"),
    "turning": Output("turning", "", "probe whose node's rotations are recorded"),
    "turning_floor": Output("turning", "", "number of its floor; 0 for a point", label=True),
    "rotational_displacement": Output(_ROTATION, "rad"),
    "rotational_acceleration": Output(_ROTATION, "rad/s2"),
    "rotational_psa": Output(_ROTATIONAL, "rad/s2", "pseudo-acceleration"),
    "rotational_psa_band": Output(_ROTATIONAL, "rad/s2", "half width of its error band"),
    "rotational_pfa": Output("turning rotation", "rad/s2", "peak acceleration at the samples"),
    "rotational_pfa_band": Output("turning rotation", "rad/s2", "half width of its error band"),
    "ground_acceleration": Output("time component", "m/s2"),
    "base_plate": Output("base_plate", "", "anchor of a device, whose plate is tied to the floor"),
    "base_plate_floor": Output("base_plate", label=True),
    "base_plate_position": Output("base_plate xyz", "m"),
    "base_plate_radius": Output("base_plate", "m", "within which nodes move as one rigid body"),
    "edge": Output("edge", "", "side of a floor, or storey, that is struck or loaded"),
    "edge_floor": Output("edge", "", "its floor, or that above the storey", label=True),
    "edge_side": Output("edge", "", "its side: x-, y+; empty for the impact edge", label=True),
    "edge_length": Output("edge", "m", "of the side"),
    "edge_force": Output("time edge", "N", "resultant, positive in compression"),
    "impact_force": Output("time edge", "N", "part of it that contact exerts, without loads"),
    "edge_moment": Output("time edge", "N m", "of the force times its distance from the middle"),
    "transfer_frequency": Output("transfer_frequency", "Hz"),
    "transfer_load": Output("transfer_load", "", "load on an edge"),
    "transfer_load_floor": Output("transfer_load", label=True),
    "transfer_re": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_im": Output(_TRANSFER, "1/kg", "acceleration over force"),
    "transfer_bound": Output(_TRANSFER, "1/kg", "rigorous bound on the modulus of the error"),
}


def write_stores(folder: Path, study: TransientStudy, key: str) -> list[Path]:
    """Write `transient.nc` and, where there are fields, `transient_maps.nc`; the files."""
    store = _response(study, key)
    files = {"transient.nc": with_scalars(store, transient_scalars(study, store))}
    if study.maps is not None:
        about = {"title": study.case.title, "inputs": key}
        files["transient_maps.nc"] = study.maps.assign_attrs(about)
    for name, content in files.items():
        write_netcdf(folder / name, content)
    return [folder / name for name in files]


def _response(study: TransientStudy, key: str) -> xr.Dataset:
    case, prepared, spectra = study.case, study.prepared, study.spectra
    transient, nodes = transient_of(case), prepared.parts.mesh.nodes
    probes, plates, loads = prepared.probes, prepared.base_plates, prepared.loads
    response, impact = study.response, main_impact(loads)
    force, moment = loads.resultants
    struck = {edge.place: edge for edge in loads.edges}.values()
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
        "edge": loads.places,
        "edge_floor": np.array([one.floor for one in struck], dtype=int),
        "edge_side": [
            one.side if one.height is None else f"storey {one.side}".rstrip() for one in struck
        ],
        "edge_length": [
            facades(prepared.parts.mesh, one.floor)[one.side][0].length for one in struck
        ],
        "edge_force": force,
        "impact_force": loads.impact_force,
        "edge_moment": moment,
    }
    if study.rotations is not None:
        turned, count = study.rotations, len(study.rotations.probes)
        values |= {
            "rotation": [f"r{axis}" for axis in AXES],
            "turning": [probes[k].name for k in turned.probes],
            "turning_floor": [probes[k].floor for k in turned.probes],
            "rotational_displacement": turned.response.displacement,
            "rotational_acceleration": turned.response.acceleration,
            "rotational_psa": by_probe(turned.spectra.psa, count),
            "rotational_psa_band": turned.band,
            "rotational_pfa": np.abs(turned.response.acceleration).max(axis=0),
            "rotational_pfa_band": turned.pfa_band,
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
        # Of forces, not of moments; of uniform ones on sides whose patterns the basis has.
        uniform = study.basis.loads
        acting = {
            edge.place if edge.place in uniform else edge.name: edge.floor
            for edge in sorted(loads.edges, key=lambda one: one.side != "")
            if edge.resultant != 0.0
        }
        found = Transfer.of(study.basis, at_probes, prepared.damping, highest, acting)
        values |= {
            "transfer_frequency": found.frequency,
            "transfer_load": found.loads,
            "transfer_load_floor": np.array([acting[name] for name in found.loads], dtype=int),
            "transfer_re": found.value.real,
            "transfer_im": found.value.imag,
            "transfer_bound": found.bound,
        }
    building = case.structure.building if case.structure else ""
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": building,
        "shown_direction": case.shown_direction,
        "wave_floor": case.wave_floor,
        "solver": transient.solver,
        "maximum_frequency": transient.maximum_frequency,
        "resolved_frequency": resolved_frequency(
            response.time_step, min(transient.maximum_frequency, float(spectra.frequency[-1]))
        ),
        "basis_vectors": len(study.basis.model.eigenvalue) if study.basis else 0,
        "main_impact": list(impact) if impact else [],
        "spread": "points" if building in case.whole.pounding_in_3d else transient.spread,
        "patch_width": transient.patch_width,
    }
    return dataset(OUTPUTS, values, attributes=attributes, notes=notes)


def transient_scalars(study: TransientStudy, store: xr.Dataset) -> list[Scalar]:
    """All scalars of the stage; spectra at the first damping, along the shown direction."""
    parts, spectra, floor = study.prepared.parts, study.spectra, study.case.wave_floor
    maps, loads = study.maps, study.prepared.loads
    finer = (
        f"of the highest frequency after up-sampling: {spectra.method}, histories made "
        f"{spectra.upsampling_factor} times finer for the spectra"
    )
    rows: list[tuple[str, float, str, str]] = [
        ("impulse_error", loads.impulse_error, "-", "of the resampling"),
        ("points_per_cycle", spectra.points_per_cycle, "-", finer),
    ]
    if study.basis is not None:
        good, highest = known(store), float(store.attrs["maximum_frequency"])
        moved = good["psa"] > 1e-3 * store["psa"].max()
        share = float((good["psa_band"] / good["psa"]).where(moved).max().fillna(0.0))
        note = f"up to {highest:g} Hz, where it is above a thousandth of the largest one"
        nested = "error of the transfer functions at the probes, by nested models"
        rows += [
            ("basis_vectors", float(len(study.basis.model.eigenvalue)), "-", ""),
            ("basis_difference", study.basis.difference, "-", nested),
            ("band_max", share, "-", note),
        ]
    if study.full is not None:
        rows.append(("energy_residual", study.full.energy.residual, "-", "of the full model"))
    if study.full_error is not None:
        note = "largest relative difference of a spectrum, both by Newmark at the same step"
        rows.append(("reduced_against_full", study.full_error, "-", note))
    d = str(store.attrs["shown_direction"])
    response = known(store).isel(damping=0).sel(component=d)
    centres, edges = (of_kind(response, kind) for kind in ("centre", "edge"))
    every = of_kind(resolved(store)["psa"].isel(damping=0).to_dataset(), "centre")["psa"]
    if every.size:
        at = every.isel(every.argmax(...))
        note = f"floor {at['probe_floor'].item()}, direction {at['component'].item()}"
        rows += [
            ("frs.largest", float(at), "m/s2", f"{note}; of all floors, in the resolved band"),
            ("frs.resolved_frequency", float(store.attrs["resolved_frequency"]), "Hz", ""),
        ]
    for k, number in enumerate(centres["probe_floor"].values):
        one, name = centres.isel(probe=k), f"floor_{number}"
        rows += [
            (f"frs.{name}.peak", float(one["psa"].max()), "m/s2", ""),
            (f"frs.{name}.peak_frequency", float(one["psa"].idxmax()), "Hz", ""),
            (f"pfa.{name}", float(one["pfa"]), "m/s2", ""),
            (f"displacement.{name}", float(abs(one["displacement"]).max()), "m", ""),
        ]
    for number, pfa in zip(edges["probe_floor"].values, edges["pfa"].values, strict=True):
        name = f"pfa.edge_{number}"
        rows.append((name, float(pfa), "m/s2", "middle of the impact edge"))
        if maps is not None:
            on_edge = np.isin(maps["node_number"], np.unique(parts.mesh.edges[int(number)]))
            along, note = maps["pfa"].sel(component=d)[on_edge], "vertices of the impact edge"
            rows += [
                (f"{name}.mean", float(along.mean()), "m/s2", note),
                (f"{name}.max", float(along.max()), "m/s2", note),
            ]
    about = "F e of the forces, e along their side from its middle, largest"
    for place, moment in zip(loads.places, np.abs(loads.resultants[1]).max(axis=0), strict=True):
        if moment > 0.0:
            name = place.replace(" ", "_").replace("+", "_high").replace("-", "_low")
            rows.append((f"moment.{name}", float(moment), "N m", about))
    # Waves by hand: the slab's bare material, and the floor as a bar.
    slab = parts.slab_material(floor)
    shear = math.sqrt(slab.E / (2.0 * slab.rho * (1.0 + slab.nu)))
    plate = math.sqrt(slab.E / (slab.rho * (1.0 - slab.nu**2)))
    inputs = "of the material, from the inputs:"
    equation_8 = f"{inputs} shear waves (equation 8 of Bodnar et al. 2022)"
    rows += [
        ("wave_speed", shear, "m/s", equation_8),
        ("plate_wave_speed", plate, "m/s", f"{inputs} waves normal to the edge of a bare plate"),
    ]
    if floor in parts.mesh.edges:
        bar = floor_bar(parts, floor, 1 - parts.mesh.edge_axis(floor))
        note = f"√(EA'/m') of floor {floor} across: slab and beams, with the added mass"
        rows += [
            ("loaded_wave_speed", bar.speed, "m/s", note),
            ("loaded_wave_crossing", bar.crossing, "s", f"by {note}"),
        ]
    return [Scalar(f"transient.{name}", value, unit, note) for name, value, unit, note in rows]

"""The store of the stage: `design.nc`.

The points of a floor are its probes and, where `transient_maps.nc` has fields over the floors, the
vertices that govern. Names that begin with `whole_` are of all vertices of a floor, with `reached_`
of those that govern, both from the fields; with `member_` of the members of an ensemble in the 3D
model, with `statistic_` of statistics over them. Directions without motion are left out.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.spectra.statistics import STATISTICS
from impactfem.stages.design.carrier import MemberResult
from impactfem.stages.design.envelopes import (
    DesignStudy,
    FloorEnvelopes,
    RotationEnvelopes,
    member_statistics,
)
from impactfem.stages.design.floors import MISSED, STILL, WholeFloors, counted
from impactfem.stages.results import outputs, scalars, value
from impactfem.stages.stores import Output, dataset
from impactfem.stages.transient.findings import LargestOrdinate
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

AXES = ["x", "y", "z"]
_FORCE = "statistic device component"
OUTPUTS = {
    "direction": Output("direction"),
    "frequency": Output("frequency", "Hz"),
    "damping": Output("damping", "-", "of the oscillators"),
    "station": Output("station", "", "building and floor"),
    "station_floor": Output("station", label=True),
    "elevation": Output("station", "m", label=True),
    "probe": Output("probe", "", "probe of the 3D model"),
    "station_probes": Output("station probe", "", "1 for a probe on the floor"),
    "elsewhere": Output("elsewhere", "", "probes on no floor"),
    **outputs(FloorEnvelopes),
    "rotation": Output("rotation", "", "about x, y, z"),
    **outputs(RotationEnvelopes, prefix="rotational_"),
    **outputs(WholeFloors),
    "candidates": Output(
        "station direction", "", "number of vertices among which those that govern are sought"
    ),
    "xyz": Output("xyz"),
    "vertex_node": Output("vertex", "", "number in building.nc", label=True),
    "vertex_station": Output("vertex", "", "number of its station, from 0", label=True),
    "vertex_direction": Output("vertex", "", "along which it governs", label=True),
    "vertex_position": Output("vertex xyz", "m"),
    **outputs(LargestOrdinate),
    "motion": Output("motion", "", "member of the ensemble"),
    **outputs(MemberResult, "motion", "member_"),
    "edge": Output("edge", "", "number of the floor"),
    "edge_storey": Output("edge", "", "1 where the storey below it is struck, too"),
    "device": Output("device"),
    "component": Output("component"),
    "failed": Output("failed", "", "members without a result"),
    "failed_reason": Output("failed", "", "why"),
    "statistic": Output("statistic", "", "over the members of the ensemble"),
    "statistic_peak": Output("statistic damping station direction", "m/s2", "peak of member_psa"),
    "statistic_zpa": Output("statistic station direction", "m/s2"),
    "statistic_centre_peak": Output("statistic damping station direction", "m/s2"),
    "statistic_impact_force": Output("statistic", "N", "largest one on the building"),
    "statistic_device_force": Output(_FORCE, "N, N m"),
    "statistic_device_spectrum": Output(_FORCE, "N, N m"),
    "statistic_device_difference": Output(_FORCE, "-", "1 - device_spectrum / device_force"),
}


def write_design(path: Path, study: DesignStudy, key: str) -> None:
    """Write `design.nc`; ImpactfemError if it cannot be written."""
    content, attributes, notes = _content(study), _attributes(study, key), {}
    if study.whole is not None:
        samples = f"{study.whole.points_per_cycle:.3g} samples in a cycle of the highest frequency"
        notes["whole_psa"] = samples
    store = dataset(OUTPUTS, content, attributes=attributes, notes=notes)
    content |= LargestOrdinate.values(store, "station_floor", "direction", study.law)
    store = dataset(OUTPUTS, content, attributes=attributes, notes=notes)
    peak = store["psa"].max(["damping", "station", "frequency"])
    moving = (peak > STILL * peak.max()) | (store["vertex_count"] > 0).any("station")
    store = with_scalars(store, design_scalars(store))
    write_netcdf(path, store.isel(direction=np.flatnonzero(moving)))


def _content(study: DesignStudy) -> dict[str, Any]:
    """Return the values of `design.nc` without the largest ordinate."""
    probes, whole = study.probes, study.whole
    floors = probes["station_floor"].values
    content: dict[str, Any] = {
        "direction": AXES,
        "frequency": probes["frequency"].values,
        "damping": probes["damping"].values,
        "station": [f"{probes.attrs['building']}.floor_{floor}" for floor in floors],
        "station_floor": floors,
        "elevation": probes["elevation"].values,
        "probe": probes["probe"].values,
        "station_probes": probes["on_floor"].values.T.astype(np.int64),
        "elsewhere": probes["probe"].values[~probes["on_floor"].any("station").values],
        **value(FloorEnvelopes.of(study)),
        **study.members,
    }
    if "rotation" in probes.dims:
        content["rotation"] = probes["rotation"].values
        content |= value(RotationEnvelopes.of(probes), "rotational_")
    if whole is not None:
        content |= value(whole) | {
            "candidates": counted(whole.candidates, len(floors)),
            "xyz": AXES,
            "vertex_node": whole.governing["node"].to_numpy(),
            "vertex_station": whole.governing["floor"].to_numpy(),
            "vertex_direction": [AXES[component] for component in whole.governing["component"]],
            "vertex_position": whole.governing[AXES].to_numpy(),
        }
    if study.members:
        content |= {"statistic": list(STATISTICS), **member_statistics(study)}
    return content


def _attributes(study: DesignStudy, key: str) -> dict[str, Any]:
    """Return what holds for the store as a whole."""
    case, about = study.case, study.probes.attrs
    return {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": str(about["building"]),
        "shown_direction": case.shown_direction,
        "maximum_frequency": float(about["maximum_frequency"]),
        "resolved_frequency": float(about["resolved_frequency"]),
        "resolved_by": about.get("resolved_by", ""),
        "missed": MISSED,
        "analysis": study.analysis,
    }


def design_scalars(store: xr.Dataset) -> list[Scalar]:
    """Select the scalars of the stage: floors at the first damping, along the shown direction."""
    shown = store.isel(damping=0).sel(direction=str(store.attrs["shown_direction"]))
    shown = shown.swap_dims(station="station_floor")
    found = [
        *scalars(store, "design.frs.{variable}", "largest=largest_psa resolved_frequency"),
        *scalars(store, "design.frs.{variable}", "structural_damping=largest_psa_damping"),
        *scalars(shown, "design.frs.floor_{station_floor}.{variable}", "peak=psa_peak zpa"),
    ]
    if "motion" in store.dims:
        count = {name: float(store.sizes[name]) for name in ("motion", "failed")}
        found += [
            Scalar("ensemble3d.members", count["motion"], "-", "motions with a result"),
            Scalar("ensemble3d.failed", count["failed"], "-", "motions without a result"),
        ]
    return found

"""The store of the stage: `design.nc`.

The points of a floor are its probes and, where `transient_maps.nc` has fields over the floors, the
vertices that govern. Names that begin with `whole_` are of all vertices of a floor, with `reached_`
of those that govern, both from the fields; with `member_` of the members of an ensemble that is
carried through the 3D model. Directions in which nothing moves are left out.

Scalars: spectra are those at the first damping along the shown direction, enveloped over the points
of each floor, up to the frequency that the 3D model is meant for. `ensemble3d.STATISTIC.X` is a
statistic over the members of their X; X has the name that it has for the case's own motion,
`design.X` for `frs.*`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from impactfem.case import Case
from impactfem.spectra.response_spectrum import ResponseSpectra
from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.design.floors import (
    MISSED,
    STILL,
    WholeFloors,
    counted,
    enveloped,
    probe_points,
)
from impactfem.stages.stores import Output, dataset, names_of
from impactfem.stages.transient.selection import known, resolved
from impactfem.system.arrays import Array
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

AXES = ["x", "y", "z"]
_CURVE = "damping station direction frequency"
_PLACE = "station direction"
_WHOLE = "station direction whole_frequency"
_FORCE = "motion device component"
OUTPUTS = {
    "direction": Output("direction"),
    "frequency": Output("frequency", "Hz"),
    "damping": Output("damping", "-", "of the oscillators"),
    "station": Output("station", "", "building and floor"),
    "station_floor": Output("station", label=True),
    "station_points": Output("station", "", "its probes", label=True),
    "elevation": Output("station", "m", label=True),
    "point": Output("point", "", "probe or node"),
    "elsewhere": Output("elsewhere", "", "probes on no floor"),
    "psa": Output(_CURVE, "m/s2", "envelope of the points under the case's own motion"),
    "zpa": Output(_PLACE, "m/s2", "envelope of their peak accelerations"),
    "governing": Output(_CURVE, "", "number of the point with the largest ordinate, from 0"),
    "rotation": Output("rotation", "", "about x, y, z"),
    "rotational_psa": Output(
        "damping station rotation frequency", "rad/s2", "envelope of the rotations of probes"
    ),
    "rotational_pfa": Output("station rotation", "rad/s2", "envelope of their peak accelerations"),
    "rotational_points": Output("station", "", "these probes", label=True),
    "probes_psa": Output(_CURVE, "m/s2", "envelope of the probes alone"),
    "probe_count": Output("station", "", "number of its probes"),
    "vertex_count": Output(_PLACE, "", "number of vertices that govern"),
    "whole_frequency": Output("whole_frequency", "Hz"),
    "whole_damping": Output("", "-", "of the oscillators of the fields"),
    "whole_psa": Output(_WHOLE, "m/s2", "envelope of all vertices"),
    "whole_zpa": Output(_PLACE, "m/s2", "envelope of all vertices"),
    "reached_psa": Output(_WHOLE, "m/s2", "envelope of the vertices that govern"),
    "reached_zpa": Output(_PLACE, "m/s2", "envelope of the vertices that govern"),
    "vertices": Output("station", "", "number of its vertices"),
    "candidates": Output(_PLACE, "", "number of vertices among which those that govern are sought"),
    "xyz": Output("xyz"),
    "vertex_node": Output("vertex", "", "number in building.nc", label=True),
    "vertex_station": Output("vertex", "", "number of its station, from 0", label=True),
    "vertex_direction": Output("vertex", "", "along which it governs", label=True),
    "vertex_position": Output("vertex xyz", "m"),
    "motion": Output("motion", "", "member of the ensemble"),
    "member_psa": Output(f"motion {_CURVE}", "m/s2", "envelope of the points"),
    "member_zpa": Output(f"motion {_PLACE}", "m/s2", "envelope of their peak accelerations"),
    "member_centre_peak": Output(
        f"motion damping {_PLACE}", "m/s2", "largest pseudo-acceleration at the mass centre"
    ),
    "member_vertices": Output(f"motion {_PLACE}", "", "number of vertices that govern"),
    "member_basis_error": Output("motion", "-", "estimated, of transfer functions at the points"),
    "edge": Output("edge", "", "number of the floor"),
    "edge_storey": Output("edge", "", "1 where the storey below it is struck, too"),
    "member_impact_force": Output("motion edge", "N", "largest one"),
    "device": Output("device"),
    "component": Output("component"),
    "member_device_force": Output(_FORCE, "N, N m", "largest one in the 3D model"),
    "member_device_spectrum": Output(_FORCE, "N, N m", "the same by response spectrum analysis"),
    "failed": Output("failed", "", "members without a result"),
    "failed_reason": Output("failed", "", "why"),
}


def write_design(
    path: Path,
    case: Case,
    key: str,
    probes: xr.Dataset,
    whole: WholeFloors | None,
    vertex_spectra: ResponseSpectra | None,
    members: Mapping[str, Any],
    analysis: str,
) -> None:
    """Write `design.nc`; ImpactfemError where it cannot be written.

    `probes` are those of `read_probes`; `whole` are the spectra over whole floors, and
    `vertex_spectra` those of the vertices that govern, None without fields over the floors.
    `members` are the results over an ensemble by their names in the store, empty without one;
    `analysis` is the response spectrum analysis of its devices, "" without devices.
    """
    names, building = names_of(probes, "probe"), str(probes.attrs["building"])
    on_floor = probes["on_floor"].values
    # Each point along one direction: the probes first, then the vertices that govern.
    points = probe_points(probes)
    along = points["point"].to_numpy(), points["component"].to_numpy()
    psa, pfa = probes["psa"].values[:, *along], probes["pfa"].values[along]
    floors = probes.sizes["station"]
    values = {
        "direction": AXES,
        "frequency": probes["frequency"].values,
        "damping": probes["damping"].values,
        "station": [f"{building}.floor_{floor}" for floor in probes["station_floor"].values],
        "station_floor": probes["station_floor"].values,
        "station_points": [", ".join(probes["probe"].values[on]) for on in on_floor.T],
        "elevation": probes["elevation"].values,
        "elsewhere": [name for name, on in zip(names, on_floor.any(axis=1), strict=True) if not on],
        "probes_psa": enveloped(points, psa, floors, axis=1),
        "probe_count": on_floor.sum(axis=0),
        "vertex_count": np.zeros((floors, 3), dtype=np.int64),
    }
    if "rotation" in probes.dims:
        # Of each floor those of its probes whose rotations are recorded, the mass centre at least.
        turning = names_of(probes, "turning")
        on = on_floor[[names.index(name) for name in turning]].T
        values |= {"rotation": names_of(probes, "rotation")}
        values["rotational_points"] = [", ".join(np.array(turning)[there]) for there in on]
        order = ("damping", "turning", "rotation", "frequency")
        psa_of = probes["rotational_psa"].transpose(*order).values
        pfa_of = probes["rotational_pfa"].transpose("turning", "rotation").values
        values["rotational_psa"] = np.stack([psa_of[:, k].max(axis=1) for k in on], axis=1)
        values["rotational_pfa"] = np.stack([pfa_of[k].max(axis=0) for k in on])
    notes = {}
    if whole is not None and vertex_spectra is not None:
        number = len(names) + np.arange(len(whole.governing))
        points = pd.concat([points, whole.governing.assign(point=number)], ignore_index=True)
        psa = np.concatenate([psa, vertex_spectra.psa], axis=1)
        pfa = np.concatenate([pfa, vertex_spectra.zpa])
        names += [f"node {node}" for node in whole.governing["node"]]
        places = whole.governing
        values |= {
            "vertex_count": counted(places, floors),
            "whole_frequency": whole.frequency,
            "whole_damping": whole.damping,
            "whole_psa": whole.envelope[..., :-1],
            "whole_zpa": whole.envelope[..., -1],
            "reached_psa": whole.reached[..., :-1],
            "reached_zpa": whole.reached[..., -1],
            "vertices": whole.vertices,
            "candidates": counted(whole.candidates, floors),
            "xyz": AXES,
            "vertex_node": places["node"].to_numpy(),
            "vertex_station": places["floor"].to_numpy(),
            "vertex_direction": [AXES[component] for component in places["component"]],
            "vertex_position": places[AXES].to_numpy(),
        }
        samples = f"{whole.points_per_cycle:.3g} samples in a cycle of the highest frequency"
        notes["whole_psa"] = samples
    governing = np.zeros(values["probes_psa"].shape, dtype=np.int64)
    for (floor, component), rows in points.groupby(["floor", "component"]).indices.items():
        largest = psa[:, rows].argmax(axis=1)
        governing[:, floor, component] = points["point"].to_numpy()[rows[largest]]
    values |= {
        "point": names,
        "psa": enveloped(points, psa, floors, axis=1),
        "zpa": enveloped(points, pfa, floors),
        "governing": governing,
        **members,
    }
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": building,
        "shown_direction": case.shown_direction,
        "maximum_frequency": float(probes.attrs["maximum_frequency"]),
        "resolved_frequency": float(probes.attrs["resolved_frequency"]),
        "missed": MISSED,
        "analysis": analysis,
    }
    store = dataset(OUTPUTS, values, attributes=attributes, notes=notes)
    peak = store["psa"].max(["damping", "station", "frequency"])
    moving = (peak > STILL * peak.max()) | (store["vertex_count"] > 0).any("station")
    store = with_scalars(store, design_scalars(store))
    write_netcdf(path, store.isel(direction=np.flatnonzero(moving)))


def design_scalars(store: xr.Dataset) -> list[Scalar]:
    """All scalars of the stage, from the content of `design.nc` with all directions."""
    axis, members = str(store.attrs["shown_direction"]), "motion" in store.dims
    shown = known(store).isel(damping=0).sel(direction=axis)
    own: list[Scalar] = []
    ensemble: list[Scalar] = []
    if members:
        failed = names_of(store, "failed")
        error = float(store["member_basis_error"].max())
        ensemble = [
            Scalar("ensemble3d.members", float(store.sizes["motion"]), "-"),
            Scalar("ensemble3d.failed", float(len(failed)), "-", "; ".join(failed)),
            Scalar("ensemble3d.basis_error", error, "-", "transfer functions at the points"),
        ]
    every = resolved(store)["psa"].isel(damping=0)
    if every.size:
        at = every.isel(every.argmax(...))
        note = f"{at['station'].item()}, direction {at['direction'].item()}; of all floors"
        highest = float(store.attrs["resolved_frequency"])
        own += [
            Scalar("design.frs.largest", float(at), "m/s2", f"{note}, in the resolved band"),
            Scalar("design.frs.resolved_frequency", highest, "Hz"),
        ]
    for s, number in enumerate(store["station_floor"].values):
        one, name = shown.isel(station=s), f"frs.floor_{number}"
        note = _points(one, int(one["vertex_count"]))
        own += [
            Scalar(f"design.{name}.peak", float(one["psa"].max()), "m/s2", note),
            Scalar(f"design.{name}.peak_frequency", float(one["psa"].idxmax()), "Hz", note),
            Scalar(f"design.{name}.zpa", float(one["zpa"]), "m/s2", note),
        ]
        if members:
            note = _points(one, round(float(one["member_vertices"].mean())))
            peaks = one["member_psa"].max("frequency").values
            ensemble += _statistics(f"{name}.peak", peaks, "m/s2", note)
            ensemble += _statistics(f"{name}.zpa", one["member_zpa"].values, "m/s2", note)
            at_centre = one["member_centre_peak"].values
            ensemble += _statistics(f"transient.{name}.peak", at_centre, "m/s2", "mass centre")
    if members:
        ensemble += _statistics("impact_force", largest_impact(store), "N", "largest one")
    for d, device in enumerate(names_of(store, "device") if "device" in store.dims else ()):
        force = store.isel(device=d).sel(component=axis)
        name = "device" if d == 0 else f"device.{device}"
        detailed, rsa = (force[f"member_device_{k}"].values for k in ("force", "spectrum"))
        analysis = f"{device}, {store.attrs['analysis']}"
        ensemble += _statistics(f"{name}.f{axis}.detailed.impact", detailed, "N", device)
        ensemble += _statistics(f"{name}.f{axis}.rsa.impact", rsa, "N", analysis)
        if np.all(detailed > 0.0):
            difference, what = 1.0 - rsa / detailed, f"{name}.relative_difference.impact"
            ensemble += _statistics(what, difference, "-", analysis)
    return own + ensemble


def largest_impact(store: xr.Dataset) -> Array:
    """Largest impact force on the building, shape (n_m,) [N]; 0 without contact pairs."""
    return np.asarray(store["member_impact_force"].values.max(axis=1, initial=0.0))


def _points(station: xr.Dataset, vertices: int) -> str:
    """What is enveloped, in words."""
    probes = f"envelope of {int(station['probe_count'])} probes"
    return probes + (f" and {vertices} vertices" if vertices else " alone")


def _statistics(name: str, values: Array, unit: str, note: str) -> list[Scalar]:
    # Differences and forces that are zero have no logarithm.
    known = [key for key in STATISTICS if key != "p84_lognormal" or np.all(values > 0.0)]
    note = f"{note}; over {len(values)} members"
    return [
        Scalar(f"ensemble3d.{key}.{name}", float(over_members(values, key)), unit, note)
        for key in known
    ]

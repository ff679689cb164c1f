"""The store of the stage: `design.nc`.

Dimensions `damping`, `station` (floors of the building of the 3D model), `direction`, `frequency`.
`psa` is the envelope over the points of a floor under the case's own motion, `zpa` that of their
peak accelerations, `governing` which point has the largest ordinate; `probes_psa` is that over the
probes alone. The points are the probes and, where `transient_maps.nc` has fields over the floors,
the vertices that govern, along `vertex` with their place. `whole_psa` and `whole_zpa` are the
envelope over all vertices of a floor at `whole_frequency`, from the fields; `reached_psa` and
`reached_zpa` that of the governing ones, from the same fields.

With an ensemble that is carried through the 3D model there is the dimension `motion`: `member_psa`
and `member_zpa` are the same for each member, over the probes and the vertices that govern under
its motion, `member_vertices` in number; `candidates` of each floor were looked at for these.
`member_impact_force` the largest force of the sticks
on each `edge`; with devices `member_device_force` and `member_device_spectrum` are their largest
forces in the 3D model and by response spectrum analysis. Directions in which nothing moves are left
out.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.case import Case
from impactfem.stages.design.carried import CarriedEnsemble
from impactfem.stages.design.case_spectra import CaseSpectra
from impactfem.stages.design.fewest import MISSED
from impactfem.stages.design.scalars import design_scalars
from impactfem.stages.design.whole_floors import STILL, WholeFloors
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]

SI = {"units": "m/s2"}


def write_design(
    path: Path,
    case: Case,
    own: CaseSpectra,
    whole: WholeFloors | None,
    carried: CarriedEnsemble | None,
    key: str,
) -> None:
    """Write `design.nc`.

    Args:
        path: The file.
        case: The case.
        own: The spectra under its own motion.
        whole: Those over whole floors; None without.
        carried: The ensemble; None without one.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    moving = _moving(own)
    curve = ("damping", "station", "direction")
    dataset = xr.Dataset(
        {
            "psa": ((*curve, "frequency"), own.floor_psa[:, :, moving], SI),
            "zpa": (curve[1:], own.floor_pfa[:, moving], SI),
            "governing": (
                (*curve, "frequency"),
                _governing(own)[:, :, moving],
                {"note": "number of the point"},
            ),
            "probes_psa": ((*curve, "frequency"), own.probes_psa[:, :, moving], SI),
            **_stations(own),
            **({} if whole is None else _whole(whole, moving)),
            **({} if whole is None else _vertices(whole)),
            **({} if carried is None else _members(carried, moving)),
        },
        coords={
            "direction": ("direction", _words("xyz"[c] for c in moving)),
            "frequency": ("frequency", own.frequency, {"units": "Hz"}),
            "damping": ("damping", own.damping, {"units": "-"}),
        },
        attrs={
            "title": case.title,
            "inputs": key,
            "case_hash": case.content_hash(),
            "building": own.building,
            "shown_direction": case.shown_direction,
            "maximum_frequency": own.maximum_frequency,
            "missed": MISSED,
            "elsewhere": json.dumps(own.elsewhere, ensure_ascii=False),
            "analysis": "" if carried is None else carried.analysis,
            "failed": json.dumps({} if carried is None else carried.failed, ensure_ascii=False),
        },
    )
    write_netcdf(path, with_scalars(dataset, design_scalars(own, case.shown_direction, carried)))


def _moving(own: CaseSpectra) -> list[int]:
    largest = own.floor_psa.max(axis=(0, 1, 3))
    known = {int(c) for c in own.vertices.component}
    return [c for c in range(3) if largest[c] > STILL * largest.max() or c in known]


def _governing(own: CaseSpectra) -> NDArray[np.int64]:
    """The point with the largest ordinate, probes first, shape (n_d, n_floors, 3, n_f)."""
    found = [
        np.asarray(floor.probes)[own.psa[:, list(floor.probes)].argmax(axis=1)]
        for floor in own.floors
    ]
    governing: NDArray[np.int64] = np.stack(found, axis=1)
    if own.vertex_spectra is None:
        return governing
    largest = np.array(own.probes_psa)
    for v, place in enumerate(zip(own.vertices.floor, own.vertices.component, strict=True)):
        here = (slice(None), *place)
        higher = own.vertex_spectra.psa[:, v] > largest[here]
        largest[here][higher] = own.vertex_spectra.psa[:, v][higher]
        governing[here][higher] = len(own.names) + v
    return governing


def _stations(own: CaseSpectra) -> Variables:
    floors = own.floors
    return {
        "point": ("point", _words([*own.names, *(f"node {n}" for n in own.vertices.node)])),
        "station": ("station", _words(f"{own.building}.floor_{f.floor}" for f in floors)),
        "station_floor": ("station", np.array([f.floor for f in floors])),
        "station_points": ("station", _words(", ".join(f.names) for f in floors)),
        "elevation": ("station", np.array([f.elevation for f in floors]), {"units": "m"}),
    }


def _whole(whole: WholeFloors, moving: list[int]) -> Variables:
    samples = f"{whole.points_per_cycle:.3g} samples in a cycle of the highest frequency"
    return {
        "whole_psa": (
            ("station", "direction", "whole_frequency"),
            whole.psa[:, moving],
            SI | {"damping": whole.damping, "note": samples},
        ),
        "whole_zpa": (("station", "direction"), whole.pfa[:, moving], SI),
        "reached_psa": (
            ("station", "direction", "whole_frequency"),
            whole.governing_psa[:, moving],
            SI | {"note": "the vertices that govern, from the same fields"},
        ),
        "reached_zpa": (("station", "direction"), whole.governing_pfa[:, moving], SI),
        "candidates": (
            ("station", "direction"),
            whole.candidates.counts(len(whole.vertices))[:, moving],
        ),
        "whole_frequency": ("whole_frequency", whole.frequency, {"units": "Hz"}),
        "vertices": ("station", whole.vertices),
    }


def _vertices(whole: WholeFloors) -> Variables:
    """The vertices that govern, each of a floor along a direction."""
    governing = whole.governing
    return {
        "vertex_node": ("vertex", governing.node),
        "vertex_station": ("vertex", governing.floor, {"note": "number of the station, from 0"}),
        "vertex_direction": ("vertex", _words("xyz"[c] for c in governing.component)),
        "vertex_position": (("vertex", "xyz"), whole.position, {"units": "m"}),
    }


def _members(carried: CarriedEnsemble, moving: list[int]) -> Variables:
    curve = ("motion", "damping", "station", "direction", "frequency")
    place = ("motion", "station", "direction")
    forces = {"units": "N", "note": "N m for rx, ry, rz"}
    variables: Variables = {
        "motion": ("motion", _words(carried.members)),
        "member_psa": (curve, carried.floor_psa[:, :, :, moving], SI),
        "member_zpa": (place, carried.floor_pfa[:, :, moving], SI),
        "member_vertices": (place, carried.vertices[:, :, moving]),
        "edge": ("edge", np.array(carried.floors, dtype=np.int64), {"note": "floor's number"}),
        "member_impact_force": (
            ("motion", "edge"),
            carried.impact_force,
            {"units": "N", "note": "largest one of the sticks on the edge of the floor"},
        ),
    }
    if carried.devices:
        dims = ("motion", "device", "component")
        variables |= {
            "device": ("device", _words(carried.devices)),
            "component": ("component", _words(("x", "y", "z", "rx", "ry", "rz"))),
            "member_device_force": (dims, carried.device_force, forces),
            "member_device_spectrum": (dims, carried.device_spectrum, forces),
        }
    return variables


def _words(values: Any) -> Any:
    return np.array(list(values), dtype=object)

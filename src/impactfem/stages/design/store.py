"""The store of the stage: `design.nc`.

The points of a floor are its probes and, where `transient_maps.nc` has fields over the floors, the
vertices that govern. Names that begin with `whole_` are of all vertices of a floor, with `reached_`
of those that govern, both from the fields; with `member_` of the members of an ensemble that is
carried through the 3D model. Directions in which nothing moves are left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Case
from impactfem.stages.design.carried import CarriedEnsemble
from impactfem.stages.design.case_spectra import CaseSpectra
from impactfem.stages.design.fewest import MISSED
from impactfem.stages.design.scalars import design_scalars
from impactfem.stages.design.whole_floors import STILL, WholeFloors
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf

Array = NDArray[np.float64]

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
    "probes_psa": Output(_CURVE, "m/s2", "envelope of the probes alone"),
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
    "member_vertices": Output(f"motion {_PLACE}", "", "number of vertices that govern"),
    "edge": Output("edge", "", "number of the floor"),
    "member_impact_force": Output("motion edge", "N", "largest one of the sticks"),
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
    moving, floors = _moving(own), own.floors
    values = {
        "direction": ["xyz"[c] for c in moving],
        "frequency": own.frequency,
        "damping": own.damping,
        "station": [f"{own.building}.floor_{f.floor}" for f in floors],
        "station_floor": [f.floor for f in floors],
        "station_points": [", ".join(f.names) for f in floors],
        "elevation": [f.elevation for f in floors],
        "point": [*own.names, *(f"node {n}" for n in own.vertices.node)],
        "elsewhere": own.elsewhere,
        "psa": own.floor_psa[:, :, moving],
        "zpa": own.floor_pfa[:, moving],
        "governing": _governing(own)[:, :, moving],
        "probes_psa": own.probes_psa[:, :, moving],
        **({} if whole is None else _whole(whole, moving)),
        **({} if carried is None else _members(carried, moving)),
    }
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": own.building,
        "shown_direction": case.shown_direction,
        "maximum_frequency": own.maximum_frequency,
        "missed": MISSED,
        "analysis": "" if carried is None else carried.analysis,
    }
    notes = {}
    if whole is not None:
        samples = f"{whole.points_per_cycle:.3g} samples in a cycle of the highest frequency"
        notes = {"whole_psa": samples}
    scalars = design_scalars(own, case.shown_direction, carried)
    store = dataset(OUTPUTS, values, attributes=attributes, scalars=scalars, notes=notes)
    write_netcdf(path, store)


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


def _whole(whole: WholeFloors, moving: list[int]) -> dict[str, Any]:
    """Envelopes of all vertices, and which of them govern, each of a floor along a direction."""
    governing = whole.governing
    return {
        "whole_frequency": whole.frequency,
        "whole_damping": whole.damping,
        "whole_psa": whole.psa[:, moving],
        "whole_zpa": whole.pfa[:, moving],
        "reached_psa": whole.governing_psa[:, moving],
        "reached_zpa": whole.governing_pfa[:, moving],
        "vertices": whole.vertices,
        "candidates": whole.candidates.counts(len(whole.vertices))[:, moving],
        "xyz": ["x", "y", "z"],
        "vertex_node": governing.node,
        "vertex_station": governing.floor,
        "vertex_direction": ["xyz"[c] for c in governing.component],
        "vertex_position": whole.position,
    }


def _members(carried: CarriedEnsemble, moving: list[int]) -> dict[str, Any]:
    values: dict[str, Any] = {
        "motion": carried.members,
        "member_psa": carried.floor_psa[:, :, :, moving],
        "member_zpa": carried.floor_pfa[:, :, moving],
        "member_vertices": carried.vertices[:, :, moving],
        "edge": np.array(carried.floors, dtype=np.int64),
        "member_impact_force": carried.impact_force,
        "failed": list(carried.failed),
        "failed_reason": list(carried.failed.values()),
    }
    if carried.devices:
        values |= {
            "device": carried.devices,
            "component": ["x", "y", "z", "rx", "ry", "rz"],
            "member_device_force": carried.device_force,
            "member_device_spectrum": carried.device_spectrum,
        }
    return values

"""The store of the stage: `design.nc`.

Dimensions `damping`, `station` (floors of the building of the 3D model), `direction`, `frequency`.
`psa` is the envelope over the points of a floor under the case's own motion, `zpa` that of their
peak accelerations, `governing` which probe has the largest ordinate. `whole_psa` is the envelope
over all vertices of a floor at `whole_frequency`, where `transient_maps.nc` has fields.

With an ensemble that is carried through the 3D model there is the dimension `motion`: `member_psa`
and `member_zpa` are the same for each member, `member_impact_force` the largest force of the sticks
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
from impactfem.design.carried import CarriedEnsemble
from impactfem.design.case_spectra import CaseSpectra
from impactfem.design.floor_points import enveloped
from impactfem.design.scalars import design_scalars
from impactfem.design.whole_floors import WholeFloors
from impactfem.files import write_netcdf
from impactfem.scalar import to_json

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]

STILL = 1e-9
"""A direction is left out where no ordinate is above this part of the largest of all."""
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
                {"note": "number of the probe in transient.nc"},
            ),
            **_stations(own),
            **({} if whole is None else _whole(whole, moving)),
            **({} if carried is None else _members(own, carried, moving)),
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
            "scalars": to_json(design_scalars(own, case.shown_direction, carried)),
            "building": own.building,
            "shown_direction": case.shown_direction,
            "maximum_frequency": own.maximum_frequency,
            "elsewhere": json.dumps(own.elsewhere, ensure_ascii=False),
            "analysis": "" if carried is None else carried.analysis,
            "failed": json.dumps({} if carried is None else carried.failed, ensure_ascii=False),
        },
    )
    write_netcdf(path, dataset)


def _moving(own: CaseSpectra) -> list[int]:
    largest = own.psa.max(axis=(0, 1, 3))
    return [c for c in range(3) if largest[c] > STILL * largest.max()]


def _governing(own: CaseSpectra) -> NDArray[np.int64]:
    """The probe with the largest ordinate, shape (n_d, n_floors, 3, n_f)."""
    found = [
        np.asarray(floor.probes)[own.psa[:, list(floor.probes)].argmax(axis=1)]
        for floor in own.floors
    ]
    return np.asarray(np.stack(found, axis=1), dtype=np.int64)


def _stations(own: CaseSpectra) -> Variables:
    floors = own.floors
    return {
        "probe": ("probe", _words(own.names)),
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
        "whole_frequency": ("whole_frequency", whole.frequency, {"units": "Hz"}),
        "vertices": ("station", whole.vertices),
    }


def _members(own: CaseSpectra, carried: CarriedEnsemble, moving: list[int]) -> Variables:
    curve = ("motion", "damping", "station", "direction", "frequency")
    psa = enveloped(carried.psa, own.floors, axis=2)[:, :, :, moving]
    zpa = enveloped(carried.pfa, own.floors, axis=1)[:, :, moving]
    forces = {"units": "N", "note": "N m for rx, ry, rz"}
    variables: Variables = {
        "motion": ("motion", _words(carried.members)),
        "member_psa": (curve, psa, SI),
        "member_zpa": (("motion", "station", "direction"), zpa, SI),
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

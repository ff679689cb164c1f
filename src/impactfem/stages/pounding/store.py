"""The stores of the stage: `motion.nc` and `pounding.nc`.

`motion.nc` has, for the ground motion number k, `time_k` [s], `acceleration_k` [m/s2] with the
attribute `direction`, `spectrum_k` (pseudo-acceleration, over `frequency_k` [Hz]) [m/s2] and, for
a synthetic one, `target_k`, the design spectrum.

`pounding.nc` has the dimensions `time`, `station` (a floor of a building), `component` (those of
x, y, z, rx, ry, rz in which anything moves), `direction`, `damping`, `frequency`, `pair`, `impact`,
`building`, `mode`, `facing` (floors that face each other and are in no pair) and `target`. All
values are SI; each variable carries its unit. Names that end in `_free` belong to the run without
contact. Displacements and velocities are relative to the ground, accelerations absolute.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.case.pair_distance import pair_distance
from impactfem.coupling.pounding import Response
from impactfem.stages.pounding.compute import StickStudy, station_dofs
from impactfem.stages.pounding.scalars import stick_scalars
from impactfem.sticks.element import DOFS
from impactfem.sticks.modes import DIRECTIONS
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import to_json

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]


def write_motion(path: Path, study: StickStudy, key: str) -> None:
    """Write `motion.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.
    """
    variables: Variables = {}
    for k, motion in enumerate(study.motions):
        a = motion.accelerogram
        variables[f"acceleration_{k}"] = (
            f"time_{k}",
            a.acceleration,
            {"units": "m/s2", "direction": motion.direction, "origin": a.origin},
        )
        variables[f"time_{k}"] = (f"time_{k}", a.time, {"units": "s"})
        s = motion.spectrum
        variables[f"frequency_{k}"] = (f"frequency_{k}", s.frequency, {"units": "Hz"})
        attributes = {"units": "m/s2", "damping": float(s.damping[0])}
        variables[f"spectrum_{k}"] = (f"frequency_{k}", s.psa[0, 0], attributes)
        if motion.target is not None:
            variables[f"target_{k}"] = (f"frequency_{k}", motion.target, attributes)
    dataset = xr.Dataset(variables, attrs={"title": study.case.title, "inputs": key})
    write_netcdf(path, dataset)


def write_sticks(path: Path, study: StickStudy, key: str) -> None:
    """Write `pounding.nc`; arguments as `write_motion`."""
    variables = {
        **_histories(study),
        **_spectra(study),
        **_modes(study),
        **_impacts(study),
        **_pairs(study),
        **_facing(study),
        **_targets(study),
    }
    dataset = xr.Dataset(
        variables,
        attrs={
            "title": study.case.title,
            "inputs": key,
            "case_hash": study.case.content_hash(),
            "scalars": to_json(stick_scalars(study)),
            "studied_building": study.system.sticks[0].name,
            "shown_direction": study.case.shown_direction,
            "elevation_direction": _elevation_direction(study),
        },
    )
    write_netcdf(path, dataset)


def _elevation_direction(study: StickStudy) -> str:
    """The horizontal direction in which the buildings stand side by side."""
    for pair in study.system.pairs:
        x, y = np.abs(pair.normal[:2])
        if x != y:
            return "x" if x > y else "y"
    spread = np.ptp([stick.axis for stick in study.system.sticks], axis=0)
    if spread[0] != spread[1]:
        return "x" if spread[0] > spread[1] else "y"
    first = study.motions[0].direction
    return first if first in "xy" else "y"


def _histories(study: StickStudy) -> Variables:
    dofs = station_dofs(study.system)
    moving = [c for c in range(6) if np.any(study.response.u[:, dofs[:, c]])]
    variables: Variables = {
        "time": ("time", study.response.time, {"units": "s"}),
        "ground": (
            ("time", "axis"),
            study.response.ground,
            {"units": "m/s2", "long_name": "ground acceleration along x, y, z"},
        ),
        "component": ("component", _words([DOFS[c] for c in moving])),
        "station": ("station", _words([f"{b}.floor_{k}" for b, k in study.stations])),
        "station_building": ("station", _words([b for b, _ in study.stations])),
        "station_floor": ("station", np.array([k for _, k in study.stations])),
        "elevation": (
            "station",
            np.concatenate([s.positions[: len(s.floors), 2] for s in study.system.sticks]),
            {"units": "m"},
        ),
        "floor_mass": (
            "station",
            np.array([floor.mass for s in study.system.sticks for floor in s.floors]),
            {"units": "kg"},
        ),
        "rigid_below": (
            "station",
            np.array([floor.below for s in study.system.sticks for floor in s.floors]),
            {"units": "m"},
        ),
        "rigid_above": (
            "station",
            np.array([floor.above for s in study.system.sticks for floor in s.floors]),
            {"units": "m"},
        ),
    }
    runs: list[tuple[str, Response]] = [("", study.response), ("_free", study.free)]
    for suffix, run in runs:
        for name, values, unit in (
            ("displacement", run.u, "m, rad"),
            ("velocity", run.v, "m/s, rad/s"),
            ("acceleration", run.absolute_acceleration, "m/s2, rad/s2"),
        ):
            variables[name + suffix] = (
                ("time", "station", "component"),
                values[:, dofs[:, moving]],
                {"units": unit},
            )
    return variables


def _spectra(study: StickStudy) -> Variables:
    dims = ("damping", "station", "direction", "frequency")
    variables: Variables = {
        "frequency": ("frequency", study.floors.spectra.frequency, {"units": "Hz"}),
        "damping": ("damping", study.floors.spectra.damping, {"units": "-"}),
        "direction": ("direction", _words(study.floors.directions)),
    }
    for suffix, floors in (("", study.floors), ("_free", study.floors_free)):
        variables |= {
            f"psa{suffix}": (dims, floors.psa, {"units": "m/s2"}),
            f"sd{suffix}": (dims, floors.sd, {"units": "m"}),
            f"pfa{suffix}": (("station", "direction"), floors.pfa, {"units": "m/s2"}),
        }
    return variables


def _modes(study: StickStudy) -> Variables:
    count = max(result.frequency.size for result in study.modes)
    n = len(study.modes)
    frequency = np.full((n, count), np.nan)
    mass = np.full((n, len(DIRECTIONS), count), np.nan)
    family = np.full((n, count), "", dtype=object)
    floors = [len(stick.floors) for stick in study.system.sticks]
    shape = np.full((sum(floors), count, 6), np.nan)
    for k, result in enumerate(study.modes):
        size = result.frequency.size
        frequency[k, :size] = result.frequency
        mass[k, :, :size] = result.effective_mass
        family[k, :size] = result.family
        mine = slice(sum(floors[:k]), sum(floors[: k + 1]))
        shape[mine, :size] = np.moveaxis(
            result.shape[: 6 * floors[k]].reshape(floors[k], 6, size), 2, 1
        )
    return {
        "building": ("building", _words([stick.name for stick in study.system.sticks])),
        "building_axis": (
            ("building", "plan"),
            np.array([stick.axis for stick in study.system.sticks]),
            {"units": "m"},
        ),
        "building_base": (
            "building",
            np.array([stick.base for stick in study.system.sticks]),
            {"units": "m"},
        ),
        "mode_shape": (
            ("station", "mode", "mode_component"),
            shape,
            {"units": "kg^-1/2", "long_name": "mode shapes with unit modal mass"},
        ),
        "mode_frequency": (("building", "mode"), frequency, {"units": "Hz"}),
        "mode_family": (("building", "mode"), family),
        "mode_direction": ("mode_direction", _words(DIRECTIONS)),
        "mode_effective_mass": (
            ("building", "mode_direction", "mode"),
            mass,
            {"units": "kg, kg m2"},
        ),
    }


def _impacts(study: StickStudy) -> Variables:
    columns = (
        ("first_contact", "start", "s"),
        ("end", "end", "s"),
        ("peak_time", "peak_time", "s"),
        ("peak_force", "peak_force", "N"),
        ("impulse", "impulse", "N s"),
        ("duration", "duration", "s"),
        ("penetration", "penetration", "m"),
        ("approach", "approach", "m/s"),
        ("separation", "separation", "m/s"),
        ("restitution", "restitution", "-"),
        ("dissipated", "dissipated", "J"),
        ("defect", "defect", "J"),
        ("steps", "steps", "-"),
    )
    checks = (
        ("bearing_pressure", "Pa"),
        ("bearing_ratio", "-"),
        ("storey_shear", "N"),
        ("shear_stress", "Pa"),
        ("cracking_ratio", "-"),
    )
    variables: Variables = {"impact_pair": ("impact", _words(i.pair.name for i in study.impacts))}
    for name, field, unit in columns:
        values = np.array([getattr(i, field) for i in study.impacts], dtype=float)
        variables[f"impact_{name}"] = ("impact", values, {"units": unit})
    for name, unit in checks:
        values = np.array([getattr(c, name) for c in study.checks], dtype=float)
        variables[f"impact_{name}"] = ("impact", values, {"units": unit})
    return variables


def _pairs(study: StickStudy) -> Variables:
    pairs = study.system.pairs
    laws = [pair.law for pair in pairs]
    fastest = [_fastest(study, pair.name) for pair in pairs]
    materials = [study.case.building(pair.a.building).material for pair in pairs]
    distances = {c.name: pair_distance(c, study.case) for c in study.case.contacts}
    numbers = {
        "young_modulus": ([material.young_modulus for material in materials], "Pa"),
        "poisson_ratio": ([material.poisson_ratio for material in materials], "-"),
        "rest_gap": ([pair.gap for pair in pairs], "m"),
        "distance": ([distances.get(pair.name, np.nan) for pair in pairs], "m"),
        "stiffness": (
            [law.stiffness for law in laws],
            ", ".join(dict.fromkeys(law.stiffness_unit for law in laws)) or "N/m",
        ),
        "dashpot": ([law.parameters[1] if law.linear else np.nan for law in laws], "N s/m"),
        "onset_force": (
            [_at(law.onset_force, v) for law, v in zip(laws, fastest, strict=True)],
            "N",
        ),
        "damping_ratio": ([law.xi for law in laws], "-"),
        "restitution": ([law.epsilon for law in laws], "-"),
        "effective_mass": ([law.mass for law in laws], "kg"),
        "law_duration": (
            # That of a linear law is the same at any speed.
            [
                _at(law.duration, 1.0 if law.linear else v)
                for law, v in zip(laws, fastest, strict=True)
            ],
            "s",
        ),
        "asked": ([law.asked for law in laws], "-"),
        "required_separation": ([s.required for s in study.separations], "m"),
        "margin": ([s.margin for s in study.separations], "m"),
        "touched": ([float(s.touched) for s in study.separations], "-"),
    }
    variables: Variables = {
        "pair": ("pair", _words(pair.name for pair in pairs)),
        "pair_building_a": ("pair", _words(pair.a.building for pair in pairs)),
        "pair_law": ("pair", _words(law.name for law in laws)),
        "pair_floor_a": ("pair", np.array([pair.a.floor for pair in pairs], dtype=int)),
        "gap": (("time", "pair"), study.response.gap, {"units": "m"}),
    }
    for name, (values, unit) in numbers.items():
        variables[f"pair_{name}"] = ("pair", np.array(values, dtype=float), {"units": unit})
    return variables


def _facing(study: StickStudy) -> Variables:
    found = study.facing
    if not found:
        return {}
    variables: Variables = {
        "facing": ("facing", _words(one.facing.name for one in found)),
        "facing_a": ("facing", _words(one.facing.a.label for one in found)),
        "facing_b": ("facing", _words(one.facing.b.label for one in found)),
    }
    for name, values, unit in (
        ("level", [one.facing.level for one in found], "m"),
        ("rest_gap", [one.facing.gap for one in found], "m"),
        ("distance_min", [one.distance for one in found], "m"),
        ("time", [one.time for one in found], "s"),
    ):
        variables[f"facing_{name}"] = ("facing", np.array(values, dtype=float), {"units": unit})
    return variables


def _at(of_speed: Callable[[float], float], speed: float) -> float:
    """What a law gives at a speed; nan where no impact had one."""
    return of_speed(speed) if np.isfinite(speed) else np.nan


def _fastest(study: StickStudy, pair: str) -> float:
    """Largest speed of approach of a pair's impacts [m/s]; nan where there is none."""
    found = (i.approach for i in study.impacts if i.pair.name == pair and i.approach > 0.0)
    return max(found, default=np.nan)


def _targets(study: StickStudy) -> Variables:
    if study.calibration is None:
        return {}
    targets = study.calibration.targets
    masses = [np.nan if t.effective_mass is None else t.effective_mass for t in targets]
    return {
        "target_building": ("target", _words(t.building for t in targets)),
        "target_mode": ("target", np.array([t.mode for t in targets])),
        "target_frequency": (
            "target",
            np.array([t.frequency for t in targets]),
            {"units": "Hz"},
        ),
        "target_effective_mass": ("target", np.array(masses), {"units": "kg"}),
        "calibrated_frequency": ("target", study.calibration.frequency, {"units": "Hz"}),
        "calibrated_effective_mass": (
            "target",
            study.calibration.effective_mass,
            {"units": "kg"},
        ),
    }


def _words(values: Any) -> NDArray[np.object_]:
    return np.array(list(values), dtype=object)

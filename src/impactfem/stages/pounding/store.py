"""The stores of the stage: `motion.nc` and `pounding.nc`.

Stations are the floors of all buildings. Names that end in `_free` belong to the run without
contact. Displacements and velocities are relative to the ground under the first building,
accelerations absolute.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case import Case
from impactfem.case.contact_checks import pair_distance
from impactfem.coupling.impacts import Impact, ImpactCheck, Separation
from impactfem.motion.acceptance import CORRELATION_LIMIT, Verdict, pair_correlation
from impactfem.motion.from_case import GroundMotion
from impactfem.records.accelerogram import Measures
from impactfem.spectra.resolved import ZPA, ResolvedBand
from impactfem.stages.pounding.compute import StickStudy, moving, station_dofs
from impactfem.stages.pounding.foundation import DIRECTIONS, Foundation
from impactfem.stages.pounding.peaks import (
    BuildingPeaks,
    FloorPeaks,
    OverTarget,
    building_peaks,
    floor_peaks,
    over_target,
)
from impactfem.stages.pounding.scalars import mode_scalars, selected_scalars
from impactfem.stages.results import outputs, value, values
from impactfem.stages.stores import Output, damping_outputs, damping_values, dataset, padded
from impactfem.sticks.calibration import Parameters
from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import Modes
from impactfem.sticks.stick import Stick
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

CHANGED = ("force", "mean_force", "frs", "pfa")
"""Results of 3D models that are compared with those of fewer points or longer steps."""
MOST_BENDING = 6
"""Modes of a stick along one direction that are listed."""
_HISTORY = "time station component"
_SPECTRUM = "damping station direction frequency"
_FOUNDATION = "foundation foundation_component"
_FIRST = "foundation foundation_direction"
OUTPUTS = {
    "time": Output("time", "s"),
    "axis": Output("axis"),
    "ground": Output("time axis", "m/s2", "ground acceleration under the first building"),
    "component": Output("component", "", "those of x, y, z, rx, ry, rz in which anything moves"),
    "station": Output("station", "", "building and floor"),
    "station_building": Output("station", label=True),
    "station_floor": Output("station", label=True),
    "elevation": Output("station", "m", label=True),
    "floor_mass": Output("station", "kg"),
    "rigid_below": Output("station", "m", "rigid depth below the mass centre"),
    "rigid_above": Output("station", "m", "rigid depth above the mass centre"),
    "displacement": Output(_HISTORY, "m, rad", "relative to the ground under the first building"),
    "velocity": Output(_HISTORY, "m/s, rad/s", "relative to the ground under the first building"),
    "acceleration": Output(_HISTORY, "m/s2, rad/s2", "absolute"),
    "displacement_free": Output(_HISTORY, "m, rad", "without contact"),
    "velocity_free": Output(_HISTORY, "m/s, rad/s", "without contact"),
    "acceleration_free": Output(_HISTORY, "m/s2, rad/s2", "absolute, without contact"),
    "frequency": Output("frequency", "Hz", "of the oscillators"),
    "damping": Output("damping", "-", "of the oscillators"),
    "direction": Output("direction"),
    "psa": Output(_SPECTRUM, "m/s2", "pseudo-acceleration"),
    "sd": Output(_SPECTRUM, "m", "spectral displacement"),
    "pfa": Output("station direction", "m/s2", "peak floor acceleration"),
    "psa_free": Output(_SPECTRUM, "m/s2", "pseudo-acceleration without contact"),
    "sd_free": Output(_SPECTRUM, "m", "spectral displacement without contact"),
    "pfa_free": Output("station direction", "m/s2", "peak floor acceleration without contact"),
    "zpa": Output("station direction", "m/s2", ZPA),
    "zpa_free": Output("station direction", "m/s2", f"{ZPA}, without contact"),
    "rotation": Output("rotation", "", "those of rx, ry, rz in which anything moves"),
    "rotational_psa": Output(
        "damping station rotation frequency", "rad/s2", "pseudo-acceleration of a rotation"
    ),
    "rotational_pfa": Output("station rotation", "rad/s2", "peak acceleration of a rotation"),
    "building": Output("building"),
    "plan": Output("plan"),
    "ground_apart": Output(
        "building time axis", "m", "displacement of the ground under it, less under the first one"
    ),
    "building_axis": Output("building plan", "m", "place of its stick"),
    "building_base": Output("building", "m", "elevation of its base"),
    "building_model": Output("building", "", "what pounds: stick or structure", label=True),
    "mode_direction": Output("mode_direction"),
    "mode_component": Output("mode_component"),
    "mode_frequency": Output("building mode", "Hz"),
    "mode_family": Output("building mode", "", "direction of bending, or the kind of the mode"),
    "mode_ratio": Output("building mode", "-", "damping ratio"),
    "mode_effective_mass": Output("building mode_direction mode", "kg, kg m2"),
    "mode_shape": Output("station mode mode_component", "kg^-1/2", "with unit modal mass"),
    **damping_outputs("building"),
    "impact_pair": Output("impact", "", "pair", label=True),
    **outputs(Impact, "impact", "impact_"),
    **outputs(ImpactCheck, "impact", "impact_"),
    "changed": Output("changed", "", "compared results of 3D models"),
    "comparison": Output("comparison", "", "run that is compared: halved contact points, ..."),
    "change": Output("comparison changed", "-", "largest change of a result, ratio - 1"),
    **outputs(FloorPeaks, "station"),
    **outputs(BuildingPeaks, "building"),
    **outputs(StickStudy),
    **outputs(ResolvedBand),
    "family_mode": Output("family_mode", "", "number of a mode in its family"),
    "bending_frequency": Output("building family_mode", "Hz", "mode along the main direction"),
    "bending_mass": Output("building family_mode", "kg", "effective mass of this mode"),
    "total_mass": Output("building", "kg", "mass of all floors"),
    "pair": Output("pair"),
    "pair_building_a": Output("pair", label=True),
    "pair_floor_a": Output("pair", label=True),
    "pair_law": Output("pair", "", "contact law", label=True),
    "pair_stiffness_unit": Output("pair", "", "unit of the stiffness", label=True),
    "gap": Output("time pair", "m"),
    "pair_young_modulus": Output("pair", "Pa", "E", shown="GPa"),
    "pair_poisson_ratio": Output("pair", "-", "nu"),
    "pair_rest_gap": Output("pair", "m", "gap", shown="mm"),
    "pair_distance": Output("pair", "m", "distance, of its points by axes and offsets"),
    "pair_stiffness": Output("pair", "N/m, N/m^1.5", "stiffness"),
    "pair_dashpot": Output("pair", "N s/m", "dashpot, of a linear law"),
    "pair_onset_force": Output("pair", "N", "onset force, at the largest approach", shown="MN"),
    "pair_damping_ratio": Output("pair", "-", "damping ratio"),
    "pair_restitution": Output("pair", "-", "of the law, restitution"),
    "pair_effective_mass": Output("pair", "kg", "effective mass", shown="t"),
    "pair_law_duration": Output(
        "pair", "s", "duration of the law, with the effective mass", shown="ms"
    ),
    "pair_asked": Output("pair", "-", "restitution requested"),
    **outputs(Separation, "pair", "pair_"),
    "facing": Output("facing", "", "facing floors without a contact pair"),
    "facing_a": Output("facing", "", "floor", label=True),
    "facing_b": Output("facing", "", "faces", label=True),
    "facing_level": Output("facing", "m", "level"),
    "facing_rest_gap": Output("facing", "m", "distance at rest", shown="mm"),
    "facing_distance_min": Output(
        "facing", "m", "smallest distance, negative if they overlap", shown="mm"
    ),
    "facing_time": Output("facing", "s", "at, time of the smallest distance"),
    "foundation": Output("foundation", "", "building, on soil"),
    "foundation_component": Output("foundation_component", "", "component"),
    "foundation_direction": Output("foundation_direction", "", "direction"),
    **outputs(Foundation, "foundation", "foundation_"),
    "foundation_pressure": Output("time foundation", "Pa", "least of the underside"),
    "base_displacement": Output("time foundation foundation_component", "m, rad", "of the base"),
    **outputs(Parameters),
    "target_building": Output("target", "", "building", label=True),
    "target_mode": Output("target", "", "mode, number in its family", label=True),
    "target_frequency": Output("target", "Hz", "target"),
    "target_effective_mass": Output("target", "kg", "target", shown="t"),
    "calibrated_frequency": Output("target", "Hz", "frequency"),
    "calibrated_effective_mass": Output("target", "kg", "effective mass", shown="t"),
    "frequency_error": Output("target", "-", "error", shown="%"),
    "effective_mass_error": Output("target", "-", "error", shown="%"),
}
MOTION_OUTPUTS = {
    "direction": Output("motion", "", "of the ground", label=True),
    "origin": Output("motion", "", "where it comes from", label=True),
    "damping": Output("motion", "-", "of the oscillators", label=True),
    "time": Output("motion sample", "s", "nan after the end of a shorter motion"),
    "acceleration": Output("motion sample", "m/s2", "of the ground"),
    "frequency": Output("motion oscillator", "Hz", "nan beyond the spectrum of a motion"),
    "spectrum": Output("motion oscillator", "m/s2", "pseudo-acceleration"),
    "target": Output("motion oscillator", "m/s2", "design spectrum; nan where it has none"),
    **outputs(Measures, "motion"),
    **outputs(GroundMotion, "motion"),
    **outputs(OverTarget, "motion"),
    "criterion": Output("criterion", "", "of US NRC SRP 3.7.1"),
    "criterion_motion": Output("criterion", "", "direction, or both directions", label=True),
    "criterion_value": Output("criterion", "as unit"),
    "criterion_unit": Output("criterion", "", "SI unit", label=True),
    "criterion_limit": Output("criterion", "as unit"),
    "criterion_at_least": Output("criterion", "", "the limit is a lower one"),
    "criterion_at": Output("criterion", "Hz", "frequency of the value; nan without one"),
    "criterion_passed": Output("criterion"),
}


def write_motion(path: Path, study: StickStudy, key: str) -> None:
    """Write `motion.nc`; the key is the hash of the inputs of the stage."""
    write_netcdf(path, motion_results(study).assign_attrs(title=study.case.title, inputs=key))


def motion_results(study: StickStudy) -> xr.Dataset:
    """The ground motions, their measures, spectra and criteria of reviewers."""
    motions = study.motions
    records, spectra = [m.accelerogram for m in motions], [m.spectrum for m in motions]
    results = {
        "direction": [m.direction for m in motions],
        "origin": [record.origin for record in records],
        "damping": [float(spectrum.damping[0]) for spectrum in spectra],
        "time": padded([record.time for record in records]),
        "acceleration": padded([record.acceleration for record in records]),
        "frequency": padded([spectrum.frequency for spectrum in spectra]),
        "spectrum": padded([spectrum.psa[0, 0] for spectrum in spectra]),
        "target": padded(
            [m.spectrum.frequency * np.nan if m.target is None else m.target for m in motions]
        ),
        **values(Measures, (m.measures for m in motions)),
        **values(GroundMotion, motions),
        **values(OverTarget, (over_target(study, m) for m in motions)),
    }
    verdicts = [
        (motion.direction, verdict)
        for motion in motions
        for verdict in (motion.acceptance.verdicts if motion.acceptance is not None else ())
    ]
    for a, b in combinations(motions, 2):
        if a.accelerogram.time_step == b.accelerogram.time_step:
            rho = abs(pair_correlation(a.accelerogram, b.accelerogram))
            verdict = Verdict("correlation", rho, CORRELATION_LIMIT, at_least=False, unit="-")
            verdicts.append((f"{a.direction}_{b.direction}", verdict))
    if verdicts:
        results |= {
            "criterion": [verdict.name for _, verdict in verdicts],
            "criterion_motion": [direction for direction, _ in verdicts],
            **{
                f"criterion_{name}": [getattr(verdict, name) for _, verdict in verdicts]
                for name in ("value", "unit", "limit", "at_least", "at", "passed")
            },
        }
    return dataset(MOTION_OUTPUTS, results, attributes={})


def write_sticks(path: Path, study: StickStudy, key: str) -> None:
    """Write `pounding.nc`; the key is the hash of the inputs of the stage."""
    store, case = stick_results(study), study.case
    # No scalar needs the ZPA, which the members of an ensemble therefore do without.
    for name, response in (("zpa", study.response), ("zpa_free", study.free)):
        about = {"units": OUTPUTS[name].unit, "long_name": OUTPUTS[name].long_name}
        store[name] = ("station", "direction"), study.zpa(response), about
    store = with_scalars(store, selected_scalars(store, motion_results(study)))
    attributes = {"title": case.title, "inputs": key, "case_hash": case.content_hash()}
    write_netcdf(path, store.assign_attrs(attributes))


def stick_scalars(study: StickStudy) -> list[Scalar]:
    """The scalars of the stage, without a results file."""
    return selected_scalars(stick_results(study), motion_results(study))


def scalars_of_modes(case: Case, sticks: Sequence[Stick], found: Sequence[Modes]) -> list[Scalar]:
    """The scalars of the modes of sticks alone."""
    results = {"building": [stick.name for stick in sticks], **bending_modes(case, sticks, found)}
    return mode_scalars(dataset(OUTPUTS, results, attributes={}))


def stick_results(study: StickStudy) -> xr.Dataset:
    """All results of the stage but the motions, as `pounding.nc` has them."""
    with_contact, free = study.floors, study.floors_free
    results = {
        **_histories(study),
        "frequency": with_contact.spectra.frequency,
        "damping": with_contact.spectra.damping,
        "direction": with_contact.directions,
        **{name: getattr(with_contact, name) for name in ("psa", "sd", "pfa")},
        **{f"{name}_free": getattr(free, name) for name in ("psa", "sd", "pfa")},
        **_modes(study),
        "impact_pair": [impact.pair.name for impact in study.impacts],
        **values(Impact, study.impacts, "impact_"),
        **values(ImpactCheck, study.checks, "impact_"),
        **_pairs(study),
        **_foundations(study),
        **values(FloorPeaks, floor_peaks(study)),
        **values(BuildingPeaks, building_peaks(study)),
        **value(study),
        **value(study.band),
    }
    if (turning := study.turning()) is not None:
        results["rotation"] = turning.directions
        results |= {f"rotational_{name}": getattr(turning, name) for name in ("psa", "pfa")}
    if study.peaks is not None:
        others = {"halved": study.halved, "doubled_step": study.doubled}
        results |= {
            "comparison": list(others),
            "changed": CHANGED,
            "change": [
                [study.peaks.change(other, what) for what in CHANGED] for other in others.values()
            ],
        }
    if study.facing:
        results |= {
            "facing": [one.facing.name for one in study.facing],
            "facing_a": [one.facing.a.label for one in study.facing],
            "facing_b": [one.facing.b.label for one in study.facing],
            "facing_level": [one.facing.level for one in study.facing],
            "facing_rest_gap": [one.facing.gap for one in study.facing],
            "facing_distance_min": [one.distance for one in study.facing],
            "facing_time": [one.time for one in study.facing],
        }
    if study.calibration is not None:
        calibration, targets = study.calibration, study.calibration.targets
        results |= {
            **value(calibration.parameters),
            "target_building": [t.building for t in targets],
            "target_mode": [t.mode for t in targets],
            "target_frequency": [t.frequency for t in targets],
            "target_effective_mass": np.array([t.effective_mass for t in targets], dtype=float),
            "calibrated_frequency": calibration.frequency,
            "calibrated_effective_mass": calibration.effective_mass,
            "frequency_error": calibration.frequency_error,
            "effective_mass_error": calibration.mass_error,
        }
    # The horizontal direction in which the buildings stand side by side.
    spans = [np.abs(pair.normal[:2]) for pair in study.system.pairs]
    spans.append(np.ptp([stick.axis for stick in study.system.sticks], axis=0)[:2])
    other = "x" if study.motions[0].direction == "x" else "y"
    attributes = {
        "studied_building": study.system.sticks[0].name,
        "shown_direction": study.case.shown_direction,
        **study.band.attributes,
        "elevation_direction": next(("x" if x > y else "y" for x, y in spans if x != y), other),
    }
    return dataset(OUTPUTS, results, attributes=attributes)


def _histories(study: StickStudy) -> dict[str, Any]:
    dofs = station_dofs(study.system)
    components = sum(moving(study.response.u, dofs), ())
    columns = dofs[:, [COMPONENTS.index(name) for name in components]]
    sticks = study.system.sticks
    floors = [floor for stick in sticks for floor in stick.floors]
    values: dict[str, Any] = {
        "time": study.response.time,
        "axis": ["x", "y", "z"],
        "ground": study.response.ground,
        "component": components,
        "station": [f"{building}.floor_{number}" for building, number in study.stations],
        "station_building": [building for building, _ in study.stations],
        "station_floor": [number for _, number in study.stations],
        "elevation": np.concatenate([s.positions[: len(s.floors), 2] for s in sticks]),
        "floor_mass": [floor.mass for floor in floors],
        "rigid_below": [floor.below for floor in floors],
        "rigid_above": [floor.above for floor in floors],
    }
    if apart := study.response.relative:
        still = np.zeros_like(study.response.ground)
        values["ground_apart"] = [apart[s.name][0] if s.name in apart else still for s in sticks]
    for suffix, run in (("", study.response), ("_free", study.free)):
        values[f"displacement{suffix}"] = run.u[:, columns]
        values[f"velocity{suffix}"] = run.v[:, columns]
        values[f"acceleration{suffix}"] = run.absolute_acceleration[:, columns]
    return values


def _modes(study: StickStudy) -> dict[str, Any]:
    sticks, laws = study.system.sticks, [building.damping.law for building in study.case.buildings]
    omega = [2.0 * np.pi * found.frequency for found in study.modes]
    ratio = [law.modal(ω**2) / (2.0 * ω) for law, ω in zip(laws, omega, strict=True)]
    family = np.full((len(sticks), max(map(len, omega))), "", dtype=object)
    shapes = []
    for k, (stick, found) in enumerate(zip(sticks, study.modes, strict=True)):
        family[k, : len(found.family)] = found.family
        rows = found.shape[: 6 * len(stick.floors)]
        shapes.append(rows.reshape(len(stick.floors), 6, -1).swapaxes(1, 2))
    # One stick after the other, all with so many modes as the one that has most.
    shape = [one[: len(stick.floors)] for stick, one in zip(sticks, padded(shapes), strict=True)]
    return {
        "building": [stick.name for stick in sticks],
        **damping_values(laws),
        "plan": ["x", "y"],
        "building_axis": [stick.axis for stick in sticks],
        "building_base": [stick.base for stick in sticks],
        "building_model": [
            "structure" if stick.name in study.case.pounding_in_3d else "stick" for stick in sticks
        ],
        "mode_direction": COMPONENTS,
        "mode_component": COMPONENTS,
        "mode_frequency": padded([found.frequency for found in study.modes]),
        "mode_family": family,
        "mode_ratio": padded(ratio),
        "mode_effective_mass": padded([found.effective_mass for found in study.modes]),
        "mode_shape": np.concatenate(shape),
        **bending_modes(study.case, sticks, study.modes),
    }


def bending_modes(case: Case, sticks: Sequence[Stick], found: Sequence[Modes]) -> dict[str, Any]:
    """Masses and first modes of sticks along the direction of calibration or pounding, else y."""
    direction = case.calibration.direction if case.calibration else case.shown_direction
    direction = direction if direction in DIRECTIONS else "y"
    frequency, mass = np.full((2, len(sticks), MOST_BENDING), np.nan)
    for k, one in enumerate(found):
        family = one.of_family(direction)[:MOST_BENDING]
        frequency[k, : len(family)] = one.frequency[family]
        mass[k, : len(family)] = one.effective_mass[COMPONENTS.index(direction), family]
    return {
        "family_mode": np.arange(1, MOST_BENDING + 1),
        "bending_frequency": frequency,
        "bending_mass": mass,
        "total_mass": [float(sum(floor.mass for floor in stick.floors)) for stick in sticks],
    }


def _foundations(study: StickStudy) -> dict[str, Any]:
    found = study.foundations
    if not found:
        return {}
    bases = [study.response.bases[one.building] for one in found]
    return {
        "foundation": [one.building for one in found],
        "foundation_component": COMPONENTS,
        "foundation_direction": DIRECTIONS,
        **values(Foundation, found, "foundation_"),
        "foundation_pressure": np.stack([one.pressure for one in found], axis=1),
        "base_displacement": np.stack([base.u for base in bases], axis=1),
    }


def _pairs(study: StickStudy) -> dict[str, Any]:
    pairs, names = study.system.pairs, [pair.name for pair in study.system.pairs]
    laws = [pair.law for pair in pairs]
    materials = [study.case.building(pair.a.building).material for pair in pairs]
    # Of a line the distance is that of its first pair: where its gap varies it says nothing.
    rest = {pair.name: pair.gap for pair in pairs}
    distances = {
        c.name: pair_distance(c, study.case)
        for c in study.case.contacts
        if abs(rest.get(c.name, c.gap) - c.gap) <= 1e-9
    }
    # Largest speed of approach; nan where no impact had one.
    speeds = dict.fromkeys(names, np.nan)
    for impact in study.impacts:
        if impact.approach > 0.0:
            speeds[impact.pair.name] = np.fmax(speeds[impact.pair.name], impact.approach)
    onset, lasts = np.full((2, len(pairs)), np.nan)
    for k, (law, speed) in enumerate(zip(laws, speeds.values(), strict=True)):
        onset[k], lasts[k] = law.onset_force(speed), law.duration(speed)
    return {
        "pair": names,
        "pair_building_a": [pair.a.building for pair in pairs],
        "pair_floor_a": [pair.a.floor for pair in pairs],
        "pair_law": [law.name for law in laws],
        "pair_stiffness_unit": [law.stiffness_unit for law in laws],
        "gap": study.response.gap,
        "pair_young_modulus": [material.young_modulus for material in materials],
        "pair_poisson_ratio": [material.poisson_ratio for material in materials],
        "pair_rest_gap": [pair.gap for pair in pairs],
        "pair_distance": [distances.get(name, np.nan) for name in names],
        "pair_stiffness": [law.stiffness for law in laws],
        "pair_dashpot": [law.dashpot for law in laws],
        "pair_onset_force": onset,
        "pair_damping_ratio": [law.xi for law in laws],
        "pair_restitution": [law.epsilon for law in laws],
        "pair_effective_mass": [law.mass for law in laws],
        "pair_law_duration": lasts,
        "pair_asked": [law.target_restitution for law in laws],
        **values(Separation, study.separations, "pair_"),
    }

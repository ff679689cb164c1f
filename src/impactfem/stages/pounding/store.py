"""The stores of the stage: `motion.nc` and `pounding.nc`.

Stations are the floors of all buildings. Names that end in `_free` belong to the run without
contact. Displacements and velocities are relative to the ground under the first building,
accelerations absolute.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from impactfem.case.contact_checks import pair_distance
from impactfem.stages.pounding.compute import StickStudy, moving, station_dofs
from impactfem.stages.pounding.foundation import DIRECTIONS
from impactfem.stages.pounding.scalars import stick_scalars
from impactfem.stages.stores import Output, damping_outputs, damping_values, dataset, padded
from impactfem.sticks.element import COMPONENTS
from impactfem.system.files import write_netcdf

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
    "impact_pair": Output("impact", label=True),
    "impact_first_contact": Output("impact", "s"),
    "impact_end": Output("impact", "s"),
    "impact_peak_time": Output("impact", "s"),
    "impact_peak_force": Output("impact", "N"),
    "impact_impulse": Output("impact", "N s"),
    "impact_duration": Output("impact", "s"),
    "impact_penetration": Output("impact", "m"),
    "impact_approach": Output("impact", "m/s", "speed before it"),
    "impact_separation": Output("impact", "m/s", "speed after it"),
    "impact_restitution": Output("impact", "-"),
    "impact_dissipated": Output("impact", "J", "by the law, by the work of the force"),
    "impact_defect": Output("impact", "J", "lost by the time stepping; negative: added"),
    "impact_steps": Output("impact", "-", "computed times with a force"),
    "impact_bearing_pressure": Output("impact", "Pa"),
    "impact_bearing_ratio": Output("impact", "-", "that over the compressive strength"),
    "impact_storey_shear": Output("impact", "N", "the largest meanwhile"),
    "impact_shear_stress": Output("impact", "Pa"),
    "impact_cracking_ratio": Output("impact", "-", "that over the tensile strength"),
    "impact_building_restitution": Output("impact", "-", "of the buildings' centres of mass"),
    "pair": Output("pair"),
    "pair_building_a": Output("pair", label=True),
    "pair_floor_a": Output("pair", label=True),
    "pair_law": Output("pair", "", "contact law", label=True),
    "pair_stiffness_unit": Output("pair", "", "by the law", label=True),
    "gap": Output("time pair", "m"),
    "pair_young_modulus": Output("pair", "Pa"),
    "pair_poisson_ratio": Output("pair", "-"),
    "pair_rest_gap": Output("pair", "m"),
    "pair_distance": Output("pair", "m", "of its points by axes and offsets"),
    "pair_stiffness": Output("pair", "N/m, N/m^1.5"),
    "pair_dashpot": Output("pair", "N s/m", "of a linear law"),
    "pair_onset_force": Output("pair", "N", "at the largest speed of approach"),
    "pair_damping_ratio": Output("pair", "-"),
    "pair_restitution": Output("pair", "-", "of the law"),
    "pair_effective_mass": Output("pair", "kg"),
    "pair_law_duration": Output("pair", "s", "of an impact with the effective mass"),
    "pair_asked": Output("pair", "-", "requested restitution"),
    "pair_required_separation": Output("pair", "m", "gap that would have prevented contact"),
    "pair_margin": Output("pair", "m", "gap less required separation"),
    "pair_touched": Output("pair"),
    "facing": Output("facing", "", "floors that face each other and are in no pair"),
    "facing_a": Output("facing", label=True),
    "facing_b": Output("facing", label=True),
    "facing_level": Output("facing", "m", "elevation"),
    "facing_rest_gap": Output("facing", "m", "distance at rest"),
    "facing_distance_min": Output("facing", "m", "smallest distance; negative: they overlap"),
    "facing_time": Output("facing", "s", "when they are nearest"),
    "foundation": Output("foundation", "", "building on soil"),
    "foundation_component": Output("foundation_component"),
    "foundation_stiffness": Output(_FOUNDATION, "N/m, N m/rad", "of the soil, at rest"),
    "foundation_dashpot": Output(_FOUNDATION, "N s/m, N m s/rad", "at the first frequency"),
    "foundation_stiffness_error": Output(_FOUNDATION, "-", "of the model of the soil, over |S|"),
    "foundation_damping_error": Output(_FOUNDATION, "-", "of the model of the soil, over Im S"),
    "foundation_direction": Output("foundation_direction"),
    "foundation_clamped_frequency": Output(_FIRST, "Hz", "first mode on a clamped base"),
    "foundation_frequency": Output(_FIRST, "Hz", "of this mode on soil"),
    "foundation_clamped_ratio": Output(_FIRST, "-", "damping ratio on a clamped base"),
    "foundation_ratio": Output(_FIRST, "-", "damping ratio on soil"),
    "foundation_radiated": Output("foundation", "J", "energy radiated"),
    "foundation_weight": Output("foundation", "N", "of building and raft"),
    "foundation_static_pressure": Output("foundation", "Pa", "by gravity, mean"),
    "foundation_pressure": Output("time foundation", "Pa", "least of the underside"),
    "base_displacement": Output("time foundation foundation_component", "m, rad", "of the base"),
    "target_building": Output("target", label=True),
    "target_mode": Output("target", "", "number in its family", label=True),
    "target_frequency": Output("target", "Hz"),
    "target_effective_mass": Output("target", "kg"),
    "calibrated_frequency": Output("target", "Hz"),
    "calibrated_effective_mass": Output("target", "kg"),
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
}


def write_motion(path: Path, study: StickStudy, key: str) -> None:
    """Write `motion.nc`; the key is the hash of the inputs of the stage."""
    motions = study.motions
    records, spectra = [m.accelerogram for m in motions], [m.spectrum for m in motions]
    values = {
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
    }
    attributes = {"title": study.case.title, "inputs": key}
    write_netcdf(path, dataset(MOTION_OUTPUTS, values, attributes=attributes))


def write_sticks(path: Path, study: StickStudy, key: str) -> None:
    """Write `pounding.nc`; the key is the hash of the inputs of the stage."""
    with_contact, free = study.floors, study.floors_free
    values = {
        **_histories(study),
        "frequency": with_contact.spectra.frequency,
        "damping": with_contact.spectra.damping,
        "direction": with_contact.directions,
        **{name: getattr(with_contact, name) for name in ("psa", "sd", "pfa")},
        **{f"{name}_free": getattr(free, name) for name in ("psa", "sd", "pfa")},
        **_modes(study),
        **_impacts(study),
        **_pairs(study),
        **_foundations(study),
    }
    if (turning := study.turning()) is not None:
        values["rotation"] = turning.directions
        values |= {f"rotational_{name}": getattr(turning, name) for name in ("psa", "pfa")}
    if study.facing:
        values |= {
            "facing": [one.facing.name for one in study.facing],
            "facing_a": [one.facing.a.label for one in study.facing],
            "facing_b": [one.facing.b.label for one in study.facing],
            "facing_level": [one.facing.level for one in study.facing],
            "facing_rest_gap": [one.facing.gap for one in study.facing],
            "facing_distance_min": [one.distance for one in study.facing],
            "facing_time": [one.time for one in study.facing],
        }
    if study.calibration is not None:
        targets = study.calibration.targets
        values |= {
            "target_building": [t.building for t in targets],
            "target_mode": [t.mode for t in targets],
            "target_frequency": [t.frequency for t in targets],
            "target_effective_mass": np.array([t.effective_mass for t in targets], dtype=float),
            "calibrated_frequency": study.calibration.frequency,
            "calibrated_effective_mass": study.calibration.effective_mass,
        }
    # The horizontal direction in which the buildings stand side by side.
    spans = [np.abs(pair.normal[:2]) for pair in study.system.pairs]
    spans.append(np.ptp([stick.axis for stick in study.system.sticks], axis=0)[:2])
    other = "x" if study.motions[0].direction == "x" else "y"
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "case_hash": study.case.content_hash(),
        "studied_building": study.system.sticks[0].name,
        "shown_direction": study.case.shown_direction,
        "resolved_frequency": study.resolved_frequency,
        "elevation_direction": next(("x" if x > y else "y" for x, y in spans if x != y), other),
    }
    scalars = stick_scalars(study)
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))


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
    }


def _foundations(study: StickStudy) -> dict[str, Any]:
    found = study.foundations
    if not found:
        return {}
    of_each = (
        *("stiffness", "dashpot", "stiffness_error", "damping_error", "clamped_frequency"),
        *("frequency", "clamped_ratio", "ratio", "radiated", "weight", "static_pressure"),
    )
    bases = [study.response.bases[one.building] for one in found]
    return {
        "foundation": [one.building for one in found],
        "foundation_component": COMPONENTS,
        "foundation_direction": DIRECTIONS,
        **{f"foundation_{name}": [getattr(one, name) for one in found] for name in of_each},
        "foundation_pressure": np.stack([one.pressure for one in found], axis=1),
        "base_displacement": np.stack([base.u for base in bases], axis=1),
    }


def _impacts(study: StickStudy) -> dict[str, Any]:
    of_impact = (
        *("end", "peak_time", "peak_force", "impulse", "duration", "penetration", "approach"),
        *("separation", "restitution", "dissipated", "defect", "steps"),
    )
    of_check = (
        *("bearing_pressure", "bearing_ratio", "storey_shear", "shear_stress", "cracking_ratio"),
        "building_restitution",
    )
    found, checks = study.impacts, study.checks
    return {
        "impact_pair": [impact.pair.name for impact in found],
        "impact_first_contact": [impact.start for impact in found],
        **{f"impact_{name}": [getattr(i, name) for i in found] for name in of_impact},
        **{f"impact_{n}": [getattr(c, n) for c in checks] for n in of_check},
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
        if np.isfinite(speed):
            onset[k] = law.onset_force(speed)
        # The duration of a linear law is the same at any speed.
        if law.linear or np.isfinite(speed):
            lasts[k] = law.duration(1.0 if law.linear else speed)
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
        "pair_dashpot": [law.parameters[1] if law.linear else np.nan for law in laws],
        "pair_onset_force": onset,
        "pair_damping_ratio": [law.xi for law in laws],
        "pair_restitution": [law.epsilon for law in laws],
        "pair_effective_mass": [law.mass for law in laws],
        "pair_law_duration": lasts,
        "pair_asked": [law.asked for law in laws],
        "pair_required_separation": [s.required for s in study.separations],
        "pair_margin": [s.margin for s in study.separations],
        "pair_touched": np.array([s.touched for s in study.separations], dtype=bool),
    }

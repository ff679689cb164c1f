"""The store of the stage: `device.nc`.

Each of several anchors of a device counts (`pipe_1`, `pipe_2`). Forces are those of the device on
the floor, moments for rx, ry and rz; accelerations are absolute.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.device.anchor_force import own_weight
from impactfem.device.modes import device_modes
from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.damping_study import DampedStudy, DeviceStudy
from impactfem.stages.device.drawing import drawing_values
from impactfem.stages.device.scalars import (
    WORDS,
    Pull,
    anchor_radius,
    device_scalars,
    headline,
    pull_of,
    tension_by_spectrum,
)
from impactfem.stages.device.spectrum_choice import SpectrumChoice
from impactfem.stages.stores import Output, dataset
from impactfem.sticks.element import COMPONENTS
from impactfem.system.files import write_netcdf

Array = NDArray[np.float64]

_LOAD = "case impact device"
OUTPUTS = {
    "case": Output("case", "", "damping of the buildings, their own first"),
    "impact": Output("impact"),
    "device": Output("device"),
    "component": Output("component"),
    "axis": Output("axis"),
    "xyz": Output("xyz"),
    "bending_about": Output("bending_about"),
    "choice": Output("choice", "", "response spectrum analysis"),
    "mode": Output("mode", "", "number of a mode of a device; values beyond its modes are nan"),
    "time": Output("time", "s"),
    "frequency": Output("frequency", "Hz"),
    "force": Output(f"{_LOAD} component time", "N, N m", "in the 3D model"),
    "largest_force": Output(f"{_LOAD} component", "N, N m"),
    "imbalance": Output(_LOAD, "-", "of inertia and springs, over the largest force"),
    "anchor_acceleration": Output(f"{_LOAD} component time", "m/s2, rad/s2", "without the device"),
    "psa": Output(f"{_LOAD} axis frequency", "m/s2", "at the device's first damping"),
    "spectrum_force": Output(f"{_LOAD} choice component", "N, N m", "nan where not done"),
    "mode_psa": Output(f"{_LOAD} component mode", "m/s2, rad/s2", "that the modes were given"),
    "mode_frequency": Output("device mode", "Hz"),
    "mode_damping": Output("device mode", "-"),
    "effective_mass": Output("device component mode", "kg, kg m2"),
    "anchor_position": Output("device xyz", "m"),
    "anchor_floor": Output("device"),
    "anchor_nodes": Output("device", "", "number of its nodes"),
    "anchor_radius": Output("device", "m", "of the circle of its anchors"),
    "weight_force": Output("device component", "N, N m", "on the floor by its weight alone"),
    "net_uplift": Output(_LOAD, "N", "largest force upward less the weight"),
    "net_tension": Output(_LOAD, "N", "n times the pull of the most loaded of n anchors"),
    "spectrum_tension": Output(f"{_LOAD} choice", "N", "the same by response spectrum analysis"),
    "mass_coefficient": Output("case", "1/s", "α of Rayleigh damping"),
    "stiffness_coefficient": Output("case", "s", "β of Rayleigh damping"),
    "epsilon": Output("case", "-", "restitution of the contact laws; nan where they keep theirs"),
    "epsilon_calibrated": Output("case", "", "whether the impact on the wall gave it"),
    "impact_force": Output("case", "N", "largest one, as resampled to the steps of the 3D model"),
    "base_stiffness": Output("device component", "N/m, N m/rad", "infinite for a rigid one"),
    "body_mass": Output("device", "kg"),
    "body_height": Output("device", "m", "of its mass centre above the anchor"),
    "body_inertia": Output("device axis", "kg m2", "through the mass centre"),
    "body_radius": Output("device", "m", "of a cylinder"),
    "body_length": Output("device", "m", "of a cylinder"),
    "beam_length": Output("device", "m"),
    "beam_mass": Output("device", "kg"),
    "beam_bending": Output("device bending_about", "N m2"),
    "level_height": Output("device level", "m", "above the anchor"),
    "mode_shape": Output("device mode level component", "1/sqrt(kg)", "relative to the anchor"),
    "note": Output("note", "", "what the response spectrum analyses assumed"),
}


def write_devices(path: Path, study: DeviceStudy, key: str) -> None:
    """Write `device.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    cases, prepared, supports = study.cases, study.prepared, study.supports
    choices, best, modes = _choices(study), headline(study), _modes(study)
    turned = replace(best, rotations=True)
    ordinates = mode_ordinates(
        cases, turned if turned in choices else best, modes["mode_frequency"].shape[1]
    )
    values = {
        "case": [case.name for case in cases],
        "impact": ["without", "with"],
        "device": [support.name for support in supports],
        "component": COMPONENTS,
        "axis": ["x", "y", "z"],
        "xyz": ["x", "y", "z"],
        "bending_about": ["x", "y"],
        "choice": [choice.label for choice in choices],
        "mode": np.arange(1, modes["mode_frequency"].shape[1] + 1),
        "time": prepared.loads.time_step * np.arange(len(prepared.loads.ground)),
        "frequency": study.case.spectra.frequency_values,
        # Nothing is read off them that single precision would spoil, and they are most of the file.
        "force": _each(study, lambda r: r.detailed.force).astype(np.float32),
        "anchor_acceleration": _each(study, lambda r: r.anchor).astype(np.float32),
        "largest_force": _each(study, lambda r: r.detailed.largest),
        "imbalance": _each(study, lambda r: r.detailed.imbalance),
        "psa": _each(study, lambda r: r.shown),
        "spectrum_force": _each(study, lambda r: [[r.value(c, w) for w in WORDS] for c in choices]),
        "mode_psa": ordinates,
        **modes,
        **_anchors(study),
        **_pulls(study, choices),
        "mass_coefficient": [case.damping.alpha for case in cases],
        "stiffness_coefficient": [case.damping.beta for case in cases],
        "epsilon": [np.nan if case.epsilon is None else case.epsilon for case in cases],
        "epsilon_calibrated": [int(case.calibrated) for case in cases],
        "impact_force": [case.loads.force.max(initial=0.0) for case in cases],
        **drawing_values(
            [study.case.devices[support.device] for support in supports],
            [prepared.devices[support.device] for support in supports],
        ),
        "note": _notes(study),
    }
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "case_hash": study.case.content_hash(),
        "building": study.case.structure.building if study.case.structure else "",
        "shown_direction": "xyz"[study.direction],
        "solver": "reduced" if study.full_error is None else "full",
        "headline": best.label,
    }
    scalars = device_scalars(study)
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))


def mode_ordinates(cases: Sequence[DampedStudy], choice: SpectrumChoice, modes: int) -> Array:
    """The variable `mode_psa` of `device.nc`.

    Args:
        cases: The devices by damping.
        choice: Which analysis; one with rotations has inputs about the axes, too.
        modes: Length of the dimension `mode`; values beyond a device's modes are nan.

    Returns:
        Shape (n_cases, 2, n_devices, 6, n_modes) [m/s2, rad/s2]: of the anchor without the device,
        at the dampings of the modes. Nan where a component of the anchor does not move or is no
        input; 0 where it moves, but not the mode. Of each of several anchors, its own.
    """
    return np.array(
        [
            [[_ordinates(one, choice, modes) for one in load] for load in (c.no_impact, c.impact)]
            for c in cases
        ]
    )


def _ordinates(result: DeviceResult, choice: SpectrumChoice, modes: int) -> Array:
    found = np.full((len(COMPONENTS), modes), np.nan)
    response = result.by_spectrum[choice]
    first = result.support.rows.start
    for one, column in zip(response.inputs, response.columns, strict=True):
        if first <= column < first + len(COMPONENTS):
            found[column - first, : one.ordinate.size] = one.ordinate
    return found


def _notes(study: DeviceStudy) -> list[str]:
    """What the response spectrum analyses assumed, each once."""
    notes = (
        f"{result.name}: {note}"
        for one in study.cases
        for result in (*one.no_impact, *one.impact)
        for analysis in result.by_spectrum.values()
        for note in analysis.notes
    )
    return list(dict.fromkeys(notes))


def _choices(study: DeviceStudy) -> list[SpectrumChoice]:
    """The analyses that were done of any device, in their order."""
    done = (
        choice
        for case in study.cases
        for one in (*case.impact, *case.no_impact)
        for choice in one.by_spectrum
    )
    return list(dict.fromkeys(done))


def _each(study: DeviceStudy, of: Callable[[DeviceResult], Any]) -> Array:
    """A value of each device, shape (n_cases, 2, n_devices, ...)."""
    return np.array(
        [
            [[np.asarray(of(one)) for one in load] for load in (case.no_impact, case.impact)]
            for case in study.cases
        ]
    )


def _modes(study: DeviceStudy) -> dict[str, Array]:
    """Modes of each device, filled up with nan."""
    plans = [study.prepared.plans[support.device] for support in study.supports]
    found = [device_modes(plan.device).below(plan.maximum_frequency) for plan in plans]
    shape = (len(found), max(modes.frequency.size for modes in found))
    frequency, damping = np.full(shape, np.nan), np.full(shape, np.nan)
    mass = np.full((shape[0], len(COMPONENTS), shape[1]), np.nan)
    for k, (modes, support) in enumerate(zip(found, study.supports, strict=True)):
        count = modes.frequency.size
        frequency[k, :count], damping[k, :count] = modes.frequency, modes.damping
        mass[k, :, :count] = modes.effective_mass[support.rows]
    return {"mode_frequency": frequency, "mode_damping": damping, "effective_mass": mass}


def _anchors(study: DeviceStudy) -> dict[str, Any]:
    plates, plans = study.prepared.base_plates, study.prepared.plans
    return {
        "anchor_position": [plate.point for plate in plates],
        "anchor_floor": [plate.floor for plate in plates],
        "anchor_nodes": [1 + len(plate.followers) for plate in plates],
        "anchor_radius": [anchor_radius(study, support) for support in study.supports],
        "weight_force": [own_weight(plans[s.device].device)[s.rows] for s in study.supports],
    }


def _pulls(study: DeviceStudy, choices: list[SpectrumChoice]) -> dict[str, Array]:
    """Net uplift and tension; nan where no weight is known."""
    loads = [(case.no_impact, case.impact) for case in study.cases]

    def each(of: Callable[[Pull], float]) -> Array:
        pulls = [
            [[pull_of(study, k, one) for k, one in enumerate(load)] for load in both]
            for both in loads
        ]
        return np.array(
            [[[of(p) if p.weight > 0.0 else np.nan for p in load] for load in c] for c in pulls]
        )

    tension = [
        [
            [
                [tension_by_spectrum(study, k, one, choice) for choice in choices]
                for k, one in enumerate(load)
            ]
            for load in both
        ]
        for both in loads
    ]
    return {
        "net_uplift": each(lambda pull: pull.uplift),
        "net_tension": each(lambda pull: pull.tension),
        "spectrum_tension": np.array(tension),
    }

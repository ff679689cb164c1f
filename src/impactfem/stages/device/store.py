"""The store of the stage: `device.nc`.

Dimensions: `case` (damping cases, the building's own first), `impact` (without, with), `device`
(each of several anchors of one counts: `pipe_1`, `pipe_2`), `time`, `component` (x, y, z, rx, ry,
rz), `choice` (response spectrum analyses), `frequency` and `mode` (of the devices; values beyond a
device's modes are nan). Forces are those of the device on the floor; accelerations are absolute;
`anchor_acceleration` is that of the anchor without the device. `equipment.drawing` and
`equipment.ordinates` say what else there is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.device.anchor_force import own_weight
from impactfem.device.modes import device_modes
from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.damping_study import DampedStudy, DeviceStudy
from impactfem.stages.device.drawing import drawing_variables
from impactfem.stages.device.scalars import (
    Pull,
    anchor_radius,
    device_scalars,
    headline,
    pull_of,
    tension_by_spectrum,
)
from impactfem.stages.device.spectrum_choice import SpectrumChoice
from impactfem.sticks.element import COMPONENTS
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]


IMPACTS = ["without", "with"]


def ordinate_variables(
    cases: Sequence[DampedStudy], choice: SpectrumChoice, modes: int
) -> Variables:
    """The variable `mode_psa` of `device.nc`.

    Args:
        cases: The devices by damping.
        choice: Which analysis; one with rotations has inputs about the axes, too.
        modes: Length of the dimension `mode`; values beyond a device's modes are nan.

    Returns:
        By name: dimensions, values and attributes. Nan where a component of the anchor does not
        move or is no input; 0 where it moves, but not the mode. Of each of several anchors, its
        own.
    """
    values = [
        [[_of(result, choice, modes) for result in load] for load in (one.no_impact, one.impact)]
        for one in cases
    ]
    note = "rad/s2 for rx, ry, rz; of the anchor without the device, at the dampings of the modes"
    return {
        "mode_psa": (
            ("case", "impact", "device", "component", "mode"),
            np.array(values, dtype=np.float64),
            {"units": "m/s2", "note": note},
        )
    }


def _of(result: DeviceResult, choice: SpectrumChoice, modes: int) -> Array:
    found = np.full((len(COMPONENTS), modes), np.nan)
    response = result.by_spectrum[choice]
    first = result.support.rows.start
    for one, column in zip(response.inputs, response.columns, strict=True):
        if first <= column < first + len(COMPONENTS):
            found[column - first, : one.ordinate.size] = one.ordinate
    return found


def write_devices(path: Path, study: DeviceStudy, key: str) -> None:
    """Write `device.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    cases, prepared = study.cases, study.prepared
    choices = _choices(study)
    best = headline(study)
    turned = replace(best, rotations=True)
    modes = _modes(study)
    names = [support.name for support in study.supports]
    setups = [study.case.devices[support.device] for support in study.supports]
    devices = [prepared.devices[support.device] for support in study.supports]
    dataset = xr.Dataset(
        {
            **_results(study),
            **_analyses(study),
            **modes,
            **_cases(cases),
            **_pulls(study),
            **drawing_variables(setups, devices),
            **ordinate_variables(
                cases,
                turned if turned in choices else best,
                modes["mode_frequency"][1].shape[1],
            ),
        },
        coords={
            "case": ("case", np.array([c.name for c in cases], dtype=object)),
            "impact": IMPACTS,
            "device": ("device", np.array(names, dtype=object)),
            "component": list(COMPONENTS),
            "choice": ("choice", np.array([c.label for c in choices], dtype=object)),
            "frequency": (
                "frequency",
                np.asarray(study.case.spectra.frequency_values),
                {"units": "Hz"},
            ),
            "time": (
                "time",
                prepared.loads.time_step * np.arange(len(prepared.loads.ground)),
                {"units": "s"},
            ),
        },
        attrs={
            "title": study.case.title,
            "inputs": key,
            "case_hash": study.case.content_hash(),
            "building": study.case.structure.building if study.case.structure else "",
            "shown_direction": "xyz"[study.direction],
            "solver": "reduced" if study.full_error is None else "full",
            "headline": best.label,
            "notes": _notes(study),
        },
    )
    write_netcdf(path, with_scalars(dataset, device_scalars(study)))


def _notes(study: DeviceStudy) -> str:
    """What the response spectrum analyses assumed, a line each."""
    return "\n".join(
        dict.fromkeys(
            f"{result.name}: {note}"
            for one in study.cases
            for result in (*one.no_impact, *one.impact)
            for analysis in result.by_spectrum.values()
            for note in analysis.notes
        )
    )


def _choices(study: DeviceStudy) -> list[SpectrumChoice]:
    """The analyses that were done of any device, in their order."""
    done = [
        choice
        for case in study.cases
        for one in (*case.impact, *case.no_impact)
        for choice in one.by_spectrum
    ]
    return list(dict.fromkeys(done))


def _each(study: DeviceStudy, of: Any) -> Array:
    """A value of each device, shape (n_cases, 2, n_devices, ...)."""

    def values(results: tuple[DeviceResult, ...]) -> list[Array]:
        return [np.asarray(of(result)) for result in results]

    return np.array([[values(c.no_impact), values(c.impact)] for c in study.cases])


def _results(study: DeviceStudy) -> Variables:
    dims = ("case", "impact", "device")
    turned = {"units": "N", "note": "N m for rx, ry, rz"}
    moved = {"units": "m/s2", "note": "rad/s2 for rx, ry, rz"}
    force = _each(study, lambda r: r.detailed.force)
    anchor = _each(study, lambda r: r.anchor)
    return {
        # Nothing is read off them that single precision would spoil, and they are most of the file.
        "force": ((*dims, "component", "time"), force.astype(np.float32), turned),
        "anchor_acceleration": ((*dims, "component", "time"), anchor.astype(np.float32), moved),
        "largest_force": ((*dims, "component"), _each(study, lambda r: r.detailed.largest), turned),
        "imbalance": (dims, _each(study, lambda r: r.detailed.imbalance), {"units": "1"}),
        "psa": (
            (*dims, "axis", "frequency"),
            _each(study, lambda r: r.shown),
            {"units": "m/s2", "note": "at the anchor, by the damping of the device's first mode"},
        ),
    }


def _analyses(study: DeviceStudy) -> Variables:
    choices = _choices(study)
    words = [f"force {c}" for c in COMPONENTS[:3]] + [f"moment {c[1]}" for c in COMPONENTS[3:]]

    def values(result: DeviceResult) -> Array:
        return np.array([[result.value(c, word) for word in words] for c in choices])

    return {
        "spectrum_force": (
            ("case", "impact", "device", "choice", "component"),
            _each(study, values),
            {
                "units": "N",
                "note": "N m for rx, ry, rz; by response spectrum analysis; nan where not done",
            },
        )
    }


def _modes(study: DeviceStudy) -> Variables:
    plans = [study.prepared.plans[support.device] for support in study.supports]
    found = [device_modes(plan.device).below(plan.maximum_frequency) for plan in plans]
    most = max(modes.frequency.size for modes in found)

    def padded(rows: list[Array]) -> Array:
        return np.array([np.append(row, np.full(most - len(row), np.nan)) for row in rows])

    variables: Variables = {
        "mode_frequency": (
            ("device", "mode"),
            padded([m.frequency for m in found]),
            {"units": "Hz"},
        ),
        "mode_damping": (("device", "mode"), padded([m.damping for m in found]), {"units": "1"}),
    }
    own = [
        modes.effective_mass[support.rows]
        for modes, support in zip(found, study.supports, strict=True)
    ]
    masses = np.stack([padded([mass[c] for mass in own]) for c in range(6)], axis=1)
    variables["effective_mass"] = (
        ("device", "component", "mode"),
        masses,
        {"units": "kg", "note": "kg m2 for rx, ry, rz"},
    )
    base_plates = study.prepared.base_plates
    variables["anchor_position"] = (
        ("device", "xyz"),
        np.array([one.point for one in base_plates]),
        {"units": "m"},
    )
    variables["anchor_floor"] = ("device", np.array([one.floor for one in base_plates]))
    variables["anchor_nodes"] = (
        "device",
        np.array([1 + len(one.followers) for one in base_plates]),
    )
    return variables


def _pulls(study: DeviceStudy) -> Variables:
    """Weight, radius of the anchors, and net uplift and tension; nan where no weight is known."""
    pulls = [
        [[pull_of(study, k, one) for k, one in enumerate(load)] for load in (c.no_impact, c.impact)]
        for c in study.cases
    ]

    choices = _choices(study)

    def each(of: Callable[[Pull], float]) -> Array:
        return np.array(
            [[[of(p) if p.weight > 0.0 else np.nan for p in load] for load in c] for c in pulls]
        )

    dims = ("case", "impact", "device")
    return {
        "weight_force": (
            ("device", "component"),
            np.array(
                [
                    own_weight(study.prepared.plans[one.device].device)[one.rows]
                    for one in study.supports
                ]
            ),
            {"units": "N", "note": "N m for rx, ry, rz; of the device on the floor by its weight"},
        ),
        "anchor_radius": (
            "device",
            np.array([anchor_radius(study, one) for one in study.supports]),
            {"units": "m"},
        ),
        "net_uplift": (
            dims,
            each(lambda p: p.uplift),
            {"units": "N", "note": "largest force upward less the weight"},
        ),
        "net_tension": (
            dims,
            each(lambda p: p.tension),
            {"units": "N", "note": "n times the pull of the most loaded of n anchors on a circle"},
        ),
        "spectrum_tension": (
            (*dims, "choice"),
            np.array(
                [
                    [
                        [
                            [tension_by_spectrum(study, k, one, choice) for choice in choices]
                            for k, one in enumerate(load)
                        ]
                        for load in (c.no_impact, c.impact)
                    ]
                    for c in study.cases
                ]
            ),
            {"units": "N", "note": "by response spectrum analysis; nan where not done"},
        ),
    }


def _cases(cases: tuple[DampedStudy, ...]) -> Variables:
    epsilon = [np.nan if c.epsilon is None else c.epsilon for c in cases]
    alpha, beta = np.array([[c.damping.alpha, c.damping.beta] for c in cases]).T
    return {
        "mass_coefficient": ("case", alpha, {"units": "1/s"}),
        "stiffness_coefficient": ("case", beta, {"units": "s"}),
        "epsilon": (
            "case",
            np.array(epsilon),
            {"units": "1", "note": "restitution of the contact laws; nan where they keep theirs"},
        ),
        "epsilon_calibrated": ("case", np.array([int(c.calibrated) for c in cases])),
        "impact_force": (
            "case",
            np.array([c.loads.force.max(initial=0.0) for c in cases]),
            {"units": "N", "note": "largest one, as resampled to the steps of the 3D model"},
        ),
    }

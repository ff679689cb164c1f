"""The store of the stage, `device.nc`, and its scalars.

Each of several anchors of a device counts (`pipe_1`, `pipe_2`). Forces are those of the device on
the floor, moments for rx, ry and rz; accelerations are absolute. Analyses are the detailed one, in
the 3D model, and the response spectrum analyses (RSA), with their choices as labels.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case.damping import OWN
from impactfem.spectra.resolved import ZPA, ResolvedBand, band_limited_zpa
from impactfem.stages.device.analysis import DeviceResult, supports_of
from impactfem.stages.device.anchor import Anchor, anchor_of_device
from impactfem.stages.device.choice import SpectrumChoice, headline_of
from impactfem.stages.device.compute import DampedStudy, DeviceStudy, Prepared
from impactfem.stages.device.selection import (
    DETAILED,
    FLAGS,
    IN_NAMES,
    LABELS,
    LOADS,
    WITH,
    headline,
    rigid_variants,
    scalar_start,
)
from impactfem.stages.results import outputs, scalars, value, values
from impactfem.stages.stores import (
    Output,
    damping_outputs,
    damping_values,
    dataset,
    names_of,
    padded,
)
from impactfem.sticks.element import COMPONENTS
from impactfem.system.arrays import Array
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

_LOAD = "case impact device"
OUTPUTS = {
    "case": Output("case", "", "damping of the buildings, their own first"),
    "impact": Output("impact"),
    "device": Output("device"),
    "analysis": Output("analysis", "", "detailed, and response spectrum analyses"),
    **{name: Output("analysis", label=True) for name in (*LABELS, *FLAGS)},
    "component": Output("component"),
    "axis": Output("axis"),
    "xyz": Output("xyz"),
    "bending_about": Output("bending_about"),
    "mode": Output("mode", "", "number of a mode of a device"),
    "time": Output("time", "s"),
    "frequency": Output("frequency", "Hz"),
    **outputs(DeviceResult, _LOAD),
    "peak_force": Output(
        f"{_LOAD} analysis component", "N, N m", "largest force on the floor, nan if not computed"
    ),
    "relative_difference": Output(
        f"{_LOAD} analysis", "-", "(detailed - RSA) / detailed, along the shown direction"
    ),
    "net_uplift": Output(f"{_LOAD} analysis", "N", "largest force upward less the weight"),
    "net_tension": Output(
        f"{_LOAD} analysis", "N", "n times the tension of the most highly loaded of n anchors"
    ),
    "mode_psa": Output(f"{_LOAD} component mode", "m/s2, rad/s2", "ordinates of the modes"),
    **outputs(Anchor, "device"),
    **damping_outputs("case"),
    **outputs(DampedStudy, "case"),
    "zpa": Output(f"{_LOAD} axis", "m/s2", ZPA),
    **outputs(DeviceStudy),
    **outputs(ResolvedBand),
    "note": Output("note", "", "assumptions of the response spectrum analyses"),
}


def write_devices(path: Path, study: DeviceStudy, key: str, contact: float) -> None:
    """Write the results of the stage into `device.nc`, with the hash of its inputs.

    The limit of the contact law on the resolved band is given [Hz]. ImpactfemError where the file
    cannot be written.
    """
    building, prepared, band = study.prepared.building, study.prepared, study.band(contact)
    case = building.case
    anchors = _anchors(prepared)
    frequency = np.asarray(case.spectra.frequency_values)
    choice = headline_of(prepared.plans[0].rules)
    store = dataset(
        OUTPUTS,
        {
            "case": [one.name for one in study.cases],
            "impact": list(LOADS),
            "device": [one.name for one in study.supports],
            "component": COMPONENTS,
            "axis": ["x", "y", "z"],
            "xyz": ["x", "y", "z"],
            "bending_about": ["x", "y"],
            "time": prepared.loads.time_step * np.arange(len(prepared.loads.ground)),
            "frequency": frequency,
            **filled(values(Anchor, anchors)),
            **values(DeviceResult, (one.results for one in study.cases)),
            **_of_analyses(study, anchors, choice),
            **damping_values([one.damping for one in study.cases]),
            **values(DampedStudy, study.cases),
            **value(study),
            **value(band),
            "zpa": [
                [_zpa(load, prepared.loads.time_step, band.frequency) for load in one.results]
                for one in study.cases
            ],
        },
        attributes={
            "title": case.title,
            "inputs": key,
            "case_hash": case.content_hash(),
            "building": building.name,
            "shown_direction": case.shown_direction,
            **band.attributes,
            "headline": choice.label,
        },
    )
    write_netcdf(path, with_scalars(store, device_scalars(store)))


def results_in_time(prepared: Prepared, results: Sequence[DeviceResult], end: float) -> xr.Dataset:
    """Return the results of `device.nc` that verdicts read, with impacts and the own damping.

    The results have no response spectrum analyses; `end` is that of the resolved band [Hz].
    """
    anchors, step = _anchors(prepared), prepared.loads.time_step
    pulls = [
        at.pulls(one.detailed.force, one.peaks(()))
        for one, at in zip(results, anchors, strict=True)
    ]
    content = {
        "case": [OWN],
        "impact": [WITH],
        "device": [one.support.name for one in results],
        "analysis": [DETAILED],
        "component": COMPONENTS,
        "axis": ["x", "y", "z"],
        "time": step * np.arange(len(prepared.loads.ground)),
        "frequency": np.asarray(prepared.building.case.spectra.frequency_values),
        **filled(values(Anchor, anchors)),
        **values(DeviceResult, [[list(results)]]),
        "net_tension": [[[pull[1] for pull in pulls]]],
        "zpa": [[_zpa(results, step, end)]],
    }
    about = {"building": prepared.building.name, "resolved_frequency": end}
    return dataset(OUTPUTS, content, attributes=about)


def _anchors(prepared: Prepared) -> list[Anchor]:
    """Return the anchors of all devices."""
    setups = prepared.building.devices
    return [
        anchor_of_device(one, setups[one.device], prepared.plans[one.device].device, plate)
        for one, plate in zip(supports_of(prepared.plans), prepared.base_plates, strict=True)
    ]


def _zpa(results: Sequence[DeviceResult], step: float, end: float) -> Array:
    """Return the ZPA of each anchor along x, y, z up to a frequency, shape (n_anchors, 3)."""
    motions = np.array([one.anchor_acceleration[:3].T for one in results], dtype=np.float64)
    return band_limited_zpa(np.moveaxis(motions, 1, 0), step, end)


def filled(columns: dict[str, list[Any]]) -> dict[str, Any]:
    """Fill up arrays of unequal sizes with nan."""
    return {
        name: padded(column) if np.ndim(column[0]) else column for name, column in columns.items()
    }


def _of_analyses(
    study: DeviceStudy, anchors: Sequence[Anchor], choice: SpectrumChoice
) -> dict[str, Any]:
    """Return what the analyses give, by variable, with their labels."""
    every, axis = study.analyses, "xyz".index(study.prepared.building.case.shown_direction)
    choices = list(dict.fromkeys(choice for _, choice, _ in every))
    turned, modes = replace(choice, rotations=True), max(len(one.mode_mass) for one in anchors)
    shown = turned if turned in choices else choice

    def each(of: Callable[[DeviceResult, Anchor], Any]) -> Array:
        """Return values of all results, shape (n_cases, 2, n_devices, ...)."""
        loads = [[zip(load, anchors, strict=True) for load in one.results] for one in study.cases]
        return np.array([[[of(*pair) for pair in pairs] for pairs in two] for two in loads])

    peaks = each(lambda result, _: result.peaks(choices))
    pulls = each(lambda result, at: at.pulls(result.detailed.force, result.peaks(choices)))
    notes = [f"{name}: {note}" for name, _, one in every for note in one.notes]
    return {
        **labels_of(choices),
        "mode": np.arange(1, modes + 1),
        "peak_force": peaks,
        "relative_difference": differences(peaks[..., axis]),
        "net_uplift": pulls[..., 0, :],
        "net_tension": pulls[..., 1, :],
        "mode_psa": each(lambda result, _: result.ordinates(shown, modes)),
        "note": list(dict.fromkeys(notes)),
    }


def labels_of(choices: Sequence[SpectrumChoice]) -> dict[str, list[Any]]:
    """Return the analyses with their labels: the detailed one, then those by spectra."""
    return {
        "analysis": [DETAILED, *(one.label for one in choices)],
        **{name: ["", *(getattr(one, name) or "" for one in choices)] for name in LABELS},
        **{name: [False, *(getattr(one, name) for one in choices)] for name in FLAGS},
    }


def differences(force: Array) -> Array:
    """Return (detailed - RSA) / detailed of forces along a last axis with the detailed one first.

    Nan for the detailed force, and for all if it is zero.
    """
    detailed = np.where(force[..., :1] > 0.0, force[..., :1], np.nan)
    found = np.asarray(1.0 - force / detailed, dtype=np.float64)
    found[..., 0] = np.nan
    return found


def device_scalars(store: xr.Dataset) -> list[Scalar]:
    """Return the scalars of the stage: of each anchor modes, forces, spectra and net tension.

    Those of further damping cases are details. Names of further anchors than the first hold their
    name.
    """
    axis = str(store.attrs["shown_direction"])
    analyses = {DETAILED: DETAILED, headline(store): "rsa"}
    analyses |= {name: f"rsa_{rigid}" for rigid, name in rigid_variants(store).items()}
    renamed = {
        "analysis": [name.replace("-", "_") for name in analyses.values()],
        "impact": [IN_NAMES[impact] for impact in names_of(store, "impact")],
    }
    view = store.sel(analysis=list(analyses), axis=axis).assign_coords(renamed)
    found: list[Scalar] = []
    for device in names_of(store, "device"):
        start, of = scalar_start(store, device), view.sel(device=device)
        modes = of.isel(mode=np.isfinite(of["mode_frequency"].values))
        found += scalars(modes, f"{start}.frequency.{{mode}}", "mode_frequency")
        found += scalars(modes, f"{start}.effective_mass.{{mode}}", "mode_mass")
        own, further = of.isel(case=0), of.isel(case=slice(1, None))
        detailed = own.sel(analysis=DETAILED)
        found += scalars(detailed, f"{start}.{{variable}}", "weight")
        found += scalars(detailed, f"{start}.{{variable}}.{{impact}}", "net_uplift net_tension pfa")
        for one, end in ((own, "{impact}"), (further, "{impact}.{case}")):
            peaks, rsa = one.sel(component=axis), one.sel(analysis="rsa")
            for some, name, variables in (
                (peaks, f"f{axis}.{{analysis}}", "peak_force"),
                (rsa, "{variable}", "relative_difference"),
                (one, "frs.{variable}", "peak=psa_peak peak_frequency=psa_peak_frequency"),
            ):
                pattern = f"{start}.{name}.{end}"
                found += scalars(some, pattern, variables, detail=one is further)
    return [scalar for scalar in found if scalar.value is not None]

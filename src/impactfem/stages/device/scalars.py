"""The scalar results of the stage `device`, by the names of `summary.json`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import xarray as xr

from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.compute import DeviceStudy
from impactfem.stages.device.spectrum_plan import SpectrumPlan, headline_of
from impactfem.system.scalar import Scalar

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Words for the forces and moments of the components x to rz."""


def device_scalars(study: DeviceStudy, store: xr.Dataset) -> list[Scalar]:
    """All scalars of the stage, from its results and its store.

    Names of further anchors than the first hold their name.
    """
    scalars = [
        Scalar("device.basis_vectors", float(len(study.model.eigenvalue)), "-"),
        Scalar("device.basis_error", study.model.difference, "-", "transfer functions"),
    ]
    if study.full_error is not None:
        note = "peak force on an anchor, of the reduced model from the full order"
        scalars.append(Scalar("device.reduced_against_full", study.full_error, "-", note))
    for k, support in enumerate(study.supports):
        name = "device" if k == 0 else f"device.{support.name}"
        of, plate = store.isel(device=k), study.prepared.base_plates[k]
        note = f"{support.name}, floor {plate.floor}, at node {plate.master}"
        scalars.append(Scalar(f"{name}.anchor_nodes", float(of["anchor_nodes"]), "-", note))
        # Effective masses are along the direction that a mode moves most.
        mass = of["effective_mass"].values[:3]
        for mode in np.flatnonzero(np.isfinite(of["mode_frequency"].values)):
            axis = int(mass[:, mode].argmax())
            frequency, damping = of["mode_frequency"][mode], of["mode_damping"][mode]
            note, most = f"along {'xyz'[axis]}", float(mass[axis, mode])
            scalars += [
                Scalar(f"{name}.frequency.{mode + 1}", float(frequency), "Hz"),
                Scalar(f"{name}.effective_mass.{mode + 1}", most, "kg", note),
                Scalar(f"{name}.damping.{mode + 1}", float(damping), "-"),
            ]
        weight = -float(of["weight_force"].sel(component="z"))
        scalars.append(Scalar(f"{name}.weight", weight, "N", "that this anchor carries"))
        plan = study.prepared.plans[support.device]
        for c, one in enumerate(study.cases):
            for i, load in enumerate(("no_impact", "impact")):
                end = f"{load}.{one.name}" if c else load
                found = load_scalars(of.isel(case=c, impact=i), plan, one.results[i][k])
                scalars += [replace(each, name=f"{name}.{each.name}.{end}") for each in found]
    for c, one in enumerate(study.cases[1:], 1):
        if one.epsilon is not None:
            note = "calibrated, by the impact on the wall" if one.calibrated else "given"
            scalars.append(Scalar(f"device.epsilon.{one.name}", one.epsilon, "-", note))
        note = "largest impact force of the sticks, as resampled to the steps of the 3D model"
        peak = float(store["impact_force"][c])
        scalars.append(Scalar(f"device.impact_force.{one.name}", peak, "N", note))
    return scalars


def load_scalars(of: xr.Dataset, plan: SpectrumPlan, result: DeviceResult) -> list[Scalar]:
    """The scalars of one device under one load with one damping, by what they are.

    Args:
        of: The store of this device, load and damping.
        plan: Its analyses.
        result: The same for what the store does not have.
    """
    axis = str(of.attrs["shown_direction"])
    c, choice = "xyz".index(axis), headline_of(plan.rules)
    words = {
        "rotations": replace(choice, rotations=True),
        "envelope": replace(choice, source="envelope"),
        "envelope_dampings": replace(choice, source="envelope-dampings"),
        "given": replace(choice, source="given"),
    }
    words |= {
        rigid.replace("-", "_"): replace(choice, rigid=rigid)
        for combination, rigid in plan.rules
        if combination == choice.combination and rigid != choice.rigid
    }
    largest = of["largest_force"].values.tolist()
    rsa = of["spectrum_force"].sel(choice=choice.label).values.tolist()
    difference = 1.0 - rsa[c] / largest[c] if largest[c] > 0.0 else None
    scalars = [
        Scalar(f"f{axis}.detailed", largest[c], "N"),
        Scalar(f"f{axis}.rsa", rsa[c], "N", choice.label),
        Scalar(
            "relative_difference",
            difference,
            "-",
            "of the response spectrum analysis from the detailed one, over the latter",
        ),
    ]
    for word, other in words.items():
        if other in result.by_spectrum:
            value = float(of["spectrum_force"].sel(choice=other.label)[c])
            scalars.append(Scalar(f"f{axis}.rsa_{word}", value, "N", other.label))
    if choice in result.by_spectrum:
        response = result.by_spectrum[choice]
        q = response.quantities.names.index(result.support.quantity(f"force {axis}"))
        inputs = [one for one in response.inputs if one.spectrum.component == axis]
        summed = float(abs(sum(one.modal[q].sum() + one.missing[q] for one in inputs)))
        note = f"modes and missing mass by the spectra along {axis}, added with their signs"
        scalars.append(Scalar(f"f{axis}.algebraic", summed, "N", note))
    for k, word in enumerate(COMPONENTS):
        if k != c:
            unit = "N" if k < 3 else "N m"
            scalars.append(Scalar(f"{word}.detailed", largest[k], unit))
            scalars.append(Scalar(f"{word}.rsa", rsa[k], unit, choice.label))
    circle = f"on a circle of {float(of['anchor_radius']):g} m, less the weight"
    for name, note in (
        ("net_uplift", "largest force upward less the weight"),
        ("net_tension", f"n times the pull of the most loaded of n anchors {circle}"),
    ):
        value = float(of[name])
        if not math.isfinite(value):
            note += "; the weight is not known: none of its modes moves along z"
        scalars.append(Scalar(name, value if math.isfinite(value) else None, "N", note))
    psa = of["psa"].sel(axis=axis)
    note = f"floor at the anchor along {axis}, without the device, damping of its first mode"
    return [
        *scalars,
        Scalar("pfa", float(abs(result.anchor[c]).max()), "m/s2"),
        Scalar("frs.peak", float(psa.max()), "m/s2", note),
        Scalar("frs.peak_frequency", float(psa.idxmax("frequency")), "Hz", note),
    ]

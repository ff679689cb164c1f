"""The store of the stage: `device.nc`.

Each of several anchors of a device counts (`pipe_1`, `pipe_2`). Forces are those of the device on
the floor, moments for rx, ry and rz; accelerations are absolute.

Figures of a device show its springs, beam and body, and its modes over the height: a point at the
height z of a device on springs moves, relative to its anchor, by

    u(z) = R(z) E s + d(z)                                                                 (1)

with the own coordinates x = (s, d): the free motions s of the base, which a rigid link R(z) takes
there, and what the beam deforms by, d. Above the beam the body is rigid.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case import DeviceSetup
from impactfem.case.devices import RIGID
from impactfem.device.anchor_force import own_weight, ring_tension
from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.device.parts import solid_cylinder
from impactfem.stages.check import resolved_frequency
from impactfem.stages.device.analysis import DeviceResult, SpectrumPlan, headline_of
from impactfem.stages.device.compute import DampedStudy, DeviceStudy
from impactfem.stages.stores import Output, damping_outputs, damping_values, dataset, padded
from impactfem.stages.transient.prepared import transient_of
from impactfem.sticks.element import COMPONENTS, rigid_link
from impactfem.system.arrays import Array
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

TOUCH = 1e-9
"""Heights that differ by less are the same [m]."""
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
    **damping_outputs("case"),
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
    """Write the results of the stage into `device.nc`, with the hash of its inputs.

    ImpactfemError where the file cannot be written.
    """
    case, cases, prepared, supports = study.case, study.cases, study.prepared, study.supports
    plates, plans = prepared.base_plates, [prepared.plans[one.device] for one in supports]
    setups = [case.devices[one.device] for one in supports]
    every = [
        (result.support.name, choice, analysis)
        for one in cases
        for result in (*one.results[1], *one.results[0])
        for choice, analysis in result.by_spectrum.items()
    ]
    choices = list(dict.fromkeys(choice for _, choice, _ in every))
    best = headline_of(plans[0].rules)
    turned = replace(best, rotations=True)
    shown = turned if turned in choices else best
    modes = _modes(study)
    count = modes["mode_frequency"].shape[1]
    force = _each(cases, lambda one: one.detailed.force)
    by_spectrum = _each(cases, lambda one: [one.values(choice) for choice in choices])
    weight = np.array(
        [own_weight(plan.device)[one.rows] for plan, one in zip(plans, supports, strict=True)]
    )
    radius = np.array(
        [setup.anchors[one.number - 1].radius for setup, one in zip(setups, supports, strict=True)]
    )
    values = {
        "case": [one.name for one in cases],
        "impact": ["without", "with"],
        "device": [one.name for one in supports],
        "component": COMPONENTS,
        "axis": ["x", "y", "z"],
        "xyz": ["x", "y", "z"],
        "bending_about": ["x", "y"],
        "choice": [choice.label for choice in choices],
        "mode": np.arange(1, count + 1),
        "time": prepared.loads.time_step * np.arange(len(prepared.loads.ground)),
        "frequency": case.spectra.frequency_values,
        # Nothing is read off them that single precision would spoil, and they are most of the file.
        "force": force.astype(np.float32),
        "anchor_acceleration": _each(cases, lambda one: one.anchor).astype(np.float32),
        "largest_force": _each(cases, lambda one: one.detailed.largest),
        "imbalance": _each(cases, lambda one: one.detailed.imbalance),
        "psa": _each(cases, lambda one: one.shown),
        "spectrum_force": by_spectrum,
        "mode_psa": _each(cases, lambda one: one.ordinates(shown, count)),
        **modes,
        "anchor_position": [plate.point for plate in plates],
        "anchor_floor": [plate.floor for plate in plates],
        "anchor_nodes": [1 + len(plate.followers) for plate in plates],
        "anchor_radius": radius,
        "weight_force": weight,
        **pulls(force, by_spectrum, weight, radius),
        **damping_values([one.damping for one in cases]),
        "epsilon": [np.nan if one.epsilon is None else one.epsilon for one in cases],
        "epsilon_calibrated": [int(one.calibrated) for one in cases],
        "impact_force": [one.loads.impact_force.max(initial=0.0) for one in cases],
        **drawing_values(setups, [plan.device for plan in plans]),
        # What the response spectrum analyses assumed, each once.
        "note": list(
            dict.fromkeys(f"{name}: {note}" for name, _, one in every for note in one.notes)
        ),
    }
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "building": case.structure.building if case.structure else "",
        "shown_direction": case.shown_direction,
        "resolved_frequency": resolved_frequency(
            prepared.loads.time_step,
            min(transient_of(case).maximum_frequency, float(case.spectra.frequency_values[-1])),
        ),
        "headline": best.label,
    }
    store = dataset(OUTPUTS, values, attributes=attributes)
    write_netcdf(path, with_scalars(store, device_scalars(study, store)))


def pulls(force: Array, by_spectrum: Array, weight: Array, radius: Array) -> dict[str, Array]:
    """Net uplift and tension (:func:`impactfem.device.anchor_force.ring_tension`) by name.

    From forces on the floor over time, shape (n_cases, 2, n_devices, 6, n_t), largest ones by
    spectrum, shape (n_cases, 2, n_devices, n_choices, 6), and by the weight alone, shape
    (n_devices, 6) [N, N m], on circles of a radius, shape (n_devices,) [m]; nan where no weight is
    known, or an analysis was not done.
    """
    whole, r = force + weight[..., None], radius[:, None]
    tension = ring_tension(np.moveaxis(whole, -2, 0), r).max(axis=-1)
    # Of a response spectrum analysis all largest values are at one instant: what has no sign adds
    # to the moments that the weight has itself.
    most = by_spectrum + np.abs(weight)[:, None]
    most[..., 2] += 2.0 * weight[:, None, 2]
    known = weight[:, 2] < 0.0
    return {
        "net_uplift": np.where(known, whole[..., 2, :].max(axis=-1), np.nan),
        "net_tension": np.where(known, tension, np.nan),
        "spectrum_tension": np.where(
            known[:, None], ring_tension(np.moveaxis(most, -1, 0), r), np.nan
        ),
    }


def _each(cases: Sequence[DampedStudy], of: Callable[[DeviceResult], Any]) -> Array:
    """A value of each device, shape (n_cases, 2, n_devices, ...)."""
    return np.array([[[of(result) for result in load] for load in one.results] for one in cases])


def _modes(study: DeviceStudy) -> dict[str, Array]:
    """Modes of each device, filled up with nan."""
    plans = [study.prepared.plans[support.device] for support in study.supports]
    found = [device_modes(plan.device).below(plan.maximum_frequency) for plan in plans]
    mass = [m.effective_mass[one.rows] for m, one in zip(found, study.supports, strict=True)]
    return {
        "mode_frequency": padded([modes.frequency for modes in found]),
        "mode_damping": padded([modes.damping for modes in found]),
        "effective_mass": padded(mass),
    }


def drawing_values(setups: Sequence[DeviceSetup], devices: Sequence[Device]) -> dict[str, Array]:
    """Variables of `device.nc` that figures of the devices need, by name.

    Nan for a device from modes; a rigid spring has an infinite stiffness.
    """
    rows: list[dict[str, Any]] = []  # None for what a device has not
    for setup in setups:
        shape, beam, springs = setup.shape, setup.beam, setup.stiffness
        # In addition to modes a body is that of the whole device.
        on_springs = setup.modes is None
        inertia = setup.inertia
        if setup.mass is not None and shape is not None:
            inertia = solid_cylinder(setup.mass, shape.radius, shape.length)
        stiffness = [None if springs is None else getattr(springs, name) for name in COMPONENTS]
        rows.append(
            {
                "base_stiffness": [math.inf if value == RIGID else value for value in stiffness],
                "body_mass": setup.mass if on_springs else None,
                "body_height": setup.mass_height if on_springs else None,
                "body_inertia": (on_springs and inertia) or (None,) * 3,
                "body_radius": shape and shape.radius,
                "body_length": shape and shape.length,
                "beam_length": beam and beam.length,
                "beam_mass": beam and beam.mass,
                "beam_bending": beam.bending if beam else (None,) * 2,
            }
        )
    values = {name: np.array([row[name] for row in rows], dtype=np.float64) for name in rows[0]}
    # Modes over the height, with nan where a device has fewer modes or levels than others.
    levels, shapes = [_levels(setup) for setup in setups], []
    for setup, device, heights in zip(setups, devices, levels, strict=True):
        count = device_modes(device).below(setup.maximum_frequency).frequency.size
        shapes.append(mode_shapes(setup, device) if len(heights) else np.zeros((count, 0, 6)))
    return values | {"level_height": padded(levels), "mode_shape": padded(shapes)}


def mode_shapes(setup: DeviceSetup, device: Device) -> Array:
    """Modes of a device on springs over its height, equation (1).

    Translations and rotations relative to the anchor, shape (n_modes, n_levels, 6) [1/√kg].
    """
    shape = device_modes(device).below(setup.maximum_frequency).shape
    heights, elements = _levels(setup), 0 if setup.beam is None else setup.beam.elements
    s, d = np.zeros((6, shape.shape[1])), np.zeros((len(heights), 6, shape.shape[1]))
    free = sum(motion.startswith("base ") for motion in device.motions)
    each = (len(shape) - free) // max(elements, 1)
    for row, motion in enumerate(device.motions):
        component = COMPONENTS.index(motion.split()[-1])
        if row < free:
            s[component] = shape[row]
        else:
            d[1 + (row - free) // each, component] = shape[row]
    if len(heights) > elements + 1:
        # The body's mass centre, on a rigid link above the last node.
        d[-1] = rigid_link(np.array([0.0, 0.0, heights[-1] - heights[-2]])) @ d[-2]
    u = [rigid_link(np.array([0.0, 0.0, z])) @ s + bent for z, bent in zip(heights, d, strict=True)]
    return np.asarray(np.moveaxis(np.array(u), 2, 0), dtype=np.float64)


def _levels(setup: DeviceSetup) -> Array:
    """Heights of the beam's nodes or of the base, then of the mass centre if it is none of them."""
    if setup.modes is not None or setup.mass_height is None:
        return np.zeros(0)
    beam = setup.beam
    heights: Array = np.zeros(1)
    if beam is not None:
        heights = np.asarray(np.linspace(0.0, beam.length, beam.elements + 1), dtype=np.float64)
    if abs(heights[-1] - setup.mass_height) > TOUCH:
        heights = np.append(heights, setup.mass_height)
    return heights


def device_scalars(study: DeviceStudy, store: xr.Dataset) -> list[Scalar]:
    """All scalars of the stage, from its results and its store.

    Names of further anchors than the first hold their name.
    """
    scalars = [
        Scalar("device.basis_vectors", float(len(study.model.eigenvalue)), "-"),
        Scalar("device.basis_error", study.model.difference, "-", "transfer functions"),
    ]
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
        note = "largest impact force, as resampled to the steps of the 3D model"
        peak = float(store["impact_force"][c])
        scalars.append(Scalar(f"device.impact_force.{one.name}", peak, "N", note))
    return scalars


def load_scalars(of: xr.Dataset, plan: SpectrumPlan, result: DeviceResult) -> list[Scalar]:
    """The scalars of one device under one load with one damping, by what they are.

    From the store of this device, load and damping, and from its result what the store lacks.
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
    note = "of the response spectrum analysis from the detailed one, over the latter"
    scalars = [
        Scalar(f"f{axis}.detailed", largest[c], "N"),
        Scalar(f"f{axis}.rsa", rsa[c], "N", choice.label),
        Scalar("relative_difference", difference, "-", note),
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
    for k, word in enumerate(("fx", "fy", "fz", "mx", "my", "mz")):
        if k != c:
            unit = "N" if k < 3 else "N m"
            scalars.append(Scalar(f"{word}.detailed", largest[k], unit))
            scalars.append(Scalar(f"{word}.rsa", rsa[k], unit, choice.label))
    circle = f"on a circle of radius {float(of['anchor_radius']):g} m, less the weight"
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

"""The scalar results of the stage `device`, by the names of `summary.json`."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from impactfem.device.anchor_force import own_weight, ring_tension
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.device.spectrum_analysis import SpectrumResponse
from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.damping_study import DampedStudy, DeviceStudy
from impactfem.stages.device.spectrum_choice import SpectrumChoice, headline_of
from impactfem.stages.device.support import Support
from impactfem.system.scalar import Scalar


def device_scalars(study: DeviceStudy) -> list[Scalar]:
    """All scalars of the stage; names of further anchors than the first hold their name."""
    scalars = [
        Scalar("device.basis_vectors", float(len(study.model.eigenvalue)), "-"),
        Scalar("device.basis_error", study.model.difference, "-", "transfer functions"),
    ]
    if study.full_error is not None:
        note = "peak force on an anchor, of the reduced model from the full order"
        scalars.append(Scalar("device.reduced_against_full", study.full_error, "-", note))
    for k, support in enumerate(study.supports):
        name = "device" if k == 0 else f"device.{support.name}"
        plan = study.prepared.plans[support.device]
        modes = device_modes(plan.device).below(plan.maximum_frequency)
        base_plate = study.prepared.base_plates[k]
        note = f"{support.name}, floor {base_plate.floor}, at node {base_plate.master}"
        scalars.append(Scalar(f"{name}.anchor_nodes", 1.0 + len(base_plate.followers), "-", note))
        scalars += _modes(name, modes, support)
        weight = float(-own_weight(plan.device)[support.rows][2])
        scalars.append(Scalar(f"{name}.weight", weight, "N", "that this anchor carries"))
        for one in study.cases:
            suffix = "" if one is study.cases[0] else f".{one.name}"
            scalars += _forces(study, name, suffix, one, k)
    for one in study.cases[1:]:
        if one.epsilon is not None:
            note = "calibrated, on the reduced model of this stage" if one.calibrated else "given"
            scalars.append(Scalar(f"device.epsilon.{one.name}", one.epsilon, "-", note))
        peak = float(one.loads.force.max(initial=0.0))
        note = "largest impact force of the sticks, as resampled to the steps of the 3D model"
        scalars.append(Scalar(f"device.impact_force.{one.name}", peak, "N", note))
    return scalars


def headline(study: DeviceStudy) -> SpectrumChoice:
    """The response spectrum analysis as the paper does it: translations, spectra as computed."""
    return headline_of(study.prepared.plans[0].rules)


def _modes(name: str, modes: DeviceModes, support: Support) -> list[Scalar]:
    """Frequencies and effective masses along the direction that each mode moves most."""
    scalars = []
    for k, frequency in enumerate(modes.frequency, 1):
        mass = modes.effective_mass[support.rows][:3, k - 1]
        axis = int(mass.argmax())
        scalars += [
            Scalar(f"{name}.frequency.{k}", float(frequency), "Hz"),
            Scalar(f"{name}.effective_mass.{k}", float(mass[axis]), "kg", f"along {'xyz'[axis]}"),
            Scalar(f"{name}.damping.{k}", float(modes.damping[k - 1]), "-"),
        ]
    return scalars


WORDS = tuple(f"{word} {axis}" for word in ("force", "moment") for axis in "xyz")
"""Quantities of a response spectrum analysis, of the components x to rz."""


@dataclass(frozen=True)
class Pull:
    """How a device pulls at one of its anchors, its weight included.

    Args:
        weight: Its weight there, downward [N]; zero where it is not known.
        uplift: Largest force upward less the weight [N]: above zero all of the base is lifted.
        tension: Largest T of `ring_tension` [N]: above zero one of the anchors is pulled.
    """

    weight: float
    uplift: float
    tension: float


def pull_of(study: DeviceStudy, k: int, result: DeviceResult) -> Pull:
    """How the device of support k pulls at it in the detailed analysis."""
    support = study.supports[k]
    own = own_weight(study.prepared.plans[support.device].device)[support.rows]
    force = result.detailed.force + own[:, None]
    return Pull(
        weight=float(-own[2]),
        uplift=float(force[2].max()),
        tension=float(ring_tension(force, anchor_radius(study, support)).max()),
    )


def tension_by_spectrum(
    study: DeviceStudy, k: int, result: DeviceResult, choice: SpectrumChoice
) -> float:
    """T of `ring_tension` by a response spectrum analysis, its largest values at one instant [N].

    Nan where the analysis was not done, or the weight is not known.
    """
    support = study.supports[k]
    own = own_weight(study.prepared.plans[support.device].device)[support.rows]
    if not own[2] < 0.0:
        return math.nan
    # What has no sign adds to the moments that the weight has itself.
    force = np.array([result.value(choice, word) for word in WORDS]) + np.abs(own)
    force[2] += 2.0 * own[2]
    return float(ring_tension(force, anchor_radius(study, support)))


def anchor_radius(study: DeviceStudy, support: Support) -> float:
    """Radius of the circle that the anchors of a support stand on [m]."""
    return study.case.devices[support.device].anchors[support.number - 1].radius


def _forces(study: DeviceStudy, name: str, suffix: str, one: DampedStudy, k: int) -> list[Scalar]:
    c = study.direction
    axis = "xyz"[c]
    plan = study.prepared.plans[study.supports[k].device]
    choice = headline_of(plan.rules)
    further = {
        "rotations": replace(choice, rotations=True),
        "envelope": replace(choice, source="envelope"),
        "envelope_dampings": replace(choice, source="envelope-dampings"),
        "given": replace(choice, source="given"),
    }
    for combination, rigid in plan.rules:
        if combination == choice.combination and rigid != choice.rigid:
            further[rigid.replace("-", "_")] = replace(choice, rigid=rigid)
    scalars = []
    for impacts, found in (("no_impact", one.no_impact[k]), ("impact", one.impact[k])):
        end = f"{impacts}{suffix}"
        detailed = float(found.detailed.largest[c])
        by_spectrum = found.value(choice, f"force {axis}")
        scalars += [
            Scalar(f"{name}.f{axis}.detailed.{end}", detailed, "N"),
            Scalar(f"{name}.f{axis}.rsa.{end}", by_spectrum, "N", choice.label),
            Scalar(
                f"{name}.relative_difference.{end}",
                1.0 - by_spectrum / detailed if detailed > 0.0 else None,
                "-",
                "of the response spectrum analysis from the detailed one, over the latter",
            ),
        ]
        scalars += [
            Scalar(
                f"{name}.f{axis}.rsa_{word}.{end}",
                found.value(other, f"force {axis}"),
                "N",
                other.label,
            )
            for word, other in further.items()
            if other in found.by_spectrum
        ]
        if choice in found.by_spectrum:
            summed = with_signs(found.by_spectrum[choice], axis, found.support)
            note = f"modes and missing mass by the spectra along {axis}, added with their signs"
            scalars.append(Scalar(f"{name}.f{axis}.algebraic.{end}", summed, "N", note))
        scalars += _other_components(name, end, found, choice, c)
        scalars += _pull(name, end, pull_of(study, k, found), anchor_radius(study, found.support))
        frequency, psa = study.case.spectra.frequency_values, found.shown[c]
        note = f"floor at the anchor along {axis}, without the device, damping of its first mode"
        scalars += [
            Scalar(f"{name}.pfa.{end}", float(abs(found.anchor[c]).max()), "m/s2"),
            Scalar(f"{name}.frs.peak.{end}", float(psa.max()), "m/s2", note),
            Scalar(f"{name}.frs.peak_frequency.{end}", float(frequency[psa.argmax()]), "Hz", note),
        ]
    return scalars


def with_signs(response: SpectrumResponse, axis: str, support: Support) -> float:
    """Force at a support by the spectra along it, modes and missing mass with their signs [N]."""
    q = response.quantities.names.index(support.quantity(f"force {axis}"))
    inputs = [one for one in response.inputs if one.spectrum.component == axis]
    return float(abs(sum(one.modal[q].sum() + one.missing[q] for one in inputs)))


def _other_components(
    name: str, end: str, found: DeviceResult, choice: SpectrumChoice, shown: int
) -> list[Scalar]:
    """Forces and moments but that along the shown direction, by both analyses."""
    scalars = []
    for i, word in enumerate(WORDS):
        if i == shown:
            continue
        unit = "N" if i < 3 else "N m"
        start = f"{name}.{word[0]}{word[-1]}"
        by_spectrum = found.value(choice, word)
        scalars += [
            Scalar(f"{start}.detailed.{end}", float(found.detailed.largest[i]), unit),
            Scalar(f"{start}.rsa.{end}", by_spectrum, unit, choice.label),
        ]
    return scalars


def _pull(name: str, end: str, pull: Pull, radius: float) -> list[Scalar]:
    known = pull.weight > 0.0
    unknown = "" if known else "; the weight is not known: none of its modes moves along z"
    return [
        Scalar(
            f"{name}.net_uplift.{end}",
            pull.uplift if known else None,
            "N",
            "largest force upward less the weight" + unknown,
        ),
        Scalar(
            f"{name}.net_tension.{end}",
            pull.tension if known else None,
            "N",
            f"n times the pull of the most loaded of n anchors on a circle of {radius:g} m, less "
            f"the weight{unknown}",
        ),
    ]

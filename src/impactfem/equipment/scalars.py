"""The scalar results of the stage `device`, by the names of `summary.json`."""

from __future__ import annotations

from dataclasses import replace

from impactfem.device.combination import Combination
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.equipment.damping_study import DampedStudy, DeviceStudy
from impactfem.equipment.spectrum_choice import SpectrumChoice
from impactfem.equipment.support import Support
from impactfem.scalar import Scalar

PREFERRED: tuple[Combination, ...] = ("srss", "cqc")
"""Combinations of modes that stand for the response spectrum analysis, the first that was asked."""


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
        rosette = study.prepared.rosettes[k]
        note = f"{support.name}, floor {rosette.floor}, at node {rosette.master}"
        scalars.append(Scalar(f"{name}.anchor_nodes", 1.0 + len(rosette.followers), "-", note))
        scalars += _modes(name, modes, support)
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
    asked = tuple(study.prepared.plans[0].rules)
    combination = next((one for one in PREFERRED if one in asked), asked[0])
    return SpectrumChoice(combination, rotations=False, broadened=False)


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


def _forces(study: DeviceStudy, name: str, suffix: str, one: DampedStudy, k: int) -> list[Scalar]:
    c = study.direction
    axis = "xyz"[c]
    choice = headline(study)
    further = {
        "rotations": replace(choice, rotations=True),
        "envelope": replace(choice, source="envelope"),
        "envelope_dampings": replace(choice, source="envelope-dampings"),
        "given": replace(choice, source="given"),
    }
    scalars = []
    for impacts, found in (("no_impact", one.no_impact[k]), ("impact", one.impact[k])):
        detailed = float(found.detailed.largest[c])
        by_spectrum = found.value(choice, f"force {axis}")
        scalars += [
            Scalar(f"{name}.f{axis}.detailed.{impacts}{suffix}", detailed, "N"),
            Scalar(f"{name}.f{axis}.rsa.{impacts}{suffix}", by_spectrum, "N", choice.label),
            Scalar(
                f"{name}.relative_difference.{impacts}{suffix}",
                1.0 - by_spectrum / detailed if detailed > 0.0 else None,
                "-",
                "of the response spectrum analysis from the detailed one, over the latter",
            ),
        ]
        scalars += [
            Scalar(
                f"{name}.f{axis}.rsa_{word}.{impacts}{suffix}",
                found.value(other, f"force {axis}"),
                "N",
                other.label,
            )
            for word, other in further.items()
            if other in found.by_spectrum
        ]
        scalars.append(
            Scalar(f"{name}.pfa.{impacts}{suffix}", float(abs(found.anchor[c]).max()), "m/s2")
        )
    return scalars

"""The scalar results of the stage `device`, by the names of `summary.json`."""

from __future__ import annotations

from impactfem.device.combination import Combination
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.equipment.analysis import DeviceResult, SpectrumChoice
from impactfem.equipment.stage import DampedStudy, DeviceStudy
from impactfem.scalar import Scalar

PREFERRED: tuple[Combination, ...] = ("srss", "cqc")
"""Combinations of modes that stand for the response spectrum analysis, the first that was asked."""


def device_scalars(study: DeviceStudy) -> list[Scalar]:
    """All scalars of the stage; names of further devices than the first hold their name."""
    scalars = [
        Scalar("device.basis_vectors", float(len(study.model.eigenvalue)), "-"),
        Scalar("device.basis_error", study.model.difference, "-", "transfer functions"),
    ]
    for k, device in enumerate(study.prepared.devices):
        name = "device" if k == 0 else f"device.{device.name}"
        modes = device_modes(device).below(_limit(study, k))
        rosette = study.prepared.rosettes[k]
        note = f"{device.name}, floor {rosette.floor}, at node {rosette.master}"
        scalars.append(Scalar(f"{name}.anchor_nodes", 1.0 + len(rosette.followers), "-", note))
        scalars += _modes(name, modes)
        for one in study.cases:
            suffix = "" if one is study.cases[0] else f".{one.name}"
            scalars += _forces(study, name, suffix, one, k)
    for one in study.cases[1:]:
        if one.epsilon is not None:
            note = "calibrated" if one.calibrated else "given"
            scalars.append(Scalar(f"device.epsilon.{one.name}", one.epsilon, "-", note))
        peak = float(one.loads.force.max(initial=0.0))
        note = "largest impact force of the sticks"
        scalars.append(Scalar(f"device.impact_force.{one.name}", peak, "N", note))
    return scalars


def headline(study: DeviceStudy) -> SpectrumChoice:
    """The response spectrum analysis as the paper does it: translations, spectra as computed."""
    asked = tuple(study.prepared.rules[0])
    combination = next((one for one in PREFERRED if one in asked), asked[0])
    return SpectrumChoice(combination, rotations=False, broadened=False)


def _limit(study: DeviceStudy, k: int) -> float | None:
    return next(iter(study.prepared.rules[k].values())).maximum_frequency


def _modes(name: str, modes: DeviceModes) -> list[Scalar]:
    """Frequencies and effective masses along the direction that each mode moves most."""
    scalars = []
    for k, frequency in enumerate(modes.frequency, 1):
        mass = modes.effective_mass[:3, k - 1]
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
    turned = SpectrumChoice(choice.combination, rotations=True, broadened=False)
    scalars = []
    for impacts, found in (("no_impact", one.no_impact[k]), ("impact", one.impact[k])):
        detailed = float(found.detailed.largest[c])
        by_spectrum = _value(found, choice, axis)
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
        if turned in found.by_spectrum:
            value = _value(found, turned, axis)
            scalars.append(
                Scalar(f"{name}.f{axis}.rsa_rotations.{impacts}{suffix}", value, "N", turned.label)
            )
        scalars.append(
            Scalar(f"{name}.pfa.{impacts}{suffix}", float(abs(found.anchor[c]).max()), "m/s2")
        )
    return scalars


def _value(found: DeviceResult, choice: SpectrumChoice, axis: str) -> float:
    return found.by_spectrum[choice].value(f"force {axis}")

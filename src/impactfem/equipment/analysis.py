"""Devices under one load: the detailed analysis, and response spectrum analyses beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.device.combination import Combination
from impactfem.device.device import Device
from impactfem.device.interface import MountedDevice
from impactfem.device.modes import device_modes
from impactfem.device.mounted import ModalStructure, MountedHistory, mounted_response
from impactfem.device.rules import Rules
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.device.spectrum_response import SpectrumResponse
from impactfem.device.springs import COMPONENTS
from impactfem.dynamics.modal_response import modal_response
from impactfem.equipment.study_model import StudyModel
from impactfem.spectra import response_spectra
from impactfem.transient.loads import Loads

Array = NDArray[np.float64]

TRANSLATIONS = COMPONENTS[:3]
STILL = 1e-9
"""A component of an anchor moves if its largest acceleration is above this part of the largest."""


@dataclass(frozen=True)
class SpectrumChoice:
    """One way of doing a response spectrum analysis.

    Args:
        combination: Of the modes.
        rotations: Whether the spectra of the anchor's rotations are inputs, too.
        broadened: Whether the peaks of the spectra are broadened.
    """

    combination: Combination
    rotations: bool
    broadened: bool

    @property
    def label(self) -> str:
        """Its name in results."""
        parts = [self.combination, "rotations" * self.rotations, "broadened" * self.broadened]
        return ".".join(part for part in parts if part)


@dataclass(frozen=True, eq=False)
class DeviceResult:
    """One device under one load.

    Args:
        name: Its name.
        detailed: Its response in the 3D model.
        anchor: Absolute acceleration of the anchor without the device, shape (6, n_t) [m/s2,
            rad/s2].
        spectra: Of the components of this motion that move, at the dampings of the device's modes.
        shown: Pseudo-acceleration of the floor at the first damping of the device along x, y, z,
            at the frequencies of the case, shape (3, n_f) [m/s2].
        by_spectrum: The response spectrum analyses.
    """

    name: str
    detailed: MountedHistory
    anchor: Array
    spectra: tuple[AnchorSpectrum, ...]
    shown: Array
    by_spectrum: Mapping[SpectrumChoice, SpectrumResponse]


@dataclass(frozen=True, eq=False)
class Analyst:
    """What all analyses of a study share.

    Args:
        model: The reduced model of the building.
        devices: The devices, in the order of the model's anchors.
        rules: Rules of the response spectrum analysis of each device, by combination.
        spectra: The case's floor spectra.
        rotations: Whether analyses with rotational spectra are done, too.
        broadening: Of the peaks of spectra for further analyses; none when 0.
        substeps: Steps of the detailed analysis in one of the loads.
    """

    model: StudyModel
    devices: Sequence[Device]
    rules: Sequence[Mapping[Combination, Rules]]
    spectra: Spectra
    rotations: bool
    broadening: float
    substeps: int

    def analyse(self, loads: Loads, damping: tuple[float, float]) -> list[DeviceResult]:
        """All devices under one load.

        Args:
            loads: The loads.
            damping: α [1/s] and β [s] of the building.

        Raises:
            ImpactfemError: A spectrum does not reach a mode of a device.
            SolutionError: The result is not finite, or action and reaction differ.
        """
        model = self.model
        alpha, beta = damping
        mounted = mounted_response(
            ModalStructure(model.eigenvalue, model.load(loads), alpha, beta),
            [
                MountedDevice(device.name, device, shapes)
                for device, shapes in zip(self.devices, model.anchors, strict=True)
            ],
            loads.amplitudes,
            loads.ground,
            loads.time_step,
            substeps=self.substeps,
        )
        alone = modal_response(model.model(loads), loads.amplitudes, loads.time_step, *damping)
        found = []
        for k, (device, rules) in enumerate(zip(self.devices, self.rules, strict=True)):
            anchor = model.anchors[k] @ alone.acceleration
            anchor[:3] += loads.ground.T
            spectra = self._spectra(device, rules, anchor, loads.time_step)
            found.append(
                DeviceResult(
                    name=device.name,
                    detailed=mounted.devices[k],
                    anchor=anchor,
                    spectra=spectra,
                    shown=self._shown(device, anchor[:3], loads.time_step),
                    by_spectrum=self._by_spectrum(device, rules, spectra),
                )
            )
        return found

    def _spectra(
        self,
        device: Device,
        rules: Mapping[Combination, Rules],
        anchor: Array,
        time_step: float,
    ) -> tuple[AnchorSpectrum, ...]:
        limit = next(iter(rules.values())).maximum_frequency
        modes = device_modes(device).below(limit)
        frequency = np.concatenate([self.spectra.frequency_values, modes.frequency])
        largest = np.abs(anchor).max(axis=1)
        scale = np.where(np.arange(6) < 3, largest[:3].max(), largest[3:].max())
        return tuple(
            AnchorSpectrum.of_motion(
                component,
                anchor[k],
                time_step,
                frequency,
                modes.damping,
                points_per_cycle=self.spectra.points_per_cycle,
                method=self.spectra.method,
            )
            for k, component in enumerate(COMPONENTS)
            if largest[k] > STILL * scale[k]
        )

    def _shown(self, device: Device, motion: Array, time_step: float) -> Array:
        damping = float(device_modes(device).damping[0])
        found = response_spectra(
            motion,
            time_step,
            np.asarray(self.spectra.frequency_values),
            [damping],
            points_per_cycle=self.spectra.points_per_cycle,
            method=self.spectra.method,
            absolute=False,
        )
        return np.asarray(found.psa[0], dtype=np.float64)

    def _by_spectrum(
        self,
        device: Device,
        rules: Mapping[Combination, Rules],
        spectra: tuple[AnchorSpectrum, ...],
    ) -> dict[SpectrumChoice, SpectrumResponse]:
        straight = tuple(s for s in spectra if s.component in TRANSLATIONS)
        inputs = {(False, False): straight}
        if self.rotations:
            inputs[True, False] = spectra
        if self.broadening > 0.0:
            for turned in (False, True)[: 1 + self.rotations]:
                given = inputs[turned, False]
                inputs[turned, True] = tuple(s.broadened(self.broadening) for s in given)
        return {
            SpectrumChoice(combination, rotations, broadened): spectrum_analysis(
                device, given, rule
            )
            for (rotations, broadened), given in inputs.items()
            for combination, rule in rules.items()
        }

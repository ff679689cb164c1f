"""Devices under one load: the detailed analysis, and response spectrum analyses beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.coupling.body import reduced_body
from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.device.mounted import MountedDevice, MountedHistory, mounted_response
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import SpectrumResponse
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import modal_response
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.stages.device.anchor_spectra import motion_spectra, shown_spectra
from impactfem.stages.device.spectrum_choice import SpectrumChoice
from impactfem.stages.device.spectrum_plan import SpectrumPlan, envelopes
from impactfem.stages.device.support import Support, largest_apart, supports_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DeviceResult:
    """One device at one of its anchors under one load.

    Args:
        support: The anchor.
        detailed: Its response in the 3D model; forces and motions of this anchor.
        anchor: Absolute acceleration of the anchor without the device, shape (6, n_t) [m/s2,
            rad/s2].
        covering: Of the components of all anchors of the device that move, at the dampings of its
            modes: the spectra, or their envelope with those of further points.
        shown: Pseudo-acceleration of the floor at the first damping of the device along x, y, z,
            at the frequencies of the case, shape (3, n_f) [m/s2].
        by_spectrum: The response spectrum analyses of the device.
    """

    support: Support
    detailed: MountedHistory
    anchor: Array
    covering: tuple[AnchorSpectrum, ...]
    shown: Array
    by_spectrum: Mapping[SpectrumChoice, SpectrumResponse]

    @property
    def name(self) -> str:
        """Name of the support in results."""
        return self.support.name

    def value(self, choice: SpectrumChoice, word: str) -> float:
        """A force at the anchor, such as "force y", by a response spectrum analysis [N, N m].

        Nan where the analysis was not done of this device.
        """
        found = self.by_spectrum.get(choice)
        return float("nan") if found is None else found.value(self.support.quantity(word))


@dataclass(frozen=True, eq=False)
class Analyst:
    """What all analyses of a study share.

    Args:
        model: The reduced model of the building.
        plans: The devices, in the order of the model's anchors, and their analyses.
        positions: Of all anchors, shape (n_anchors, 3) [m].
        covered: Of each anchor, numbers of the model's points that an envelope covers, too.
        spectra: The case's floor spectra.
        substeps: Steps of the detailed analysis in one of the loads.
    """

    model: CompleteModel
    plans: Sequence[SpectrumPlan]
    positions: Array
    covered: Sequence[Sequence[int]]
    spectra: Spectra
    substeps: int

    @property
    def devices(self) -> list[Device]:
        """The devices."""
        return [plan.device for plan in self.plans]

    def analyse(self, loads: Loads, damping: Rayleigh) -> list[DeviceResult]:
        """All devices at all their anchors under one load.

        Args:
            loads: The loads.
            damping: α [1/s] and β [s] of the building.

        Raises:
            ImpactfemError: A spectrum does not reach a mode of a device.
            SolutionError: The result is not finite, or action and reaction differ.
        """
        model = self.model
        supports = supports_of(self.devices)
        places = [
            [i for i, one in enumerate(supports) if one.device == k] for k in range(len(self.plans))
        ]
        ports = {str(i): Φ for i, Φ in enumerate(model.anchors)}
        mounted = mounted_response(
            [reduced_body("building", model.eigenvalue, damping, ports)],
            [
                MountedDevice(device.name, device, tuple(("building", str(i)) for i in rows))
                for device, rows in zip(self.devices, places, strict=True)
            ],
            loads.amplitudes @ model.load(loads).T,
            loads.ground,
            loads.time_step,
            substeps=self.substeps,
        )
        alone = modal_response(model.model(loads), loads.amplitudes, loads.time_step, damping)
        found = []
        for plan, history, rows in zip(self.plans, mounted.devices, places, strict=True):
            motions = [_shaken(model.anchors[i], alone.acceleration, loads) for i in rows]
            apart: Array = np.zeros(6 * len(rows))
            if len(rows) > 1:
                moved = np.concatenate(model.anchors[rows]) @ alone.displacement
                apart = largest_apart(plan.device, self.positions[rows], moved)
            own, covering = self._spectra(plan, motions, apart, rows, alone.acceleration, loads)
            by_spectrum = plan.analyses(own, "computed")
            if any(self.covered[i] for i in rows):
                by_spectrum |= plan.analyses(covering, "envelope")
            by_spectrum |= plan.given_analyses()
            first = float(device_modes(plan.device).damping[0])
            found += [
                DeviceResult(
                    support=supports[i],
                    detailed=_at(history, supports[i]),
                    anchor=motion,
                    covering=covering,
                    shown=shown_spectra(first, motion[:3], loads.time_step, self.spectra),
                    by_spectrum=by_spectrum,
                )
                for i, motion in zip(rows, motions, strict=True)
            ]
        return found

    def _spectra(
        self,
        plan: SpectrumPlan,
        motions: Sequence[Array],
        apart: Array,
        rows: Sequence[int],
        acceleration: Array,
        loads: Loads,
    ) -> tuple[tuple[AnchorSpectrum, ...], tuple[AnchorSpectrum, ...]]:
        """Spectra of the anchors of a device, and their envelope with those of further points."""
        modes = device_modes(plan.device).below(plan.maximum_frequency)
        dt, settings = loads.time_step, self.spectra
        own: list[AnchorSpectrum] = []
        points = list[tuple[AnchorSpectrum, ...]]()
        for number, (motion, row) in enumerate(zip(motions, rows, strict=True), 1):
            shift = apart[6 * (number - 1) : 6 * number]
            own += motion_spectra(modes, motion, dt, settings, anchor=number, displacement=shift)
            for point in self.covered[row]:
                shaken = _shaken(self.model.points[point], acceleration, loads)
                points.append(motion_spectra(modes, shaken, dt, settings, anchor=number))
        return tuple(own), envelopes([own, *points]) if points else tuple(own)

    def over_dampings(
        self, cases: Sequence[Sequence[DeviceResult]]
    ) -> list[tuple[DeviceResult, ...]]:
        """Results of all damping cases with the analyses of the envelope of their spectra.

        Args:
            cases: Results of `analyse` under the same kind of load, one damping after the other.

        Raises:
            ImpactfemError: A spectrum does not reach a mode of a device.
        """
        further = []
        for k, plan in enumerate(self.plans):
            first = next(i for i, one in enumerate(cases[0]) if one.support.device == k)
            widest = envelopes([case[first].covering for case in cases])
            further.append(plan.analyses(widest, "envelope-dampings"))
        return [
            tuple(
                replace(one, by_spectrum={**one.by_spectrum, **further[one.support.device]})
                for one in case
            )
            for case in cases
        ]


def with_detailed(
    results: Sequence[DeviceResult], histories: Sequence[MountedHistory]
) -> tuple[DeviceResult, ...]:
    """Results with the detailed analysis of another model.

    Args:
        results: Of all devices at all their anchors.
        histories: The devices by that model.
    """
    return tuple(
        replace(one, detailed=_at(histories[one.support.device], one.support)) for one in results
    )


def _shaken(shapes: Array, acceleration: Array, loads: Loads) -> Array:
    """Absolute acceleration of a point, shape (6, n_t) [m/s2, rad/s2]."""
    motion = np.asarray(shapes @ acceleration, dtype=np.float64)
    motion[:3] += loads.ground.T
    return motion


def _at(history: MountedHistory, support: Support) -> MountedHistory:
    """The history of a device with the forces and motions of one anchor."""
    rows = support.rows
    return replace(
        history,
        name=support.name,
        force=history.force[rows],
        anchor_displacement=history.anchor_displacement[rows],
        anchor_velocity=history.anchor_velocity[rows],
        anchor_acceleration=history.anchor_acceleration[rows],
    )

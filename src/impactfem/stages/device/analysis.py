"""Devices under one load: the detailed analysis and the response spectrum analyses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.case.devices import ModeRule, SupportRule
from impactfem.coupling.body import reduced_body
from impactfem.device.combination import Rules
from impactfem.device.device import Device
from impactfem.device.from_case import first_method
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.device.mounted import MountedDevice, MountedHistory, mounted_response
from impactfem.device.spectrum import LAST, NO_SHIFT, AnchorSpectrum, NotRigidError
from impactfem.device.spectrum_analysis import SpectrumResponse, spectrum_analysis
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.spectra import response_spectra
from impactfem.stages.device.choice import Source, SpectrumChoice
from impactfem.sticks.element import COMPONENTS
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.quantity import results, si

WORDS = tuple(f"{word} {axis}" for word in ("force", "moment") for axis in "xyz")
"""Quantities of a response spectrum analysis, of the components x to rz."""
FREE = 1e-6
"""A motion of all anchors as a rigid body is free if the force that it needs is below this part of
the largest force of its parts."""
STILL = 1e-9
"""A component of an anchor moves if its largest acceleration is above this part of the largest."""
NO_RIGID_PART = (
    "the rigid part by '{}' is left out where a spectrum ends before it comes down to its "
    "zero-period acceleration, or has its corners the other way round"
)


Analyses = dict[SpectrumChoice, SpectrumResponse]


@dataclass(frozen=True, eq=False)
class SpectrumPlan:
    """What is done with the spectra of a device's anchors."""

    device: Device
    rules: Mapping[ModeRule, Rules]  #: by combination of the modes and method of their rigid part
    rotations: bool  #: whether analyses with rotational spectra are done, too
    broadening: float  #: of the peaks of spectra for further analyses; none when 0
    #: Combinations of several supports, the first for all analyses
    supports: tuple[SupportRule, ...] = ("srss",)
    #: Spectra of a file for a further analysis; none when empty
    given: tuple[AnchorSpectrum, ...] = ()

    @property
    def maximum_frequency(self) -> float | None:
        """Modes above it count as missing mass [Hz]."""
        return next(iter(self.rules.values())).maximum_frequency

    def analyses(self, spectra: Sequence[AnchorSpectrum], source: Source) -> Analyses:
        """All analyses with the spectra of one source: of all components of all anchors that move.

        ImpactfemError where a spectrum does not reach a mode.
        """
        straight = [s for s in spectra if s.component in COMPONENTS[:3]]
        inputs = {False: straight, True: spectra} if self.rotations else {False: straight}
        found: Analyses = {}
        for turned, chosen in inputs.items():
            found |= self._combined(SpectrumChoice("srss", turned, False, source), chosen)
        if self.broadening > 0.0:
            for turned, chosen in inputs.items():
                broad = [s.broadened(self.broadening) for s in chosen]
                found |= self._combined(SpectrumChoice("srss", turned, True, source), broad)
        if self.device.anchors == 1:
            return found
        first, *further = self.supports
        note = f"several supports are combined by '{first}' where no other is named"
        found = {choice: _with_notes(one, note) for choice, one in found.items()}
        for rule in further if source == "computed" else ():
            for turned, chosen in inputs.items():
                choice = SpectrumChoice("srss", turned, False, source, rule)
                found |= self._combined(choice, chosen)
        return found

    def given_analyses(self) -> Analyses:
        """The analyses with the spectra of a file; none without one.

        ImpactfemError where a spectrum does not reach a mode.
        """
        if not self.given:
            return {}
        found = self._combined(SpectrumChoice("srss", source="given"), self.given)
        notes = (LAST, NO_SHIFT) if self.device.anchors > 1 else (LAST,)
        return {choice: _with_notes(one, *notes) for choice, one in found.items()}

    def _combined(self, choice: SpectrumChoice, spectra: Sequence[AnchorSpectrum]) -> Analyses:
        """The analyses of a choice with every combination of modes and every rigid part."""
        # A further rigid part than the first is left out where a spectrum says too little for it.
        rule = choice.supports or self.supports[0]
        if rule == "envelope":
            # All anchors move together by the envelope over them, each apart as far as it was.
            shift = {(s.component, s.anchor): s.displacement for s in spectra}
            spectra = [
                replace(widest, anchor=k, displacement=shift.get((widest.component, k), 0.0))
                for widest in envelopes([[replace(s, anchor=1) for s in spectra]])
                for k in range(1, self.device.anchors + 1)
            ]
            rule = "algebraic"
        found: Analyses = {}
        missing: dict[str, None] = {}
        for (combination, rigid), rules in self.rules.items():
            try:
                answer = spectrum_analysis(self.device, spectra, replace(rules, supports=rule))
            except ImpactfemError as error:
                if isinstance(error, NotRigidError) and rigid != first_method(self.rules):
                    missing[NO_RIGID_PART.format(rigid)] = None
                    continue
                named = f"device {self.device.name}: "
                raise ImpactfemError(named + str(error).removeprefix(named)) from error
            found[replace(choice, combination=combination, rigid=rigid)] = answer
        return {one: _with_notes(answer, *missing) for one, answer in found.items()}


def _with_notes(response: SpectrumResponse, *notes: str) -> SpectrumResponse:
    return replace(response, notes=response.notes + notes)


def envelopes(families: Sequence[Sequence[AnchorSpectrum]]) -> tuple[AnchorSpectrum, ...]:
    """The envelope of several spectra, component by component and anchor by anchor.

    A component may be missing in some of the families of spectra.
    """
    groups: dict[tuple[int, str], list[AnchorSpectrum]] = {}
    for one in (spectrum for family in families for spectrum in family):
        groups.setdefault((one.anchor, one.component), []).append(one)
    return tuple(AnchorSpectrum.envelope(group) for group in groups.values())


@dataclass(frozen=True)
class Support:
    """One anchor of one device."""

    device: int  #: number of the device, from 0
    number: int  #: number of the anchor, from 1
    name: str  #: the device's name; with several anchors, with the number of the anchor
    several: bool  #: whether the device has several

    @property
    def rows(self) -> slice:
        """Its components among those of the device's anchors."""
        return slice(6 * (self.number - 1), 6 * self.number)

    def quantity(self, word: str) -> str:
        """Name of a force at it, such as "force y", among those of the device."""
        return f"{word} at anchor {self.number}" if self.several else word

    def of(self, history: MountedHistory) -> MountedHistory:
        """The history of the device with the forces and motions of this anchor."""
        return replace(
            history,
            name=self.name,
            force=history.force[self.rows],
            anchor_displacement=history.anchor_displacement[self.rows],
            anchor_velocity=history.anchor_velocity[self.rows],
            anchor_acceleration=history.anchor_acceleration[self.rows],
        )


def supports_of(plans: Sequence[SpectrumPlan]) -> tuple[Support, ...]:
    """All supports, device by device."""
    return tuple(
        Support(
            device=k,
            number=number,
            name=f"{one.name}_{number}" if one.anchors > 1 else one.name,
            several=one.anchors > 1,
        )
        for k, one in enumerate(plan.device for plan in plans)
        for number in range(1, one.anchors + 1)
    )


@results
class DeviceResult:
    """One device at one of its anchors under one load.

    Motions of the anchor and its spectra are those without the device; histories that are read off
    figures alone have single precision.
    """

    support: Support
    detailed: MountedHistory  #: its response in the 3D model; forces and motions of this anchor
    #: of the components of all anchors of the device that move, at the dampings of its modes: the
    #: spectra, or their envelope with those of further points
    covering: tuple[AnchorSpectrum, ...]
    by_spectrum: Analyses  #: the response spectrum analyses of the device
    force: NDArray[np.float32] = si("N, N m", "force on the floor", dims="component time")
    imbalance: float = si("-", "imbalance of inertia and springs, over the largest force")
    anchor_acceleration: NDArray[np.float32] = si(
        "m/s2, rad/s2", "acceleration of the anchor", dims="component time"
    )
    pfa: Array = si("m/s2", "peak acceleration of the anchor", dims="axis")
    psa: Array = si("m/s2", "spectrum, first damping of the device", dims="axis frequency")
    psa_peak: Array = si("m/s2", "largest ordinate of psa", dims="axis")
    psa_peak_frequency: Array = si("Hz", "frequency of the largest ordinate", dims="axis")

    def peaks(self, choices: Sequence[SpectrumChoice]) -> Array:
        """Return the largest forces in detail, then by analyses, shape (1 + n, 6) [N, N m]."""
        return np.array([self.detailed.largest, *(self.values(choice) for choice in choices)])

    def values(self, choice: SpectrumChoice) -> list[float]:
        """Forces and moments at the anchor by a response spectrum analysis, x to rz [N, N m].

        Nan where the analysis was not done of this device.
        """
        if choice not in self.by_spectrum:
            return [float("nan")] * len(WORDS)
        found = self.by_spectrum[choice]
        return [found.value(self.support.quantity(word)) for word in WORDS]

    def ordinates(self, choice: SpectrumChoice, modes: int) -> Array:
        """Pseudo-accelerations of the anchor without the device, at its modes and their dampings.

        Shape (6, modes) [m/s2, rad/s2]: nan beyond the device's modes, and where a component of the
        anchor does not move or is no input of this analysis; 0 where it moves, but not the mode.
        """
        found = np.full((len(COMPONENTS), modes), np.nan)
        response, first = self.by_spectrum[choice], self.support.rows.start
        for one, column in zip(response.inputs, response.columns, strict=True):
            if first <= column < first + len(COMPONENTS):
                found[column - first, : one.ordinate.size] = one.ordinate
        return found


@dataclass(frozen=True, eq=False)
class Analyst:
    """What all analyses of a study share."""

    model: CompleteModel  #: the reduced model of the building
    #: the devices, in the order of the model's anchors, and their analyses
    plans: Sequence[SpectrumPlan]
    positions: Array  #: of all anchors, shape (n_anchors, 3) [m]
    #: of each anchor, numbers of the model's points that an envelope covers, too
    covered: Sequence[Sequence[int]]
    spectra: Spectra  #: the case's floor spectra
    substeps: int  #: steps of the detailed analysis in one of the loads

    def analyse(
        self, loads: Loads, damping: DampingLaw, *, by_spectra: bool = True
    ) -> list[DeviceResult]:
        """All devices at all their anchors under loads, with a damping of the building.

        Without `by_spectra` there are no response spectrum analyses.

        Raises:
            ImpactfemError: A spectrum does not reach a mode of a device.
            SolutionError: The result is not finite, or action and reaction differ.
        """
        supports = supports_of(self.plans)
        places = [
            [i for i, one in enumerate(supports) if one.device == k] for k in range(len(self.plans))
        ]
        histories = self._mounted(loads, damping, places)
        alone = self.model.response(loads, damping)
        anchors, further = self.model.shapes(), self.model.shapes(anchors=False)

        def shaken(shapes: Array) -> Array:
            """Absolute acceleration of a point, shape (6, n_t) [m/s2, rad/s2]."""
            motion = np.asarray(shapes @ alone.acceleration, dtype=np.float64)
            motion[:3] += loads.ground.T
            return motion

        found = []
        for plan, history, rows in zip(self.plans, histories, places, strict=True):
            motions = [shaken(anchors[i]) for i in rows]
            covering, by_spectrum = tuple[AnchorSpectrum, ...](), Analyses()
            if by_spectra:
                moved = np.concatenate(anchors[rows]) @ alone.displacement
                apart = _largest_apart(plan.device, self.positions[rows], moved).reshape(-1, 6)
                beyond = [[shaken(further[k]) for k in self.covered[row]] for row in rows]
                covering, by_spectrum = self._by_spectra(
                    plan, motions, beyond, apart, loads.time_step
                )
            frequency = np.asarray(self.spectra.frequency_values)
            for i, motion in zip(rows, motions, strict=True):
                detailed = supports[i].of(history)
                psa = self._floor_spectra(plan, motion, loads.time_step)
                found.append(
                    DeviceResult(
                        supports[i],
                        detailed,
                        covering,
                        by_spectrum,
                        force=detailed.force.astype(np.float32),
                        imbalance=detailed.imbalance,
                        anchor_acceleration=motion.astype(np.float32),
                        pfa=np.abs(motion[:3]).max(axis=1),
                        psa=psa,
                        psa_peak=psa.max(axis=1),
                        psa_peak_frequency=frequency[psa.argmax(axis=1)],
                    )
                )
        return found

    def _by_spectra(
        self,
        plan: SpectrumPlan,
        motions: Sequence[Array],
        further: Sequence[Sequence[Array]],
        apart: Array,
        time_step: float,
    ) -> tuple[tuple[AnchorSpectrum, ...], Analyses]:
        """Return covering spectra and analyses of a device.

        From the motions of its anchors and of the further points of each, shape (6, n_t); `apart`
        are the largest displacements of the anchors against the first one, shape (n_anchors, 6).
        """
        modes = device_modes(plan.device).below(plan.maximum_frequency)
        own: list[AnchorSpectrum] = []
        points = list[list[AnchorSpectrum]]()
        for number, (motion, others) in enumerate(zip(motions, further, strict=True), 1):
            own += self._spectra(modes, motion, time_step, number, apart[number - 1])
            points += [self._spectra(modes, other, time_step, number) for other in others]
        by_spectrum = plan.analyses(own, "computed")
        covering = envelopes([own, *points]) if points else tuple(own)
        if points:
            by_spectrum |= plan.analyses(covering, "envelope")
        return covering, by_spectrum | plan.given_analyses()

    def anchor_spectra(self, loads: Loads, damping: DampingLaw) -> Array:
        """Return the spectra of all anchors without the devices, shape (n_anchors, 3, n_f)."""
        alone, shapes = self.model.response(loads, damping), self.model.shapes()
        return np.array(
            [
                self._floor_spectra(
                    self.plans[support.device],
                    row[:3] @ alone.acceleration + loads.ground.T,
                    loads.time_step,
                )
                for support, row in zip(supports_of(self.plans), shapes, strict=True)
            ]
        )

    def _floor_spectra(self, plan: SpectrumPlan, motion: Array, time_step: float) -> Array:
        """Return the spectra of a motion at the first damping of a device, shape (3, n_f)."""
        spectra = response_spectra(
            motion[:3],
            time_step,
            np.asarray(self.spectra.frequency_values),
            [float(device_modes(plan.device).damping[0])],
            points_per_cycle=self.spectra.points_per_cycle,
            method=self.spectra.method,
            absolute=False,
        )
        return np.asarray(spectra.psa[0], dtype=np.float64)

    def _mounted(
        self, loads: Loads, damping: DampingLaw, places: Sequence[Sequence[int]]
    ) -> tuple[MountedHistory, ...]:
        """The response of building and devices as one system; `places` are anchors by device."""
        model, below = self.model, self.model.foundation
        if below is None:
            ports = {str(i): Φ for i, Φ in enumerate(model.anchors)}
            building = reduced_body("building", model.eigenvalue, damping, ports)
            forces = loads.amplitudes @ model.load(loads).T
        else:
            # Device, building, raft and soil as one system.
            both = zip(model.anchors, model.anchors_carried, strict=True)
            on_base = {str(i): one for i, one in enumerate(both)}
            building = below.body(model.eigenvalue, model.ground, damping, on_base)
            forces = below.loads(building, model.load(loads)[:, len(loads.directions) :], loads)
        devices = [
            MountedDevice(plan.device.name, plan.device, tuple(("building", str(i)) for i in rows))
            for plan, rows in zip(self.plans, places, strict=True)
        ]
        return mounted_response(
            [building], devices, forces, loads.ground, loads.time_step, substeps=self.substeps
        ).devices

    def _spectra(
        self,
        modes: DeviceModes,
        motion: Array,
        time_step: float,
        anchor: int,
        apart: Array | None = None,
    ) -> list[AnchorSpectrum]:
        """Spectra of the components of a motion that move, at the modes' frequencies, too."""
        frequency = np.concatenate([self.spectra.frequency_values, modes.frequency])
        largest = np.abs(motion).max(axis=1)
        scale = np.where(np.arange(6) < 3, largest[:3].max(), largest[3:].max())
        return [
            replace(
                AnchorSpectrum.of_motion(
                    component,
                    motion[k],
                    time_step,
                    frequency,
                    modes.damping,
                    anchor=anchor,
                    points_per_cycle=self.spectra.points_per_cycle,
                    method=self.spectra.method,
                ),
                displacement=0.0 if apart is None else float(apart[k]),
            )
            for k, component in enumerate(COMPONENTS)
            if largest[k] > STILL * scale[k]
        ]

    def over_dampings(self, cases: Sequence[Sequence[DeviceResult]]) -> list[list[DeviceResult]]:
        """Results by damping with the analyses of the envelope of the spectra of all dampings.

        ImpactfemError where a spectrum does not reach a mode of a device.
        """
        further = []
        for k, plan in enumerate(self.plans):
            first = next(i for i, one in enumerate(cases[0]) if one.support.device == k)
            widest = envelopes([case[first].covering for case in cases])
            further.append(plan.analyses(widest, "envelope-dampings"))
        return [
            [
                replace(one, by_spectrum=one.by_spectrum | further[one.support.device])
                for one in case
            ]
            for case in cases
        ]


def _largest_apart(device: Device, points: Array, displacement: Array) -> Array:
    """Largest displacements of anchors against where the first one carries them, shape (6 p,)."""
    # As a rigid body, by its translations, and by those rotations that the stiffness between the
    # anchors leaves free. Points have the shape (p, 3) [m], displacements (6 p, n_t) [m, rad].
    K_a = device.anchor_stiffness
    if device.anchors == 1 or K_a is None or not np.any(K_a):
        return np.zeros(6 * device.anchors)
    R = np.tile(np.eye(6), (device.anchors, 1))
    for k, (x, y, z) in enumerate(points - points[0]):
        R[6 * k : 6 * k + 3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    force = np.abs(K_a @ R).max(axis=0)
    parts = (np.abs(K_a) @ np.abs(R)).max(axis=0)
    carried = np.where(force <= FREE * parts, 1.0, 0.0)[:, None] * displacement[:6]
    return np.asarray(np.abs(displacement - R @ carried).max(axis=1), dtype=np.float64)

"""The stage `pounding`: motions, calibrated sticks, pounding, impacts, floor response spectra."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from impactfem.case import Case
from impactfem.case.contact_search import facing_floors
from impactfem.coupling.from_case import calibration_of, ground_of, loads_of, system_of
from impactfem.coupling.ground import Ground, History
from impactfem.coupling.impacts import (
    FORCE_BAND,
    Approach,
    Impact,
    ImpactCheck,
    Separation,
    approaches,
    impact_checks,
    impacts,
    largest_means,
    separations,
)
from impactfem.coupling.line_response import with_lines
from impactfem.coupling.pounding import Load, Response, System, simulate
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.spectra import ResponseSpectra, response_spectra
from impactfem.spectra.resolved import (
    ResolvedBand,
    band_limited_zpa,
    refinement_limit,
    sampling_limit,
    step_limit,
)
from impactfem.stages.pounding.foundation import Foundation, foundations
from impactfem.sticks.calibration import Calibration
from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import Modes, modes
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER, quiet
from impactfem.system.parallel import threads
from impactfem.system.quantity import quantity, results

if TYPE_CHECKING:
    from impactfem.reduction.models_3d import Models3D

FEW = 4
"""Points of a line with which half of them is no line any more."""
SMALL = 0.1
"""Part of the largest force below which an impact is too short to count its steps, and of the
largest floor response below which that of a floor is not compared."""
STILL = 1e-9
"""A component moves if its largest value is above this part of the largest of its kind."""
STEPS = {"motions": 1.0, "sticks": 3.0, "pounding": 2.0, "spectra": 4.0}
"""Steps of the stage and their expected share of its time, for the progress bar."""


@dataclass(frozen=True)
class FloorSpectra:
    """Spectra of all floors in the directions in which they move."""

    directions: tuple[str, ...]  #: "x" to "z", or "rx" to "rz": those in which a floor moves
    #: Pseudo-acceleration [m/s2, rad/s2], shape (n_dampings, n_stations, n_directions,
    #: n_frequencies).
    psa: Array
    sd: Array  #: relative displacement, same shape [m, rad]
    pfa: Array  #: peak floor acceleration, shape (n_stations, n_directions) [m/s2, rad/s2]
    spectra: ResponseSpectra  #: as computed, with frequencies, dampings and the sampling bound


@dataclass(frozen=True)
class Peaks:
    """Largest values of the response of 3D models."""

    force: float  #: of a line along which they touch [N]
    mean_force: float  #: of `largest_means` of such forces [N]
    #: Ordinates up to `FORCE_BAND` at the first damping, shape (n_stations, n_directions) [m/s2].
    frs: Array
    pfa: Array  #: accelerations of the floors, same shape [m/s2]

    @classmethod
    def of(cls, response: Response, lines: int, floors: FloorSpectra) -> Peaks:
        """Of a response whose first pairs are its lines."""
        force = response.force[:, :lines]
        mean = float(largest_means(response.time, force).max(initial=0.0))
        largest = float(response.largest_forces[:, :lines].max(initial=0.0))
        band = floors.spectra.frequency <= FORCE_BAND
        frs = floors.psa[0][..., band].max(axis=-1, initial=0.0)
        return cls(largest, mean, frs, floors.pfa)

    def change(self, other: Peaks | None, what: str) -> float:
        """Largest change of a value in another response, where it is not small; nan if unknown."""
        if other is None or self.force == 0.0:
            return np.nan
        own, changed = (np.atleast_1d(getattr(one, what)) for one in (self, other))
        counts = (own > 0.0) & (own >= SMALL * own.max())
        if not counts.any():
            return np.nan
        return float(np.abs(changed[counts] / own[counts] - 1.0).max())


@results
class StickStudy:
    """Everything that the stage computed; stations are the floors of all buildings in order."""

    case: Case
    motions: tuple[GroundMotion, ...]  #: the ground motions
    calibration: Calibration | None  #: the calibration; None when the case has none
    system: System  #: sticks and pairs
    modes: tuple[Modes, ...]  #: modes of each building, in the order of the sticks
    response: Response  #: the run with contact
    free: Response  #: the run without contact
    impacts: tuple[Impact, ...]  #: all impacts in order of time
    checks: tuple[ImpactCheck, ...]  #: what each impact asks of the buildings
    separations: tuple[Separation, ...]  #: required separation of each pair
    #: Closest approach of floors that face each other and are in no pair.
    facing: tuple[Approach, ...]
    floors: FloorSpectra  #: floor spectra with contact
    floors_free: FloorSpectra  #: floor spectra without contact
    foundations: tuple[Foundation, ...] = ()  #: of the buildings on soil
    #: Of 3D models; then with about half of the points of their lines, and with steps twice as
    #: long, None where that was not computed.
    peaks: Peaks | None = None
    halved: Peaks | None = None
    doubled: Peaks | None = None
    #: The run with another time step, half of it for sticks and twice it for 3D models, and its
    #: spectra; None where it was not computed.
    other: Response | None = None
    other_floors: FloorSpectra | None = None

    @property
    def main_impact(self) -> Impact | None:
        """The impact with the largest force; None when nothing touched."""
        return max(self.impacts, key=lambda impact: impact.peak_force, default=None)

    @property
    @quantity("-", "fewest steps in an impact, by the durations of the contact laws")
    def steps_per_impact_min(self) -> float | None:
        """Fewest steps of an impact by the laws' own durations, with the effective masses [-].

        Of unilateral contact, which has no duration, by those of the impacts with at least a tenth
        of the largest force, in parts of steps. None without an impact; nan if every contact begins
        at rest.
        """
        if not self.impacts:
            return None
        if self.unilateral:
            least = SMALL * max((i.peak_force for i in self.impacts), default=0.0)
            fewest = min((i.steps for i in self.impacts if i.peak_force >= least), default=0)
            return float(fewest * self.response.parts)
        durations = [i.pair.law.duration(i.approach) for i in self.impacts if i.approach > 0.0]
        return min(durations, default=np.nan) / self.response.time_step

    @property
    @quantity("-", "fewest steps in an impact, in the run")
    def steps_per_impact_observed(self) -> float | None:
        """Fewest steps of an impact in the run; other forces may cut it short. None without one."""
        return min((float(impact.steps) for impact in self.impacts), default=None)

    @property
    @quantity("-", "residual of the energy balance")
    def energy_residual(self) -> float:
        """Residual of the discrete energy identity."""
        return self.response.energy.residual

    @property
    @quantity("m", "gap required to avoid contact", shown="mm")
    def required_separation(self) -> float | None:
        """Largest approach of a pair without contact; None without pairs."""
        return max((one.required for one in self.separations), default=None)

    @property
    @quantity("-", "contact points of 3D models")
    def contact_points(self) -> float | None:
        """Number of contact points of 3D models; None if no 3D model pounds."""
        return None if self.peaks is None else float(len(self._points))

    @property
    @quantity("-", "contact lines of 3D models")
    def contact_lines(self) -> float | None:
        """Number of lines along which 3D models touch; None if no 3D model pounds."""
        return None if self.peaks is None else float(len(set(self._points)))

    @property
    def _points(self) -> list[str]:
        return [point.line for point in self.response.exerted[0] if point.hats is not None]

    @property
    @quantity("-", "residual of complementarity, over the largest speed")
    def complementarity(self) -> float | None:
        """Residual of the conditions of unilateral contact; None with contact laws."""
        return self.response.residual if self.unilateral else None

    @property
    @quantity("-", "energy lost by time stepping in contact, over the largest kinetic energy")
    def contact_energy_defect(self) -> float | None:
        """Energy lost in contact by the time stepping; None without an impact.

        None with Moreau's scheme, whose impulses dissipate.
        """
        impulsive = self.unilateral and self.case.pounding.unilateral_scheme == "moreau"
        if impulsive or not self.impacts:
            return None
        largest = float(np.max(self.response.energy.kinetic))
        return sum(impact.defect for impact in self.impacts) / largest

    @property
    @quantity("-", "largest penetration / gap")
    def penetration_over_gap(self) -> float | None:
        """Largest penetration over the gap, of the pairs with a gap; None without an impact."""
        ratios = (i.penetration / i.pair.gap for i in self.impacts if i.pair.gap > 0.0)
        return max(ratios, default=None)

    @property
    @quantity("N", "largest mean force over 5 ms, of a pair", shown="MN")
    def mean_force_5ms(self) -> float | None:
        """Largest mean over 5 ms of the force of a pair; None without an impact."""
        if not self.impacts:
            return None
        return float(largest_means(self.response.time, self.response.force).max())

    @property
    @quantity("-", "samples per cycle of the highest frequency, of the spectra")
    def points_per_cycle(self) -> float:
        """Samples in a cycle of the highest frequency after refinement."""
        return self.floors.spectra.points_per_cycle

    @property
    @quantity("-", "bound of the sampling error of a spectral peak")
    def peak_error_bound(self) -> float:
        """Largest loss of a spectral peak between samples."""
        return self.floors.spectra.peak_error_bound

    @property
    def unilateral(self) -> bool:
        """Whether contact has no law."""
        return any(pair.law.unilateral for pair in self.system.pairs)

    @property
    def band(self) -> ResolvedBand:
        """Resolved band of the floor spectra."""
        case, step, spectra = self.case, self.response.time_step, self.floors.spectra
        steps = self.steps_per_impact_min
        contact = refinement = basis = math.inf
        if steps is not None and math.isfinite(steps):
            # With fewer steps than required the course of the force is not resolved.
            contact = step_limit(step) * min(1.0, steps / case.pounding.points_per_impact)
        if self.other is not None and self.other_floors is not None:
            ratio = self.other.time_step / step
            both = self.floors.psa, self.other_floors.psa
            refinement = refinement_limit(spectra.frequency, both[0], both[1], ratio)
        if case.pounding_in_3d and case.transient is not None:
            basis = case.transient.maximum_frequency
        return ResolvedBand(
            time_step=step_limit(step),
            oscillators=sampling_limit(spectra),
            mesh=math.inf,
            basis=basis,
            contact=contact,
            refinement=refinement,
        )

    def zpa(self, response: Response) -> Array:
        """Return the ZPA of the floors under a response, shape (n_stations, n_directions)."""
        components = [COMPONENTS.index(name) for name in self.floors.directions]
        columns = station_dofs(self.system)[:, components]
        motion = response.absolute_acceleration[:, columns]
        return band_limited_zpa(motion, response.time_step, self.band.frequency)

    @property
    def stations(self) -> list[tuple[str, int]]:
        """Building and floor of each station."""
        return [
            (stick.name, floor.number) for stick in self.system.sticks for floor in stick.floors
        ]

    def turning(self) -> FloorSpectra | None:
        """Floor spectra of the rotations, with contact; None where no floor turns."""
        axes = moving(self.response.absolute_acceleration, station_dofs(self.system))[1]
        return floor_spectra(self.case, self.response, axes) if axes else None


@contextmanager
def comparison(what: str) -> Iterator[None]:
    """Warn, and go on, where a run that others are only compared with does not succeed."""
    try:
        yield
    except SolutionError as error:
        LOGGER.warning(
            "warning: pounding: the run with %s, for comparison, failed: %s", what, error
        )


def run_sticks(
    case: Case,
    step: Callable[[str], AbstractContextManager[None]] = lambda name: nullcontext(),
    *,
    ready: tuple[Calibration | None, System] | None = None,
    models: Models3D | None = None,
) -> StickStudy:
    """Run the stage.

    Args:
        case: The case.
        step: Called with the name of each step of `STEPS`; the step runs inside its context.
        ready: Calibration and system where they are known, as with user-defined contact laws; made
            from the case when None.
        models: The 3D models that pound, and their lines; None where all buildings are sticks.

    Raises:
        InputError: A record of the motion is not usable.
        SolutionError: A part of the computation found no usable result.
    """
    dt = case.pounding.time_step
    with step("motions"):
        motions = ground_motions(case.motions, accept=ready is None)
        histories = [motion.history for motion in motions]
        ground = ground_of(case, histories, dt)
    with step("sticks"):
        if ready is None:
            calibration = calibration_of(case)
            system = system_of(case, calibration)
        else:
            calibration, system = ready
        all_modes = tuple(modes(stick) for stick in system.sticks)
    others = dict[str, Response]()
    with step("pounding"):
        loads = loads_of(case, system, dt, len(ground.acceleration))
        if models is None:
            response = _simulated(case, system, ground, dt, loads)
            free = free_response(system, ground, dt, loads)
            if ready is None and system.pairs:
                with comparison("steps half as long"):
                    finer = _driven(case, system, histories, 0.5 * dt)
                    others["other"] = _simulated(case, system, *finer)
        else:
            from impactfem.reduction.pounding_3d import Pounding3D

            in_3d = Pounding3D(case, system, models)
            response, free = in_3d.respond(ground, dt, loads), in_3d.free(ground, dt, loads)
            # What either changes is a check of the run, which does not need it.
            with comparison("half of the points of contact"):
                if ready is None and all(len(line) > FEW for line in models.lines):
                    fewer = Pounding3D(case, system, models, every=2)
                    others["halved"] = fewer.respond(ground, dt, loads)
            if ready is None and system.pairs:
                with comparison("steps twice as long"):
                    others["doubled"] = in_3d.respond(*_driven(case, system, histories, 2.0 * dt))
        system = response.system
        found = tuple(impacts(response))
        strength = {b.name: b.material.compressive_strength for b in case.buildings}
        checks = tuple(impact_checks(response, found, strength))
        apart = tuple(separations(free, response))
        facing = tuple(approaches(response, facing_floors(case).pairs))
    with step("spectra"):
        floors = floor_spectra(case, response)
        floors_free = floor_spectra(case, free, floors.directions)
        peaks = dict[str, Peaks]()
        other = others.get("other", others.get("doubled"))
        other_floors = None if other is None else floor_spectra(case, other, floors.directions)
        if models is not None:
            lines = len(models.lines)
            peaks["peaks"] = Peaks.of(response, lines, floors)
            for name, run in others.items():
                spectra = other_floors if run is other else None
                spectra = spectra or floor_spectra(case, run, floors.directions)
                peaks[name] = Peaks.of(run, lines, spectra)
    return StickStudy(
        case,
        motions,
        calibration,
        system,
        all_modes,
        response,
        free,
        found,
        checks,
        apart,
        facing,
        floors,
        floors_free,
        foundations(case, response),
        other=other,
        other_floors=other_floors,
        **peaks,
    )


def _simulated(
    case: Case, system: System, ground: Ground, step: float, loads: Sequence[Load]
) -> Response:
    run = simulate(system, ground, step, update=case.pounding.update, loads=loads)
    return with_lines(run, system.pairs)


def free_response(system: System, ground: Ground, step: float, loads: Sequence[Load]) -> Response:
    """Return the response of sticks without contact at a time step [s]."""
    free = simulate(system.without_contact(), ground, step, loads=loads)
    return with_lines(free, system.pairs)


def _driven(
    case: Case, system: System, histories: Sequence[History], step: float
) -> tuple[Ground, float, list[Load]]:
    """Return ground, step and loads for a run with another step [s], which is only compared."""
    ground = ground_of(case, histories, step)
    with quiet(warnings=False):  # the case's own steps have given theirs
        return ground, step, loads_of(case, system, step, len(ground.acceleration))


def station_dofs(system: System) -> Index:
    """Degrees of freedom of the floors of all buildings, shape (n_stations, 6)."""
    return np.vstack([system.floor_dofs(stick.name) for stick in system.sticks])


def moving(history: Array, dofs: Index) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The translations and the rotations in which a floor moves by more than rounding.

    Of a history of all degrees of freedom, shape (n_t, n_dofs), of those of the floors, shape
    (n_stations, 6).
    """
    largest = np.abs(history[:, dofs]).max(axis=(0, 1))
    translations, rotations = (
        tuple(COMPONENTS[k] for k in kind if largest[k] > STILL * largest[kind].max())
        for kind in (np.arange(3), np.arange(3, 6))
    )
    return translations, rotations


def floor_spectra(
    case: Case, response: Response, directions: tuple[str, ...] | None = None
) -> FloorSpectra:
    """Floor spectra at all mass centres along the directions in which a floor moves, or these."""
    dofs = station_dofs(response.system)
    if directions is None:
        directions = moving(response.absolute_acceleration, dofs)[0]
    columns = dofs[:, [COMPONENTS.index(name) for name in directions]]
    records, asked = response.absolute_acceleration[:, columns.ravel()].T, case.spectra
    spectra = response_spectra(
        records,
        response.time_step,
        case.spectra.frequency_values,
        case.spectra.damping,
        points_per_cycle=case.spectra.points_per_cycle,
        method=case.spectra.method,
        threads=threads(),
        absolute=False,
    )
    shape = (len(asked.damping), len(dofs), len(directions), spectra.frequency.size)
    return FloorSpectra(
        directions=directions,
        psa=spectra.psa.reshape(shape),
        sd=spectra.sd.reshape(shape),
        pfa=spectra.zpa.reshape(len(dofs), len(directions)),
        spectra=spectra,
    )


def pounded(
    case: Case,
    calibration: Calibration | None,
    motions: Sequence[GroundMotion],
    duration: float | None = None,
    models: Models3D | None = None,
) -> Response:
    """Run the pounding alone, of sticks or of 3D models, under given ground motions.

    The calibration does not depend on damping; damping and laws are those of the case. The duration
    [s] is that of the case where it is None; `models` are as of `run_sticks`. SolutionError where
    the start penetrates, contact forces do not converge, or lagged ones create energy.
    """
    dt, system = case.pounding.time_step, system_of(case, calibration)
    n_t = None if duration is None else int(duration / dt) + 2
    ground = ground_of(case, [motion.history for motion in motions], dt, n_t)
    loads = loads_of(case, system, dt, len(ground.acceleration))
    if models is None:
        return _simulated(case, system, ground, dt, loads)
    from impactfem.reduction.pounding_3d import Pounding3D

    return Pounding3D(case, system, models).respond(ground, dt, loads)

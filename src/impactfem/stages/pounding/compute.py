"""The stage `pounding`: motions, calibrated sticks, pounding, impacts, floor response spectra."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Case
from impactfem.case.facing import facing_floors
from impactfem.coupling.from_case import calibration_of, loads_of, system_of
from impactfem.coupling.impacts import (
    Approach,
    Impact,
    ImpactCheck,
    Separation,
    approaches,
    impact_checks,
    impacts,
    separations,
)
from impactfem.coupling.pounding import Response, System, interpolate_ground, simulate
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.spectra import ResponseSpectra, response_spectra
from impactfem.sticks.calibration import Calibration
from impactfem.sticks.modes import Modes, modes
from impactfem.system.parallel import threads

Array = NDArray[np.float64]
STEPS = {"motions": 1.0, "sticks": 3.0, "pounding": 2.0, "spectra": 4.0}
"""Steps of the stage and their expected share of its time, for the progress bar."""


@dataclass(frozen=True)
class FloorSpectra:
    """Spectra of all floors in the directions in which they move."""

    directions: tuple[str, ...]  #: "x", "y", "z": those in which a floor moves
    #: Pseudo-acceleration, shape (n_dampings, n_stations, n_directions, n_frequencies) [m/s2].
    psa: Array
    sd: Array  #: relative displacement, same shape [m]
    pfa: Array  #: peak floor acceleration, shape (n_stations, n_directions) [m/s2]
    spectra: ResponseSpectra  #: as computed, with frequencies, dampings and the sampling bound


@dataclass(frozen=True)
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

    @property
    def main_impact(self) -> Impact | None:
        """The impact with the largest force; None when nothing touched."""
        return max(self.impacts, key=lambda impact: impact.peak_force, default=None)

    @property
    def steps_of_law(self) -> float:
        """Fewest steps of an impact by the laws' own durations, over all impacts [-].

        nan without an impact, and where every contact began at rest.
        """
        durations = [i.pair.law.duration(i.approach) for i in self.impacts if i.approach > 0.0]
        return min(durations, default=np.nan) / self.response.time_step

    @property
    def stations(self) -> list[tuple[str, int]]:
        """Building and floor of each station."""
        return [
            (stick.name, floor.number) for stick in self.system.sticks for floor in stick.floors
        ]


def run_sticks(
    case: Case,
    step: Callable[[str], AbstractContextManager[None]] = lambda name: nullcontext(),
    *,
    ready: tuple[Calibration | None, System] | None = None,
    buildings: int | None = None,
) -> StickStudy:
    """Run the stage.

    Args:
        case: The case.
        step: Called with the name of each step of `STEPS`; the step runs inside its context.
        ready: Calibration and system where they are known, as with user-defined contact laws; made
            from the case when None.
        buildings: Number of buildings, from the first on, whose floor spectra are made; all when
            None.

    Raises:
        InputError: A record of the motion is not usable.
        SolutionError: A part of the computation found no usable result.
    """
    dt = case.pounding.time_step
    with step("motions"):
        motions = ground_motions(case.motions, accept=ready is None)
        longest = max(motion.accelerogram.duration for motion in motions)
        # Rounded, so that a step printed with four digits still gives the steps that were meant.
        n_t = round((case.pounding.duration or longest) / dt) + 1
        ground = interpolate_ground([motion.history for motion in motions], dt, n_t)
    with step("sticks"):
        if ready is None:
            calibration = calibration_of(case)
            system = system_of(case, calibration)
        else:
            calibration, system = ready
        all_modes = tuple(modes(stick) for stick in system.sticks)
    with step("pounding"):
        loads = loads_of(case, system, dt, n_t)
        response = simulate(system, ground, dt, update=case.pounding.update, loads=loads)
        free = simulate(system.without_contact(), ground, dt, loads=loads)
        found = tuple(impacts(response))
        strength = {b.name: b.material.compressive_strength for b in case.buildings}
        checks = tuple(impact_checks(response, found, strength))
        apart = tuple(separations(free, response))
        facing = tuple(approaches(response, facing_floors(case).pairs))
    with step("spectra"):
        floors = floor_spectra(case, response, buildings=buildings)
        floors_free = floor_spectra(case, free, floors.directions, buildings=buildings)
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
    )


def station_dofs(system: System, buildings: int | None = None) -> NDArray[np.int64]:
    """Degrees of freedom of the floors of the first buildings or all, shape (n_stations, 6)."""
    return np.vstack([system.floor_dofs(stick.name) for stick in system.sticks[:buildings]])


def floor_spectra(
    case: Case,
    response: Response,
    directions: tuple[str, ...] | None = None,
    *,
    buildings: int | None = None,
) -> FloorSpectra:
    """Floor response spectra at the mass centres of the first buildings, of all when None.

    Along the directions in which a floor moves, or along these.
    """
    dofs = station_dofs(response.system, buildings)
    acceleration = response.absolute_acceleration
    if directions is None:
        directions = tuple(
            name for i, name in enumerate("xyz") if np.any(acceleration[:, dofs[:, i]])
        )
    columns = dofs[:, ["xyz".index(name) for name in directions]]
    records = acceleration[:, columns.ravel()].T
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
    shape = (len(case.spectra.damping), len(dofs), len(directions), spectra.frequency.size)
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
    duration: float,
) -> Response:
    """Run the pounding of the sticks alone, under given ground motions.

    The calibration does not depend on damping; damping and laws are those of the case.

    Raises:
        SolutionError: The contact forces do not converge, or lagged ones create energy.
    """
    dt = case.pounding.time_step
    ground = interpolate_ground([m.history for m in motions], dt, int(duration / dt) + 2)
    system = system_of(case, calibration)
    loads = loads_of(case, system, dt, len(ground))
    return simulate(system, ground, dt, update=case.pounding.update, loads=loads)

"""Demands of a case: the quantities of its verdicts, from a run and from a variation.

A variation goes through the functions of the stages `pounding`, `transient` and `device`, without
results files, figures and response spectrum analyses. Its resolved band is that of the run: a
change is one of the response, not of the band.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case import BuildingInTime, Case
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import ground_of, loads_of, system_of
from impactfem.coupling.impacts import Separation, separations
from impactfem.coupling.pounding import Response
from impactfem.dynamics.damping import DampingLaw
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.reduction.loads import Loads
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.pounding_3d import Pounding3D
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.spectra.resolved import band_limited_zpa
from impactfem.stages.device import capacity
from impactfem.stages.device.compute import Prepared as DevicePrepared
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.device.selection import loaded
from impactfem.stages.device.store import results_in_time
from impactfem.stages.pounding import limits as of_floors
from impactfem.stages.pounding.compute import (
    floor_spectra,
    free_response,
    moving,
    pounded,
    station_dofs,
)
from impactfem.stages.pounding.peaks import storey_drifts
from impactfem.stages.pounding.store import OUTPUTS as FLOOR_OUTPUTS
from impactfem.stages.results import values
from impactfem.stages.stores import dataset, open_store
from impactfem.stages.transient import limits as of_models
from impactfem.stages.transient.node_results import by_node
from impactfem.stages.transient.prepared import Prepared, case_loads
from impactfem.stages.transient.reduced_run import ReducedRun
from impactfem.stages.transient.selection import resolved
from impactfem.stages.transient.store import AXES
from impactfem.stages.transient.store import OUTPUTS as MODEL_OUTPUTS
from impactfem.stages.verdict import Verdict
from impactfem.sticks.calibration import Calibration
from impactfem.sticks.element import COMPONENTS

LEFT_OUT = 0.01
"""Largest impulse that is left out, over the largest one."""
NEAR = 0.8
"""Part of the largest ordinate from which on the error of an ordinate counts."""
QUANTITY = "largest ordinate of the floor spectra"


def demands_of_run(case: Case, run: Path) -> list[Verdict]:
    """Return the demands of a run, from its results files, in the order of `Chain.demands`."""
    with open_store(run / "pounding.nc") as store:
        found = of_floors.verdicts_of(case, store)
        if not case.in_time:
            found.append(largest_ordinate("pounding.floor_spectrum", store))
    for building in case.in_time:
        folder = building.folder(run)
        with open_store(folder / "transient.nc") as store:
            found += of_models.verdicts_of(building, store)
            found.append(largest_ordinate("transient.floor_spectrum", store))
        if building.devices:
            with open_store(folder / "device.nc") as store:
                found += capacity.verdicts_of(building, loaded(store))
    return found


def largest_ordinate(id: str, store: xr.Dataset) -> Verdict:
    """Return the largest ordinate of the floor spectra of a results file, in its resolved band."""
    psa = resolved(store[["psa"]].isel(damping=0).assign_attrs(store.attrs))["psa"]
    at = psa.isel(psa.argmax(...))
    if "station" in psa.dims:
        place = f"{at['station_building'].item()}, floor {at['station_floor'].item()}"
        direction = at["direction"].item()
    else:
        place = f"{store.attrs['building']}, {at['probe'].item()}"
        direction = at["component"].item()
    return Verdict(
        id,
        QUANTITY,
        "m/s2",
        f"{place}, direction {direction}",
        float(at),
        frequency=float(at["frequency"]),
        band=(0.0, float(store.attrs["resolved_frequency"])),
    )


@dataclass(frozen=True, eq=False)
class Model:
    """A building with a reduced 3D model, and what its demands need."""

    name: str
    prepared: Prepared  #: with the devices, if it has some
    basis: ReducedBasis
    complete: CompleteModel  #: with the anchors
    end: float  #: of the resolved band at the probes [Hz]
    device_end: float  #: of the resolved band at the anchors [Hz]


@dataclass(frozen=True, eq=False)
class Demands:
    """The demands of a variation."""

    verdicts: list[Verdict]
    #: Largest error band of the largest ordinates of the reduced models, relative; nan where it
    #: was not requested.
    basis_error: float
    #: Largest impulse on a floor that a reduced model does not let touch, over the largest one.
    left_out: float


@dataclass(eq=False)
class Chain:
    """All that variations share: motion, sticks, 3D models and resolved bands."""

    calibration: Calibration | None
    models: tuple[Model, ...]
    end: float  #: of the resolved band of the floor spectra of the stage `pounding` [Hz]
    #: Responses without contact by what they depend on.
    free: dict[Any, Response] = field(default_factory=dict)

    def demands(self, case: Case, models: Models3D | None, *, basis_error: bool = False) -> Demands:
        """Return the demands of a case.

        Args:
            case: The case.
            models: The 3D models that pound, with the gaps of the case.
            basis_error: Whether the error of the reduced models is estimated.

        Raises:
            SolutionError: A response is not usable.
            KeyError: A reduced model has no pattern of a contact force.
        """
        motions = ground_motions(case.motions)
        response = pounded(case, self.calibration, motions, models=models)
        store = self._floors(case, motions, response, models)
        found = of_floors.verdicts_of(case, store)
        if not case.in_time:
            found.append(largest_ordinate("pounding.floor_spectrum", store))
        forces = ForceHistory.of_response(response)
        buildings = {building.name: building for building in case.in_time}
        errors, left_out = list[float](), 0.0
        for model in self.models:
            building = buildings[model.name]
            known, omitted = served(building, forces)
            left_out = max(left_out, omitted)
            loaded_model = LoadedModel.of(model, building, motions, known)
            found += loaded_model.verdicts()
            errors += [loaded_model.basis_error()] if basis_error else []
        return Demands(found, max(errors, default=math.nan), left_out)

    def _floors(
        self,
        case: Case,
        motions: tuple[GroundMotion, ...],
        response: Response,
        models: Models3D | None,
    ) -> xr.Dataset:
        """Return the results of `pounding.nc` that verdicts read."""
        system = response.system
        directions = moving(response.absolute_acceleration, station_dofs(system))[0]
        columns = station_dofs(system)[:, [COMPONENTS.index(name) for name in directions]]
        free = self._free(case, motions, models)
        drifts = [
            np.concatenate([storey_drifts(run, stick) for stick in system.sticks])
            for run in (response, free)
        ]
        stations = [(stick.name, floor.number) for stick in system.sticks for floor in stick.floors]
        content: dict[str, Any] = {
            "station": [f"{building}.floor_{number}" for building, number in stations],
            "station_building": [building for building, _ in stations],
            "station_floor": [number for _, number in stations],
            "direction": directions,
            "zpa": band_limited_zpa(
                response.absolute_acceleration[:, columns], response.time_step, self.end
            ),
            "zpa_free": band_limited_zpa(
                free.absolute_acceleration[:, columns], free.time_step, self.end
            ),
            "storey_drift": drifts[0],
            "storey_drift_no_contact": drifts[1],
        }
        if not case.in_time:
            spectra = floor_spectra(case, response, directions)
            content |= {
                "frequency": spectra.spectra.frequency,
                "damping": spectra.spectra.damping,
                "psa": spectra.psa,
            }
        if system.pairs:
            content |= {
                "pair": [pair.name for pair in system.pairs],
                "pair_rest_gap": [pair.gap for pair in system.pairs],
                **values(Separation, separations(free, response), "pair_"),
            }
        return dataset(FLOOR_OUTPUTS, content, attributes={"resolved_frequency": self.end})

    def _free(
        self, case: Case, motions: tuple[GroundMotion, ...], models: Models3D | None
    ) -> Response:
        """Return the response without contact, once for all variations of contact."""
        key = case.buildings, case.motions, case.pounding.time_step, case.pounding_in_3d
        if key not in self.free:
            dt, system = case.pounding.time_step, system_of(case, self.calibration)
            ground = ground_of(case, [motion.history for motion in motions], dt)
            loads = loads_of(case, system, dt, len(ground.acceleration))
            if models is None:
                self.free[key] = free_response(system, ground, dt, loads)
            else:
                self.free[key] = Pounding3D(case, system, models).free(ground, dt, loads)
        return self.free[key]


def served(building: BuildingInTime, forces: ForceHistory) -> tuple[ForceHistory, float]:
    """Return impact forces without those on floors that [transient] does not let touch.

    Such forces are left out up to `LEFT_OUT` of the largest impulse; the second value is their
    part. With more the forces are returned as they are, and the model refuses them.
    """
    floors = building.transient.floors
    ends = {contact.name: contact.ends for contact in building.contacts}
    beyond = [
        j
        for j, name in enumerate(forces.pairs)
        if floors is not None
        and any(
            point.building == building.name and point.level not in floors
            for point, _ in ends.get(name, ())
        )
    ]
    impulse = np.abs(forces.force).sum(axis=0)
    part = float(impulse[beyond].max(initial=0.0) / max(impulse.max(initial=0.0), 1e-300))
    if not 0.0 < part <= LEFT_OUT:
        return forces, 0.0
    force = forces.force.copy()
    force[:, beyond] = 0.0
    return replace(forces, force=force), part


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """A 3D model under the impact forces of a variation."""

    model: Model
    building: BuildingInTime  #: of the variation
    loads: Loads

    @classmethod
    def of(
        cls,
        model: Model,
        building: BuildingInTime,
        motions: tuple[GroundMotion, ...],
        forces: ForceHistory,
    ) -> LoadedModel:
        """Load a model by impact forces and motions."""
        prepared = model.prepared
        duration = building.transient.duration or float(forces.time[-1])
        loads = case_loads(
            building,
            prepared.parts.mesh,
            motions,
            forces,
            building.case.path,
            duration,
            impulses=prepared.impulses,
        )
        return cls(model, building, loads)

    @property
    def damping(self) -> DampingLaw:
        """Damping of the building."""
        return self.building.entry.damping.law

    @cached_property
    def run(self) -> ReducedRun:
        """The response of the reduced model."""
        transient, spectra = self.building.transient, self.building.case.spectra
        highest, band = transient.maximum_frequency, transient.band
        return ReducedRun(self.model.basis, self.loads, self.damping, spectra, highest, band)

    def verdicts(self) -> list[Verdict]:
        """Return the demands: at the probes, and of the devices."""
        prepared, end = self.model.prepared, self.model.end
        response, spectra = self.run.spectra_at(prepared.probe_nodes)
        store = dataset(
            MODEL_OUTPUTS,
            {
                "component": AXES,
                "probe": [probe.name for probe in prepared.probes],
                "probe_kind": [probe.kind for probe in prepared.probes],
                "probe_floor": [probe.floor for probe in prepared.probes],
                "frequency": spectra.frequency,
                "damping": spectra.damping,
                "psa": by_node(spectra.psa),
                "zpa": band_limited_zpa(response.acceleration, response.time_step, end),
            },
            attributes={"building": self.building.name, "resolved_frequency": end},
        )
        found = of_models.verdicts_of(self.building, store)
        found.append(largest_ordinate("transient.floor_spectrum", store))
        if isinstance(prepared, DevicePrepared):
            varied = replace(
                prepared, building=self.building, loads=self.loads, damping=self.damping
            )
            analyst = analyst_of(varied, self.model.complete)
            results = analyst.analyse(self.loads, self.damping, by_spectra=False)
            at_devices = results_in_time(varied, results, self.model.device_end)
            found += capacity.verdicts_of(self.building, at_devices)
        return found

    def basis_error(self) -> float:
        """Return the largest error band of an ordinate near the largest one, relative."""
        probes = self.run.at(self.model.prepared.probe_nodes)
        inside = probes.spectra.frequency <= self.model.end * (1.0 + 1e-9)
        psa, band = probes.psa[0][..., inside], probes.psa_band[0][..., inside]
        counts = psa >= NEAR * psa.max()
        return float((band[counts] / psa[counts]).max())

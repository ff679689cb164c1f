"""The stage `sensitivity`: variations of a case through sticks, reduced 3D models and devices."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from impactfem.case import BuildingInTime, Case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate.selection import with_contact_of_run
from impactfem.stages.device.compute import prepare_devices
from impactfem.stages.ensemble.compute import members_of
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.compute import reduced_on_soil
from impactfem.stages.reduce.stage import model_key, models_of_run
from impactfem.stages.sensitivity.demands import Chain, Model, demands_of_run
from impactfem.stages.sensitivity.variations import Source, Unknown, Variation, variations
from impactfem.stages.stores import names_of, open_store
from impactfem.stages.transient.prepared import prepared_of_run
from impactfem.stages.verdict import Verdict
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER
from impactfem.system.quantity import quantity, results, si

IMPACT_FORCE, DISPLACEMENT = (
    "pounding.main_impact_band_force",
    "pounding.required_separation",
)
"""Results by which the motions of an ensemble are ordered: the first one that it has."""


@results
class Demand:
    """A demand of the run; of a spectrum with a capacity, the ratio of both."""

    id: str = si("", "verdict", name="demand_id")
    quantity: str = si("", "demand", name="demand_quantity")
    place: str = si("", "place", name="demand_place")
    unit: str = si("", "SI unit", name="demand_unit")
    value: float = si("as unit", "value of the run")
    capacity: float = si("as unit", "capacity, nan without one")

    @classmethod
    def of(cls, verdict: Verdict) -> Demand:
        """Return the demand of a verdict; nan where it is not known."""
        known = math.nan if verdict.demand is None else verdict.demand
        capacity = math.nan if verdict.capacity is None else verdict.capacity
        of_spectrum = verdict.frequency is not None and verdict.ratio is not None
        if of_spectrum:
            words = f"{verdict.quantity}, demand / capacity"
            known, capacity = verdict.ratio or 0.0, 1.0
        else:
            words = verdict.quantity
        unit = "-" if of_spectrum else verdict.unit
        return cls(verdict.id, words, verdict.place, unit, known, capacity)


@results
class SensitivityResult:
    """Results of the stage."""

    demands: list[Demand]  #: of the run
    variations: list[Variation]
    #: Demands of the variations; nan where one failed.
    varied: Array = si("as unit", "value of the variation", dims="variation demand")
    unknown: list[Unknown]
    failed: dict[str, str]  #: reasons by the label of the variation
    #: Largest error band of the ordinates near the largest one; nan if damping is not varied.
    damping_basis_error: float = si("-", "error of the reduced models with the changed damping")
    #: Nan of a variation that failed.
    left_out: Array = si(
        "-", "impulse on floors that no reduced model lets touch / largest", dims="variation"
    )

    @property
    @quantity("-", "change of the demand", dims="variation demand")
    def change(self) -> Array:
        """Change of each demand, shape (n_variations, n_demands) [-]; nan of a demand of zero."""
        value = np.array([one.value for one in self.demands])
        change = self.varied / np.where(value != 0.0, value, math.nan) - 1.0
        return np.asarray(change, dtype=np.float64)


def run_sensitivity(case: Case, run: Path, progress: Callable[[float], None]) -> SensitivityResult:
    """Compute the demands of all variations of a case from the results of its run. Not collective.

    Args:
        case: The case as it was read.
        run: The folder of the run.
        progress: Called with the part that is done.

    Raises:
        ImpactfemError: A file of the run is missing or cannot be read.
    """
    inputs = POUNDING.key(case)
    case = with_contact_of_run(with_structure_sticks(case, run), run)
    calibration = calibration_of(case)
    found = list(map(Demand.of, demands_of_run(case, run)))
    models = tuple(_model(one, run, inputs) for one in case.in_time)
    with open_store(run / "pounding.nc") as store:
        end = float(store.attrs["resolved_frequency"])
    chain = Chain(calibration, models, end)
    source = Source(case, system_of(case, calibration), _impact_forces(case, run), members_of(case))
    known, unknown = variations(source)
    in_contact = models_of_run(case, run)
    failed = dict[str, str]()
    varied, left_out = np.full((len(known), len(found)), math.nan), np.full(len(known), math.nan)
    error = math.nan
    for k, one in enumerate(known):
        try:
            # Gaps along the edges are those of the variation.
            pounding = in_contact if one.parameter != "gap" else models_of_run(one.case, run)
            pounding = pounding if one.case.pounding_in_3d else None
            damped = one.parameter == "damping"
            demands = chain.demands(one.case, pounding, basis_error=damped)
        except (ImpactfemError, KeyError) as reason:
            failed[one.label] = str(reason)
            LOGGER.warning("warning: sensitivity: %s failed: %s", one.label, reason)
        else:
            varied[k] = [Demand.of(verdict).value for verdict in demands.verdicts]
            left_out[k] = demands.left_out
            error = demands.basis_error if damped else error
        progress((k + 1) / len(known))
    # A demand that the case does not compute, such as the gap of a code, has no sensitivity.
    there = [k for k, demand in enumerate(found) if math.isfinite(demand.value)]
    return SensitivityResult(
        demands=[found[k] for k in there],
        variations=known,
        varied=varied[:, there],
        unknown=unknown,
        failed=failed,
        damping_basis_error=error,
        left_out=left_out,
    )


def _model(building: BuildingInTime, run: Path, inputs: str) -> Model:
    folder = building.folder(run)
    reduced = reduced_on_soil(folder, model_key(building), building)
    prepared = prepared_of_run(building, run, inputs)
    ends = []
    for name in ("transient.nc", "device.nc") if building.devices else ("transient.nc",):
        with open_store(folder / name) as store:
            ends.append(float(store.attrs["resolved_frequency"]))
    return Model(
        building.name,
        prepare_devices(prepared) if building.devices else prepared,
        reduced.basis,
        # The contacts of the impact on the wall are most of the model, and not needed here.
        replace(reduced.complete, wall=None),
        ends[0],
        ends[-1],
    )


def _impact_forces(case: Case, run: Path) -> dict[str, float]:
    """Return what the motions of an ensemble are ordered by; empty without an ensemble."""
    if case.ensemble is None:
        return {}
    with open_store(run / "ensemble.nc") as store:
        names = names_of(store, "scalar")
        by = next((name for name in (IMPACT_FORCE, DISPLACEMENT) if name in names), None)
        if by is None:
            return {}
        values = store["value"].sel(scalar=by).values
        return dict(zip(names_of(store, "motion"), values.tolist(), strict=True))

"""One motion through the 3D building and the devices: spectra at the points, forces on anchors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.loads import Loads
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.design.floors import (
    NO_POINTS,
    WholeFloors,
    counted,
    enveloped,
    fewest,
    probe_points,
)
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.choice import SpectrumChoice, headline_of
from impactfem.stages.device.compute import Prepared as DevicePrepared
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.results import value
from impactfem.stages.transient.maps import AS_THEY_ARE
from impactfem.stages.transient.prepared import Prepared
from impactfem.system.arrays import Array, Index
from impactfem.system.parallel import threads
from impactfem.system.quantity import results, si

EVERY = 2
"""Step in the frequencies of the fields for the search of the vertices that govern under other
motions: 33 frequencies in a decade."""
AT_ONCE = 768
"""Records whose spectra are computed together."""
Arrays = dict[str, Any]


@dataclass(frozen=True, eq=False)
class DesignInputs:
    """Inputs of the stage, the same on all ranks, but for the reduced building."""

    #: the building with the loads of the case's own motion, targets of sticks and contact laws
    prepared: Prepared
    reduced: ReducedBuilding | None  #: on rank 0
    equipment: DevicePrepared | None = None  #: None without devices, or without an ensemble
    models: Models3D | None = None  #: the 3D models that pound; None if all buildings are sticks
    members_key: str = ""  #: hash of the inputs of all members, without their motions


@results
class MemberResult:
    """The results of one motion of an ensemble; forces on anchors are None without devices."""

    psa: Array = si("m/s2", "envelope of the points", dims="damping station direction frequency")
    zpa: Array = si("m/s2", "envelope of their peak accelerations", dims="station direction")
    centre_peak: Array = si(
        "m/s2",
        "largest pseudo-acceleration at the mass centre, up to maximum_frequency",
        dims="damping station direction",
    )
    vertices: Index = si("", "number of vertices that govern", dims="station direction")
    basis_error: Array = si("-", "estimated error of the transfer functions at the points")
    impact_force: Array = si("N", "largest impact force", dims="edge")
    device_force: Array | None = si(
        "N, N m", "largest force in the 3D model", dims="device component"
    )
    device_spectrum: Array | None = si(
        "N, N m", "force by response spectrum analysis", dims="device component"
    )


@dataclass(frozen=True, eq=False)
class Carrier:
    """The 3D building and the devices, which all motions share."""

    basis: ReducedBasis  #: of the building, at all nodes of the points and candidates
    points: pd.DataFrame  #: the probes of the floors, as of `probe_points`
    #: Which of them are at the mass centre of their floor, shape (n_points,).
    centres: NDArray[np.bool_]
    #: Vertices among which those that govern are sought; none without fields over the floors.
    candidates: pd.DataFrame
    frequency: Array  #: frequencies of this search [Hz]
    search_damping: float  #: damping ratio of its oscillators [-]
    damping: DampingLaw  #: of the building
    spectra: Spectra  #: the case's floor spectra
    highest: float  #: frequency up to which the model is valid [Hz]
    analyst: Analyst | None  #: of the devices; None without devices
    choice: SpectrumChoice | None  #: the response spectrum analysis; None without devices

    @classmethod
    def of(cls, inputs: DesignInputs, probes: xr.Dataset, whole: WholeFloors | None) -> Carrier:
        """Make it from the reduced building, on rank 0; the probes are those of `read_probes`."""
        building, reduced = inputs.prepared.building, inputs.reduced
        if reduced is None:
            raise ValueError("without a reduced building")
        damping, highest = inputs.prepared.damping, building.transient.maximum_frequency
        governing = NO_POINTS if whole is None else whole.governing
        candidates = NO_POINTS if whole is None else whole.candidates
        nodes = np.union1d(probes["probe_node"].values, governing["node"])
        points = probe_points(probes)
        error = reduced.basis.error(nodes, damping, highest)
        at_points = reduced.basis.at(np.union1d(nodes, candidates["node"]))
        analyst, choice = _analyst(inputs.equipment, reduced)
        return cls(
            basis=replace(at_points, difference=error),
            points=points,
            centres=np.isin(points["point"], probes["centre"].values),
            candidates=candidates,
            frequency=np.zeros(0) if whole is None else whole.frequency[::EVERY],
            search_damping=0.0 if whole is None else whole.damping,
            damping=damping,
            spectra=building.case.spectra,
            highest=highest,
            analyst=analyst,
            choice=choice,
        )

    def governing(self, loads: Loads, modal: Array) -> pd.DataFrame:
        """Choose the vertices that govern under a motion: the fewest of the candidates.

        `modal` is q'' of the finest model of the basis under the loads, shape (r, n_t).
        """
        every = self.candidates
        curves = np.empty((len(every), len(self.frequency) + 1))
        for first in range(0, len(every), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            # Records without samples between: accurate enough for the choice.
            rough = response_spectra(
                point_records(self.basis, loads, modal, every.iloc[part], np.float32),
                loads.time_step,
                self.frequency,
                [self.search_damping],
                points_per_cycle=AS_THEY_ARE,
                threads=threads(),
                absolute=False,
            )
            curves[part, :-1], curves[part, -1] = rough.psa[0], rough.zpa
        groups = every.groupby(["floor", "component"]).indices.values()
        return pd.concat([NO_POINTS, *(every.iloc[rows[fewest(curves[rows])]] for rows in groups)])


def _analyst(
    equipment: DevicePrepared | None, reduced: ReducedBuilding
) -> tuple[Analyst | None, SpectrumChoice | None]:
    """Return the analyst of the devices with one response spectrum analysis each, and which."""
    if equipment is None:
        return None, None
    # Of each device the headline analysis alone: translations, spectra as computed.
    choice = headline_of(equipment.plans[0].rules)
    rule = choice.combination, choice.rigid
    # The contacts of the wall experiment are most of the model, and not needed here.
    analyst = analyst_of(equipment, replace(reduced.complete, wall=None))
    plans = [
        replace(plan, rules={rule: plan.rules[rule]}, rotations=False, broadening=0.0, given=())
        for plan in analyst.plans
    ]
    return replace(analyst, plans=plans, covered=[()] * len(analyst.covered)), choice


def point_records(
    basis: ReducedBasis, loads: Loads, modal: Array, points: pd.DataFrame, kind: Any = np.float64
) -> Array:
    """Compute absolute accelerations of points along their directions, shape (n, n_t) [m/s2].

    `modal` is q'' of the finest model of the basis under the loads, shape (r, n_t). Single
    precision, as `kind`, takes half the time. KeyError: the basis was not made for a node.
    """
    component = points["component"].to_numpy()
    shapes = basis.of(basis.model, points["node"].to_numpy())[np.arange(len(points)), component]
    relative = shapes.astype(kind) @ modal.astype(kind)
    return np.asarray(relative + loads.ground.T[component], dtype=np.float64)


def carry(carrier: Carrier, loads: Loads, impact_force: Array) -> Arrays:
    """Compute the results of one motion: the values of a `MemberResult` by their stored names.

    Points are the probes and the vertices that govern under this motion; the error of the basis is
    that at the probes and at the vertices that govern under the case's own motion.

    Loads and largest impact forces [N] are those of `motion_loads`.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device, or the result is not finite.
        KeyError: The basis has no pattern of one of the loads.
    """
    basis, floors = carrier.basis, int(carrier.centres.sum()) // 3
    modal = modal_histories(basis, loads, carrier.damping).acceleration
    chosen = carrier.governing(loads, modal)
    points = pd.concat([carrier.points, chosen], join="inner")
    spectra = record_spectra(
        point_records(basis, loads, modal, points), loads.time_step, carrier.spectra
    )
    valid = spectra.frequency <= carrier.highest * (1.0 + 1e-9)
    at_centres = spectra.psa[:, np.flatnonzero(carrier.centres)][..., valid]
    force = by_spectrum = None
    if carrier.analyst is not None and carrier.choice is not None:
        found = carrier.analyst.analyse(loads, carrier.damping)
        force = np.array([one.detailed.largest for one in found])
        by_spectrum = np.array([one.values(carrier.choice) for one in found])
    result = MemberResult(
        psa=enveloped(points, spectra.psa, floors, axis=1),
        zpa=enveloped(points, spectra.zpa, floors),
        centre_peak=at_centres.max(axis=2).reshape(-1, floors, 3),
        vertices=counted(chosen, floors),
        basis_error=np.array(basis.difference),
        impact_force=impact_force,
        device_force=force,
        device_spectrum=by_spectrum,
    )
    return value(result, "member_")

"""An ensemble of motions through the 3D building and the devices, one motion after another.

Each motion goes through the sticks first, whose impact forces then act on the 3D building. Its
results are stored as soon as they are there, so that an interrupted run goes on.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case, Spectra
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import ground_of, loads_of
from impactfem.coupling.pounding import System
from impactfem.dynamics.damping import DampingLaw
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.forces import with_floor_forces
from impactfem.reduction.loads import Loads, make_loads
from impactfem.reduction.pounding_3d import Models3D
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.design.floors import NO_POINTS, counted, enveloped, fewest
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.spectrum_plan import SpectrumChoice
from impactfem.stages.pounding.compute import respond
from impactfem.stages.transient.maps import AS_THEY_ARE
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError
from impactfem.system.parallel import threads

Arrays = dict[str, Any]

AT_ONCE = 768
"""Records whose spectra are computed together."""


def motion_loads(
    case: Case,
    system: System,
    names: Sequence[str],
    edges: Sequence[Shares],
    mesh: BuildingMesh,
    models: Models3D | None = None,
) -> tuple[Loads, Array]:
    """Compute the pounding under the motions of a case as the stage `pounding` does.

    Gives the loads at the step of the 3D model, by the patterns of each of the contact pairs that
    touch the building (`names`), and the largest force on each floor that a pair touches, ascending
    [N]; 0 on one that is not hit.

    Raises:
        InputError: A record is not usable.
        SolutionError: The sticks found no usable result, or their motion is too short.
    """
    transient, dt = transient_of(case), case.pounding.time_step
    motions = ground_motions(case.motions, accept=False)
    histories = [motion.history for motion in motions]
    ground = ground_of(case, histories, dt)
    forces = loads_of(case, system, dt, len(ground.acceleration))
    response = respond(case, system, ground, forces, models)
    duration = transient.duration or float(response.time[-1])
    if response.time[-1] < duration - dt:
        raise SolutionError(
            f"the pounding ends at {response.time[-1]:g} s, the 3D model runs up to {duration:g} s"
        )
    exerted = ForceHistory.of_response(response)
    history = exerted.of([exerted.pairs.index(name) for name in names])
    n_steps = math.floor(duration / transient.time_step * (1.0 + 1e-9))
    on_building, acting = with_floor_forces(case, mesh, history, list(edges))
    loads = make_loads(
        *(histories, on_building, acting, transient.time_step, n_steps, len(acting) - len(edges)),
        delay=case.delays.get(case.modelled.building, 0.0),
    )
    floor = np.array([shares[0][0].floor for shares in edges])
    # Points of contact of one line press together.
    lines = np.array(history.ends.line or names)
    lines = np.where(lines == "", names, lines)
    of_line = {k: history.force[:, lines == k].sum(axis=1).max() for k in np.unique(lines)}
    peaks = [max(of_line[k] for k in lines[floor == one]) for one in np.unique(floor)]
    return loads, np.array(peaks, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Carrier:
    """What all motions share."""

    #: The reduced basis of the building, at all nodes of the points and candidates.
    basis: ReducedBasis
    points: pd.DataFrame  #: the probes of the floors, as of `probe_points`
    #: Which of them are at the mass centre of their floor, shape (n_points,).
    centres: NDArray[np.bool_]
    #: Among which the vertices that govern are sought; none without fields over the floors, where
    #: the probes stand alone for them.
    candidates: pd.DataFrame
    frequency: Array  #: at which frequencies they are sought [Hz]
    search_damping: float  #: with which damping of the oscillators [-]
    damping: DampingLaw  #: of the building
    spectra: Spectra  #: the case's floor spectra
    analyst: Analyst | None  #: of the devices; None without devices
    choice: SpectrumChoice | None  #: which response spectrum analysis counts; None without devices


def point_records(
    basis: ReducedBasis, loads: Loads, modal: Array, points: pd.DataFrame, kind: Any = np.float64
) -> Array:
    """Absolute accelerations of points, each along its direction, shape (n, n_t) [m/s2].

    `modal` is q'' of the finest model of the basis under the loads, shape (r, n_t). In single
    precision, as `kind`, it takes half the time. KeyError: the basis was not made for a node.
    """
    component = points["component"].to_numpy()
    shapes = basis.of(basis.model, points["node"].to_numpy())[np.arange(len(points)), component]
    relative = shapes.astype(kind) @ modal.astype(kind)
    return np.asarray(relative + loads.ground.T[component], dtype=np.float64)


def carry(carrier: Carrier, loads: Loads, impact_force: Array) -> Arrays:
    """The results of one motion, by their names in `design.nc`.

    From loads and largest forces as of `motion_loads`; these are among the results.
    `member_psa`, the envelope over the probes of each floor and the vertices that govern under this
    motion, shape (n_dampings, n_floors, 3, n_f), and `member_zpa` of their peak accelerations,
    shape (n_floors, 3) [m/s2]; `member_centre_peak`, the largest ordinate at the mass centres,
    shape (n_dampings, n_floors, 3) [m/s2]; `member_vertices`, how many govern, shape (n_floors, 3);
    `member_basis_error`, the largest estimated error of the transfer functions of the basis at the
    probes and at the vertices that govern under the case's own motion [-]; with devices
    `member_device_force` and `member_device_spectrum`, the largest force on each anchor in the 3D
    model and by response spectrum analysis, shape (n_a, 6) [N, N m].

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device, or the result is not finite.
        KeyError: The basis has no pattern of one of the loads.
    """
    basis, floors = carrier.basis, int(carrier.centres.sum()) // 3
    modal = modal_histories(basis, loads, carrier.damping).acceleration
    # The fewest candidates whose envelope is near that of all candidates, as of `fewest`.
    every = carrier.candidates
    curves = np.empty((len(every), len(carrier.frequency) + 1))
    for first in range(0, len(every), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        # Records as they are, without samples between: enough to choose by.
        rough = response_spectra(
            point_records(basis, loads, modal, every.iloc[part], np.float32),
            loads.time_step,
            carrier.frequency,
            [carrier.search_damping],
            points_per_cycle=AS_THEY_ARE,
            threads=threads(),
            absolute=False,
        )
        curves[part, :-1], curves[part, -1] = rough.psa[0], rough.zpa
    groups = every.groupby(["floor", "component"]).indices.values()
    chosen = pd.concat([NO_POINTS, *(every.iloc[rows[fewest(curves[rows])]] for rows in groups)])
    points = pd.concat([carrier.points, chosen], join="inner")
    spectra = record_spectra(
        point_records(basis, loads, modal, points), loads.time_step, carrier.spectra
    )
    centres = np.flatnonzero(carrier.centres)
    found = {
        "member_psa": enveloped(points, spectra.psa, floors, axis=1),
        "member_zpa": enveloped(points, spectra.zpa, floors),
        "member_centre_peak": spectra.psa[:, centres].max(axis=2).reshape(-1, floors, 3),
        "member_vertices": counted(chosen, floors),
        "member_basis_error": np.array(basis.difference),
        "member_impact_force": impact_force,
    }
    if carrier.analyst is not None and carrier.choice is not None:
        results = carrier.analyst.analyse(loads, carrier.damping)
        by_spectrum = [one.values(carrier.choice) for one in results]
        found["member_device_force"] = np.array([one.detailed.largest for one in results])
        found["member_device_spectrum"] = np.array(by_spectrum)
    return found


def stacked(names: Sequence[str], found: Mapping[str, Arrays], failed: Mapping[str, str]) -> Arrays:
    """The results of all motions, each array with the motions first; at least two are needed."""
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(
            f"fewer than two members of the ensemble went through the 3D model: {reasons}"
        )
    # Those that were stored before have their key among them.
    parts = [part for part in found[names[0]] if part != "key"]
    return {part: np.stack([found[name][part] for name in names]) for part in parts}

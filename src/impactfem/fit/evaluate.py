"""What the model gives for the data of a fit, by the cheapest way: algebra, modes, or a run."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from impactfem.case import Case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.fit.fit_file import ModesTarget, ScalarTarget
from impactfem.fit.pieces import Pieces, read_off
from impactfem.fit.problem import STICK_MODES, Problem, sensor_nodes
from impactfem.run.sweep import run_variant
from impactfem.run.variants import write_case
from impactfem.stages.pounding.store import scalars_of_modes
from impactfem.stages.stores import open_store
from impactfem.sticks.modes import modes
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError
from impactfem.system.log import collected_warnings
from impactfem.system.parallel import alone

if TYPE_CHECKING:
    from impactfem.fit.modal import View


@dataclass(frozen=True)
class Evaluation:
    """What the model gives."""

    values: list[float]  #: one for each datum, in SI
    #: Their slopes by each key on the scale of the fit, a list a key; None for a key whose slopes
    #: differences give. None where they were not requested.
    slopes: list[list[float] | None] | None
    shown: dict[str, float]  #: MAC of each measured mode, and the number of the model's
    scale: str = ""  #: the scale of the slopes, as `Problem.scale`


def evaluate(problem: Problem, u: Array, folder: Path, slopes: bool = False) -> Evaluation:
    """Evaluate the model at places on the scale of the fit, shape (n,). Not collective.

    Slopes come in closed form from the modes of the 3D models, and with them from differences of
    the algebra; without 3D modes, and by a key that changes the mesh, there are none.

    Args:
        problem: The problem.
        u: The places.
        folder: Folder of the fit, where runs go.
        slopes: Whether slopes are wanted.

    Raises:
        InputError: A target names no result, or one of another unit.
        SolutionError: A computation failed, or a result has no value.
    """
    with alone(), collected_warnings("progress"), ExitStack() as held:
        case, pieces, views = problem.case(u), Pieces(), []
        _sticks(problem, case, pieces)
        if problem.level == "run":
            _run(problem, case, u, folder, pieces)
        elif problem.level != "sticks":
            from impactfem.fit.modal import View, mesh_floors  # dolfinx where it is needed

            where = Path(held.enter_context(TemporaryDirectory()))
            for name, building in case.modelled.items():
                (where / name).mkdir()
                if problem.level == "modes":
                    views.append(View(building, where / name, problem))
                    held.callback(views[-1].destroy)
                    views[-1].into(pieces)
                elif problem.of_floors(name):
                    pieces.floors[name] = mesh_floors(building, where / name, problem)
        values, shown = read_off(problem, case, pieces)
        off = [d.name for d, x in zip(problem.data, values, strict=True) if not np.isfinite(x)]
        if off:
            raise SolutionError(f"the model has no finite value of {', '.join(off[:3])}")
        # Without 3D modes there is nothing to compute: the place is not evaluated again for them.
        of_keys = _slopes(problem, u, views) if slopes or not views else None
        return Evaluation(values, of_keys, shown, problem.scale)


def _slopes(problem: Problem, u: Array, views: Sequence[View]) -> list[list[float] | None]:
    """Slopes by each key a step to either side: the sticks anew, the 3D models linear in modes."""
    found: list[list[float] | None] = [None] * len(u)
    sides, changes = {}, []
    for k in range(len(u)) if views else ():
        ends = problem.ends(u, k)
        cases = problem.case(ends[0]), problem.case(ends[1])
        of_key = [view.change(cases, (ends[0][k] - u[k], ends[1][k] - u[k])) for view in views]
        if None not in of_key:
            sides[k] = [(case, Pieces()) for case in cases]
            changes.append([change for change in of_key if change is not None])
    pieces = [(low[1], high[1]) for low, high in sides.values()]
    for view, of_view in zip(views, zip(*changes, strict=True), strict=False):
        view.moved(of_view, pieces)
    for k, both in sides.items():
        for case, at in both:
            _sticks(problem, case, at)
        low, high = (np.array(read_off(problem, case, at)[0]) for case, at in both)
        ends = problem.ends(u, k)
        found[k] = ((high - low) / (ends[1][k] - ends[0][k])).tolist()
    return found


def _sticks(problem: Problem, case: Case, pieces: Pieces) -> None:
    """Add the modes of the sticks, where a target is one of them."""
    models = {one.building for one in case.structures}
    targets = problem.fit.targets
    measured = [t for t in targets if isinstance(t, ModesTarget) and t.building not in models]
    if not measured and not any(
        isinstance(t, ScalarTarget) and STICK_MODES.fullmatch(t.result) for t in targets
    ):
        return
    # Contact laws may wait for a calibration, and sticks of 3D models for a run.
    own = tuple(one for one in case.buildings if one.name not in case.sticks_on_models)
    bare = case.model_copy(update={"contacts": (), "buildings": own})
    sticks = system_of(bare, calibration_of(case)).sticks
    found = [modes(stick) for stick in sticks]
    pieces.scalars |= {one.name: one for one in scalars_of_modes(case, sticks, found)}
    for target in measured:
        k = [stick.name for stick in sticks].index(target.building)
        building = case.building(target.building)
        centres = np.array([(*building.axis, z) for z in building.elevations])
        # A rigid floor moves a sensor by u + θ × (x − c): the nearest one, by its height.
        floor = np.abs(target.places[:, 2:] - centres[:, 2]).argmin(axis=1)
        e = np.eye(3)[target.along]
        turned = np.cross(target.places - centres[floor], e)  # (θ × a) · e = θ · (a × e)
        φ = found[k].shape[: 6 * len(centres)].reshape(len(centres), 6, -1)[floor]
        at = np.einsum("ni,nik->kn", e, φ[:, :3]) + np.einsum("ni,nik->kn", turned, φ[:, 3:])
        pieces.modes[target.building] = found[k].frequency, at


def _run(problem: Problem, case: Case, u: Array, folder: Path, pieces: Pieces) -> None:
    """Add what a run of the stages gives, in a folder of its own; finished stages are reused."""
    variant = problem.tried(u)
    write_case(variant, problem.source, folder)
    for stage in problem.stages:
        outcome = run_variant(variant, folder, stage, draw=False, apart=True)
        if outcome.error:
            raise SolutionError(f"{variant.title}: {outcome.error}")
        pieces.scalars |= {one.name: one for one in outcome.scalars}
    pieces.run = variant.run_folder(folder)
    for name, building in case.modelled.items():
        own = building.folder(pieces.run)
        target = problem.measured(name)
        if problem.of_floors(name):
            from impactfem.fit.modal import mesh_floors

            pieces.floors[name] = mesh_floors(building, own)
        if target is not None:
            from impactfem.building.read_mesh import read_mesh
            from impactfem.stages.building.compute import mesh_of_run

            mesh = read_mesh(mesh_of_run(building, own))
            nodes = sensor_nodes(problem.path, problem.fit, target, mesh)
            with open_store(own / "building.nc") as store:
                at = store["shape"].values[:, nodes, target.along].astype(np.float64)
                pieces.modes[name] = store["frequency"].values, at

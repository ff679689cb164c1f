"""The stage `reduce`: one basis of few vectors for the 3D building, under all of its loads."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from impactfem.case import Building3D, Case
from impactfem.case.transient import transient_files
from impactfem.stages.building.stage import BUILDING, storey_factor
from impactfem.stages.check import Check, Criterion
from impactfem.stages.inputs import inputs_key
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.stages.stores import names_of, open_store
from impactfem.system.files import atomic, read_archive
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root

if TYPE_CHECKING:
    from impactfem.reduction.models_3d import Models3D


def _wanted(building: Building3D) -> str:
    """What loads, nodes and accuracy of the reduced building depend on, but for damping."""
    case, transient = building.case, building.transient
    keys = {"tolerance", "maximum_frequency", "largest_basis", "band", "floors", "probes"}
    keys |= {"export", "export_nodes", "serve_damping_cases"}
    keys |= {"spread", "patch_width", "eccentricity"}
    content: dict[str, object] = {
        "transient": None if transient is None else transient.model_dump_json(include=keys),
        # The lightest of them counts where devices stand on the building, or where all are served.
        "dampings": [str(one.law) for one in case.damping_cases]
        if building.devices or (transient is not None and transient.serve_damping_cases)
        else [],
        "directions": sorted(motion.direction for motion in case.motions),
        "soil": building.entry.soil is not None,
        "contacts": [
            contact.model_dump_json(include={"a", "b", "normal", "along", "length", "depth"})
            for contact in case.contacts
        ],
    }
    if case.pounding_in_3d:
        content["pounding"] = case.pounding.model_dump_json(include={"models", "contact_spacing"})
        content["gaps"] = [contact.gap for contact in case.contacts]
        content["others"] = [BUILDING.key(one) for one in case.modelled.values()]
    return json.dumps(content)


def _files(building: Building3D) -> tuple[Path, ...]:
    """Forces that say which floors are hit, where no contacts do."""
    case, transient = building.case, building.transient
    forces = () if transient is None or case.contacts else transient_files(transient)
    return (*forces, *(loads.file for loads in case.loads))


def model_key(building: Building3D) -> str:
    """Hash of what the vectors of the reduced building depend on: not on gaps, times and masses.

    Its loads, its nodes, and how accurate it is for a damping are checked when it is used again.
    """
    transient, wall = building.transient, building.wall_impact
    own = "" if transient is None else transient.model_dump_json(include={"shift"})
    if wall is not None:
        own += wall.model_dump_json(
            include={"floors", "displaced_floor", "pull", "contact_spacing"}
        )
    placed = {"point", "radius", "supports", "envelope"}
    own += "".join(device.model_dump_json(include=placed) for device in building.devices)
    covered = any(anchor.envelope for device in building.devices for anchor in device.anchor_points)
    if covered and transient is not None:
        own += transient.model_dump_json(include={"probes"})
    # The matrices are those of the stage building.
    rest = inputs_key(building, BUILDING.sections, BUILDING.files(building))
    return hashlib.sha256(f"{own}{rest}".encode()).hexdigest()


def take_model(building: Building3D, run: Path, others: Iterable[Path]) -> Path | None:
    """Copy the largest reduced building of other runs with the same 3D model.

    It may serve another damping, gap or motion, which the stage then sees. Gives the folder it was
    copied from; None when none has it, or this run has one already.
    """
    from impactfem.stages.reduce.store import MODEL

    own = building.folder(run)
    if (own / MODEL).is_file():
        return None
    found = {other: building.folder(other) / MODEL for other in others}
    sizes = {other: path.stat().st_size for other, path in found.items() if path.is_file()}
    key = model_key(building)
    for other in sorted(sizes, key=sizes.__getitem__, reverse=True):
        if read_archive(found[other], key) is not None:
            own.mkdir(parents=True, exist_ok=True)
            with atomic(own / MODEL) as temporary:
                shutil.copyfile(found[other], temporary)
            return other
    return None


def models_of_run(case: Case, run: Path) -> Models3D | None:
    """The 3D models of a run that pound, and the lines along which they touch. Not collective.

    None where all buildings are sticks; ImpactfemError where a reduced building is lacking.
    """
    if not case.pounding_in_3d:
        return None
    # dolfinx and PETSc are loaded where 3D models pound, not before.
    from impactfem.building.mesh import outward_normal
    from impactfem.building.read_mesh import read_mesh
    from impactfem.reduction.contact_line import contact_lines
    from impactfem.reduction.forces import loaded_edges
    from impactfem.reduction.models_3d import Models3D
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.reduce.compute import reduced_of_run

    meshes, models, pushes = {}, {}, {}
    for name, building in case.modelled.items():
        if building.pounds:
            own = building.folder(run)
            meshes[name] = read_mesh(mesh_of_run(building, own))
            for floor, shares in loaded_edges(building, meshes[name]).items():
                pushes[name, floor] = outward_normal(meshes[name], floor), shares
            complete = reduced_of_run(own, model_key(building)).complete
            # Without what stands on it, and the wall: members of ensembles are handed the rest.
            models[name] = replace(
                complete,
                wall=None,
                anchors=complete.anchors[:0],
                anchors_carried=complete.anchors_carried[:0],
            )
    return Models3D(contact_lines(case, meshes), models, pushes)


def _compute(building: Building3D, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.reduce.compute import prepare, run_reduce
    from impactfem.stages.reduce.store import MODEL, write_reduced

    mesh, run = mesh_of_run(building, folder), building.run_folder(folder)
    with steps.step("inputs"):
        others = {
            name: mesh_of_run(other, other.folder(run))
            for name, other in building.case.modelled.items()
        }
        prepared = on_root(lambda: prepare(building, mesh, storey_factor(folder), others))
    reduced = run_reduce(prepared, folder, steps, model_key=on_root(lambda: model_key(building)))

    def write() -> list[Path]:
        if reduced is None:
            return []
        path = folder / "reduce.nc"
        write_reduced(path, building.case.title, reduced, prepared.plan.accuracies, key)
        return [path, folder / MODEL]

    return on_root(write)


def _subjects(case: Case) -> tuple[Building3D, ...]:
    """The buildings whose 3D models are computed in time, hit the wall, or pound."""
    return tuple(b for b in case.modelled.values() if b.transient or b.wall_impact or b.pounds)


TRANSFER_FUNCTIONS = Criterion(
    "reduce.transfer_function_error",
    "error of the transfer functions",
    "%",
    consequence="Responses of the reduced model may be wrong by this error",
    remedy="Raise transient.largest_basis, or allow a larger transient.tolerance",
)


def _checks(folder: Path) -> list[Check]:
    """Check the transfer functions of the reduced model against the required accuracy."""
    checks: list[Check] = []
    with open_store(folder / "reduce.nc") as store:
        for k, name in enumerate(names_of(store, "accuracy")):
            at = store.isel(accuracy=k)
            place = f"up to {float(at['maximum_frequency']):g} Hz, damping {name}"
            tolerance = float(at["tolerance"])
            checks.append(TRANSFER_FUNCTIONS.check(float(at["error"]), place, upper=tolerance))
    return checks


REDUCE = StageOf[Building3D](
    name="reduce",
    title="The reduced 3D model",
    about="One basis of few vectors under all loads of the 3D model, and its error.",
    headlines=("{reduce.krylov_vectors} vectors, {reduce.complete_vectors} with contacts",),
    steps={
        "inputs": 2.0,
        "matrices": 4.0,
        "loads": 7.0,
        "factor": 7.0,
        "basis": 70.0,
        "contacts and anchors": 35.0,
        "modes": 3.0,
        "shapes": 3.0,
        "stores": 1.0,
        DRAWING: 0.0,
    },
    sections=("buildings", "damping"),
    files=_files,
    further=lambda building: f"{model_key(building)}{_wanted(building)}",
    stores={"reduce": "reduce.nc"},
    compute=_compute,
    tabulate=lambda building, folder: [],
    checks=lambda building, folder: _checks(folder),
    needs=lambda building: (BUILDING,),
    subjects=_subjects,
    section="transient",
    collective=True,
)

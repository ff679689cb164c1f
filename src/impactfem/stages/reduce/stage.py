"""The stage `reduce`: one basis of few vectors for the 3D building, under all of its loads."""

from __future__ import annotations

import json
from pathlib import Path

from impactfem.case import Case
from impactfem.case.transient import transient_files
from impactfem.stages.building.stage import BUILDING, storey_factor
from impactfem.stages.check import Check, limited
from impactfem.stages.inputs import matrices_key
from impactfem.stages.stage import DRAWING, Stage
from impactfem.stages.stores import names_of, open_store
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root


def _wanted(case: Case) -> str:
    """What loads, nodes and accuracy of the reduced building depend on, but for damping."""
    transient = case.transient
    keys = {
        *("tolerance", "maximum_frequency", "largest_basis", "band", "floors", "probes"),
        *("export", "export_nodes", "serve_damping_cases"),
        *("spread", "patch_width", "eccentricity"),
    }
    content = {
        "transient": None if transient is None else transient.model_dump_json(include=keys),
        # The lightest of them counts where devices stand on the building, or where all are served.
        "dampings": [str(one.law) for one in case.damping_cases]
        if case.devices or (transient is not None and transient.serve_damping_cases)
        else [],
        "directions": sorted(motion.direction for motion in case.motions),
        "contacts": [
            contact.model_dump_json(include={"a", "b", "normal"}) for contact in case.contacts
        ],
    }
    return json.dumps(content)


def _files(case: Case) -> tuple[Path, ...]:
    """Forces that say which floors are hit, where no contacts do."""
    forces = () if case.transient is None or case.contacts else transient_files(case.transient)
    return (*forces, *(loads.file for loads in case.loads))


def model_key(case: Case) -> str:
    """Hash of what the vectors of the reduced building depend on: not on gaps, times and masses.

    Its loads, its nodes, and how accurate it is for a damping are looked at when it is used again.
    """
    transient, wall = case.transient, case.wall_impact
    own = "" if transient is None else transient.model_dump_json(include={"shift"})
    if wall is not None:
        own += wall.model_dump_json(
            include={"floors", "displaced_floor", "pull", "contact_spacing"}
        )
    placed = {"point", "radius", "supports", "envelope"}
    own += "".join(device.model_dump_json(include=placed) for device in case.devices)
    covered = any(anchor.envelope for device in case.devices for anchor in device.anchors)
    if covered and transient is not None:
        own += transient.model_dump_json(include={"probes"})
    return matrices_key(case, REDUCE.modules, own)


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.reduce.compute import MODEL, prepare, run_reduce
    from impactfem.stages.reduce.store import write_reduced

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        prepared = on_root(lambda: prepare(case, mesh, storey_factor(folder)))
    reduced = run_reduce(
        prepared,
        folder,
        communicator(),
        steps.step,
        model_key=on_root(lambda: model_key(case)),
        within=steps.within,
    )

    def write() -> list[Path]:
        if reduced is None:
            return []
        with steps.step("stores"):
            path = folder / "reduce.nc"
            write_reduced(path, case.title, reduced, prepared.plan.accuracies, key)
        return [path, folder / MODEL]

    return on_root(write)


def _lacks(case: Case) -> str | None:
    return "transient" if case.transient is None and case.wall_impact is None else None


def _checks(folder: Path) -> list[Check]:
    """Whether the transfer functions are as accurate as required, in words."""
    checks: list[Check] = []
    with open_store(folder / "reduce.nc") as store:
        for k, name in enumerate(names_of(store, "accuracy")):
            at = store.isel(accuracy=k)
            text = (
                f"reduce: error of the transfer functions up to {float(at['maximum_frequency']):g} "
                f"Hz with a damping of {name}"
            )
            checks.append(limited(text, float(at["error"]), float(at["tolerance"]), "%"))
    return checks


REDUCE = Stage(
    name="reduce",
    title="The reduced 3D model",
    about="One basis of few vectors under all loads of the 3D model, and its error.",
    headlines=("{reduce.krylov_vectors} vectors, {reduce.complete_vectors} with contacts",),
    steps={"inputs": 2.0, "matrices": 5.0, "basis": 100.0, "stores": 2.0, DRAWING: 0.0},
    sections=("buildings", "damping"),
    files=_files,
    further=lambda case: f"{model_key(case)}{_wanted(case)}",
    computed_by=("compute", "store"),
    drawn_by=(),
    stores={"reduce": "reduce.nc"},
    compute=_compute,
    draw=lambda case, folder: [],
    checks=lambda case, folder: _checks(folder),
    needs=lambda case: (BUILDING,),
    lacks=_lacks,
    collective=True,
    each=True,
)

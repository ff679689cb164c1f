"""The stage `building`: mesh, matrices and modes of the 3D model."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case
from impactfem.case.bays import Bay
from impactfem.case.generated_mesh import GeneratedMesh
from impactfem.case.structure import structure_files
from impactfem.stages.building.checks import building_checks
from impactfem.stages.building.pictures import building_pictures
from impactfem.stages.building.tables import building_tables
from impactfem.stages.inputs import inputs_key, published_values
from impactfem.stages.stage import Stage
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root

BUILDING_ROOMS = ("building", "dynamics", "reduction", "stages/building", "_fenicsx.py")
BUILDING_INPUTS = ("materials", "buildings", "structure", "published")
STEPS = {
    "mesh": 3.0,
    "matrices": 5.0,
    "modes": 25.0,
    "stores": 1.0,
    "tables and pictures": 4.0,
}


def building_key(case: Case) -> str:
    """Hash of what the stage depends on, the user's mesh file included."""
    files = structure_files(case.structure) if case.structure is not None else ()
    return inputs_key(case, BUILDING_INPUTS, BUILDING_ROOMS, files)


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import MESH, run_building
    from impactfem.stages.building.store import write_building

    study = run_building(case, folder, communicator(), steps.step)

    def write() -> list[Path]:
        files = [folder / "building.nc"]
        if (folder / MESH).is_file():
            files.append(folder / MESH)
        with steps.step("stores"):
            write_building(files[0], study, case.title, key)
        with steps.step("tables and pictures"):
            files += building_tables(folder, published_values(case), _bays(case))
            files += building_pictures(folder)
        return files

    return on_root(write) or []


def _bays(case: Case) -> tuple[Bay, ...]:
    mesh = None if case.structure is None else case.structure.mesh
    return mesh.bays if isinstance(mesh, GeneratedMesh) else ()


BUILDING = Stage(
    name="building",
    steps=STEPS,
    rooms=BUILDING_ROOMS,
    key=building_key,
    store="building.nc",
    run=_run,
    checks=lambda case, folder: building_checks(folder),
    lacks=lambda case: "structure" if case.structure is None else None,
    collective=True,
)

"""The stage `building`: mesh, matrices and modes of the 3D model."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case import Building3D, Case
from impactfem.case.buildings import GeneratedMesh, structure_files
from impactfem.case.floors import Floor
from impactfem.case.members import Bay
from impactfem.case.plausibility import PERIOD_PER_STOREY
from impactfem.stages.building import pictures
from impactfem.stages.building.pictures import BuildingData
from impactfem.stages.building.tables import building_tables
from impactfem.stages.building.targets import ECCENTRIC
from impactfem.stages.check import PROGRAM_FAULT, Check, Criterion
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import published_values
from impactfem.stages.stage import DRAWING, Stage, StageOf
from impactfem.stages.stores import number_of, open_store
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root

MASS = 1e-9
"""Largest relative difference of the masses of floors and base from the mass matrix."""
INERTIA = 0.2
"""Largest relative difference of an inertia of a floor from the floor table, with which the sticks
are made: a radius of gyration within a tenth."""
FAR = 0.1
"""The same, from which on the node is probably not the one that was meant."""
STICK_ERROR, STICK_MAC = 0.02, 0.95
"""Largest difference of a frequency between stick and 3D model, and least MAC of its shape."""
RESIDUAL = 1e-6
"""Largest residual of a mode that counts as converged."""


def storey_factor(folder: Path) -> float:
    """The storey factor that the stage was given or fitted, from `building.nc` of a run.

    ImpactfemError where the store has none.
    """
    with open_store(folder / "building.nc") as store:
        return number_of(store, "storey_factor")


def _compute(building: Building3D, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import MESH, analysed
    from impactfem.stages.building.store import write_building

    study, _, _ = analysed(building, folder, communicator(), steps.step)

    def write() -> list[Path]:
        files = [folder / "building.nc"]
        if (folder / MESH).is_file():
            files.append(folder / MESH)
        with steps.step("stores"):
            write_building(files[0], study, building.case.title, key)
        return files

    return on_root(write) or []


def _tabulate(building: Building3D, folder: Path) -> list[Path]:
    mesh = building.structure.mesh
    bays: tuple[Bay, ...] = mesh.built[1] if isinstance(mesh, GeneratedMesh) else ()
    return building_tables(folder, published_values(building), building.entry.floors, bays)


MESH_WARNINGS = Criterion(
    "building.mesh_warnings",
    "warnings of the mesh",
    upper=0,
    consequence="Results near these places may be inaccurate",
    remedy="Correct the mesh, or buildings.structure.mesh, and run `impactfem check`",
)
MASS_BALANCE = Criterion(
    "building.mass_balance",
    "relative difference of the masses of floors and base from the mass matrix",
    upper=MASS,
    severity="invalid",
    consequence="The masses of the floors are not those of the 3D model",
    remedy=PROGRAM_FAULT,
)
MODE_RESIDUAL = Criterion(
    "building.mode_residual",
    "largest residual of the modes",
    upper=RESIDUAL,
    severity="invalid",
    consequence="The modes are not converged",
    remedy=PROGRAM_FAULT,
)
BENDING_MODES = Criterion(
    "building.bending_modes",
    "number of bending modes",
    lower=1,
    consequence="No computed mode bends the building along this direction",
    remedy="Raise buildings.structure.modes",
)
FIRST_PERIOD = Criterion(
    "building.period_per_storey",
    "first period divided by the number of storeys",
    "s",
    lower=PERIOD_PER_STOREY[0],
    upper=PERIOD_PER_STOREY[1],
    severity="invalid",
    consequence="Supports are missing, or a stiffness or a mass has another unit. All results are "
    "those of another building",
    remedy="Check walls, columns, base and young_modulus",
)
FLOOR_INERTIA = Criterion(
    "building.floor_inertia",
    "difference of a moment of inertia between 3D model and floor table",
    "%",
    upper=INERTIA,
    consequence="The stick and the 3D model twist or rock at different frequencies",
    remedy="Give the floor table the moments of inertia in tables/building_floor_inertias.csv",
)
MASS_CENTRE = Criterion(
    "building.mass_centre_distance",
    "distance of the node of a floor from its centre of mass, as a part of the plan",
    "%",
    upper=FAR,
    consequence="Results named after the mass centre are those of the node",
    remedy="Compare with the results at the edges of the floor",
)


STICK_FIT_ERROR = Criterion(
    "building.stick_error",
    "difference of a frequency between the 3D model and its stick",
    "%",
    upper=STICK_ERROR,
    consequence="The stick does not have the stiffness of the 3D model",
    remedy='Use the 3D model in the pounding (models of [pounding]), or stick = "own"',
    concerns=("pounding.main_impact_*",),
)
STICK_SHAPE = Criterion(
    "building.stick_shape",
    "MAC of a mode of the 3D model and its stick",
    lower=STICK_MAC,
    consequence="Floors do not move as rigid bodies in this mode, as those of a stick do",
    remedy='Use the 3D model in the pounding (models of [pounding]), or stick = "own"',
    concerns=("pounding.main_impact_*",),
)
NO_STICK_MODE = Criterion("building.stick_modes", "modes of the 3D model that its stick has")


def stick_fit_checks(store: xr.Dataset) -> Iterator[Check]:
    """Check frequencies and shapes of a stick that is made of the 3D model."""
    if "stick_stiffness" not in store:
        return
    if not store.sizes["matched"]:
        yield NO_STICK_MODE.check(0, detail="no computed mode moves the floors as a whole")
        return
    model, mac = store["stick_model_frequency"].values, store["stick_mac"].values
    error = np.abs(store["stick_frequency"].values / model - 1.0)
    modes = f"{error.size} modes up to {model.max():.3g} Hz"
    for criterion, values, k in (
        (STICK_FIT_ERROR, error, int(error.argmax())),
        (STICK_SHAPE, mac, int(mac.argmin())),
    ):
        mode = f"mode {store['stick_mode'].values[k]}, {model[k]:.3g} Hz"
        yield criterion.check(values[k], mode, modes)


def building_checks(folder: Path, floors: Sequence[Floor] = ()) -> list[Check]:
    """Check mesh, masses, modes, and moments of inertia against a floor table."""
    with open_store(folder / "building.nc") as store:
        warnings = [str(text) for text in store["mesh_warning"].values]
        checks = [MESH_WARNINGS.check(len(warnings), detail="; ".join(warnings))]
        total = store["total_mass"]
        standing, base = float(store["floor_mass"].sum()), float(store["base_mass"])
        off = abs((standing + base) / float(total.sel(direction="y")) - 1.0)
        masses = f"floors {standing / 1e3:,.0f} t, base {base / 1e3:,.0f} t"
        checks.append(MASS_BALANCE.check(off, detail=masses))
        frequency = store["frequency"].values
        modes = (
            f"{frequency.size} modes from {frequency[0]:.3f} to {frequency[-1]:.3f} Hz; the Sturm "
            "count finds no missing mode"
        )
        checks.append(MODE_RESIDUAL.check(float(store["residual"].max()), detail=modes))
        direction = str(store.attrs["bending_direction"])
        bending = store.sel(mode=store["bending_mode"].values, direction=direction)
        share = bending["effective_mass"].values / float(total.sel(direction=direction))
        modes = ", ".join(
            f"{f:.3f} Hz ({100.0 * part:.1f} % of the mass)"
            for f, part in zip(bending["frequency"].values, share, strict=True)
        )
        checks.append(BENDING_MODES.check(share.size, f"along {direction}", modes))
        period = 1.0 / float(frequency[0])
        per_storey = period / store.sizes["floor"]
        checks.append(FIRST_PERIOD.check(per_storey, detail=f"first period {period:.3g} s"))
        differences = {
            f"J_{axis} of floor {floor.floor}": abs(float(own) / getattr(floor, f"J{axis}") - 1.0)
            for axis in ("xyz" if floors else "")
            for floor, own in zip(floors, store[f"floor_J{axis}"].values, strict=True)
        }
        if differences:
            where = max(differences, key=lambda name: differences[name])
            checks.append(FLOOR_INERTIA.check(differences[where], where))
        plan = np.ptp(store["node_position"].values[:, :2], axis=0)
        e = np.array([store["floor_ex"].values, store["floor_ey"].values]).T
        away = np.abs(e / plan).max(axis=1)
        if away.max() > ECCENTRIC:
            k = int(away.argmax())
            where, distance = f"floor {store['floor'].values[k]}", f"{np.hypot(*e[k]):.3g} m"
            checks.append(MASS_CENTRE.check(away[k], where, distance))
        checks += stick_fit_checks(store)
        return checks


def _floors_of_stick(building: Building3D) -> tuple[Floor, ...]:
    """The floor table where the stick has its moments of inertia; else none."""
    on_model = building.name in building.case.sticks_on_models
    return () if on_model else building.entry.floors


BUILDING = StageOf[Building3D](
    name="building",
    title="The 3D model",
    about="Mesh of shells and beams, its masses and modes.",
    headlines=(
        "{building.elements} elements",
        "{building.dofs} degrees of freedom",
        "first bending modes {building.frequency.1}, {building.frequency.2}",
    ),
    steps={"mesh": 3.0, "matrices": 5.0, "modes": 25.0, "stick": 4.0, "stores": 1.0, DRAWING: 4.0},
    sections=("materials", "buildings", "structure"),
    files=lambda building: structure_files(building.structure),
    further=lambda building: "stick" * (building.name in building.case.sticks_on_models),
    stores={"building": "building.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(BuildingData, pictures),
    checks=lambda building, folder: building_checks(folder, _floors_of_stick(building)),
    subjects=lambda case: tuple(case.modelled.values()),
    section="structure",
    collective=True,
)


def target_models(case: Case) -> tuple[Stage, ...]:
    """Return the stage `building` of the 3D models that sticks are made of or fitted to."""
    targets = {*case.sticks_on_models}
    if case.calibration is not None and case.calibration.from_structure:
        targets |= {target.building for target in case.calibration.targets}
    if not targets:
        return ()

    def subjects(case: Case) -> tuple[Building3D, ...]:
        return tuple(one for name, one in case.modelled.items() if name in targets)

    # The sticks do not depend on other 3D models than those.
    return (replace(BUILDING, subjects=subjects),)

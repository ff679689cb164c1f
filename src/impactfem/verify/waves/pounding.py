"""Two buildings that pound in 3D: their reduced models against the meshes themselves."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg
import scipy.sparse

from impactfem.building.shell_model import csr
from impactfem.case import Case, load_case
from impactfem.coupling.contact_loop import ContactHistory
from impactfem.coupling.from_case import system_of
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.coupling.unilateral import unilateral_response
from impactfem.spectra import response_spectra
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree
from impactfem.system.log import LOGGER
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.waves import BALANCE

if TYPE_CHECKING:
    from impactfem.building.mesh import BuildingMesh
    from impactfem.building.model import BuildingModel
    from impactfem.reduction.contact_line import ContactLine
    from impactfem.reduction.pounding_3d import Pounding3D
    from impactfem.reduction.reduced_building import CompleteModel

CASE = "geometry/npp_pair_coupled.toml"
WINDOW, PULSE, LASTS = 0.4, 3.0, 0.6
"""Time that is computed [s], and the ground in it: one sine of so many m/s2 and so many seconds."""
LEAST_FREE, SIZE = 60_000, 2.5
"""Free degrees of freedom that each mesh has at least, and the size of its elements here [m]: the
default mesh has 340,000."""
LOW, HIGH = 5.0, 100.0  # frequencies of the spectra [Hz]
MATTERS = 0.1  # part of the largest ordinate of any floor or edge from which on one is compared
WITHIN = 0.005  # largest relative error of a spectrum
FULL = "Moreau's stepping of both meshes, in full order"


@benchmark("pounding in 3D, reduced models against the full ones", heavy=True)
def pounding_reduced_against_full(
    rows: Rows, case_file: Path | None = None, window: float = WINDOW, least: int = LEAST_FREE
) -> None:
    """Impulses and spectra of the first impacts of the two buildings of the paper.

    A single sine of the ground along the normal makes them touch. Spectra are those of what
    velocities change by in each step, at mass centres and of the edges as they touch.
    """
    case = load_case(in_source_tree(CASE) if case_file is None else case_file)
    bare = {"transient": None, "devices": (), "device_analysis": None, "wall_impact": None}
    case = case.model_copy(update=bare)
    if case_file is None:
        meshes = [one.mesh.model_copy(update={"size": SIZE}) for one in case.structures]
        first, *further = (
            one.model_copy(update={"mesh": mesh})
            for one, mesh in zip(case.structures, meshes, strict=True)
        )
        case = case.model_copy(update={"structure": first, "further_structures": tuple(further)})
    h = case.pounding.time_step
    time = h * np.arange(round(window / h) + 1)
    ground = PULSE * np.sin(2.0 * np.pi * time / LASTS) * (time < LASTS)
    with tempfile.TemporaryDirectory() as folder:
        pair = FullPair(case, Path(folder))
    sizes = [model.n_free for model in pair.models.values()]
    fewest = min(sizes)
    rows.add(f"free degrees of freedom, at least {least} (yes = 1)", 1.0, fewest >= least, "-", 0.0)
    reduced = pair.reduced(h, ground)
    LOGGER.info("pounding: %d steps of %d rows", len(time) - 1, sum(sizes))
    full = pair.full(h, ground)
    points = pair.pounding.pair_of
    lines = [line.name for line in pair.lines]
    joined = np.eye(len(lines))[points]
    ours, theirs = (one.impulse.sum(axis=0) @ joined for one in (reduced, full))
    touched = theirs > MATTERS * theirs.max()
    counted = f"{np.count_nonzero(touched)} of {len(lines)}"
    rows.add("lines that touch, at least 1 (yes = 1)", 1.0, touched.any(), "-", 0.0, counted)
    for k in np.flatnonzero(touched):
        rows.add(f"impulse, {lines[k]}", theirs[k], ours[k], "N s", 0.01, FULL)
    largest = (full.force @ joined).max(axis=0), (reduced.force @ joined).max(axis=0)
    main = int(largest[0].argmax())
    rows.add(f"largest force, {lines[main]}", largest[0][main], largest[1][main], "N", 0.01, FULL)
    frequency = np.geomspace(LOW, HIGH, 1 + round(30.0 * np.log10(HIGH / LOW)))
    changes = (np.diff(one.velocity, axis=0).T / h for one in (reduced, full))
    spectra = [response_spectra(a, h, frequency, [0.05], absolute=False).psa for a in changes]
    exact = spectra[1].reshape(len(pair.names), -1)
    apart = np.abs(spectra[0].reshape(exact.shape) / exact - 1.0)
    apart[exact < MATTERS * exact.max()] = 0.0
    for kind in ("floor", "edge"):
        here = [k for k, name in enumerate(pair.names) if name.startswith(kind)]
        quantity = f"largest error of a spectrum from {LOW:g} to {HIGH:g} Hz, {kind}s"
        rows.add(quantity, 0.0, apart[here].max(), "-", WITHIN, f"{FULL}; {len(here)} spectra")
    for name, one in (("reduced", reduced), ("full", full)):
        quantity = f"residual of the energy identity, {name}"
        rows.add(quantity, 0.0, one.energy.residual, "-", 1e-8, BALANCE)
        rows.add(f"complementarity, {name}", 0.0, one.residual.max(), "-", 1e-8, "exact")


class FullPair:
    """The 3D models of a case that touch nothing but each other or walls, on one rank.

    The buildings have one Rayleigh damping; meshes are made in a folder. What is recorded has
    `names`: "floor" at its mass centre along y, "edge" in the mean of a hat.
    """

    def __init__(self, case: Case, folder: Path) -> None:
        from mpi4py import MPI

        from impactfem.building.from_case import geometry_of
        from impactfem.building.generate import generate
        from impactfem.building.model import assemble_building
        from impactfem.building.read_mesh import read_mesh
        from impactfem.reduction.contact_line import contact_lines
        from impactfem.reduction.models_3d import Models3D
        from impactfem.reduction.pounding_3d import Pounding3D
        from impactfem.reduction.reduced_building import reduce_building
        from impactfem.stages.reduce.compute import prepare

        structures = {one.building: one for one in case.structures}
        laws = {case.building(name).damping.law for name in structures}
        if set(structures) != {one.name for one in case.buildings} or len(laws) != 1:
            raise ValueError(f"{case.path}: expected 3D models of all buildings and one damping")
        self._damping, files = laws.pop().rayleigh, dict[str, Path]()
        for name, building in case.modelled.items():
            files[name] = folder / f"{name}.msh"
            generate(geometry_of(building), files[name], source=str(case.path))
        self._meshes: dict[str, BuildingMesh] = {k: read_mesh(file) for k, file in files.items()}
        self.lines: tuple[ContactLine, ...] = contact_lines(case, self._meshes)
        self.models: dict[str, BuildingModel] = {}
        self._stiffness: dict[str, Any] = {}
        reduced: dict[str, CompleteModel] = {}
        for name, building in case.modelled.items():
            factor = building.structure.storey_stiffness_factor
            prepared = prepare(building, files[name], factor, files)
            once = assemble_building(MPI.COMM_SELF, prepared.parts)
            reduced[name] = reduce_building(
                once, prepared.parts.mesh, factor, prepared.plan
            ).complete
            self.models[name] = assemble_building(MPI.COMM_SELF, prepared.parts)
            self._stiffness[name] = self.models[name].take_stiffness(factor)
        self._reduced: Mapping[str, CompleteModel] = reduced
        given = Models3D(self.lines, reduced)
        self.pounding: Pounding3D = Pounding3D(case, system_of(case, None), given)
        self.names = [
            *(f"floor {k} of {name}" for name in reduced for k in self._meshes[name].floors),
            *(f"edge of {name}, {k}" for name in reduced for k in range(len(self._forces(name)))),
        ]

    def _forces(self, name: str) -> list[Any]:
        return [force for line in self.lines for force in line.forces_on(name)]

    def reduced(self, h: float, ground: Array) -> ContactHistory:
        """Return the response of the reduced models to the ground along y [m/s2] at steps h [s]."""
        one, floors, edges = self.pounding.assembly, [], []
        for name, model in self._reduced.items():
            column = {str(known): k for k, known in enumerate(model.names)}
            touching = [column[force.name] for force in self._forces(name)]
            floors.append(model.points[-len(self._meshes[name].floors) :, 1].T)
            edges.append(model.edges[:, touching])
        probes = np.hstack([scipy.linalg.block_diag(*floors), scipy.linalg.block_diag(*edges)])
        motion = ModalMotion(one, h, load=one.ground[:, 1:2], probes=probes)
        return unilateral_response(motion, one.gaps, len(ground) - 1, amplitudes=ground[:, None])

    def full(self, h: float, ground: Array) -> ContactHistory:
        """Return the response of the meshes, in full order."""
        from impactfem.verify.full_order import FullMotion

        # Index of the first point of each line.
        firsts = np.cumsum([0, *(len(line) for line in self.lines[:-1])])
        floors, edges, closing, load = [], [], [], []
        for name, model in self.models.items():
            mesh = self._meshes[name]
            centres = np.array([mesh.centres[k] for k in mesh.floors])
            floors.append(model.along(centres, (0.0, 1.0, 0.0)))
            pushes = [force.vector(model, mesh) for force in self._forces(name)]
            pushed = scipy.sparse.csr_matrix(np.column_stack(pushes))
            edges.append(pushed)
            # Forces push inwards, which opens: the rows of closing are those with the other sign.
            at = [
                first + k
                for first, line in zip(firsts, self.lines, strict=True)
                for k in range(len(line))
                if line.forces_on(name)
            ]
            selected = (np.ones(len(at)), (np.arange(len(at)), at))
            shape = (len(at), len(self.pounding.points))
            closing.append(-pushed @ scipy.sparse.csr_matrix(selected, shape=shape))
            load.append(-model.ground[:, 1])
        probes = scipy.sparse.hstack(
            [scipy.sparse.block_diag(floors), scipy.sparse.block_diag(edges)]
        )
        K, M = (
            scipy.sparse.block_diag([csr(one) for one in matrices], format="csr")
            for matrices in (self._stiffness.values(), [m.mass for m in self.models.values()])
        )
        contact, gaps = scipy.sparse.vstack(closing), self.pounding.assembly.gaps
        pattern, amplitudes = np.concatenate(load)[:, None], ground[:, None]
        with FullMotion(
            K, M, contact, h, damping=self._damping, patterns=pattern, probes=probes
        ) as motion:
            return unilateral_response(motion, gaps, len(ground) - 1, amplitudes=amplitudes)

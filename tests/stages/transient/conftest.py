"""The shipped frame as matrices with loads on it, its responses, and a study of it."""

import pickle
import resource
import shutil
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI
from scipy.sparse import csr_matrix

from frame_case import QUICK, floors_meet, neighbour
from impactfem.building.floor import linear
from impactfem.building.from_case import read_parts
from impactfem.building.links import Displacements
from impactfem.building.model import BuildingModel, assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.case import Case, load_case
from impactfem.coupling.force_history import ForceHistory
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.loads import make_loads
from impactfem.reduction.probes import recorded_nodes, standard_probes
from impactfem.reduction.reduced_basis import Accuracy, BasisPlan, build_basis
from impactfem.run import loop
from impactfem.stages.transient import export
from impactfem.stages.transient.full_run import FullModel, Resumption, run_full
from impactfem.system import files
from impactfem.system.arrays import Index
from impactfem.system.files import atomic
from no_pictures import no_pictures
from one_building import building_of

GEOMETRY = Path(__file__).parents[3] / "geometry"
STOREY_FACTOR = 0.5
HIGHEST = 200.0
TIME_STEP = 0.5e-3
STEPS = 1600
TOLERANCE = 0.005
TRANSIENT = (
    """
[contact_laws.floor]
type = "kelvin-voigt"
stiffness = "1e9 N/m"
restitution = 0.65
"""
    + floors_meet("1 m")
    + """
[transient]
solver = "reduced"
time_step = "1 ms"
maximum_frequency = "50 Hz"
forces = "forces_of_another.csv"
checkpoint_every = "0.2 s"
"""
)
# On the edges along y = 4 m, from x = 0 to 6 m, 0.3 m beside their middles.
INWARDS = {
    k: EdgeForce(f"floor {k}", k, (0.0, -1.0, 0.0), moment=0.3, line=linear(0.0, 6.0, 3.3))
    for k in (1, 2)
}


def pulses(time):
    """A smooth impact on floor 2, and on floor 1 a later and shorter one with kinks."""
    upper = np.where(np.abs(time - 0.31) < 0.01, np.cos(50 * np.pi * (time - 0.31)) ** 2, 0.0)
    lower = np.where(np.abs(time - 0.405) < 0.005, np.cos(100 * np.pi * (time - 0.405)), 0.0)
    return ForceHistory(time, ("upper", "lower"), np.column_stack([5e5 * upper, 3e5 * lower]))


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame on one rank."""

    case: Case
    parts: BuildingParts  #: its mesh and sections
    model: BuildingModel  #: its matrices
    K: Any  #: its stiffness
    nodes: Index  #: of the probes that are always there
    damping: Rayleigh  #: of the case
    light: Rayleigh  #: with a fifth of its β

    def loads(self, time_step=TIME_STEP, steps=STEPS):
        """A ground motion along y with the impacts of `pulses`, both from one fine grid."""
        time = np.linspace(0.0, 0.8, 3201)
        # It rises and fades as sin²; frequencies up to some 20 Hz.
        ground = np.sin(np.pi * time / 0.8) ** 2 * np.sin(2 * np.pi * (3.0 + 12.0 * time) * time)
        edges = [((INWARDS[2], 1.0),), ((INWARDS[1], 1.0),)]
        return make_loads([(1, 0.25e-3, 3.0 * ground)], pulses(time), edges, time_step, steps)

    def patterns(self, loads):
        return loads.patterns(self.model, self.parts.mesh)

    def full(self, loads, damping, folder, nodes=None, **options):
        """The full model, its checkpoints in the folder: without an interruption the last alone."""
        probes = Displacements(self.model, self.nodes if nodes is None else nodes)
        progress = options.pop("progress", lambda part: None)
        more = {name: options.pop(name) for name in ("C", "modal") if name in options}
        resumption = Resumption(folder, **{"key": "frame", "every": 10**6} | options)
        model = FullModel(self.model, self.K, damping, **more)
        return run_full(model, loads, self.patterns(loads), probes, resumption, progress)

    def basis(self, loads, **changes):
        """A reduced basis for the light damping."""
        asked = {
            "probes": self.nodes,
            "nodes": recorded_nodes(self.parts.mesh, self.nodes),
            "shift": 60.0,
            "largest": 1200,
        }
        damping, tolerance = changes.pop("damping", self.light), changes.pop("tolerance", TOLERANCE)
        asked["accuracies"] = (Accuracy(damping, HIGHEST, tolerance),)
        options = {"progress": changes.pop("progress")} if "progress" in changes else {}
        plan = BasisPlan(loads.names, **asked | changes)
        return build_basis(self.model, self.K, self.patterns(loads), plan, **options)


@pytest.fixture(scope="session")
def frame():
    case = load_case(GEOMETRY / "frame.toml")
    parts, _ = read_parts(building_of(case), GEOMETRY / "frame.msh")
    model = assemble_building(MPI.COMM_SELF, parts)
    damping = case.building("F").damping.rayleigh
    return Frame(
        case=case,
        parts=parts,
        model=model,
        K=model.stiffness(STOREY_FACTOR),
        nodes=np.array([probe.node for probe in standard_probes(parts.mesh)]),
        damping=damping,
        light=Rayleigh(damping.alpha, damping.beta / 5.0),
    )


@pytest.fixture(scope="session")
def loads(frame):
    return frame.loads()


@pytest.fixture(scope="session")
def basis(frame, loads):
    return frame.basis(loads)


@pytest.fixture(scope="session")
def full_runs(frame, loads, tmp_path_factory):
    """By name of the damping, the damping and the full model under it."""
    dampings = {"the case's": frame.damping, "light": frame.light}
    return {
        name: (damping, frame.full(loads, damping, tmp_path_factory.mktemp("full")))
        for name, damping in dampings.items()
    }


@pytest.fixture(scope="session")
def spectra(frame):
    """Up to the highest frequency of the basis."""
    frequencies = tuple(np.geomspace(0.5, HIGHEST, 100))
    return frame.case.spectra.model_copy(update={"frequencies": frequencies, "damping": (0.05,)})


@pytest.fixture
def stores(transient_folder):
    """`transient.nc` and `pounding.nc` of a run without fields that no solver made."""

    def loaded(**wanted):
        folder = transient_folder(**{"maps": False} | wanted)
        names = ("transient.nc", "pounding.nc")
        return [xr.load_dataset(folder / name, engine="netcdf4") for name in names]

    return loaded


@pytest.fixture(scope="session")
def csc():
    """A matrix of PETSc on one rank as one of SciPy."""

    def converted(matrix):
        indptr, indices, values = matrix.getValuesCSR()
        return csr_matrix((values, indices, indptr), shape=matrix.getSize()).tocsc()

    return converted


def write_forces(path, largest=4e5, starts=(0.4, 0.7)):
    """Two impacts of floor 2, which start at these times, and none of floor 1, at 0.5 ms."""
    time = 0.5e-3 * np.arange(2001)
    force = np.zeros(2001)
    for start, size in zip(starts, (0.3, 1.0), strict=True):
        inside = (time > start) & (time < start + 0.02)
        force[inside] = largest * size * np.sin(np.pi * (time[inside] - start) / 0.02)
    header = "time [s],F.floor_1-G.floor_1 [N],F.floor_2-G.floor_2 [N]"
    values = np.column_stack([time, np.zeros(2001), force])
    np.savetxt(path, values, delimiter=",", header=header, comments="", fmt="%.9g")


def seen_by_vtk(path, found):
    """What VTK reads of a motion file, by way of another file."""
    script = Path(__file__).with_name("read_motion.py")
    command = [sys.executable, "-P", str(script), str(path), str(found)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    return pickle.loads(found.read_bytes())


SHORT = "0.25 s"
"""A history in which a checkpoint, at 0.2 s, lies between the impacts of `EARLY`."""
EARLY = (0.1, 0.21)


def steps_of(run):
    return {name.removeprefix("transient: ") for name in run.times if "transient" in name}


def killed(name, case, *options):
    """Run the stage in a process that is killed while it writes this file; "-" is no file."""
    script = Path(__file__).with_name("interrupted.py")
    words = [sys.executable, str(script), name, str(case), str(case.parent / "run"), *options]
    return subprocess.run(words, capture_output=True, text=True, check=False)


@contextmanager
def full_disk(name):
    """No file of this name can be written while the block runs."""

    @contextmanager
    def limited(path):
        if path.name == name:
            resource.setrlimit(resource.RLIMIT_FSIZE, (20, resource.RLIM_INFINITY))
        try:
            with atomic(path) as temporary:
                yield temporary
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)

    with pytest.MonkeyPatch.context() as patch:
        for module in (files, export):
            patch.setattr(module, "atomic", limited)
        yield


@pytest.fixture(scope="session")
def begun(edited, tmp_path_factory):
    """The case's folder, with a run of the stages before; not to be changed."""
    folder = tmp_path_factory.mktemp("begun")
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, folder)
    # So far away that the sticks never touch.
    steps = ("title = ", 'allow = ["steps"]\ntitle = ')
    case = edited(folder / "frame.toml", *QUICK, neighbour(), steps)
    case.write_text(case.read_text() + TRANSIENT)
    write_forces(folder / "forces_of_another.csv")
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        loop.run(case, out=folder / "run", stage="building", draw=False)
        loop.run(case, out=folder / "run", stage="pounding", draw=False)
    return folder


@pytest.fixture(scope="session")
def reduced(begun, tmp_path_factory):
    """The same with the stage by the reduced model, and its run; not to be changed."""
    folder = tmp_path_factory.mktemp("reduced")
    shutil.copytree(begun, folder, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        done = loop.run(folder / "frame.toml", out=folder / "run", stage="transient", draw=False)
    return folder, done


@pytest.fixture
def again(reduced, tmp_path, monkeypatch):
    """A copy of the case after it."""
    no_pictures(monkeypatch)
    shutil.copytree(reduced[0], tmp_path, dirs_exist_ok=True)
    return tmp_path / "frame.toml"

"""The stage `building` on the shipped mesh of a small frame."""

import gc
import json
import shutil
import weakref
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg
import xarray as xr
from mpi4py import MPI

from impactfem import study
from impactfem.building.from_case import read_parts
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.dynamics.columns import product
from impactfem.dynamics.modes import Modes, modes
from impactfem.run import loop
from impactfem.stages.building import compute
from impactfem.stages.building.compute import analysed, fit_storey_factor
from impactfem.stages.building.store import building_scalars
from impactfem.stages.building.study import BuildingStudy
from impactfem.stages.building.targets import bending_modes
from impactfem.system.errors import InputError, SolutionError
from one_building import building_of

GEOMETRY = Path(__file__).parents[3] / "geometry"
ROOF = "2,28,5.3e4,1.2e5,1.7e5,1.2,0.1,1.3,1.1,0.8,0.3,3\n"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="session")
def frame_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frame")
    return loop.run(GEOMETRY / "frame.toml", out=folder / "run", stage="building")


@pytest.fixture(scope="session")
def store(frame_run):
    with xr.open_dataset(frame_run.folder / "building.nc", engine="netcdf4") as opened:
        yield opened.load()


@pytest.fixture
def frame(tmp_path):
    """The frame's files in a folder of their own, to be changed."""
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, tmp_path)
    return tmp_path / "frame.toml"


@pytest.fixture(scope="session")
def parts():
    case = load_case(GEOMETRY / "frame.toml")
    return read_parts(building_of(case), GEOMETRY / "frame.msh")[0]


def scalars(run):
    return {entry.name: entry.value for entry in run.scalars}


def test_bending_modes_are_those_across_the_edges_that_face_others(parts):
    """Unless a fit has a direction; y where nothing is known of neighbours."""

    def direction(edges=parts.mesh.edges, turned=False, fit=None):
        nodes = parts.mesh.nodes[:, [1, 0, 2]] if turned else parts.mesh.nodes
        mesh = replace(parts.mesh, nodes=nodes, edges=edges)
        return BuildingStudy.bending_direction.fget(
            SimpleNamespace(
                structure=SimpleNamespace(calibration=fit), parts=SimpleNamespace(mesh=mesh)
            )
        )

    assert (direction(), direction(turned=True)) == ("y", "x")
    assert direction(edges={}, turned=True) == "y"
    assert direction(fit=SimpleNamespace(direction="x")) == "x"


def test_first_bending_mode_is_where_it_was_asked(frame_run, store):
    values = scalars(frame_run)
    assert values["building.frequency.1"] == pytest.approx(4.0, rel=1e-6)
    # Walls and columns alone do not give a frequency as the root of their factor.
    assert 0.1 < values["building.storey_stiffness_factor"] < 1.0
    assert values["building.effective_mass.1"] == store.effective_mass.sel(direction="y").max()


def test_scalars(frame_run, store):
    values = scalars(frame_run)
    assert values["building.elements"] == 400
    assert values["building.dofs"] == 6 * int(store.nodes)
    assert values["building.floor_mass.1"] == pytest.approx(30e3)
    assert values["building.floor_mass.2"] == pytest.approx(28e3)
    assert values["building.mass"] > 58e3  # with what belongs to the base
    listed = json.loads((frame_run.folder / "summary.json").read_text())
    assert {entry["name"] for entry in listed} >= set(values)


def test_a_bending_mode_that_was_not_computed_has_no_value(store):
    few = store.isel(mode=slice(1, 2), bending=slice(1)).assign(bending_mode=("bending", [2]))
    found = {one.name: one for one in building_scalars(few)}
    assert found["building.frequency.1"].value == float(few["frequency"][0])
    assert found["building.frequency.2"].value is None
    assert found["building.effective_mass.3"].value is None
    assert "structure.modes" in found["building.frequency.2"].note


def test_effective_masses_add_up_to_less_than_the_mass(store):
    share = store.effective_mass.sum("mode") / store.total_mass
    assert (share < 1.0 + 1e-9).all()
    assert (share.sel(direction=["x", "y", "rx"]) > 0.5).all()


def test_shapes_have_unit_modal_mass_and_rest_at_the_base(store):
    assert store.shape.dtype == np.float32
    assert not store["shape"].isel(node=store.base.values).any()
    assert np.abs(store["shape"]).max() > 1e-4


def test_mesh_of_the_store_is_that_of_the_file(store, parts):
    mesh = parts.mesh
    kept = {
        "node_position": mesh.nodes,
        "triangle_node": mesh.triangles,
        "triangle_part": mesh.triangle_part,
        "line_node": mesh.lines,
        "line_part": mesh.line_part,
        "base": mesh.base,
        "edge_line": np.concatenate([mesh.edges[floor] for floor in sorted(mesh.edges)]),
        "centre": [mesh.centres[floor] for floor in store.floor.values],
        "shell_part_name": [part.group for part in mesh.shell_parts],
        "beam_part_name": [part.group for part in mesh.beam_parts],
    }
    for name, values in kept.items():
        np.testing.assert_array_equal(store[name].values, values, err_msg=name)


def test_tables_and_pictures(frame_run):
    tables = sorted(path.name for path in (frame_run.folder / "tables").iterdir())
    assert tables == [
        "building_bending_modes.csv",
        "building_floor_inertias.csv",
        "building_floor_masses.csv",
        "building_modes.csv",
        "building_storey_sections.csv",
    ]
    pictures = list((frame_run.folder / "figures").iterdir())
    assert len(pictures) >= 2
    assert all(path.read_bytes().startswith(PNG) for path in pictures)


def test_finished_stage_is_reused_and_a_changed_mesh_is_not(frame, frame_run, tmp_path):
    shutil.copytree(frame_run.folder, tmp_path / "run")
    assert loop.run(frame, out=tmp_path / "run", stage="building").reused == ["building"]
    mesh = tmp_path / "frame.msh"
    mesh.write_text(mesh.read_text() + "$Comments\nchanged\n$EndComments\n")
    assert loop.run(frame, out=tmp_path / "run", stage="building").reused == []


def test_floors_of_mesh_and_table_must_agree(frame):
    table = frame.with_name("frame_floors.csv")
    row = table.read_text().splitlines()[-1]
    table.write_text(table.read_text() + row.replace("2,28", "3,28") + "\n")
    with pytest.raises(InputError, match="floors 1, 2, 3 of building F"):
        read_parts(building_of(load_case(frame)), frame.with_name("frame.msh"))


def test_storeys_of_mesh_and_table_must_agree(frame, edited):
    """Both heights are told; a level may be of the slab's middle or of the mass centre."""
    edited(frame.with_name("frame_floors.csv"), (ROOF, ROOF.replace("0.3,3", "0.3,3.2")))
    found = "storey below floor 2 is 3 m high in the mesh and 3.2 m in the floor table of building"
    with pytest.raises(InputError, match=f"frame.msh: centre_2: the {found} F") as caught:
        study.check(frame, mesh=True)
    assert len(caught.value.faults) == 1
    with pytest.raises(InputError, match=found):
        loop.run(frame, out=frame.parent / "run", stage="building")


def test_storeys_that_nearly_agree(frame, edited):
    edited(frame.with_name("frame_floors.csv"), (ROOF, ROOF.replace("0.3,3", "0.3,3.08")))
    study.check(frame, mesh=True)


@pytest.mark.parametrize(
    ("mass", "more", "expected"),
    [
        ("3", {}, r"floor_masses: .*floor 1: 26\.4 t, floor table"),
        ("3", {"mass_eccentricity": (0.1, 0.0)}, "floor_masses: .*floor 1: "),
        (
            "3",
            {"mass_eccentricity": (9.0, 0.0)},
            r"(?s)eccentricity = '\(9, 0\) m': the.*floor_masses: .*floor 1: 26\.4 t",
        ),
        ("30", {"mass_eccentricity": (9.0, 0.0)}, r"eccentricity = '\(9, 0\) m': the mass of"),
    ],
)
def test_masses_that_parts_do_not_allow(frame, edited, mass, more, expected):
    """The key that is at fault is named, whatever else is given."""
    edited(frame.with_name("frame_floors.csv"), ("\n1,30,", f"\n1,{mass},"))
    case = load_case(frame)
    case = case.model_copy(update={"structure": case.structure.model_copy(update=more)})
    with pytest.raises(InputError, match=expected):
        read_parts(building_of(case), frame.with_name("frame.msh"))


def test_mechanism_is_named_by_its_place(frame, tmp_path, monkeypatch):
    """Without its base the frame floats."""
    case = load_case(frame)
    parts, masses = read_parts(building_of(case), frame.with_name("frame.msh"))
    floating = replace(parts, mesh=replace(parts.mesh, base=np.empty(0, dtype=np.int64)))

    monkeypatch.setattr(compute, "read_parts", lambda *_: (floating, masses))
    with pytest.raises(SolutionError, match=r"node at \(.*\) m in \w+_[12]"):
        analysed(building_of(case), tmp_path, MPI.COMM_SELF, nullcontext)


def test_a_rank_without_free_nodes(monkeypatch, tmp_path):
    """Three modes of another rank's two nodes; this one has rows of the base alone."""
    other = np.arange(36.0).reshape(12, 3)
    mine = Modes(np.ones(3), np.zeros((0, 3)), np.zeros(3))
    model = SimpleNamespace(
        nodes=np.zeros(0, dtype=np.int64),
        n_nodes=4,
        n_free=12,
        about=lambda origin: (np.zeros((0, 6)), np.eye(6)),
    )
    sent = np.array([3, 1]), other.reshape(2, 6, 3)[:, :3].astype(np.float32)
    comm = SimpleNamespace(
        size=2, gather=lambda own, root: [own, sent], allreduce=lambda value: value
    )
    monkeypatch.setattr(compute, "assemble_building", lambda comm, parts: model)
    monkeypatch.setattr(compute, "_modes", lambda model, structure, known: (1.0, mine))
    case = load_case(GEOMETRY / "frame.toml")
    found, _, _ = analysed(building_of(case), tmp_path, comm, lambda name: nullcontext())
    assert found.shapes.shape == (3, 4, 3) and found.participation.shape == (3, 6)
    np.testing.assert_array_equal(found.shapes[:, 3].T, other[:3])


def test_factor_against_the_full_search(parts):
    """The factor found in the space of the modes is that of the full model."""
    model = assemble_building(MPI.COMM_SELF, parts)
    factor, _, rounds = fit_storey_factor(model, 4.0, 1, 0.05, 8)
    assert rounds > 1
    K = model.stiffness(factor)
    again = modes(K, model.mass, 8)
    gamma = again.shapes.T @ model.ground[:, 1]
    first = bending_modes(gamma**2, model.total[1, 1])[0]
    assert again.frequency[first] == pytest.approx(4.0, rel=1e-6)
    # From near by the space of the ground motion gives it; no second modal analysis follows.
    near, _, rounds = fit_storey_factor(model, 4.0, 1, 0.95 * factor, 8)
    assert rounds == 1 and near == pytest.approx(factor, rel=1e-5)
    stiffer = modes(model.stiffness(1.1 * factor), model.mass, 8)
    assert stiffer.frequency[first] > 4.0 * 1.01


def test_factor_in_a_space_against_its_own_eigenvalue_problem(parts):
    """With λ given the factor f is an eigenvalue: (λ M − K_fixed) a = f K_storeys a, in V."""
    model = assemble_building(MPI.COMM_SELF, parts)
    V = modes(model.stiffness(0.3), model.mass, 8).shapes
    fixed, storeys, mass = (V.T @ product(A, V) for A in (model.fixed, model.storeys, model.mass))
    for frequency in (3.0, 4.0, 5.0):
        factor = compute._reduced_fit(model, V, frequency, 1, 0.3)
        exact = scipy.linalg.eigvals((2 * np.pi * frequency) ** 2 * mass - fixed, storeys)
        assert np.abs(exact / factor - 1).min() < 1e-9
        assert np.abs(exact / (1.001 * factor) - 1).min() > 1e-4


def test_no_vectors_are_kept_beside_a_modal_analysis(parts, monkeypatch):
    made, kept = [], []

    class Basis(compute.KrylovBasis):
        def __init__(self, *given):
            super().__init__(*given)
            made.append(weakref.ref(self.vectors))

    def analysis(*given, **further):
        gc.collect()
        kept.extend(vectors() is not None for vectors in made)
        return modes(*given, **further)

    monkeypatch.setattr(compute, "KrylovBasis", Basis)
    monkeypatch.setattr(compute, "modes", analysis)
    fit_storey_factor(assemble_building(MPI.COMM_SELF, parts), 4.0, 1, 0.3, 8)
    assert made and kept and not any(kept)


def test_frequency_that_no_factor_gives(parts):
    model = assemble_building(MPI.COMM_SELF, parts)
    with pytest.raises(SolutionError, match=r"storey factor .* 400 Hz"):
        fit_storey_factor(model, 400.0, 1, 0.5, 8)


def test_check_reads_the_mesh(frame, edited):
    assert study.check(frame, mesh=True).structure is not None
    edited(frame, ('groups = "floor_*"', 'groups = "floor_1"'))
    assert study.check(frame).structure is not None
    with pytest.raises(InputError, match=r"frame\.msh: floor_2:"):
        study.check(frame, mesh=True)

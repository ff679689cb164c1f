"""The motion of the whole model, beside the histories of the probes."""

import shutil
from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray as xr

from impactfem.case.transient import Transient
from impactfem.reduction.probes import motion_grid
from impactfem.run import loop
from impactfem.stages.transient import export
from impactfem.stages.transient.export import exported_steps, write_motion
from impactfem.system.errors import InputError, SolutionError
from one_building import building_of

from .conftest import no_pictures, seen_by_vtk, steps_of

NAMES = ("displacement", "acceleration")
FILE = "transient_motion.vtkhdf"
ON = ('checkpoint_every = "0.2 s"', 'checkpoint_every = "0.2 s"\nexport = true')
IMPACT = (0.31, 0.33)


@pytest.fixture(scope="module")
def exported(reduced, edited, tmp_path_factory):
    """The reduced run again with its motion."""
    folder = tmp_path_factory.mktemp("exported")
    shutil.copytree(reduced[0], folder, dirs_exist_ok=True)
    case = edited(folder / "frame.toml", ON)
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        return loop.run(case, out=folder / "run", stage="transient", draw=False)


@pytest.fixture(scope="module")
def seen(exported, tmp_path_factory):
    """What VTK reads of it."""
    return seen_by_vtk(exported.folder / FILE, tmp_path_factory.mktemp("seen") / "found")


@pytest.fixture
def store(exported):
    return xr.load_dataset(exported.folder / "transient.nc", engine="netcdf4")


def test_what_is_written(exported, seen, frame):
    """The default: 0.2 s at every step, from 10 ms before the impact of 0.7 s, at all vertices."""
    listed = (exported.folder / "transient.stage.json").read_text()
    assert FILE in listed
    assert "export" in steps_of(exported)
    assert seen["times"] == pytest.approx(np.arange(691, 892) * 1e-3, abs=1e-9)
    grid = motion_grid(frame.parts.mesh, "vertices")
    assert np.array_equal(seen["points"], grid.points)
    assert np.count_nonzero(seen["types"] == 5) == len(frame.parts.mesh.triangles)
    assert np.count_nonzero(seen["types"] == 3) == len(frame.parts.mesh.lines)
    log = (exported.folder / "run.log").read_text()
    assert f"motion of {len(grid.nodes)} nodes at 201 times, 0.691 to 0.891 s" in log
    assert "nodes whose motion" in log


def test_histories_are_those_of_the_probes(seen, store, frame):
    nodes = motion_grid(frame.parts.mesh, "vertices").nodes
    steps = np.rint(np.array(seen["times"]) / 1e-3).astype(int)
    compared = 0
    for k, node in enumerate(store.probe_node.values):
        if node not in nodes:
            continue
        compared += 1
        at = int(np.searchsorted(nodes, node))
        for name in NAMES:
            known = store[name].values[:, k]
            close = {"rtol": 0.0, "atol": 1e-6 * np.abs(known).max()}
            assert np.allclose(seen[name][:, at], known[steps], **close)
            assert not np.allclose(seen[name][:, at], known[steps - 1], **close)
            assert not np.allclose(seen[name][:, at - 1], known[steps], **close)
    assert compared >= 6


def test_base_moves_with_the_ground(seen, store, frame):
    mesh = frame.parts.mesh
    nodes = motion_grid(mesh, "vertices").nodes
    base = np.isin(nodes, mesh.base)
    assert base.any() and not seen["displacement"][:, base].any()
    ground = store.ground_acceleration.values[691:892].astype(np.float32)
    assert np.array_equal(seen["acceleration"][:, base], np.tile(ground[:, None], (base.sum(), 1)))
    assert seen["displacement"][1:, ~base].any(axis=(0, 2)).all()


@pytest.fixture
def whole(frame, loads):
    """What the export needs of a study on the frame; the basis keeps all nodes."""
    basis = frame.basis(loads, nodes=np.arange(len(frame.parts.mesh.nodes)))

    def made(**asked):
        transient = Transient(time_step=loads.time_step, export=True, **asked)
        building = building_of(frame.case.model_copy(update={"transient": transient}))
        prepared = SimpleNamespace(
            building=building, parts=frame.parts, loads=loads, damping=frame.damping
        )
        return SimpleNamespace(prepared=prepared, basis=basis)

    return made


def fields_of(path):
    with h5py.File(path) as file:
        times = file["VTKHDF/Steps/Values"][...]
        found = {name: file[f"VTKHDF/PointData/{name}"][...] for name in NAMES}
    return {name: values.reshape(len(times), -1, 3) for name, values in found.items()} | {
        "times": times
    }


def test_parts_do_not_show(whole, tmp_path, monkeypatch):
    """Results do not depend on the nodes computed at once, apart from rounding."""
    progress = []
    path = tmp_path / "m.vtkhdf"
    case = whole(export_nodes="all", export_duration=0.01)
    assert write_motion(path, case, "key", progress.append) == [path]
    once = fields_of(path)
    assert progress == [1.0]
    monkeypatch.setattr(export, "NODES", 7)
    write_motion(path, case, "key", progress.append)
    assert len(progress) > 3 and progress[-1] == 1.0
    for name in NAMES:
        largest = np.abs(once[name]).max()
        assert np.abs(fields_of(path)[name] - once[name]).max() < 1e-6 * largest


def test_choice_of_times(whole, tmp_path):
    path = tmp_path / "m.vtkhdf"
    write_motion(path, whole(export_start=0.3, export_duration=0.05), "key")
    every = fields_of(path)
    assert every["times"] == pytest.approx(np.linspace(0.3, 0.35, 101), abs=1e-9)
    write_motion(path, whole(export_start=0.3, export_duration=0.05, export_step=2e-3), "key")
    some = fields_of(path)
    assert some["times"] == pytest.approx(every["times"][::4], abs=1e-12)
    for name in NAMES:
        assert np.abs(some[name] - every[name][::4]).max() < 1e-6 * np.abs(every[name]).max()


def test_basis_without_the_nodes(whole, tmp_path):
    asked = whole(export_nodes="all")
    short = replace(asked.basis, nodes=asked.basis.nodes[:-1], vectors=asked.basis.vectors[:-1])
    asked.basis = short
    path = tmp_path / "m.vtkhdf"
    path.write_text("old")
    with pytest.raises(KeyError, match="not made for"):
        write_motion(path, asked, "key")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("asked", "impact", "steps"),
    [
        ({}, IMPACT, range(600, 1001)),
        ({"export_duration": 0.01}, IMPACT, range(600, 621)),
        ({"export_step": 0.01}, IMPACT, range(600, 1001, 20)),
        ({"export_step": 0.00124}, IMPACT, range(600, 1001, 2)),
        ({"export_start": 0.0}, IMPACT, range(401)),
        ({"export_start": 0.1001}, IMPACT, range(201, 601)),
        ({"export_start": 0.75}, IMPACT, range(1500, 1601)),  # to the end of what is computed
        ({"export_start": 0.8}, IMPACT, [1600]),
        ({"export_duration": 1e-4}, IMPACT, [600]),
        ({}, (0.004, 0.01), range(401)),
    ],
)
def test_exported_steps(loads, asked, impact, steps):
    transient = Transient(time_step=loads.time_step, **asked)
    assert exported_steps(transient, loads, impact).tolist() == list(steps)


def test_without_an_impact(loads):
    largest = int(np.argmax(np.abs(loads.ground[:, 1])))
    found = exported_steps(Transient(time_step=loads.time_step), loads, None)
    assert found[0] == largest - 20


def test_start_that_is_not_computed(loads):
    transient = Transient(time_step=loads.time_step, export_start=0.81)
    with pytest.raises(SolutionError, match=r"computed is 0\.8 s"):
        exported_steps(transient, loads, IMPACT)


def test_start_behind_the_forces_is_told_before_the_basis(begun, tmp_path, edited):
    shutil.copytree(begun, tmp_path, dirs_exist_ok=True)
    late = (ON[0], ON[1] + '\nexport_start = "1 s"')
    case = edited(tmp_path / "frame.toml", late)
    with pytest.raises(InputError, match="'1 s': expected less than"):
        loop.run(case, out=tmp_path / "run", stage="transient", draw=False)
    assert not (tmp_path / "run" / "reduce.npz").exists()


def test_motion_of_a_run_before_is_removed(exported, tmp_path, edited, monkeypatch):
    """And its basis, which has more nodes than asked for, is used again."""
    no_pictures(monkeypatch)
    shutil.copytree(exported.folder.parent, tmp_path, dirs_exist_ok=True)
    case = edited(tmp_path / "frame.toml", (ON[1], ON[0]))
    assert (tmp_path / "run" / FILE).is_file()
    done = loop.run(case, out=tmp_path / "run", stage="transient", draw=False)
    assert not (tmp_path / "run" / FILE).exists()
    assert "export" not in steps_of(done)


def test_lost_motion_is_made_again(exported, tmp_path, monkeypatch):
    no_pictures(monkeypatch)
    shutil.copytree(exported.folder.parent, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "run" / FILE
    whole = path.read_bytes()
    path.write_bytes(whole[:-1000])
    done = loop.run(tmp_path / "frame.toml", out=tmp_path / "run", stage="transient", draw=False)
    assert "export" in steps_of(done) and "basis" not in steps_of(done)
    assert path.read_bytes() == whole

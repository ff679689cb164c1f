"""Damping by part in full order: the shipped frame, and the stage of its study."""

import shutil

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from impactfem.building.model import damping_matrix
from impactfem.building.parts import PartDamping
from impactfem.dynamics.damping import Rayleigh
from impactfem.run import loop
from impactfem.system.errors import ImpactfemError, InputError

from .conftest import EARLY, SHORT, STOREY_FACTOR, full_disk, no_pictures, write_forces

OTHER = Rayleigh(0.05, 1e-4)
ENTRY = """
[[buildings.structure.damping]]
parts = ["{parts}"]
ratio = "{ratio} %"
frequencies = ["1 Hz", "20 Hz"]
"""


@pytest.fixture(scope="module")
def short(frame):
    return frame.loads(1e-3, 420)


@pytest.fixture
def run(frame, short, tmp_path):
    """The full model with a damping, and another one of some families of parts."""

    def running(whole, own, families=""):
        mesh = frame.parts.mesh
        C = None
        if own is not None:
            shells, beams = (
                tuple(own if part.family in families else None for part in some)
                for some in (mesh.shell_parts, mesh.beam_parts)
            )
            dampings = PartDamping(shells, beams)
            C = damping_matrix(MPI.COMM_SELF, frame.parts, dampings, STOREY_FACTOR, whole)
        return frame.full(short, whole, tmp_path / f"{families}_{own}_{whole}", C=C)

    return running


def apart(one, other):
    return max(
        float(np.abs(getattr(one.response, name) - value).max() / np.abs(value).max())
        for name in ("displacement", "acceleration")
        for value in [getattr(other.response, name)]
    )


def test_all_parts_alike_are_the_whole(frame, run):
    every = "floor storey beam column"
    same = run(frame.damping, None)
    # From a lighter and from a heavier damping of the building, which then holds for no part.
    for whole in (OTHER, Rayleigh(3.0, 5e-3)):
        parts = run(whole, frame.damping, every)
        assert apart(parts, same) < 1e-10
        assert parts.energy.damped == pytest.approx(
            same.energy.damped, rel=1e-10, abs=1e-10 * same.energy.input.max()
        )
        assert parts.energy.residual < 1e-9
    assert apart(run(frame.damping, OTHER, "beam column storey"), same) > 0.05


def test_energy_by_part(frame, run):
    """What parts dissipate is counted; less damping of the slabs leaves more energy."""
    same = run(frame.damping, None)
    parts = run(frame.damping, OTHER, "floor")
    assert parts.energy.residual < 1e-9
    assert parts.energy.damped[-1] > 0.0
    stored = [one.energy.kinetic + one.energy.elastic for one in (parts, same)]
    assert stored[0][-1] > 1.02 * stored[1][-1]
    # Without what the parts take the balance does not hold.
    assert (
        np.abs(stored[0] + same.energy.damped - parts.energy.input).max() > 1e-6 * stored[0].max()
    )


@pytest.fixture
def case(begun, edited, tmp_path, monkeypatch):
    """The case by the full solver with a damping of some parts."""
    no_pictures(monkeypatch)

    def made(name, parts="", ratio="1", duration=SHORT):
        folder = tmp_path / name
        shutil.copytree(begun, folder)
        write_forces(folder / "forces_of_another.csv", starts=EARLY)
        asked = f'solver = "full"\nduration = "{duration}"\n'
        path = edited(folder / "frame.toml", ('solver = "reduced"\n', asked))
        if parts:
            entry = f"{ENTRY.format(parts=parts, ratio=ratio)}[buildings.structure.mesh]"
            path.write_text(path.read_text().replace("[buildings.structure.mesh]", entry, 1))
        return path

    return made


def computed(case):
    done = loop.run(case, out=case.parent / "run", stage="transient", draw=False)
    assert done.reused == ["building", "pounding"]
    store = loaded(case)
    assert float(store.energy_residual) < 1e-9
    return store


def loaded(case):
    return xr.load_dataset(case.parent / "run" / "transient.nc", engine="netcdf4")


def test_stage(case, edited):
    """What is the same for all parts is [damping]; the modes do not depend on it."""
    plain = computed(case("plain", duration="0.2 s"))
    path = case("alike", "*", "5", duration="0.2 s")
    alike = computed(path)
    largest = float(np.abs(plain.acceleration).max())
    assert float(np.abs(alike.acceleration - plain.acceleration).max()) < 1e-10 * largest
    assert "14 of 14 parts have" in (path.parent / "run/run.log").read_text()
    light = computed(edited(path, ('["*"]\nratio = "5 %"', '["*"]\nratio = "1 %"')))
    assert float(np.abs(light.acceleration - plain.acceleration).max()) > 0.05 * largest


def test_patterns_without_a_part(case):
    path = case("unknown", "roof_*")
    match = (
        r"structure\.damping\[0\]\.parts\[0\] = .roof_\*.: expected a pattern of the parts of the "
        r"mesh: beam_1_east, .*floor_1, floor_2"
    )
    with pytest.raises(InputError, match=match):
        loop.run(path, out=path.parent / "run", stage="transient", draw=False)


@pytest.mark.slow
def test_resumed(case, caplog):
    """An interrupted run resumes with its own damping only."""
    whole = computed(case("whole", "storey_*"))
    for ratio, resumes in (("1", True), ("2", False)):
        path = case(f"interrupted_{ratio}", "storey_*", ratio)
        with full_disk("rank_0_250.npz"), pytest.raises(ImpactfemError, match="rank_0_250"):
            computed(path)
        path.write_text(path.read_text().replace(f'ratio = "{ratio} %"', 'ratio = "1 %"'))
        caplog.clear()
        with caplog.at_level("INFO", "impactfem"):
            again = computed(path)
        assert ("going on from 0.200 s" in caplog.text) == resumes
        np.testing.assert_array_equal(again.acceleration, whole.acceleration)

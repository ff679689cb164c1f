"""The estimate of a run: beside what the shipped cases were measured to take."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.run import estimate as module
from impactfem.run.estimate import StageCost, duration, estimate, side_by_side, too_much

GEOMETRY = Path(__file__).parents[2] / "geometry"
# Largest memory of the stages that make matrices [GB], of the provenance of runs; the others are
# below, and have that of their figures, too.
MEASURED = {
    "npp_pair": {"building": 2.7, "reduce": 5.0, "transient": 2.1, "device": 2.1},
    "npp_pair_fine": {"building": 11.0},
    "two_frames": {"building": 0.74, "reduce": 1.1, "transient": 2.1, "device": 1.6, "design": 1.2},
}
DOFS = {"npp_pair": 342_594, "npp_pair_fine": 1_464_204}
LONGEST = 16.79


@pytest.fixture(scope="module")
def case():
    return load_case(GEOMETRY / "npp_pair.toml")


@pytest.mark.parametrize("name", MEASURED)
def test_memory_within_a_factor_of_one_and_a_half(name):
    found = estimate(load_case(GEOMETRY / f"{name}.toml"), LONGEST)
    assert name not in DOFS or found.dofs == pytest.approx(DOFS[name], rel=0.05)
    stages = {stage.name: stage for stage in found.stages}
    for stage, measured in MEASURED[name].items():
        assert 1 / 1.5 < 1e-9 * stages[stage].memory / measured < 1.5, stage


def test_time_and_disk_within_a_factor_of_two(case, monkeypatch):
    """330 s on two cores, and a folder of 329 MB."""
    monkeypatch.setattr(module, "threads", lambda: 2)
    found = estimate(case, LONGEST)
    assert 0.5 < found.seconds / 330.0 < 2.0 and 0.5 < 1e-6 * found.disk / 329.0 < 2.0
    assert "degrees of freedom" in found.line and "\n" not in found.line


@pytest.mark.parametrize(("step", "measured"), [(0.3358e-3, 0.85), (0.03358e-3, 5.06)])
def test_memory_of_sticks_alone(case, step, measured):
    """`impactfem run geometry/npp_pair.toml --stage pounding`, with shorter steps as well."""
    shorter = case.pounding.model_copy(update={"time_step": step})
    found = estimate(case.model_copy(update={"pounding": shorter, "structure": None}), LONGEST)
    (sticks,) = (one for one in found.stages if one.name == "pounding")
    assert 1 / 1.5 < 1e-9 * sticks.memory / measured < 1.5


def test_buildings_side_by_side(monkeypatch):
    """With memory for both, a core for each and enough to compute."""
    costs = [StageCost("reduce", 30.0, 6e9), StageCost("B2/reduce", 40.0, 6e9)]
    for room, cores, together in ((64e9, 2, True), (10e9, 2, False), (64e9, 1, False)):
        monkeypatch.setattr(module, "available_memory", lambda room=room: room)
        monkeypatch.setattr(module, "threads", lambda cores=cores: cores)
        assert side_by_side(costs) is together and not side_by_side(costs[:1])


@pytest.mark.parametrize(
    ("machine", "disk", "words"),
    [
        (64e9, 0, None),
        (20e9, 10e9, None),
        (20e9, 1e9, "GB of memory, and /scratch 1 GB for the rest"),
        (8e9, 1e12, "needs about"),
    ],
)
def test_what_can_go_to_a_file_is_not_refused(monkeypatch, machine, disk, words):
    fine = load_case(GEOMETRY / "npp_pair_fine.toml")
    monkeypatch.setattr(module, "available_memory", lambda whole: machine)
    monkeypatch.setenv("TMPDIR", "/scratch")
    usage = module.shutil._ntuple_diskusage(disk, 0, disk)
    monkeypatch.setattr(module.shutil, "disk_usage", lambda folder: usage)
    found = list(too_much(fine, estimate(fine, LONGEST)))
    assert len(found) == (words is not None)
    assert words is None or words in found[0].expected


def test_the_stages_that_are_asked_for(monkeypatch):
    """A machine that is too small for the 3D model runs the sticks."""
    fine = load_case(GEOMETRY / "npp_pair_fine.toml")
    monkeypatch.setattr(module, "available_memory", lambda whole: 4e9)
    found = estimate(fine, LONGEST)
    assert list(too_much(fine, found)) and not list(too_much(fine, found.of({"pounding"})))
    assert found.of(set()) == found


def test_times_in_words():
    words = [duration(s) for s in (0.2, 61.0, 600.0, 9000.0, 3e5, 1e15)]
    assert words == ["1 s", "61 s", "10 min", "2 h", "3 days", "12,000,000,000 days"]


def test_longer_takes_more(case):
    base = estimate(case, LONGEST)
    mesh = case.structure.mesh.model_copy(update={"size": 0.5})
    more = {
        "pounding": case.pounding.model_copy(update={"time_step": 1e-6}),
        "transient": case.transient.model_copy(update={"time_step": 1e-5}),
        "structure": case.structure.model_copy(update={"mesh": mesh}),
        "ensemble": case.ensemble.model_copy(update={"motions": 10_000}),
    }
    for name, section in more.items():
        found = estimate(case.model_copy(update={name: section}), LONGEST)
        assert found.seconds > base.seconds, name
        assert sum(s.memory for s in found.stages) > sum(s.memory for s in base.stages), name

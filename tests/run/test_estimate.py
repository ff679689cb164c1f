"""The estimate of a run: beside what the shipped cases were measured to take."""

import re
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.read_mesh import read_mesh
from impactfem.case import load_case
from impactfem.case.motions import WavePassage
from impactfem.run import estimate as module
from impactfem.run.estimate import duration, estimate, nodes_of_file, too_much

GEOMETRY = Path(__file__).parents[2] / "geometry"
# Largest memory of the stages that make matrices [GB], of the provenance of runs; the others are
# below, and have that of their figures, too.
MEASURED = {
    "npp_pair": {"building": 2.7, "reduce": 5.0, "calibrate": 1.4, "transient": 2.1, "device": 2.1},
    "npp_pair_fine": {"building": 11.0},
    "two_frames": {"building": 0.74, "reduce": 1.1, "transient": 2.1, "device": 1.6, "design": 1.2},
}
FOLDERS = {"npp_pair": 329, "npp_pair_fine": 857, "two_frames": 260, "row_of_three": 39}
"""Size of the folder of a whole run [MB]."""
DOFS = {"npp_pair": 342_594, "npp_pair_fine": 1_464_204, "two_frames": 58_500}
LONGEST = 16.79


@pytest.fixture(scope="module")
def case():
    return load_case(GEOMETRY / "npp_pair.toml")


@pytest.mark.parametrize("name", MEASURED)
def test_memory_within_a_factor_of_one_and_a_half(name):
    found = estimate(load_case(GEOMETRY / f"{name}.toml"), LONGEST)
    assert found.dofs == pytest.approx(DOFS[name], rel=0.05)
    stages = {stage.name: stage for stage in found.stages}
    for stage, measured in MEASURED[name].items():
        assert 1 / 1.5 < 1e-9 * stages[stage].memory / measured < 1.5, stage
    if "reduce" in MEASURED[name]:
        assert 1 / 1.5 < 1e-9 * found.largest.memory / max(MEASURED[name].values()) < 1.5


@pytest.mark.parametrize("name", FOLDERS)
def test_disk_within_a_factor_of_two(name):
    found = estimate(load_case(GEOMETRY / f"{name}.toml"), LONGEST)
    assert 0.5 < sum(1e-6 * stage.disk for stage in found.stages) / FOLDERS[name] < 2.0


def test_time_within_a_factor_of_two(case, monkeypatch):
    monkeypatch.setattr(module, "threads", lambda: 2)  # as where it was measured
    assert 0.5 < estimate(case, LONGEST).seconds / 330.0 < 2.0


@pytest.mark.parametrize(
    ("step", "measured"), [(0.3358e-3, 0.85), (0.1e-3, 1.98), (0.03358e-3, 5.06)]
)
def test_memory_of_sticks_alone(case, step, measured):
    """`impactfem run geometry/npp_pair.toml --stage pounding`, with shorter steps as well."""
    shorter = case.pounding.model_copy(update={"time_step": step})
    found = estimate(case.model_copy(update={"pounding": shorter, "structure": None}), LONGEST)
    assert 1 / 1.5 < 1e-9 * found.stages[0].memory / measured < 1.5


def test_the_lines(case):
    text = "\n".join(estimate(case, LONGEST).lines())
    assert "50,000 of the pounding, 3,824 at the wall, 10,000 of the 3D model, 80,000 with" in text
    assert re.search(r"about 3[0-9]0,000 degrees of freedom; vectors .* transient, .* reduce", text)
    assert re.search(
        r"^about \d+ min, (\S+) GB of memory \((\S+) GB of it in a file where memory is short\) "
        r"and \d+ MB of disk, within a factor of 2: building ",
        text,
        re.MULTILINE,
    )


def test_stages_of_two_buildings_side_by_side(monkeypatch):
    """They take the memory of both and the time of one, where there is room and a core for each."""
    pair = load_case(GEOMETRY / "npp_pair_coupled.toml")
    found = {}
    for room, cores in ((64e9, 2), (12e9, 2), (64e9, 1)):
        monkeypatch.setattr(module, "available_memory", lambda room=room: room)
        monkeypatch.setattr(module, "threads", lambda cores=cores: cores)
        costs = estimate(pair, LONGEST)
        found[room, cores] = {one.name: one for one in costs.in_turn}, costs.largest.memory
    (both, most), (alone, least) = found[64e9, 2], found[12e9, 2]
    first, second = alone["reduce"], alone["B2/reduce"]
    assert both["reduce"].memory == most == first.memory + second.memory
    assert least == first.memory
    assert both["reduce"].seconds == max(first.seconds, second.seconds)
    assert both["reduce"].disk == first.disk + second.disk and "B2/reduce" not in both
    assert "B2/reduce" in found[64e9, 1][0]


def test_steps_are_whole(case):
    """A step printed with four digits gives the steps that were meant."""
    exact = case.pounding.model_copy(update={"duration": 10.0, "time_step": 0.1})
    found = estimate(case.model_copy(update={"pounding": exact}), LONGEST)
    assert found.steps["of the pounding"] == 100


def test_steps_until_waves_have_passed(case):
    """The longest motion ends under all buildings, of records too: B2 is 15.61 m further."""
    passage = WavePassage(apparent_velocity=500.0, direction=(0.0, 1.0))
    update = {"pounding": case.pounding.model_copy(update={"duration": None, "time_step": 1e-3})}
    steps = [
        estimate(case.model_copy(update={**update, "wave_passage": waves}), 10.0).steps
        for waves in (None, passage)
    ]
    assert [found["of the pounding"] for found in steps] == [10_000, 10_032]


@pytest.mark.parametrize(("spacing", "measured"), [(1.9, 4.6), (15.4, 3.2)])
def test_time_of_pounding_in_3d(spacing, measured):
    """Of 10 s of motion with contact [s], docs/coupled-study.md; it hardly goes with the points."""
    coupled = load_case(GEOMETRY / "npp_pair_coupled.toml")
    pounding = coupled.pounding.model_copy(update={"contact_spacing": spacing, "duration": 10.0})
    sticks = pounding.model_copy(update={"models": {}})
    seconds = [
        {one.name: one.seconds for one in found.stages}["pounding"]
        for found in (
            estimate(coupled.model_copy(update={"pounding": models}), LONGEST)
            for models in (pounding, sticks)
        )
    ]
    # With contact, without it, and with half of the points.
    assert 0.5 < (seconds[0] - seconds[1]) / (3.0 * measured) < 2.0


def test_nodes_that_a_file_says(tmp_path):
    """In text, in binary form, in an earlier version, and where there are none."""
    for name in ("frame.msh", "two_frames.msh"):
        assert nodes_of_file(GEOMETRY / name) >= len(read_mesh(GEOMETRY / name).nodes)
    head = b"$MeshFormat\n4.1 1 8\n" + np.array([1], np.int32).tobytes() + b"\n$EndMeshFormat\n"
    path = tmp_path / "a.msh"
    path.write_bytes(head + b"$Nodes\n" + np.array([7, 1234, 1, 1234], np.uint64).tobytes())
    assert nodes_of_file(path) == 1234
    path.write_bytes(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n55\n1 0 0 0\n")
    assert nodes_of_file(path) == 55
    path.write_bytes(b"$Nodes\n")
    assert nodes_of_file(path) == 0


@pytest.mark.parametrize(
    ("machine", "disk", "words"),
    [
        (64e9, 0, None),
        (23e9, 10e9, None),
        (23e9, 1e9, "GB of memory, and /scratch 1 GB for the rest"),
        (8e9, 1e12, "stage reduce needs about"),
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
    more = {
        "pounding": case.pounding.model_copy(update={"time_step": 1e-6}),
        "transient": case.transient.model_copy(update={"time_step": 1e-5}),
        "structure": case.structure.model_copy(
            update={"mesh": case.structure.mesh.model_copy(update={"size": 0.5})}
        ),
        "ensemble": case.ensemble.model_copy(update={"motions": 10_000}),
    }
    for name, section in more.items():
        found = estimate(case.model_copy(update={name: section}), LONGEST)
        assert found.seconds > base.seconds, name
        assert sum(s.memory for s in found.stages) > sum(s.memory for s in base.stages), name

"""Two buildings with a 3D model each: what a case may say, what is computed again, a whole run."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from impactfem import study
from impactfem.case import load_case
from impactfem.run import loop
from impactfem.run.estimate import estimate
from impactfem.run.stages import OF_CASE, STAGES
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.manifest import is_finished
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE
from impactfem.stages.sensitivity.stage import SENSITIVITY
from impactfem.system.errors import InputError, SolutionError
from no_pictures import no_pictures
from two_models import BUILDINGS, CASE, DEVICE, PROBE, WALL, in_3d, write_case

CALIBRATION = """
[calibration]
targets = "targets.csv"
direction = "y"
stiffness_factor = [0.01, 1]
rigid_depth = "0.3 m"
height = "6 m"
from_structure = true
"""
FULL = (WALL, DEVICE, PROBE)
DAMPED = '\n[[damping_cases]]\nname = "light"\nratio = "2 %"\nfrequencies = ["1 Hz", "20 Hz"]\n'


@pytest.fixture
def case(tmp_path):
    return load_case(write_case(tmp_path, *FULL))


def test_handles(case):
    """Devices, impact on the wall and probes belong to one building; the first has no folder."""
    a, b = case.modelled["A"], case.modelled["B"]
    assert [one.name for one in (a, b)] == list(case.modelled) == ["A", "B"]
    assert [one.folder(Path("run")) for one in (a, b)] == [Path("run"), Path("run/B")]
    assert [one.run_folder(one.folder(Path("run"))) for one in (a, b)] == 2 * [Path("run")]
    assert [one.entry.name for one in (a, b)] == ["A", "B"]
    assert [one.name for one in case.at_wall] == ["B"]
    assert (a.wall_impact, a.devices, a.device_analysis, a.transient.probes) == (None, (), None, ())
    assert (b.wall_impact, b.devices) == (case.wall_impact, case.devices)
    assert b.transient.probes == case.transient.probes
    assert [one.case is case for one in (a, b)] == [True, True]


def test_floors_by_building(tmp_path, edited):
    floors = ("[transient]", "[transient]\nfloors = { B = [2] }")
    a, b = load_case(edited(write_case(tmp_path), floors)).in_time
    assert (a.transient.floors, b.transient.floors) == (None, (2,))


@pytest.mark.parametrize(
    ("more", "change", "key", "expected"),
    [
        (WALL, ('building = "B"\ngap', "gap"), "wall_impact.building", "'A' or 'B'"),
        (WALL, ('building = "B"\ngap', 'building = "C"\ngap'), "wall_impact.building", "unknown"),
        (DEVICE, ('building = "B"\npoint', "point"), "devices[0].building", "'A' or 'B'"),
        (DEVICE, ('name = "pump"', 'name = "b"'), "buildings[1].name", "one of [[devices]]"),
        (PROBE, ('"0 m", "6 m"', '"0 m", "60 m"'), "transient.probes[0].point", "a point of B"),
        (
            PROBE,
            ('point = ["0 m", "0 m", "6 m"]', 'group = "edge_3"'),
            "transient.probes[0].group",
            "floors of B",
        ),
        ("", ("[transient]", "[transient]\nfloors = { C = 1 }"), "transient.floors.C", "A"),
        ("", ("[transient]", "[transient]\nfloors = { B = 3 }"), "transient.floors", "in B"),
        ("", ("[transient]", "[transient]\nfloors = [3]"), "transient.floors", "in A"),
        ("", ('"B"', '"figures"'), "buildings[1].name", "a folder of the run"),
    ],
)
def test_refused(tmp_path, edited, more, change, key, expected):
    with pytest.raises(InputError) as error:
        load_case(edited(write_case(tmp_path, more), change))
    assert {one.key for one in error.value.faults} == {key}
    assert any(expected in one.expected for one in error.value.faults)


def test_no_model_of_the_building(tmp_path, edited):
    """Where one building has a 3D model, others are refused by name; none need be named."""
    text = BUILDINGS[0]
    bare = (text, text[: text.index("[buildings.structure]")])
    for change in [bare, ('building = "B"\ngap', 'building = "A"\ngap')], [bare]:
        path = edited(write_case(tmp_path, WALL), *change)
        if len(change) == 1:
            assert load_case(path).wall_impact.building == "B"
            continue
        with pytest.raises(InputError, match=r"wall_impact\.building.*a 3D model:"):
            load_case(path)


def test_every_fault_of_both(tmp_path, edited):
    """A fault in one 3D model hides none of the other, whose mesh is looked at as well."""
    path = write_case(tmp_path)
    head, b = path.read_text(encoding="utf-8").split('name = "B"')
    b = b.replace("modes = 8", "modes = 0").replace('"20 cm"', '"20 kg"', 1)
    head = head.replace("modes = 8", 'modes = 8\nmaterials = [{ parts = ["x"], material = "c" }]')
    path.write_text(f'{head}name = "B"{b}', encoding="utf-8")
    with pytest.raises(InputError) as error:
        study.check(path)
    assert {one.key for one in error.value.faults} == {
        "buildings[0].structure.materials[0].material",
        "buildings[1].structure.modes",
        "buildings[1].structure.mesh.slab_thickness",
    }


def test_sticks_depend_on_the_models_whose_modes_are_their_targets(tmp_path):
    (tmp_path / "targets.csv").write_text(
        "building,mode,frequency [Hz],effective_mass [t]\nB,1,3,50\n", encoding="utf-8"
    )
    case = load_case(write_case(tmp_path, CALIBRATION))
    for changed, depends in ((0, False), (1, True)):
        assert (POUNDING.key(with_more_modes(case, changed)) != POUNDING.key(case)) == depends
    assert [stage.labels(case) for stage in POUNDING.needs(case)] == [("B/building",)]


@pytest.mark.parametrize(("targets", "depends"), [("AB", True), ("B", False)])
def test_the_stick_before_the_wall_has_the_modes_of_all_targets(tmp_path, targets, depends):
    """The wall hits B, whose stick is fitted together with that of A."""
    rows = "".join(f"{name},1,3,50\n" for name in targets)
    head = "building,mode,frequency [Hz],effective_mass [t]\n"
    (tmp_path / "targets.csv").write_text(head + rows, encoding="utf-8")
    case = load_case(write_case(tmp_path, WALL, CALIBRATION))
    other = with_more_modes(case, 0)
    assert (CALIBRATE.key(case.modelled["B"]) != CALIBRATE.key(other.modelled["B"])) == depends


def with_more_modes(case, changed):
    """The case with another 3D model of its first or its second building."""
    structures = list(case.structures)
    structures[changed] = structures[changed].model_copy(update={"modes": 9})
    return case.model_copy(
        update={"structure": structures[0], "further_structures": tuple(structures[1:])}
    )


def test_a_second_model_computes_nothing_of_the_first(tmp_path, edited):
    """Probes that name no building are those of the only one, and of each of two."""
    more = PROBE.replace('building = "B"\n', "")
    both = load_case(write_case(tmp_path, more))
    text = BUILDINGS[1]
    model = text[text.index("[buildings.structure]") :]
    first = load_case(edited(write_case(tmp_path, more), (text, text.replace(model, ""))))
    assert [one.numbered_probes[0][0] for one in both.modelled.values()] == [0, 0]
    for stage in STAGES:
        # The changed parameters are those of both 3D models.
        if stage is not SENSITIVITY and stage.lacks(first) is None:
            assert stage.key(first) == stage.key(both.modelled["A"]), stage.name


@pytest.mark.parametrize("changed", [0, 1])
def test_another_model_computes_nothing_of_the_other(case, changed):
    """A stage of one building depends on its own 3D model; what serves both on neither.

    The sensitivity changes parameters of both.
    """
    other = with_more_modes(case, changed)
    for stage in STAGES:
        for one in stage.of(case):
            if stage in OF_CASE:
                assert (stage.key(one) == stage.key(other)) == (stage is not SENSITIVITY)
            else:
                same = stage.key(one) == stage.key(other.modelled[one.name])
                assert same == (one.name != "AB"[changed]), (stage.name, one.name)


def test_estimate(case, monkeypatch):
    """On one core buildings run one after another: times add up, the larger needs the memory."""
    monkeypatch.setattr("impactfem.run.estimate.threads", lambda: 1)
    found = estimate(case, 1.0)
    models = [{"structure": one, "further_structures": ()} for one in case.structures]
    alone = [estimate(case.model_copy(update=one), 1.0) for one in models]
    assert {"reduce", "B/reduce", "B/device"} < {one.name for one in found.stages}
    assert found.largest.memory == max(one.largest.memory for one in alone)
    assert {one.name for one in found.of({"reduce"}).stages} == {"reduce", "B/reduce"}


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_run(tmp_path, edited):
    """All stages of both; calibrated contact and devices of the second one."""
    path = edited(
        write_case(tmp_path, *FULL, DAMPED, '[sensitivity]\nparameters = ["gap"]\n'),
        ('"5e8 N/m"\nrestitution = 0.5', '"calibrated"\nrestitution = "calibrated"'),
    )
    folder = tmp_path / "run"
    result = loop.run(path, out=folder)
    labels = ["building", "B/building", "reduce", "B/reduce", "B/calibrate", "pounding"]
    labels += ["transient", "B/transient", "B/device", "design", "B/design"]
    labels += ["sensitivity"]
    made = json.loads((folder / "provenance.json").read_text())
    assert list(made["inputs"]) == labels
    assert made["needs"]["B/device"] == ["B/reduce", "B/calibrate", "pounding"]
    assert made["needs"]["pounding"] == ["B/calibrate"]
    values = {one.name: one.value for one in result.scalars}
    assert len(values) == len(result.scalars)
    assert (values["building.frequency.1"], values["building.B.frequency.1"]) == pytest.approx(
        (4.0, 3.0), rel=1e-5
    )
    with study.open_run(folder) as opened:
        b = opened.of("B")
        assert opened.of("A") is opened
        assert b.value("building.frequency.1") == pytest.approx(3.0, rel=1e-5)
        assert float(b.building.frequency[0]) == pytest.approx(3.0, rel=1e-5)
        assert b.pounding.attrs == opened.pounding.attrs
        assert "device" in b.stores and "device" not in opened.stores
        epsilon = b.calibrate["epsilon"]
        assert b.device["epsilon"].sel(case="light") == epsilon.sel(case="light")
        # Both take the force of a pair at the step of the 3D model, each on its own edge.
        a_force, b_force = (one.transient["edge_force"] for one in (opened, b))
        assert float(abs(a_force).max()) > 0.0
        np.testing.assert_allclose(b_force, a_force, rtol=1e-9)
        with pytest.raises(InputError, match="with a 3D model are: A, B"):
            opened.of("C")
    log = (folder / "run.log").read_text(encoding="utf-8")
    assert log.count("transient: time steps in a cycle") == 1  # before the first stage, for both
    page = (folder / "report.html").read_text()
    assert all(title in page for title in ("The 3D model: A", "The 3D model: B", "Devices: B"))
    assert loop.run(path, out=folder).reused == labels


@pytest.mark.slow
def test_buildings_side_by_side(tmp_path, monkeypatch, capfd):
    """Each in a process of its own: the same results and messages; one failure is no other's."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    path, one, two = in_3d(tmp_path), tmp_path / "one", tmp_path / "two"
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        loop.run(path, out=one, stage="building", draw=False)
        shutil.copytree(one, two)
        one_by_one = loop.run(path, out=one, stage="reduce", draw=False)
        patch.setattr("impactfem.run.estimate.APART", 0.0)
        capfd.readouterr()
        at_once = loop.run(path, out=two, stage="reduce", draw=False)
        assert "DEBUG:" not in capfd.readouterr().err  # what a library's handler would say
        for one_value, other in zip(one_by_one.scalars, at_once.scalars, strict=True):
            assert one_value.name == other.name
            if other.value is not None:
                assert one_value.value == pytest.approx(other.value, rel=1e-6, abs=1e-9)
        assert one_by_one.times.keys() == at_once.times.keys()
        log = [(folder / "run.log").read_text() for folder in (one, two)]
        for text in ("stage B/reduce: starts", "reduced basis: ", "matrices: "):
            assert log[0].count(text) == log[1].count(text) > 0
        assert "B/reduce: reduced basis: " in log[1] and "B/reduce: reduced" not in log[0]
        assert log[0].index("stage reduce: done") < log[0].index("stage B/reduce: starts")
        assert log[1].index("stage B/reduce: starts") < log[1].index("stage reduce: done")
        # So few vectors serve the stiffer building alone, whose model is there.
        (two / "B" / "reduce.npz").unlink()
        path.write_text(path.read_text().replace("= 0.05", "= 0.01\nlargest_basis = 45"))
        with pytest.raises(SolutionError, match="45 vectors"):
            loop.run(path, out=two, stage="reduce", draw=False)
    every = REDUCE.of(load_case(path))
    finished = [is_finished(two, REDUCE.label(one), REDUCE.key(one)) for one in every]
    assert finished == [True, False]


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_a_mirrored_pair(tmp_path):
    """Pushed together, equal buildings answer as in a mirror, to what their meshes differ."""
    path = write_case(tmp_path)
    text = CASE.replace('"3 Hz"', '"4 Hz"').replace("factor = 0.2", "factor = 1")
    start, end = text.index("[[motions]]"), text.index("[contact_laws")
    loads = '[[loads]]\nfile = "push.csv"\ndirection = [0, 1, 0]\n'
    path.write_text(
        (text[:start] + loads + text[end:]).replace("[pounding]", '[pounding]\nduration = "0.5 s"')
    )
    (tmp_path / "push.csv").write_text(
        "time [s],A.floor_2 [MN],B.floor_2 [MN]\n0,0,0\n0.05,2,-2\n0.1,0,0\n0.5,0,0\n"
    )
    folder = tmp_path / "run"
    loop.run(path, out=folder, stage="transient", draw=False)
    with study.open_run(folder) as opened:
        a, b = (
            one.transient["acceleration"].sel(probe="centre_2", component="y").values
            for one in (opened, opened.of("B"))
        )
        assert opened.value("pounding.impacts") > 0
    np.testing.assert_allclose(b, -a, atol=0.05 * np.abs(a).max())

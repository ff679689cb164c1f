"""What `check` finds beyond the files of a case, in one round, and what it warns of."""

import csv
import json
import logging
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from frame_case import floors_meet, neighbour, pump
from impactfem import study
from impactfem.building.links import BasePlate
from impactfem.case import load_case
from impactfem.case.devices import NODES
from impactfem.case.soil import COMPONENTS
from impactfem.coupling.force_history import ForceHistory
from impactfem.run import loop
from impactfem.run.check import checked, node_checks
from impactfem.stages.pounding import stage as pounding
from impactfem.stages.pounding.model_checks import STICK_FREQUENCY
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.transient import stage as transient
from impactfem.stages.transient.checks import SAMPLES
from impactfem.system.errors import InputError
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar
from impactfem.verify.motion import knet_text

GEOMETRY = Path(__file__).parents[2] / "geometry"
TRANSIENT = """
[contact_laws.floor]
type = "hertz"
stiffness = "1e9 N/m^1.5"
[transient]
time_step = "1 ms"
maximum_frequency = "50 Hz"
"""
FORCES = """forces = "forces.csv"
duration = "0.5 s"
"""
PROBE = """[[transient.probes]]
name = "corner"
point = ["0 m", "0 m", "%s"]
"""


@pytest.fixture
def frame(tmp_path, edited):
    """A case of the shipped frame with a mesh of its own, changed and with more text."""
    for path in GEOMETRY.glob("frame*"):
        shutil.copy(path, tmp_path)
    case = tmp_path / "frame.toml"
    edited(case, neighbour('axis = ["0 m", "5 m"]\n'))

    def made(more="", *changes):
        with case.open("a", encoding="utf-8") as stream:
            stream.write(TRANSIENT + more)
        return edited(case, *changes)

    return made


def forces(folder, pairs=("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), end=0.5, peak=0.0):
    t = 0.001 * np.arange(round(1000 * end) + 1)
    force = peak * np.maximum(0.0, np.sin(50.0 * t))[:, None] * np.ones(len(pairs))
    ForceHistory(t, pairs, force).write_csv(folder / "forces.csv")


def faults(case, mesh=True):
    with pytest.raises(InputError) as caught:
        study.check(case, mesh=mesh)
    return [str(fault).removeprefix(f"{case.parent}/") for fault in caught.value.faults]


AT_ONCE = {
    "devices[0].point = ['3 m', '1 m', '4.5 m']: device pump: its anchor at z = 4.5 m is on no": (
        '"1 m", "4.5 m"]',
        '"1 m", "3 m"]',
    ),
    "ensemble.structure_motions = 2: expected 0: each member has": ("_motions = 2", "_motions = 0"),
    "pounding.time_step = '5 s': expected at most half of what is computed, 3 s": (
        '"5 s"',
        '"1 ms"',
    ),
    "baem_*": ("baem_*", "beam_*"),
    "transient.probes[0].point = ['0 m', '0 m', '99 m']: the probe corner at (": ("99 m", "6 m"),
    "spectra.dampings: unknown key": ("dampings", "damping"),
}
"""What the faults of a case say, and how each is mended."""


def test_everything_at_once(frame, tmp_path, edited):
    forces(tmp_path)
    more = FORCES + PROBE % "99 m" + floors_meet("1 m") + pump('["3 m", "1 m", "4.5 m"]', "0.5 m")
    case = frame(
        more + "[ensemble]\nmotions = 4\nstructure_motions = 2\n",
        ('groups = "beam_*"', 'groups = "baem_*"'),
        ('[pounding]\ntime_step = "1 ms"', '[pounding]\ntime_step = "5 s"'),
        ("[spectra]\ndamping = ", "[spectra]\ndampings = "),
    )
    left = dict(AT_ONCE)
    while left:
        found = faults(case)
        for words in AT_ONCE:
            assert (words in "\n".join(found)) == (words in left), (words, found)
        _, change = left.popitem()
        edited(case, change)
    assert study.check(case, mesh=True).devices


@pytest.mark.parametrize(
    ("pairs", "end", "meet", "words"),
    [
        (("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), 0.5, True, ""),
        (("F.floor_1-G.floor_1", "F.floor_9-G.floor_9"), 0.5, True, "did you mean 'F.floor_"),
        (("F.floor_1-G.floor_1",), 0.5, True, "the forces of the pair F.floor_2-G.floor_2"),
        (("F.floor_1-G.floor_1", "F.floor_2-G.floor_2"), 0.2, True, "forces up to 0.5 s, which"),
        (("F.floor_1-G.floor_1",), 0.5, False, "the case has no contacts to say it"),
    ],
    ids=["good", "no pair", "a pair too few", "too short", "no contacts"],
)
@pytest.mark.parametrize("mesh", [False, True])
def test_forces_of_a_table(frame, tmp_path, pairs, end, meet, words, mesh):
    forces(tmp_path, pairs, end)
    case = frame(FORCES + (floors_meet("1 m") if meet else ""))
    if words:
        assert words in "\n".join(faults(case, mesh))
    else:
        assert study.check(case, mesh=mesh).transient is not None


def test_forces_of_another_sign_and_size(frame, tmp_path, caplog):
    case = frame(FORCES + floors_meet("1 m"))
    forces(tmp_path, peak=-1e5)
    assert 'type compression = "negative"' in "\n".join(faults(case))
    other = case.with_name("other.toml")
    other.write_text(f'extends = "{case.name}"\n[transient]\ncompression = "negative"\n')
    caplog.clear()
    assert study.check(other, mesh=True).transient.compression == "negative"
    assert "forces.csv" not in caplog.text
    forces(tmp_path, peak=-1e2)  # kilonewtons as newtons
    study.check(other, mesh=True)
    assert "weight of the lighter" in caplog.text


def test_forces_that_only_later_stages_need(frame, tmp_path):
    case = frame(FORCES + floors_meet("1 m"))
    wanted = ["frame.toml: transient.forces = 'forces.csv': no such file; expected a force history"]
    for stage in (None, "transient", "design", "report"):
        with pytest.raises(InputError) as caught:
            checked(case, stage=stage)
        found = [str(fault).removeprefix(f"{tmp_path}/") for fault in caught.value.faults]
        assert [one.startswith(w) for one, w in zip(found, wanted, strict=True)] == [True], found
    for stage in ("building", "pounding", "reduce"):
        made, _ = checked(case, stage=stage)
        # The stages that read it have a key that is not that of any file.
        before = transient.TRANSIENT.key(made)
        forces(tmp_path)
        assert transient.TRANSIENT.key(made) != before
        (tmp_path / "forces.csv").unlink()


def recorded(case, file):
    """Put a record in the place of the motion of a case."""
    whole = case.read_text()
    start, end = whole.index("[[motions]]"), whole.index("[pounding]")
    record = f'[[motions]]\ndirection = "y"\ntype = "record"\nfile = "{file}"\n'
    case.write_text(whole[:start] + record + whole[end:])


def test_a_duration_that_no_record_lasts(frame, tmp_path):
    """How long a record lasts is known once it is read."""
    text = "time [s],acceleration [m/s2]\n" + "".join(f"{0.01 * k:g},{k % 7}\n" for k in range(201))
    (tmp_path / "record.csv").write_text(text)
    case = frame('duration = "3 s"\n')
    recorded(case, "record.csv")
    (found,) = faults(case, mesh=False)
    assert "duration = '3 s'" in found and "2 s" in found


MISSPELT = ('groups = "beam_*"', 'groups = "baem_*"')


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (('time_step = "5 ms"', 'time_step = "5 s"'), "motions[0].time_step"),
        (
            ('[pounding]\ntime_step = "1 ms"', '[pounding]\ntime_step = "1 ns"'),
            "pounding.time_step",
        ),
        (('[pounding]\ntime_step = "1 ms"', "[pounding]\ntime_step = 1"), "pounding.time_step"),
        (None, ""),
    ],
    ids=["motions", "too much", "no unit", "nothing"],
)
def test_no_fault_hides_those_of_the_mesh(frame, change, key):
    """Nor those of times that are known: three seconds are computed."""
    case = frame('duration = "9 s"\n' + PROBE % "99 m", MISSPELT, *([change] if change else []))
    found = faults(case)
    assert any("baem_*" in one for one in found) and any("probes[0].point" in one for one in found)
    assert sum(f"frame.toml: {key}" in one for one in found if key) == (1 if key else 0)
    times = [one for one in found if "transient.duration = '9 s': expected at most what is" in one]
    assert len(times) == (key != "motions[0].time_step"), found


SPECTRUM = 'ground_acceleration = "2 m/s2"\ncorner_periods = ["0.1 s", "0.3 s", "2 s"]'
TABLE = 'type = "table"\nfile = "table.csv"'
GROUP = PROBE.replace("point", "group").replace('["0 m", "0 m", "%s"]', '"%s"')


@pytest.mark.parametrize(
    ("more", "change", "key"),
    [
        ("", (SPECTRUM, f"{TABLE} # 2 %"), "motions[0].damping"),
        ("", (SPECTRUM, f"{TABLE} # 5 %"), ""),
        (GROUP % "edge_9", None, "transient.probes[0].group"),
        (GROUP % "beam_9", None, "transient.probes[0].group"),
        (GROUP % "floor_2", None, ""),
    ],
)
def test_a_fault_is_told_once(frame, tmp_path, more, change, key):
    """What the case says of itself, a table or the mesh does not say again."""
    damping = 0.02 if change and "2 %" in change[1] else 0.05
    rows = "".join(f"{f:g},1,{damping}\n" for f in (0.1, 100.0))
    (tmp_path / "table.csv").write_text(f"frequency [Hz],acceleration [m/s2],damping\n{rows}")
    case = frame(more, *([change] if change else []))
    if key:
        (found,) = faults(case)
        assert found.startswith(f"frame.toml: {key}")
    else:
        assert study.check(case, mesh=True).transient is not None


def test_records_of_an_ensemble(frame, tmp_path, caplog):
    """Those that are none are all told; one in another unit is warned of."""
    (tmp_path / "records").mkdir()
    header, time = "time [s],acceleration [m/s2]\n", 0.01 * np.arange(501)
    rows = zip(time, 2.0 * np.sin(2.0 * np.pi * time), strict=True)
    text = header + "".join(f"{t:.2f},{a:.6f}\n" for t, a in rows)
    for name in "abcd":
        (tmp_path / "records" / f"{name}.csv").write_text(text)
    case = frame('[ensemble]\nrecords = "records"\n')
    recorded(case, "records/a.csv")
    assert not any("records/" in one for one in warned(caplog, case))
    (tmp_path / "records" / "d.csv").write_text(text.replace("m/s2", "g"))
    (told,) = (one for one in warned(caplog, case) if "records/" in one)
    assert "records/d.csv" in told and "19.61 m/s2" in told
    for name in "bc":
        (tmp_path / "records" / f"{name}.csv").write_text("none")
    found = faults(case, mesh=False)
    assert len(found) == 2 and all(f"records/{name}.csv" in found[k] for k, name in enumerate("bc"))


def test_a_mesh_of_another_building(frame, tmp_path):
    """It has fewer floors: told once, and no search for what it cannot have."""
    case = frame(PROBE % "6 m")
    table = tmp_path / "frame_floors.csv"
    rows = table.read_text().splitlines()
    last = next(row for row in rows if row.startswith("2,"))
    table.write_text("\n".join([*rows, f"3{last[1:]}", ""]))
    assert any("floors 1, 2" in one and "the floors 1, 2, 3" in one for one in faults(case))


@pytest.fixture
def coarse(tmp_path, edited):
    """The paper's case on a coarse mesh, which the generator makes."""
    for path in GEOMETRY.glob("npp_*.*"):
        shutil.copy(path, tmp_path)
    return edited(tmp_path / "npp_pair.toml", ('size = "1.0 m" ', 'size = "3 m" '))


def test_devices_on_a_generated_mesh(coarse):
    text = coarse.read_text(encoding="utf-8")
    start, end = text.index("[[devices]]"), text.index("[device_analysis]")
    second = text[start:end].replace('"pump"', '"second"')
    small = second.replace('"second"', '"small"').replace('"0.5 m"', '"1 mm"')
    small = small.replace('"23.1 m", "12.0 m"', '"20.2 m", "9.1 m"')
    coarse.write_text(text[:end] + second + small + text[end:], encoding="utf-8")
    wide = text.replace('radius = "0.5 m"', 'radius = "3 m"')
    found = faults(coarse)
    assert all(one.startswith("npp_pair.toml: ") for one in found), found
    assert any("devices[2].point" in one and "type a radius" in one for one in found)
    twice = wide.replace("[device_analysis]", second + "[device_analysis]")
    coarse.write_text(twice.replace('radius = "0.5 m"', 'radius = "3 m"'), encoding="utf-8")
    (found,) = faults(coarse)
    assert "devices[1].radius" in found and "floor 8" in found
    coarse.write_text(wide, encoding="utf-8")
    assert study.check(coarse, mesh=True).devices


@pytest.mark.parametrize("count", [NODES - 1, NODES])
def test_base_plates_of_few_nodes(count):
    """The radius to type is rounded up."""
    plate = BasePlate("pump", 3, np.zeros(3), 0, np.arange(1, count), np.zeros(3), 0.623)
    (check,) = node_checks([plate])
    assert check.criterion.id == "device.anchor_nodes"
    assert check.passed is (count == NODES) and check.value == count
    assert check.place == "pump on floor 3" and "63 cm" in check.detail


PAIRS = "floor = [1, 2, 3]"
LISTED = tuple(
    (f'building = "{name}", {PAIRS}', f'building = "{name}", floor = [1, 2]')
    for name in ("west", "east")
)


def warned(caplog, path, *, mesh=True, level=logging.WARNING):
    caplog.clear()
    with caplog.at_level(logging.INFO, "impactfem"):
        study.check(path, mesh=mesh)
    return [r.getMessage() for r in caplog.records if r.levelno == level]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            LISTED,
            (
                "contacts: floors that face each other and are in no pair: west.floor_3 and east.",
                "(20 mm apart at 10.5 m); type [contact_search]",
            ),
        ),
        (
            [('gap = "2 cm"', 'gap = "20 cm"'), ("title = ", 'allow = ["gap"]\ntitle = ')],
            ("contacts: ", "gap 0.2 m, distance 0.02 m", "2 more pairs"),
        ),
        (
            [('"30 GPa"', '"30 Pa"')],
            ("materials.concrete.young_modulus = '30 Pa': outside the usual range",),
        ),
        ([], ()),
    ],
)
def test_check_warns(new_case, tmp_path, caplog, changes, words):
    """A run says it itself, of gaps at the end of its stage."""
    path = new_case(tmp_path, *changes)
    lines = warned(caplog, path)
    assert len(lines) == bool(words)
    assert all(word in lines[0] for word in words), lines
    assert warned(caplog, path, mesh=False) == []


def test_check_says_what_it_cannot_tell(new_case, tmp_path, caplog):
    whole = (tmp_path / "bare").with_suffix(".toml")
    path = new_case(tmp_path, name="bare")
    text = path.read_text(encoding="utf-8")
    first, last = text.index("[[contacts]]"), text.index("# A floor that meets a wall")
    lines = (text[:first] + text[last:]).splitlines()
    plans = [line for line in lines if line.startswith(("length = ", "width = "))]
    path.write_text("\n".join(line for line in lines if line not in plans), encoding="utf-8")
    (line,) = warned(caplog, whole, level=logging.INFO)
    assert "type length and width, or plan, of [[buildings]]" in line


@pytest.mark.usefixtures("no_figures")
def test_a_run_reports_an_overlap(new_case, tmp_path):
    path = new_case(tmp_path, *LISTED)
    result = loop.run(path, out=tmp_path / "run", stage="pounding", bar=False)
    (check,) = (c for c in result.checks["pounding"] if c.id == "pounding.facing_overlap")
    with (tmp_path / "run/tables/facing_floors.csv").open(encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert (row["floor"], row["faces"]) == ("west.floor_3", "east.floor_3")
    assert float(row["distance at rest [mm]"]) == pytest.approx(20.0)
    nearest = float(row["smallest distance [mm]"])
    assert nearest < 0.0
    assert check.passed is False
    assert f"{nearest:.4g} mm" in check.detail
    values = {scalar.name: scalar.value for scalar in result.scalars}
    assert values["pounding.facing_distance_min"] == pytest.approx(1e-3 * nearest)
    checks = json.loads((tmp_path / "run/checks.json").read_text(encoding="utf-8"))
    assert check.row("pounding") in checks


@pytest.mark.parametrize(("layered", "told"), [(True, 2), (False, 0)])
def test_a_soil_that_no_model_has(new_case, tmp_path, caplog, layered, told):
    """A layer on rock, by its shear column of 5 Hz: its stiffness falls to nothing there."""
    f = np.geomspace(0.5, 60.0, 20)
    x = np.pi / 10.0 * f / np.sqrt(1.0 + 0.1j)
    S = 3e9 * ((1.0 + 0.1j) * x / np.tan(x) if layered else 1.0 + 0.02j * f)
    table = list(zip(f, S, strict=True))
    units = {c: "N m/rad" if c.startswith("r") else "N/m" for c in COMPONENTS}
    rows = [f"{c},{a:.6g},{b.real:.6g},{b.imag:.6g},{units[c]}\n" for c in units for a, b in table]
    header = "component,frequency [Hz],real,imaginary,unit\n"
    (tmp_path / "soil.csv").write_text(header + "".join(rows))
    raft = '{ length = "20 m", width = "12 m", thickness = "1 m", density = "2500 kg/m3" }'
    soil = f'[buildings.soil]\ntype = "table"\nfile = "soil.csv"\nraft = {raft}\n'
    path = new_case(tmp_path, ("\n[[motions]]\n", f"\n{soil}[[motions]]\n"))
    with caplog.at_level(logging.WARNING):
        study.check(path, mesh=True)
    off = [line for line in caplog.messages if "of the soil model" in line and "east" in line]
    assert len(off) == told


def test_a_case_that_nothing_moves_has_one_fault(new_case, tmp_path):
    path = new_case(tmp_path)
    text = path.read_text(encoding="utf-8")
    start, end = text.index("[[motions]]"), text.index("# Laws of")
    path.write_text(text[:start] + text[end:], encoding="utf-8")
    (found,) = faults(path, mesh=False)
    assert found.startswith("small.toml: motions: ")


def test_checks_of_a_whole_case(finished):
    checks = json.loads((finished.folder / "checks.json").read_text(encoding="utf-8"))
    assert not [check for check in checks if check["id"].startswith("pounding.facing")]
    assert not (finished.folder / "tables/facing_floors.csv").exists()
    assert "published value" not in (finished.folder / "run.log").read_text(encoding="utf-8")
    (row,) = (check for check in checks if check["id"] == "pounding.gap_geometry")
    assert (row["stage"], row["passed"], row["unit"]) == ("pounding", True, "mm")
    assert row["value"] <= row["upper"] and row["lower"] is None
    case = load_case(finished.case)
    assert row in [c.row("pounding") for c in POUNDING.checks(case, finished.folder)]


@pytest.mark.parametrize("forces", [None, Path("forces.csv")])
def test_the_stick_is_checked_where_its_forces_are_taken(monkeypatch, forces):
    own, stick = SAMPLES.check(20.0), STICK_FREQUENCY.check(0.5)
    monkeypatch.setattr(transient, "transient_checks", lambda folder: [own])
    monkeypatch.setattr(transient, "stick_against_model", lambda folder: [stick])
    for name in ("given_forces", "read_forces", "impulse_check"):
        monkeypatch.setattr(transient, name, lambda *_: [])
    building = SimpleNamespace(transient=SimpleNamespace(forces=forces), pounds=False)
    found = transient.TRANSIENT.checks(building, Path())
    assert found == ([own, stick] if forces is None else [own])
    # A 3D model that pounds itself takes no forces of its stick.
    building.pounds = True
    assert transient.TRANSIENT.checks(building, Path()) == [own]


@pytest.mark.parametrize(
    ("inputs", "applied", "pounds", "compared"),
    [
        ("key", None, False, True),
        ("another", None, False, False),  # of a run before
        ("key", SimpleNamespace(), False, False),  # stage transient compares them
        ("key", None, True, False),  # the stick does not pound
    ],
)
def test_a_stick_is_compared_with_a_3d_model_that_takes_no_forces(
    monkeypatch, tmp_path, inputs, applied, pounds, compared
):
    check = STICK_FREQUENCY.check(0.5, "A along y")
    monkeypatch.setattr(pounding, "BUILDING", SimpleNamespace(key=lambda building: "key"))
    monkeypatch.setattr(pounding, "stick_against_model", lambda folder: [check])
    one = SimpleNamespace(transient=applied, pounds=pounds, folder=lambda run: run)
    case = SimpleNamespace(modelled={"A": one})
    assert pounding._sticks_against_models(tmp_path, case) == []  # no 3D model was computed
    write_netcdf(tmp_path / "building.nc", xr.Dataset(attrs={"inputs": inputs}))
    assert pounding._sticks_against_models(tmp_path, case) == [check] * compared


def test_a_peak_that_is_not_the_header_s_is_told_once(with_record, tmp_path, caplog):
    """However often the record is read."""
    text = knet_text([0, 200, 0, -200] * 100, 100).replace("3920(gal)/6182761", "1(gal)/1")
    path = with_record(tmp_path, text, 'format = "knet"\n')
    (line,) = warned(caplog, path)
    assert "header has 0.127 gal" in line


def test_seeds_by_their_keys(new_case, tmp_path):
    """Those of an ensemble and of a fit where the case has them."""
    further = {"calibration.seed": 0, "ensemble.first_seed": 0}
    for path, seeds in (
        (GEOMETRY / "npp_pair.toml", {"motions[0].seed": 127} | further),
        (new_case(tmp_path), {"motions[0].seed": 1}),
    ):
        loop._write_results(load_case(path), loop.Record(tmp_path, [], {}), [], "now")
        assert json.loads((tmp_path / "provenance.json").read_text())["seeds"] == seeds


@pytest.mark.usefixtures("no_figures")
def test_a_run_warns_once(new_case, tmp_path):
    axis = 'axis = ["10 m", "18.02 m"]'
    path = new_case(tmp_path, (f'{axis}\nlength = "20 m"', f'{axis}\nlength = "4 km"'))
    loop.run(path, out=tmp_path / "run", stage="pounding", bar=False)
    text = (tmp_path / "run/run.log").read_text(encoding="utf-8")
    assert text.count("buildings[1].length = '4 km'") == 1


def test_published_values_that_no_result_has(caplog):
    def value(unit):
        return SimpleNamespace(unit=unit)

    published = {
        "frs.floor_8.peak": value("m/s2"),
        "frs.floor_8.pfa": value("m"),
        "frs.flor_8.pfa": value("m/s2"),
        "sticks.nobody": value("Hz"),
        "calibration.epsilon.damped.printed": value("-"),
    }
    found = {
        "frs.floor_8.peak": "m/s2",
        "frs.floor_8.pfa": "m/s2",
        "calibration.epsilon.damped": "-",
    }
    scalars = [Scalar(name, 1.0, unit) for name, unit in found.items()]
    loop._warn_of_published(SimpleNamespace(published=published), scalars)
    names = [r.getMessage().split(": ")[1] for r in caplog.records]
    assert names == [
        "published value frs.floor_8.pfa",
        "published value frs.flor_8.pfa",
        "published value sticks.nobody",
    ]


def test_a_folder_of_records_that_is_not_there(frame):
    case = frame('[ensemble]\nrecords = "nowhere"\n')
    assert "expected a folder" in "".join(faults(case, True))

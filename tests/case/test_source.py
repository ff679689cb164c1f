"""Case files that extend others."""

import os
import shutil
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.source import MOST_FILES, read_source

from .faults import all_faults as faults_of
from .faults import check_fault

DATA = Path(__file__).parent / "data"


@pytest.fixture
def write(tmp_path):
    """Copy the case into a folder below, and write files beside; gives the path of the last."""
    for source in DATA.glob("pair*"):
        (tmp_path / "base").mkdir(exist_ok=True)
        shutil.copy(source, tmp_path / "base")

    def files(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name}.toml"
            path.write_text(text, encoding="utf-8")
        return path

    return files


def the_fault(path):
    (fault,) = faults_of(path)
    return Path(fault.file).name, fault.key, fault.value, fault.expected


BASE = 'extends = "base/pair.toml"\n'


def test_nothing_but_the_other(write, pair):
    path = write(top=BASE)
    case, base = load_case(path), load_case(pair)
    assert case.path == path
    assert case.input_files.items() > {f"base/{n}": h for n, h in base.input_files.items()}.items()
    own = {name: getattr(case, name) for name in ("path", "digest", "input_files")}
    assert case == base.model_copy(update=own)
    assert case.digest != base.digest


def test_tables_merge_and_all_else_replaces(write, pair):
    text = f"""{BASE}
title = "Another"
materials.soft = {{ young_modulus = "3 GPa", poisson_ratio = 0.2 }}
[materials.concrete]
poisson_ratio = 0.18
[damping]
frequencies = ["2 Hz", "30 Hz"]
[spectra]
damping = ["2 %"]
[[buildings]]
name = "B1"
material = "soft"
floors = "base/pair_floors.csv"
rigid_below = "0.06 m"
rigid_above = "0.79 m"
[[buildings]]
name = "B2"
material = "concrete"
floors = "base/pair_floors.csv"
rigid_below = "0.06 m"
rigid_above = "0.79 m"
"""
    case, base = load_case(write(top=text)), load_case(pair)
    assert case.title == "Another"
    assert case.materials["concrete"].poisson_ratio == 0.18
    assert case.materials["concrete"].young_modulus == 33e9
    assert case.materials["soft"].young_modulus == 3e9
    assert (case.damping.ratio, case.damping.frequencies) == (0.07, (2.0, 30.0))
    assert case.spectra.damping == (0.02,)
    assert case.spectra.frequencies == base.spectra.frequencies
    assert case.buildings[0].stiffness_factor == 1.0  # 0.131 in the list that was replaced
    assert case.contacts == base.contacts
    assert case.published == base.published


def test_tables_of_an_array_by_name(write, pair):
    base = load_case(pair)
    case = load_case(write(top=f'{BASE}[buildings.B2]\nbase = "10 cm"\nstiffness_factor = 0.2\n'))
    changed = base.buildings[1].model_copy(update={"base": 0.1, "stiffness_factor": 0.2})
    assert case.buildings == (base.buildings[0], changed)


def test_chain(write):
    path = write(
        middle=f'{BASE}title = "middle"\n[pounding]\npoints_per_impact = 5\nupdate = "lagged"\n',
        top='extends = "middle.toml"\n[pounding]\nupdate = "implicit"\n',
    )
    case = load_case(path)
    assert case.title == "middle"
    assert (case.pounding.points_per_impact, case.pounding.update) == (5, "implicit")
    assert case.pounding.time_step == pytest.approx(0.3358e-3)


def test_what_the_files_above_another_one_change(write):
    """A table that they say alone counts as one key, one that they change by its keys."""
    path = write(
        middle=f'{BASE}title = "middle"\n[buildings.B2]\nbase = "1 m"\n',
        top='extends = "middle.toml"\n[pounding]\nupdate = "lagged"\n[contact_laws.soft]\n'
        'type = "hertz"\nstiffness = "1e10 N/m^1.5"\n[damping]\ntype = "constant"\n'
        'ratio = "5 %"\n[spectra]\ndamping = ["2 %"]\n',
    )
    source = read_source(path, CaseFile)
    above = ["damping", "spectra.damping", "contact_laws.soft", "pounding.update"]
    assert sorted(source.changes(path.with_name("middle.toml"))) == sorted(above)
    below = path.parent / "base" / "pair.toml"
    assert sorted(source.changes(below)) == sorted([*above, "title", "buildings[1].base"])
    assert source.changes(path) == []


def test_a_table_of_another_type_replaces(write):
    path = write(top=f'{BASE}[contact_laws.floor]\ntype = "hertz"\nstiffness = "1e10 N/m^1.5"\n')
    assert load_case(path).contact_laws["floor"].type == "hertz"
    # A table of the same type is merged: the damping ratio stays.
    path = write(top=f'{BASE}[contact_laws.floor]\ntype = "kelvin-voigt"\nstiffness = "1 N/m"\n')
    law = load_case(path).contact_laws["floor"]
    assert (law.stiffness, law.damping_ratio) == (1.0, 0.12)


def test_a_value_in_place_of_a_table_and_back(write):
    path = write(
        middle=f"{BASE}pounding = 3\n",
        top='extends = "middle.toml"\n[pounding]\ntime_step = "1 ms"\n',
    )
    assert load_case(path).pounding.time_step == 1e-3


def test_files_are_relative_to_who_names_them(write, tmp_path, monkeypatch):
    record = 'direction = "y"\ntype = "record"\nfile = "sub/motion.csv"\n'
    text = f"{BASE}[[motions]]\n{record}"
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "motion.csv").write_text("time [s],acceleration [m/s2]\n0,0\n1,1\n")
    path = write(top=text)
    monkeypatch.chdir(tmp_path.parent)
    case = load_case(Path(tmp_path.name) / path.name)
    assert len(case.calibration.targets) == 6  # beside the other file
    assert case.motions[0].file == Path(tmp_path.name) / "sub" / "motion.csv"
    # And now both from one folder further.
    (tmp_path / "variants").mkdir()
    variant = tmp_path / "variants" / "v.toml"
    variant.write_text('extends = "../top.toml"\n')
    case = load_case(variant)
    assert case.motions[0].file.resolve() == tmp_path / "sub" / "motion.csv"
    assert len(case.buildings[0].floors) == 8


def test_every_file_of_a_case_is_found_by_the_model(write, tmp_path):
    text = """
published = "a.csv"
extra = "no.csv"
calibration.targets = "c.csv"
ensemble.records = "d"
motions = [{ type = "record", file = "g.csv" },
           { type = "synthetic", spectrum = { type = "table", file = "h.csv" } }]
transient = { forces = "i.nc", probes = [{ name = "no.csv", group = "no.csv", from = "no.csv" }] }
[[buildings]]
floors = "b.csv"
name = "no.csv"
structure.mesh = { type = "generated", walls = "e.csv", bays = "/f.csv", impact_edge = "no.csv" }
"""
    (tmp_path / "base" / "all.toml").write_text(text)
    source = read_source(write(top='extends = "base/all.toml"\n'), CaseFile)
    # /f.csv is absolute.
    written = {"a.csv", "b.csv", "c.csv", "d", "e.csv", "g.csv", "h.csv", "i.nc"}
    assert set(source.written.values()) == written
    assert source.raw["published"] == "base/a.csv"
    assert source.raw["motions"][1]["spectrum"]["file"] == "base/h.csv"
    assert source.raw["buildings"][0]["structure"]["mesh"]["bays"] == "/f.csv"
    assert source.raw["extra"] == "no.csv"


@pytest.mark.parametrize(
    ("top", "fault"),
    [
        # said by the case file
        ('pounding.time_step = 3\n', ("top.toml", "pounding.time_step", 3)),
        ('pounding.tim = 3\n', ("top.toml", "pounding.tim", None)),
        ('[[motions]]\ndirection = "y"\n', ("top.toml", "motions[0].type", None)),
        ('[ensemble]\nrecords = "none"\n', ("top.toml", "ensemble.records", None)),
        ('calibration.targets = "none.csv"\n', ("top.toml", "calibration.targets", "none.csv")),
        ('materials.soft.poisson_ratio = 0\n', ("top.toml", "materials.soft.young_modulus", None)),
        # said by the other file, broken by this one
        ('[contact_laws.floor]\nrestitution = 0.5\n',
         ("pair.toml", "contact_laws.floor.damping_ratio", "12 %")),
        ('calibration.height = "40 m"\n', ("top.toml", "calibration.height", "40 m")),
    ],
)  # fmt: skip
def test_faults_name_the_file_that_says_it(write, top, fault):
    faults = faults_of(write(top=BASE + top))
    found = {(Path(one.file).name, one.key): one.value for one in faults}
    assert fault[:2] in found
    if fault[2] is not None:
        assert found[fault[:2]] == fault[2]


@pytest.mark.parametrize(
    ("old", "new", "key", "value"),
    [
        ('gap = "1 cm"', 'gap = "1 s"', "contacts[0].gap", "1 s"),
        ('gap = "1 cm"', "", "contacts[0].gap", None),
        ('"pair_targets.csv"', '"none.csv"', "calibration.targets", "none.csv"),
        ('"pair_published.csv"', '"none.csv"', "published", "none.csv"),
        ('"pair_floors.csv"\naxis', '"none.csv"\naxis', "buildings[0].floors", "none.csv"),
        ('name = "B2"', 'name = "B1"', "buildings[1].name", "B1"),
        ("[pounding]\n", '[pounding]\nspeed = "1 m/s"\n', "pounding.speed", None),
    ],
)
def test_faults_of_the_other_file(write, edited, tmp_path, old, new, key, value):
    """Values are shown as they are written, not as they are seen from the case file."""
    base = edited(tmp_path / "base" / "pair.toml", (old, new))
    found = {(str(one.file), one.key): one.value for one in faults_of(write(top=BASE))}
    assert found.get((str(base), key), "not found") == value


def test_a_key_missing_in_both(write, edited, tmp_path):
    step = 'time_step = "0.3358 ms"'
    base = edited(tmp_path / "base" / "pair.toml", (step, ""))
    assert the_fault(write(top=BASE))[:2] == ("pair.toml", "pounding.time_step")
    # The last file that says the table is the one to mend.
    both = f'{BASE}[pounding]\nupdate = "lagged"\n'
    assert the_fault(write(top=both))[:2] == ("top.toml", "pounding.time_step")
    edited(base, ("[pounding]", f"[pounding]\n{step}"), ("title = ", "# title = "))
    assert the_fault(write(top=BASE))[:2] == ("top.toml", "title")


def test_tables_of_the_other_file(write, tmp_path):
    floors = tmp_path / "base" / "pair_floors.csv"
    floors.write_text(floors.read_text().replace("1787", "-1787"))
    assert the_fault(write(top=BASE))[:2] == ("pair_floors.csv", "line 4, column mass [t]")


MIDDLE = 'extends = "middle.toml"\n'
NO_NAME = "file_name"
IN_TURN = "expected a file that does not extend this one in turn: "
NO_FILE = "file"
KEYS = "[unknown]\n" + "".join(f"k{k} = {{ a = [{{ b = 1 }}] }}\n" for k in range(2000))


@pytest.mark.parametrize(
    ("texts", "file", "key", "value", "kind"),
    [
        *(
            ({"top": f"extends = {value}\n"}, "top", "extends", ..., NO_NAME)
            for value in ("3", '""', '"  "', "[]", '"a\\u0000b"')
        ),
        ({"top": 'extends = "none.toml"\n'}, "top", "extends", "none.toml", NO_FILE),
        ({"middle": 'extends = "none.toml"\n', "top": MIDDLE}, "middle", "extends", "none.toml",
         NO_FILE),
        ({"middle": "title = = 3\n", "top": MIDDLE}, "middle", "line 1, column 9", "title = = 3",
         "toml"),
        ({"top": 'extends = "base/../top.toml"\n'}, "top", "extends", ...,
         "source"),
        ({"last": MIDDLE, "middle": 'extends = "last.toml"\n', "top": MIDDLE}, "last", "extends",
         "middle.toml", "source"),
        ({"top": KEYS}, "top", "", ..., "source 6001"),
        ({"top": "#" * 1_000_001}, "top", "", ..., "file 1 MB"),
        ({"top": f"{'.'.join('a' * 5_000)} = 1\n"}, "top", "", ..., "toml"),
        ({"top": f"{BASE}pounding = 3\n"}, "top", "pounding", 3, "model_type"),
        ({"top": f'{BASE}[buildings.B2]\nbase = "1 s"\n'}, "top", "buildings[1].base", "1 s",
         "unit"),
        ({"top": f"{BASE}[buildings.b2]\naxis = 3\n"}, "top", "buildings.b2", ...,
         "source 'B2'"),
        ({"top": f'{BASE}[buildings]\nbase = "1 m"\n'}, "top", "buildings", ...,
         "tuple_type"),
    ],
)  # fmt: skip
def test_one_fault(write, texts, file, key, value, kind):
    (fault,) = faults_of(write(**texts))
    assert Path(fault.file).name == f"{file}.toml" and value in (..., fault.value)
    check_fault([fault], key, kind)


def test_a_chain_that_is_too_long(write):
    write(**{f"c{k}": f'extends = "c{k + 1}.toml"\n' for k in range(MOST_FILES - 2)})
    assert load_case(write(**{f"c{MOST_FILES - 2}": BASE}).with_name("c0.toml"))  # 50 files
    _, key, _, expected = the_fault(write(top='extends = "c0.toml"\n'))
    assert key == "extends" and "at most 50 files" in expected


def test_a_link_to_itself(write, tmp_path):
    os.symlink("top.toml", tmp_path / "again.toml")  # noqa: PTH211
    assert "in turn" in the_fault(write(top='extends = "again.toml"\n'))[3]


def test_hash_covers_all_files(write, tmp_path):
    path = write(middle=BASE, top='extends = "middle.toml"\n')
    hashes = {load_case(path).digest}
    files = ["top.toml", "middle.toml", "base/pair.toml", "base/pair_floors.csv"]
    for name in files:
        with (tmp_path / name).open("a") as stream:
            stream.write("# one more comment\n")
        hashes.add(load_case(path).digest)
    assert len(hashes) == len(files) + 1
    shutil.copytree(tmp_path, tmp_path / "elsewhere")
    assert load_case(tmp_path / "elsewhere" / "top.toml").digest in hashes

"""Variants of a case: keys and values as on a command line, names, case files and faults."""

import os
import shutil
import tomllib
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.place import dotted
from impactfem.case.source import Source, read_source
from impactfem.run import variants
from impactfem.run.variants import (
    Key,
    Variant,
    check_variants,
    in_si,
    read_variants,
    write_case,
)
from impactfem.system.errors import InputError

SOURCE = Source(
    Path("case.toml"),
    {
        "title": "A case",
        "damping": {"ratio": "5 %", "frequencies": ["1 Hz", "20 Hz"]},
        "buildings": [{"name": "A"}, {"name": "B"}],
        "transient": {"solver": "reduced"},
        "wall_impact": {"displaced_floor": 8},
    },
)


def values(text, key="title"):
    return tuple(variant.values[0] for variant in read_variants([f"{key}={text}"], None, SOURCE))


def faults(*texts):
    with pytest.raises(InputError) as caught:
        read_variants(texts, None, SOURCE)
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("3 %, 5 %", ("3 %", "5 %")),
        ("1,2.5,-3e2", (1, 2.5, -300.0)),
        ("reduced,full", ("reduced", "full")),
        ("true,false", (True, False)),
        ("'a, b',\"c\"", ("a, b", "c")),
        ("[8],[7, 8],[]", ([8], [7, 8], [])),
        ("{ a = 1, b = 2 }", ({"a": 1, "b": 2},)),
        ("2020-01-01", ("2020-01-01",)),
    ],
)
def test_values(text, expected):
    found = values(text)
    assert found == expected
    assert [type(one) for one in found] == [type(one) for one in expected]


@pytest.mark.parametrize("text", ["", "1,,2", "1,", "1,2,1"])
def test_values_with_a_fault(text):
    (fault,) = faults(f"title={text}")
    assert fault.startswith("command line: --set title")


def test_a_table_of_variants(tmp_path):
    """Keys in the first line; a cell in quotes may hold commas."""
    path = tmp_path / "v.csv"
    path.write_text('damping.ratio,wall_impact.displaced_floor,title\n3 %,8,"a, b"\n5 %, 7,c\n')
    found = read_variants((), path, SOURCE)
    assert [variant.values for variant in found] == [("3 %", 8, "a, b"), ("5 %", 7, "c")]
    assert [key.name for key in found[0].keys][:1] == ["damping.ratio"]
    for content, count in (
        ("damping.rato,title\n1,a\n", 1),
        ("damping.ratio,title\n1\n1,\n", 2),
        ("title\n", 1),
    ):
        path.write_text(content)
        with pytest.raises(InputError) as caught:
            read_variants((), path, SOURCE)
        assert [fault.file for fault in caught.value.faults] == [path] * count
    with pytest.raises(InputError, match=r"none\.csv"):
        read_variants((), tmp_path / "none.csv", SOURCE)


def test_all_faults_of_all_keys():
    found = faults("damping.rato=1", "x y=2", "", "buildings[9].name=C,C", "extends=a")
    text = "\n".join(found)
    assert "you mean 'damping.ratio'" in text and "an index below 2" in text
    assert "each value once" in text and text.count("a key of the case file") == 3
    assert len(faults()) == 1


def test_keys_that_hold_one_another():
    for texts in (("damping=1", "damping.ratio=2"), ("damping.ratio=1", "damping.ratio=2")):
        (fault,) = faults(*texts)
        assert "hold one another" in fault
    assert read_variants(["damping.ratio=1", "damping.frequencies=2"], None, SOURCE)


def test_values_from_python():
    settings = {"damping.ratio": ["3 %", 0.05], "transient.solver": "reduced,full"}
    found = [variant.values for variant in read_variants(settings, None, SOURCE)]
    solvers = "reduced", "full"
    assert found == [(ratio, solver) for ratio in ("3 %", 0.05) for solver in solvers]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("25 cm", (0.25, "m")),
        ("5 %", (0.05, "-")),
        ("2.5", (2.5, "-")),
        (3, (3.0, "-")),
        (True, ("true", "")),
        ("full", ("full", "")),
        ("5 parrots", ("5 parrots", "")),
        ([7, 8], ("[7, 8]", "")),
    ],
)
def test_in_si(value, expected):
    assert in_si(value) == expected


@pytest.fixture(scope="module")
def source(new_case, tmp_path_factory):
    return read_source(new_case(tmp_path_factory.mktemp("variants")), CaseFile)


def asked(source, *texts):
    return read_variants(texts, None, source)


def test_names_depend_on_the_own_values_only(source):
    first, *_ = asked(source, "damping.ratio=3 %,5 %", "buildings[0].stiffness_factor=0.5,1")
    assert first.name == "damping.ratio=3pct,buildings0.stiffness_factor=0.5"
    assert first.title == "damping.ratio = 3 %, buildings[0].stiffness_factor = 0.5"
    assert first.case_file(Path("s")) == Path(f"s/cases/{first.name}.toml")
    assert first.run_folder(Path("s")) == Path(f"s/runs/{first.name}")


def test_names_are_names_of_files():
    odd = ["a/b: 'c' \"d\"\n*", "é", "../..", "x" * 300, "x" * 301]
    names = [variant.name for variant in read_variants({"title": odd}, None, SOURCE)]
    assert len(set(names)) == 5 and max(map(len, names)) == 120
    assert not [letter for name in names for letter in "/ \n*'\":" if letter in name]


@pytest.mark.parametrize(
    "settings",
    [
        {"title": range(101), "damping.ratio": range(101)},
        {"title": ["5 cm", "5cm"]},
    ],
)
def test_what_makes_no_variants(settings):
    with pytest.raises(InputError):
        read_variants(settings, None, SOURCE)


@pytest.mark.parametrize("linked", [False, True])
def test_a_case_file_of_its_own(source, tmp_path, linked):
    """The user can run it again from where it lies; `..` leads to the parent of the real folder."""
    folder = tmp_path / "sweep"
    if linked:
        (tmp_path / "deep" / "er" / "sweep").mkdir(parents=True)
        folder.symlink_to(tmp_path / "deep" / "er" / "sweep")
    else:
        folder.mkdir()
    one, two = asked(source, "damping.ratio=3 %", "contacts[0].gap=1 cm,3 cm", "allow=gap")
    for variant in (one, two):
        write_case(variant, source, folder)
    case, before = load_case(two.case_file(folder)), load_case(source.path)
    assert case.damping.ratio == 0.03 and {c.gap for c in case.contacts} == {0.03}
    assert {c.gap for c in before.contacts} == {0.02}
    assert [b.floors for b in case.buildings] == [b.floors for b in before.buildings]
    assert two.case_file(folder).read_text().startswith(f"# A variant: {two.title}\n")


def test_every_fault_of_every_variant(source):
    found = asked(
        source,
        "damping.ratio=3 %,150 %",
        "allow=gap",
        "contacts[0].gap=1 cm,-1 cm,1 kg",
        "buildings[0].floors=absent.csv,small_floors.csv",
    )
    with pytest.raises(InputError) as caught:
        check_variants(found, source, None)
    texts = sorted(map(str, caught.value.faults))
    assert len(texts) == 4 and all(text.startswith("command line: --set ") for text in texts)
    for text, expected in zip(
        texts,
        ("floors = 'absent.csv': no such", "gap = '-1 cm'", "gap = '1 kg'", "ratio = '150 %'"),
        strict=True,
    ):
        assert expected in text


def test_faults_name_a_file_and_not_a_temporary_folder(source):
    bad = source.path.with_name("bad.csv")
    bad.write_text("floor,mass\n1,x\n")
    with pytest.raises(InputError) as caught:
        check_variants(asked(source, "buildings[0].floors=bad.csv"), source, None)
    assert {fault.file for fault in caught.value.faults} == {bad.resolve()}


def test_a_fault_of_values_together(source):
    """Each value alone is good; what does not go together is told with the variant."""
    found = asked(source, "motions[0].duration=1 s,3 s")
    with pytest.raises(InputError, match=r"motions\[0\]\.strong_phase") as caught:
        check_variants(found, source, None)
    assert len(caught.value.faults) == 1
    check_variants(found[1:], source, None)


def test_a_stage_that_a_variant_lacks(source):
    with pytest.raises(InputError, match="ratio = 3 %: structure: expected"):
        check_variants(asked(source, "damping.ratio=3 %"), source, "building")


def test_nothing_is_left_behind(source, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    used = []
    monkeypatch.setattr(variants, "check", lambda path, **_: used.append(path) or load_case(path))
    check_variants(asked(source, "damping.ratio=3 %"), source, None)
    assert [path.parent.parent for path in used] == [tmp_path] and not list(tmp_path.iterdir())


def overlay(base, changes, folder):
    keys = tuple(Key(dotted(place), place) for place in changes)
    text = Variant(keys, tuple(changes.values())).case_text(read_source(base, CaseFile), folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "over.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_key_outside_lists_is_all_that_is_said(source, tmp_path):
    path = overlay(source.path, {("damping", "ratio"): "3 %"}, tmp_path / "a" / "b")
    extends = os.path.relpath(source.path, path.parent)
    assert tomllib.loads(path.read_text()) == {"extends": extends, "damping": {"ratio": "3 %"}}
    case, before = load_case(path), load_case(source.path)
    assert case.damping.ratio == 0.03 and before.damping.ratio != 0.03
    assert case.contacts == before.contacts


def test_a_list_is_written_as_a_whole(source, tmp_path):
    """Its files are read from the new folder, and the other entries are as they were."""
    changes = {("buildings", 1, "stiffness_factor"): 0.25, ("buildings", 0, "rigid_below"): "7 cm"}
    raw = repr(source.raw)
    case, before = load_case(overlay(source.path, changes, tmp_path)), load_case(source.path)
    assert [b.stiffness_factor for b in case.buildings][1] == 0.25
    assert case.buildings[0].rigid_below == 0.07
    changed = before.buildings[0].model_copy(update={"rigid_below": 0.07})
    first = case.buildings[0]
    assert first == changed.model_copy(update={"damping": first.damping})
    assert repr(source.raw) == raw


def test_names_of_files_are_those_of_the_case(source, tmp_path):
    floors = source.path.with_name("small_floors.csv")
    other = shutil.copy(floors, source.path.with_name("other.csv"))
    for name in ("other.csv", str(other)):
        case = load_case(overlay(source.path, {("buildings", 0, "floors"): name}, tmp_path))
        assert case.buildings[0].floors == load_case(source.path).buildings[0].floors
    path = overlay(source.path, {("buildings", 0, "floors"): "absent.csv"}, tmp_path)
    with pytest.raises(InputError, match=r"absent\.csv.*no such file"):
        load_case(path)


@pytest.mark.parametrize(
    "value",
    [
        'a "quoted" text\\with\nlines\tand \x7f é',
        *(True, 7, 1e-05, 1e22, -0.5, ["1 cm", "2 cm"], [], {}),
        {"a key": [1, {"b": False}], "c": {"d": "é"}},
        [{"a": 1}, {"b": [[1], [2]]}],
    ],
)
def test_values_come_back(source, value):
    text = Variant((Key("title", ("title",)),), (value,)).case_text(source, Path("/"))
    assert tomllib.loads(text)["title"] == value

"""Variants of a case: keys and values as on a command line, names, case files and faults."""

import os
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.place import dotted
from impactfem.case.source import Source, read_source
from impactfem.run import variants
from impactfem.run.variants import (
    Axis,
    Variant,
    check_variants,
    in_si,
    read_axes,
    variants_of,
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
    (axis,), faults = read_axes([f"{key}={text}"], SOURCE)
    assert not faults
    return axis.values


def faults(*texts):
    return [str(fault) for fault in read_axes(texts, SOURCE)[1]]


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
        ("25 cm:35 cm:3", ("25 cm", "30 cm", "35 cm")),
        ("25:35 cm:3", ("25 cm", "30 cm", "35 cm")),
        ("0.1:0.3:3", (0.1, 0.2, 0.3)),
        ("6:8:3", (6, 7, 8)),
        ("6:7:3", (6.0, 6.5, 7.0)),
        ("5 %:1 %:3", ("5 %", "3 %", "1 %")),
        ("1e10 N/m:1e12 N/m:3:log", ("10000000000 N/m", "100000000000 N/m", "1e+12 N/m")),
        ("1:2:2,5", (1, 2, 5)),
        ("'1:2:3'", ("1:2:3",)),
        ("2020-01-01", ("2020-01-01",)),
    ],
)
def test_values(text, expected):
    found = values(text)
    assert found == expected
    assert [type(one) for one in found] == [type(one) for one in expected]


def test_ranges_are_even_or_in_equal_ratios():
    even = np.diff(np.array(values("0.3:7:11"), dtype=np.float64))
    assert np.allclose(even, 0.67, rtol=1e-11)
    ratios = np.array(values("0.3:7:11:log"), dtype=np.float64)
    assert np.allclose(ratios[1:] / ratios[:-1], (7 / 0.3) ** 0.1, rtol=1e-11)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "one value or more"),
        ("1,,2", "a value between two commas"),
        ("1,", "a value between two commas"),
        ("1,2,1", "each value once"),
        ("1:2", "a range start:stop:count"),
        ("1:2:3:4", "a range start:stop:count"),
        ("1:2:3:log:5", "a range start:stop:count"),
        ("a:b:3", "a range start:stop:count"),
        ("1:2:2.5", "a range start:stop:count"),
        ("1:2:1", "2 to 10000 values"),
        ("1:2:10001", "2 to 10000 values"),
        ("1:1:3", "two different finite numbers"),
        ("1:1e999:3", "two different finite numbers"),
        ("1 m:2 cm:3", "one unit for both ends"),
        ("-1:1:3:log", "above zero"),
        ("0:1:3:log", "above zero"),
    ],
)
def test_values_with_a_fault(text, expected):
    (fault,) = faults(f"title={text}")
    assert fault.startswith("command line: --set title") and expected in fault


def test_all_faults_of_all_keys():
    found = faults("damping.rato=1", "x y=2", "", "buildings[9].name=C,C", "title=1:2", "extends=a")
    assert len(found) == 7
    assert "did you mean 'ratio'" in found[0] and "an index below 2" in found[3]
    assert "each value once" in found[4] and "start:stop" in found[5]
    assert all("a key of the case file" in found[k] for k in (1, 2, 6))
    assert "one key or more" in faults()[0]


def test_keys_that_hold_one_another():
    for texts in (("damping=1", "damping.ratio=2"), ("damping.ratio=1", "damping.ratio=2")):
        (fault,) = faults(*texts)
        assert "do not hold one another" in fault
    assert not faults("damping.ratio=1", "damping.frequencies=2", "buildings[0].name=A")


def test_values_from_python():
    settings = {"damping.ratio": ["3 %", 0.05], "transient.solver": "reduced,full"}
    axes, none = read_axes(settings, SOURCE)
    assert not none
    assert [axis.values for axis in axes] == [("3 %", 0.05), ("reduced", "full")]


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


def test_one_unit_for_an_axis():
    lengths = Axis("a", ("a",), ("25 cm", "1 m"))
    assert lengths.unit == "m" and lengths.cell("25 cm") == 0.25
    mixed = Axis("a", ("a",), ("25 cm", "calibrated"))
    assert mixed.unit == "" and mixed.cell("25 cm") == "25 cm"


A = Axis("damping.ratio", ("damping", "ratio"), ("3 %", "5 %"))
B = Axis("buildings[0].stiffness_factor", ("buildings", 0, "stiffness_factor"), (0.5, 1, 2))


@pytest.fixture(scope="module")
def source(new_case, tmp_path_factory):
    return read_source(new_case(tmp_path_factory.mktemp("variants")), CaseFile)


def asked(source, *texts):
    axes, faults = read_axes(texts, source)
    assert not faults
    return variants_of(axes, zipped=False)


def test_each_meets_each_or_they_run_together():
    product = [variant.values for variant in variants_of([A, B], zipped=False)]
    assert product == [(a, b) for a in ("3 %", "5 %") for b in (0.5, 1, 2)]
    together = Axis("title", ("title",), ("x", "y"))
    zipped = [variant.values for variant in variants_of([A, together], zipped=True)]
    assert zipped == [("3 %", "x"), ("5 %", "y")]


def test_keys_that_run_together_may_repeat_a_value(source):
    texts = ("damping.ratio=3 %,3 %,5 %", "contacts[0].gap=1 cm,2 cm,2 cm")
    assert len(read_axes(texts, source)[1]) == 2
    axes, faults = read_axes(texts, source, zipped=True)
    assert not faults
    found = [variant.values for variant in variants_of(axes, zipped=True)]
    assert found == [("3 %", "1 cm"), ("3 %", "2 cm"), ("5 %", "2 cm")]
    axes, _ = read_axes(["damping.ratio=3 %,3 %", "title=a,a"], source, zipped=True)
    with pytest.raises(InputError, match="each combination of values once"):
        variants_of(axes, zipped=True)


def test_names_depend_on_the_own_values_only():
    first, *_ = variants_of([A, B], zipped=False)
    assert first.name == "damping.ratio=3pct,buildings0.stiffness_factor=0.5"
    assert first.title == "damping.ratio = 3 %, buildings[0].stiffness_factor = 0.5"
    alone = Variant((A, B), first.values)
    assert alone.name == first.name
    assert alone.case_file(Path("s")) == Path(f"s/cases/{first.name}.toml")
    assert alone.run_folder(Path("s")) == Path(f"s/runs/{first.name}")


def test_names_are_names_of_files():
    odd = Axis("title", ("title",), ("a/b: 'c' \"d\"\n*", "é", "../..", "x" * 300, "x" * 301))
    names = [variant.name for variant in variants_of([odd], zipped=False)]
    assert len(set(names)) == 5 and max(map(len, names)) == 120
    assert not [letter for name in names for letter in "/ \n*'\":" if letter in name]


@pytest.mark.parametrize(
    ("axes", "zipped", "expected"),
    [
        ((A, B), True, "--zip: .*same number .*damping.ratio has 2, .*factor has 3"),
        ((Axis("a", ("a",), tuple(range(101))),) * 2, False, "at most 10000 variants, found 10201"),
        ((Axis("a", ("a",), ("5 cm", "5cm")),), False, "differ in letters and digits, as in a = 5"),
    ],
)
def test_what_makes_no_variants(axes, zipped, expected):
    with pytest.raises(InputError, match=expected):
        variants_of(axes, zipped=zipped)


@pytest.mark.parametrize("linked", [False, True])
def test_a_case_file_of_its_own(source, tmp_path, linked):
    """The user can run it again from where it lies; `..` leads to the parent of the real folder."""
    folder = tmp_path / "sweep"
    if linked:
        (tmp_path / "deep" / "er" / "sweep").mkdir(parents=True)
        folder.symlink_to(tmp_path / "deep" / "er" / "sweep")
    else:
        folder.mkdir()
    one, two = asked(source, "damping.ratio=3 %", "contacts[0].gap=1 cm,3 cm")
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
    with pytest.raises(InputError, match=r"duration = 1 s: motions\[0\]\.strong_phase") as caught:
        check_variants(found, source, None)
    assert len(caught.value.faults) == 1
    check_variants(found[1:], source, None)


def test_a_stage_that_a_variant_lacks(source):
    with pytest.raises(InputError, match="ratio = 3 %: structure: expected a section"):
        check_variants(asked(source, "damping.ratio=3 %"), source, "building")


def test_nothing_is_left_behind(source, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    used = []
    monkeypatch.setattr(variants, "check", lambda path: used.append(path) or load_case(path))
    check_variants(asked(source, "damping.ratio=3 %"), source, None)
    assert [path.parent.parent for path in used] == [tmp_path] and not list(tmp_path.iterdir())


def overlay(base, changes, folder):
    axes = tuple(Axis(dotted(place), place, (value,)) for place, value in changes.items())
    text = Variant(axes, tuple(changes.values())).case_text(read_source(base, CaseFile), folder)
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
    text = Variant((Axis("title", ("title",), (value,)),), (value,)).case_text(source, Path("/"))
    assert tomllib.loads(text)["title"] == value

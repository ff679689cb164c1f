"""Variants of a case: their names, case files and faults."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.model import CaseFile
from impactfem.case.source import Source, read_source
from impactfem.run import variant as variants
from impactfem.run.axis import Axis, read_axes
from impactfem.run.variant import Variant, check_variants, variants_of, write_case
from impactfem.system.errors import InputError

A = Axis("damping.ratio", ("damping", "ratio"), ("3 %", "5 %"))
B = Axis("buildings[0].stiffness_factor", ("buildings", 0, "stiffness_factor"), (0.5, 1, 2))


@pytest.fixture(scope="module")
def source(new_case: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Source:
    return read_source(new_case(tmp_path_factory.mktemp("variants")), CaseFile)


def asked(source: Source, *texts: str, zipped: bool = False) -> list[Variant]:
    axes, faults = read_axes(texts, source)
    assert not faults
    return variants_of(axes, zipped=zipped)


def test_each_meets_each_or_they_run_together() -> None:
    product = [variant.values for variant in variants_of([A, B], zipped=False)]
    assert product == [(a, b) for a in ("3 %", "5 %") for b in (0.5, 1, 2)]
    together = Axis("title", ("title",), ("x", "y"))
    zipped = [variant.values for variant in variants_of([A, together], zipped=True)]
    assert zipped == [("3 %", "x"), ("5 %", "y")]


def test_names_depend_on_the_own_values_only() -> None:
    first, *_ = variants_of([A, B], zipped=False)
    assert first.name == "damping.ratio=3pct,buildings0.stiffness_factor=0.5"
    assert first.title == "damping.ratio = 3 %, buildings[0].stiffness_factor = 0.5"
    alone = Variant((A, B), first.values)
    assert alone.name == first.name
    assert alone.case_file(Path("s")) == Path(f"s/cases/{first.name}.toml")
    assert alone.run_folder(Path("s")) == Path(f"s/runs/{first.name}")


def test_names_are_names_of_files() -> None:
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
def test_what_makes_no_variants(axes: tuple[Axis, ...], zipped: bool, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        variants_of(axes, zipped=zipped)


def test_a_case_file_of_its_own(source: Source, tmp_path: Path) -> None:
    """The user can run it again from where it lies."""
    (tmp_path / "sweep").mkdir()
    one, two = asked(source, "damping.ratio=3 %", "contacts[0].gap=1 cm,3 cm")
    for variant in (one, two):
        write_case(variant, source, tmp_path / "sweep")
    case = load_case(two.case_file(tmp_path / "sweep"))
    before = load_case(source.path)
    assert case.damping.ratio == 0.03 and {c.gap for c in case.contacts} == {0.03}
    assert {c.gap for c in before.contacts} == {0.02}
    assert [b.floors for b in case.buildings] == [b.floors for b in before.buildings]
    assert two.case_file(tmp_path / "sweep").read_text().startswith(f"# A variant: {two.title}\n")


def test_a_folder_behind_a_link(source: Source, tmp_path: Path) -> None:
    """`..` from a linked folder leads to the parent of the real one."""
    (tmp_path / "deep" / "er" / "sweep").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "deep" / "er" / "sweep")
    (one,) = asked(source, "damping.ratio=3 %")
    write_case(one, source, tmp_path / "link")
    assert load_case(one.case_file(tmp_path / "link")).damping.ratio == 0.03


def test_every_fault_of_every_variant(source: Source) -> None:
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


def test_a_fault_of_values_together(source: Source) -> None:
    """Each value alone is good; what does not go together is told with the variant."""
    found = asked(source, "motions[0].duration=1 s,3 s")
    with pytest.raises(InputError, match=r"duration = 1 s: motions\[0\]\.strong_phase") as caught:
        check_variants(found, source, None)
    assert len(caught.value.faults) == 1
    check_variants(found[1:], source, None)


def test_a_stage_that_a_variant_lacks(source: Source) -> None:
    with pytest.raises(InputError, match="ratio = 3 %: structure: expected a section"):
        check_variants(asked(source, "damping.ratio=3 %"), source, "building")


def test_nothing_is_left_behind(
    source: Source, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    used = []
    monkeypatch.setattr(variants, "check", lambda path: used.append(path) or load_case(path))
    check_variants(asked(source, "damping.ratio=3 %"), source, None)
    assert [path.parent.parent for path in used] == [tmp_path] and not list(tmp_path.iterdir())


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written(source: Source, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    (one,) = asked(source, "damping.ratio=3 %")
    with pytest.raises(Exception, match="cannot write"):
        write_case(one, source, tmp_path)

"""What a report says beside the results: assumptions, and the places of a publication."""

import pytest

from impactfem.case import load_case
from impactfem.errors import InputError

REFERENCE = """title = "A paper"
[[assumptions]]
text = "It is so."
reason = "Nothing is said."
[[items]]
kind = "figure"
number = "1"
title = "A curve"
shows = ["figures/figure_01*"]
[[items.values]]
name = "motion.pga"
tolerance = "5 %"
"""


@pytest.fixture
def with_reference(new_case, tmp_path):
    def write(text):
        path = new_case(tmp_path)
        path.write_text(path.read_text() + '\n[report]\nreference = "paper.toml"\n')
        if text is not None:
            (tmp_path / "paper.toml").write_text(text)
        return path

    return write


def test_a_reference(with_reference):
    report = load_case(with_reference(REFERENCE)).report
    (item,) = report.reference.items
    assert (item.kind, item.number, item.shows) == ("figure", "1", ("figures/figure_01*",))
    assert item.values[0].tolerance == pytest.approx(0.05)
    assert report.reference.assumptions[0].reason == "Nothing is said."


def test_it_is_part_of_the_case(with_reference):
    path = with_reference(REFERENCE)
    before = load_case(path).content_hash()
    (path.parent / "paper.toml").write_text(REFERENCE.replace("5 %", "6 %"))
    assert load_case(path).content_hash() != before


def test_none(new_case, tmp_path):
    report = load_case(new_case(tmp_path)).report
    assert report.reference is None and report.assumptions == ()


def test_own_assumptions(new_case, tmp_path):
    path = new_case(tmp_path)
    path.write_text(path.read_text() + '\n[[report.assumptions]]\ntext = "a"\nreason = "b"\n')
    assert load_case(path).report.assumptions[0].text == "a"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no such file"),
        ("title = ", "not valid TOML"),
        (REFERENCE.replace('"figure"', '"picture"'), "'equation' or 'figure' or 'table'"),
        (REFERENCE.replace('"5 %"', '"-5 %"'), "expected a number of at least 0"),
        (REFERENCE + REFERENCE[REFERENCE.index("[[items]]") :], "each figure once"),
        (REFERENCE.replace("title", "titel", 1), "missing"),
        (REFERENCE.replace('reason = "Nothing is said."', ""), "missing"),
    ],
)
def test_what_is_wrong_with_it_is_told(with_reference, text, words):
    with pytest.raises(InputError) as error:
        load_case(with_reference(text))
    lines = [str(fault) for fault in error.value.faults]
    assert any(words in line and ("paper.toml" in line) for line in lines), lines

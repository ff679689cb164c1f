"""The numbers of the README's quick start are those of a run."""

import re

import pytest

from impactfem.case.template import write_new_case
from impactfem.run import loop

from .pages import ROOT

NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?")


def block():
    """Lines that the quick start shows, as words; lines that go on are joined."""
    text = (ROOT / "README.md").read_text("utf-8").partition("The run ends with\n")[2]
    lines = [line.strip() for line in re.findall(r"^ {4}.*$", text, re.MULTILINE)]
    assert lines[-1].startswith("report: ")
    return " ".join(" ".join(lines[:-1]).split())


def disagreements(shown, printed):
    """Pairs of numbers that differ by more than their last digit; `None` for other words."""
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return None
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return [
        (ours, theirs)
        for ours, theirs in pairs
        if abs(float(ours) - float(theirs)) > 1.01 * 10.0 ** -len(ours.partition(".")[2])
    ]


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("readme")
    case = write_new_case(folder / "towers.toml")[0]
    run = loop.run(case, out=folder / "run", draw=False, bar=False)
    return " ".join(run.console_lines()[:-1])


def test_the_quick_start_shows_the_output_of_a_run(printed):
    assert disagreements(block(), " ".join(printed.split())) == []

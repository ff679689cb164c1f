import csv
import re

import pytest

from docs._ext import verification as module
from docs._ext.verification import description, section, table
from impactfem.verify.manual import BENCHMARKS, FULL
from impactfem.verify.validation import cases

from .pages import ROOT

REMAKE = "run: impactfem verify --json FILE; python docs/_ext/verification.py FILE"
QUICK = ("decree_ordinates", "cqc_coefficient", "mode_combinations", "rg_1_122", "two_supports")


@pytest.fixture(scope="module")
def committed():
    return module.PAGE.read_text(encoding="utf-8")


def test_the_page_has_the_benchmarks_of_the_program(committed):
    names = re.findall(r"(?m)^### `(\w+)`$", committed)
    assert sorted(names) == sorted({**BENCHMARKS, **FULL}), REMAKE
    for name in names:
        assert description(name).strip() in committed, REMAKE


@pytest.fixture(scope="module")
def rows():
    with module.PAGE.with_suffix(".csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", QUICK)
def test_the_table_has_the_rows_of_the_program(rows, name):
    entries = [{"benchmark": name, **row.as_dict()} for row in BENCHMARKS[name]()]
    made = list(csv.DictReader(table(entries).splitlines()))
    listed = [row for row in rows if row["benchmark"] == name]
    # Errors of rounding differ from machine to machine.
    for row in (*made, *listed):
        row["deviation"] = re.sub(r"\d\.\de-1[0-9]", "tiny", row["deviation"])
    assert listed == made, REMAKE


def test_the_page_counts_the_rows_of_the_table(rows, committed):
    counts = dict(re.findall(r"(?m)^\| \[(\w+)\]\(#\1\) \| (\d+) \|", committed))
    listed = [row["benchmark"] for row in rows]
    assert counts == {name: str(listed.count(name)) for name in dict.fromkeys(listed)}
    assert f"\n{len(rows)} rows of {len(counts)} benchmarks, {len(rows)} within" in committed
    assert {row["passed"] for row in rows} == {"yes"}


def test_pages_of_benchmarks_show_rows_of_the_table(rows):
    for path in (ROOT / "docs" / "benchmarks").glob("*.csv"):
        assert f":file: {path.name}\n" in path.with_suffix(".md").read_text(encoding="utf-8")
        with path.open(encoding="utf-8") as file:
            shown = list(csv.DictReader(file))
        listed = [row for row in rows if row["benchmark"] == path.stem]
        assert [row | short for row, short in zip(listed, shown, strict=True)] == listed


def test_the_page_of_cases_beside_other_programs():
    text = module.VALIDATION.read_text(encoding="utf-8")
    names = re.findall(r"(?m)^### `(\w+)`$", text)
    assert names == list(cases()), REMAKE.replace("verify", "verify --validation", 1)
    assert f"of {len(names)} cases" in text and "fails**" not in text
    name = "sdnl104"
    made = section(name, [{"benchmark": name, **row.as_dict()} for row in cases()[name]()])
    assert made.strip() in text, REMAKE.replace("verify", "verify --validation", 1)
    template = (ROOT / "docs" / "_ext" / "validation.md.in").read_text(encoding="utf-8")
    for part in re.split(r"\{\{ \w+ \}\}", template):
        assert part.strip() in text, REMAKE.replace("verify", "verify --validation", 1)

"""The page on the status of validation has the counts of the pages that it sums up."""

import csv
import json
import re

from .pages import ROOT

DOCS = ROOT / "docs"
PAGE = (DOCS / "validation-status.md").read_text(encoding="utf-8")
KINDS = {
    "standards": r"EN 1998|arrêté|RG 1\.|Regulatory Guide|ASCE|EN 10365|AISC",
    "formulas and tables": r"Bodnar|^paper,|of the paper|table 6",
    "published": "code_aster|NAFEMS|Siconos|MacNeal|Hurlebaus|Taylor and Govindjee"
    "|Bathe, Ios|Ayad|Belytschko|Lindberg|Kiendl|Ohtori|SAP2000",
}


def count(text):
    """The number in the last cell of the row that begins with a text."""
    return int(re.search(rf"(?m)^\| {text}.*\| (\d+) \|$", PAGE)[1])


def test_counts_of_the_manual():
    with (DOCS / "verification.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert f"{len(rows)} of {len(rows)} rows of {len({r['benchmark'] for r in rows})} bench" in PAGE
    counts = dict.fromkeys((*KINDS, "closed forms"), 0)
    for row in rows:
        kinds = (kind for kind, words in KINDS.items() if re.search(words, row["source"]))
        counts[next(kinds, "closed forms")] += 1
    assert counts == {kind: count(kind) for kind in counts}


def test_counts_of_other_programs():
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    rows, cases = re.search(r"(\d+) rows of (\d+) cases, \1 within", text).groups()
    assert f"{rows} of {rows} rows of {cases} cases" in PAGE


def test_counts_of_the_paper():
    content = json.loads((DOCS / "_ext" / "npp_pair.json").read_text(encoding="utf-8"))
    values = content["counts"]["values"]
    shown = {"reproduced": "reproduced", "differs": "not reproduced", "given or fitted": "input"}
    assert {kind: count(words) for kind, words in shown.items()} == values
    compared = values["reproduced"] + values["differs"]
    assert f"{values['reproduced']} of {compared} comparable values" in PAGE

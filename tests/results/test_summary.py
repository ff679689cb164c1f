import json
import math

import pytest

from impactfem.results.summary import write_summary
from impactfem.scalar import Scalar, from_json, to_json

SCALARS = [
    Scalar("a.b", 1.5, "N", "é"),
    Scalar("none", None, "s"),
    Scalar("nan", math.nan, "s"),
    Scalar("inf", math.inf, "-"),
]


def test_entries(tmp_path):
    path = tmp_path / "summary.json"
    write_summary(path, SCALARS, {"a.b": 2.0, "elsewhere": 3.0})
    entries = json.loads(path.read_text(encoding="utf-8"))
    assert entries[0] == {"name": "a.b", "value": 1.5, "unit": "N", "paper": 2.0, "note": "é"}
    assert [entry["name"] for entry in entries] == ["a.b", "none", "nan", "inf"]
    assert [entry["value"] for entry in entries] == [1.5, None, None, None]
    assert [entry["paper"] for entry in entries] == [2.0, None, None, None]


def test_no_results(tmp_path):
    write_summary(tmp_path / "summary.json", [], {})
    assert json.loads((tmp_path / "summary.json").read_text()) == []


def test_scalars_through_a_store():
    found = from_json(to_json(SCALARS))
    assert found[:2] == SCALARS[:2] and math.isnan(found[2].value) and found[3] == SCALARS[3]
    with pytest.raises(TypeError):
        from_json('[{"name": "a"}]')

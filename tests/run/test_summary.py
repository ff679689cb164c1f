import json
import math

import pytest

from impactfem.case import Published
from impactfem.run.summary import write_summary
from impactfem.system.scalar import Scalar, from_json, to_json

SCALARS = [
    Scalar("a.b", 1.5, "N", "é"),
    Scalar("none", None, "s"),
    Scalar("nan", math.nan, "s"),
    Scalar("inf", math.inf, "-"),
]


def test_entries(tmp_path):
    path = tmp_path / "summary.json"
    theirs = Published(value=2.0, unit="N", source="table 1")
    write_summary(path, SCALARS, {"a.b": theirs, "elsewhere": theirs})
    entries = json.loads(path.read_text(encoding="utf-8"))
    beside = {"paper": 2.0, "relation": "=", "kind": "result"}
    assert entries[0] == {"name": "a.b", "value": 1.5, "unit": "N", **beside, "note": "é"}
    assert [entry["name"] for entry in entries] == ["a.b", "none", "nan", "inf"]
    assert [entry["value"] for entry in entries] == [1.5, None, None, None]
    assert [entry["paper"] for entry in entries] == [2.0, None, None, None]


def test_what_ours_is_beside_the_published_value(tmp_path):
    theirs = Published(value=1.0, relation=">", unit="N", source="it", kind="fitted")
    write_summary(tmp_path / "summary.json", SCALARS[:2], {"a.b": theirs})
    found = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert [(one["relation"], one["kind"]) for one in found] == [(">", "fitted"), (None, None)]


def test_no_results(tmp_path):
    write_summary(tmp_path / "summary.json", [], {})
    assert json.loads((tmp_path / "summary.json").read_text()) == []


def test_scalars_through_a_store():
    found = from_json(to_json(SCALARS))
    assert found[:2] == SCALARS[:2] and math.isnan(found[2].value) and found[3] == SCALARS[3]
    with pytest.raises(TypeError):
        from_json('[{"name": "a"}]')

import json
import math
from dataclasses import replace

import pytest
import xarray as xr

from impactfem.case import Published
from impactfem.run.summary import write_summary
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, scalars_of, values_of, with_scalars

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


def test_scalars_through_a_store(tmp_path):
    store = with_scalars(xr.Dataset({"other": ("time", [1.0])}), SCALARS)
    write_netcdf(tmp_path / "store.nc", with_scalars(store, SCALARS[:3]))
    with xr.open_dataset(tmp_path / "store.nc", engine="h5netcdf") as found:
        # What is not a number does not exist.
        assert scalars_of(found) == [*SCALARS[:2], replace(SCALARS[2], value=None)]
        assert found["result_value"].sel(result=SCALARS[0].name) == SCALARS[0].value
        assert values_of(found) == {s.name: s.value for s in SCALARS[:2] if s.value is not None}
    assert scalars_of(with_scalars(store, [])) == []
    with pytest.raises(KeyError, match="result"):
        scalars_of(xr.Dataset())

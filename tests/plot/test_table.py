import csv

import numpy as np
import pytest
import xarray as xr

from impactfem.plot.table import Table, columns_of, write_tables
from impactfem.system.errors import ImpactfemError

TABLE = Table(
    "impacts",
    "Impacts [all]",
    (("pair", ""), ("peak force", "MN"), ("steps", "-")),
    (("a-b, #2", 12.3456789, 38), ("é [red]", None, None)),
)


def test_csv(tmp_path):
    path = TABLE.write_csv(tmp_path)
    assert path == tmp_path / "impacts.csv"
    with path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows == [
        ["pair", "peak force [MN]", "steps [-]"],
        ["a-b, #2", "12.3456789", "38"],
        ["é [red]", "", ""],
    ]
    # All digits: what is read back is what was written.
    assert float(rows[1][1]) == TABLE.rows[0][1]


def test_csv_without_rows(tmp_path):
    path = Table("empty", "Nothing", TABLE.columns, ()).write_csv(tmp_path)
    assert path.read_text().splitlines() == ["pair,peak force [MN],steps [-]"]


def test_csv_where_there_is_no_folder(tmp_path):
    with pytest.raises(ImpactfemError, match=r"cannot write .*impacts\.csv"):
        TABLE.write_csv(tmp_path / "absent")


@pytest.mark.parametrize("value", [None, 12.0, 0.0])
def test_columns_to_compare_with(value):
    columns = (*TABLE.columns, ("published", "MN"), ("over published", ""))
    table = Table("impacts", "Impacts", columns, (("a", 1.0, 2, None, None), ("b", 3, 4, value, 1)))
    found = table.comparing({"published"}, ", beside the published ones")
    if value is None:
        assert found.title == "Impacts"
        assert found.columns == (*TABLE.columns, ("over published", ""))
        assert found.rows == (("a", 1.0, 2, None), ("b", 3, 4, 1))
    else:
        assert (found.columns, found.rows) == (table.columns, table.rows)
        assert found.title == "Impacts, beside the published ones"


def test_text():
    text = TABLE.as_text()
    lines = text.splitlines()
    assert lines[0].strip() == "Impacts [all]"
    assert "peak force" in text and "[MN]" in text and "[-]" in text
    assert "12.35" in text and "12.345" not in text
    # What stands in brackets is text, not a colour; None is a dash.
    assert lines[-1].split() == ["é", "[red]", "-", "-"]


def test_text_in_a_notebook(monkeypatch):
    """Its kernel shows what rich prints, and asks for colours."""
    expected = TABLE.as_text()
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert TABLE.as_text() == expected and "\x1b" not in expected


@pytest.mark.parametrize("width", [60, 140])
def test_the_width_is_kept(width):
    assert max(len(line) for line in TABLE.as_text(width).splitlines()) <= width


def test_variables_of_a_store(tmp_path):
    store = xr.Dataset(
        {
            "force": ("pair", [2e6, np.nan]),
            "steps": ("pair", [7, 8]),
            "touched": ("pair", [True, False]),
        },
        coords={"pair": ["a-b", "b-c"]},
    )
    columns = [("pair", "pair", ""), ("force", "peak", "MN"), ("steps", "steps", "-")]
    table = columns_of(store, "pairs", "Pairs", [*columns, ("touched", "touched", "")])
    assert table.columns == (("pair", ""), ("peak", "MN"), ("steps", "-"), ("touched", ""))
    assert table.rows == (("a-b", 2.0, 7, "yes"), ("b-c", None, 8, "no"))
    assert write_tables(tmp_path, [table]) == [tmp_path / "tables" / "pairs.csv"]
    assert columns_of(store.isel(pair=slice(0)), "pairs", "Pairs", columns).rows == ()

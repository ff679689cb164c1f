import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import Field, field_validator, model_validator

from impactfem.case.base import Section, refuse
from impactfem.case.calibration import Target, read_targets
from impactfem.case.floors import Floor, read_floors
from impactfem.case.quantity import PositiveLength
from impactfem.case.reading import Reading
from impactfem.case.report import read_published
from impactfem.case.source import Source
from impactfem.case.table import read_numbers, read_table

from .faults import check_fault

HEADER = (
    "floor,mass [t],Jx [kg m2],Jy [kg m2],Jz [kg m2],Ix [m4],Iy [m4],Iz [m4],"
    "A [m2],Avy [m2],Avx [m2],storey_height [m]"
)
ROW = "1,2502,6.3e7,5.1e8,5.7e8,6.4e3,4.2e4,4.8e4,234,169,214,3.26"
KNOWN = SimpleNamespace(
    context=Reading(Source(Path(), {"buildings": [{"name": "B1"}, {"name": "B2"}]}))
)
SECOND = "2,1787,4.1e7,3.3e8,3.7e8,3.1e3,1.3e4,1.8e4,67,11,62,2.62"


def write(folder, *lines, newline="\n"):
    path = folder / "floors.csv"
    path.write_bytes(newline.join(lines).encode())
    return path


def faults_of(path):
    faults = []
    assert read_floors(path, faults) is None
    assert faults
    assert all(fault.file == path for fault in faults)
    return faults


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_floors(tmp_path, newline):
    path = write(tmp_path, "# a comment", HEADER, "", ROW, "  # another", SECOND, newline=newline)
    faults = []
    table = read_floors(path, faults)
    assert faults == []
    assert table.lines == (4, 6)
    first, second = table.rows
    assert (first.floor, first.mass, first.Jx) == (1, 2502e3, 6.3e7)
    assert (second.Ix, second.Avy, second.storey_height) == (3.1e3, 11.0, 2.62)
    assert (second.storey_height_min, second.storey_height_max) == (2.62, 2.62)
    assert second.storey_stiffness_factor == 1.0


def test_columns_in_any_order_and_unit(tmp_path):
    path = write(
        tmp_path,
        'frequency [kHz],"effective_mass [kg]", mode ,building,mass_weight [%]',
        '0.00175,"10100000",1, B1 ,50',
    )
    faults = []
    table = read_targets(path, faults, KNOWN)
    assert faults == []
    assert table.rows[0] == Target(
        building="B1", mode=1, frequency=1.75, effective_mass=10.1e6, mass_weight=0.5
    )


def test_more_rows_than_a_table_has(tmp_path):
    (fault,) = faults_of(write(tmp_path, HEADER, *[ROW] * 201))
    assert fault.expected == "201 rows below the header; expected at most 200"
    (fault,) = faults_of(write(tmp_path, HEADER, "#" * 20_000_000, ROW))
    assert fault.expected.startswith("the file has 20 MB; expected at most 20 MB: a table")


@pytest.mark.parametrize("line", [0, 1])
def test_a_cell_that_no_csv_file_has(tmp_path, line):
    lines = [HEADER, ROW]
    lines[line] = "x" * 200_000 + lines[line]
    (fault,) = faults_of(write(tmp_path, *lines))
    assert fault.key == f"line {line + 1}"
    assert "larger than field" in fault.expected


def test_byte_order_mark_of_a_spreadsheet(tmp_path):
    path = tmp_path / "floors.csv"
    path.write_bytes(b"\xef\xbb\xbf" + "\n".join([HEADER, ROW]).encode())
    assert read_floors(path, []) is not None


@pytest.mark.parametrize(
    ("old", "new", "key", "kind"),
    [
        ("2502", "-2502", "line 2, column mass [t]", "greater_than 0"),
        ("2502", "0", "line 2, column mass [t]", "greater_than 0"),
        ("2502", "nan", "line 2, column mass [t]", "cell"),
        ("2502", "inf", "line 2, column mass [t]", "cell"),
        ("2502", "1e999", "line 2, column mass [t]", "cell"),
        ("2502", "2502 t", "line 2, column mass [t]", "cell"),
        ("2502", "", "line 2, column mass [t]", "cell"),
        ("\n1,", "\n1.5,", "line 2, column floor", "cell"),
        ("\n1,", "\n0,", "line 2, column floor", "greater_than_equal 1"),
        ("\n1,", "\n2,", "line 3, column floor", "duplicate"),
        ("\n1,", "\n3,", "line 3, column floor", "bottom_to_top"),
        (",3.26", "", "line 2", "cells 12"),
        (",3.26", ",3.26,1", "line 2", "cells 12"),
        ("mass [t]", "mass", "line 1, column mass", "column"),
        ("mass [t]", "mass [m]", "line 1, column mass [m]", "column"),
        ("mass [t]", "mass [?]", "line 1, column mass [?]", "column"),
        ("Jy [kg", "Jyy [kg", "line 1, column Jyy [kg m2]", "column 'Jy'"),
        ("Jy [kg m2]", "Jx [kg m2]", "line 1, column Jx [kg m2]", "column"),
        ("Jy [kg m2]", "Jx [kg m2]", "line 1", "missing_column"),
        ("floor,", "floor [m],", "line 1, column floor [m]", "column"),
        ("mass [t]", "mass (t)", "line 1, column mass (t)", "column"),
        ("mass [t]", "mass [t", "line 1, column mass [t", "column 'mass'"),
    ],
)
def test_fault(tmp_path, old, new, key, kind):
    text = "\n".join([HEADER, ROW, SECOND])
    assert old in text
    faults = faults_of(write(tmp_path, text.replace(old, new, 1)))
    check_fault(faults, key, kind)


@pytest.mark.parametrize("floor", ["1", "2"])
@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("1787", "-1787", "line 3, column mass [t]"),
        ("1787", "", "line 3, column mass [t]"),
        ("mass [t]", "mass [m]", "line 1, column mass [m]"),
        ("1787", "1787", ""),
    ],
)
def test_no_fault_hides_a_floor_that_stands_twice(tmp_path, old, new, key, floor):
    text = "\n".join([HEADER, ROW, SECOND]).replace("\n2,", f"\n{floor},").replace(old, new, 1)
    faults = []
    read_floors(write(tmp_path, text), faults)
    found = {fault.key: fault.kind for fault in faults}
    twice = {"line 3, column floor": "duplicate"}
    assert found.keys() == ({key} - {""}) | (twice.keys() if floor == "1" else set())
    assert floor == "2" or twice.items() <= found.items()


LOW, HIGH = "storey_height_min [m]", "storey_height_max [m]"
ORDER, AROUND = "in order: storey_height_min is 4 m", "around storey_height, which is 3.26 m"


@pytest.mark.parametrize(
    ("columns", "cells", "key", "expected"),
    [
        ([LOW, HIGH], ["2", "4"], "", ""),
        ([LOW], ["3"], "", ""),
        ([HIGH], ["4"], "", ""),
        ([LOW, HIGH], ["4", "2"], f", column {HIGH}", f"expected bounds {ORDER}"),
        ([LOW, HIGH], ["3.5", "4"], f", column {HIGH}", f"expected bounds {AROUND}"),
        ([LOW, HIGH], ["-1", "4"], f", column {LOW}", "expected a length greater than 0"),
        # Of a column that is not there the row is at fault.
        ([LOW], ["4"], "", f"storey_height_max, which has no column: expected bounds {ORDER}"),
    ],
)
def test_bounds(tmp_path, columns, cells, key, expected):
    path = write(tmp_path, ",".join([HEADER, *columns]), ",".join([ROW, *cells]))
    faults = []
    table = read_floors(path, faults)
    assert (table is None) == bool(expected) == bool(faults)
    if table is not None:
        (row,) = table.rows
        bounds = {LOW: row.storey_height_min, HIGH: row.storey_height_max}
        assert [bounds[name] for name in columns] == [float(cell) for cell in cells]
    for fault in faults:
        assert fault.key == f"line 2{key}" and fault.expected.startswith(expected)


class Split(Section):
    """A row whose faults are those of a field that may be left out, and of the row."""

    depth: PositiveLength = Field(description="Of both parts.")
    first: PositiveLength = Field(default=1.0, validate_default=True, description="Of it.")
    second: PositiveLength = Field(default=1.0, validate_default=True, description="Of it.")

    @field_validator("first")
    @classmethod
    def _within(cls, value, info):
        if value > info.data.get("depth", math.inf):
            raise refuse("expected at most the depth", kind="within")
        return value

    @model_validator(mode="after")
    def _both(self):
        if self.first + self.second > self.depth:
            raise refuse("expected first and second within the depth", kind="both")
        return self


@pytest.mark.parametrize(
    ("header", "row", "expected"),
    [
        ("depth [m]", "2", {}),
        ("depth [m]", "0.5", {"line 2": "within"}),
        ("depth [m]", "1.5", {"line 2": "both"}),
        # Each fault once, and none of what cannot be read.
        ("depth [m]", "-1", {"line 2, column depth [m]": "greater_than"}),
        ("depth [m]", "x", {"line 2, column depth [m]": "cell"}),
        ("depth [m],first [m]", "0.5,x", {"line 2, column first [m]": "cell"}),
        ("depth [m],second [m]", "0.5,-1",
         {"line 2, column second [m]": "greater_than", "line 2": "within"}),
    ],
)  # fmt: skip
def test_no_row_is_lost_without_a_fault(tmp_path, header, row, expected):
    faults = []
    table = read_table(write(tmp_path, header, row), Split, faults)
    assert (table is None) == bool(expected)
    assert {fault.key: fault.kind for fault in faults} == expected


def test_all_faults_at_once(tmp_path):
    row = ROW.replace("2502", "-1").replace("6.3e7", "x").replace("3.26", "-3")
    faults = faults_of(write(tmp_path, HEADER.replace("Iz [m4]", "Iz [m]"), row, "2,3"))
    assert [fault.key for fault in faults] == [
        "line 3",  # that cells are lacking is seen before they are read
        "line 1, column Iz [m]",
        "line 2, column Jx [kg m2]",
        "line 2, column mass [t]",
        "line 2, column storey_height [m]",
    ]


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"1,240,2,3\n2,240,2,3\n", "header"),
        (b"# nothing but a comment\n", "csv"),
        (HEADER.encode(), "no_row"),
        (f"{HEADER}\n{ROW}".replace(",", ";").encode(), "csv"),
        (f"{HEADER}\n{ROW}".replace(",", "\t").encode(), "csv"),
    ],
)
def test_no_table(tmp_path, content, kind):
    path = tmp_path / "floors.csv"
    path.write_bytes(content)
    (fault,) = faults_of(path)
    check_fault([fault], fault.key, kind)


def test_numbers_are_read_fast_and_as_written(tmp_path):
    values = np.random.default_rng(1).normal(size=(40_000, 3))
    rows = [",".join(f"{value:.17g}" for value in row) for row in values]
    for extra in ("", ",,"):
        lines = ("sep=,", "# a comment", f"a,b,c{extra}", *(f"{row}{extra}" for row in rows))
        table = read_numbers(write(tmp_path, *lines), "numbers", "a,b,c", faults := [], 50_000)
        assert not faults and np.array_equal(table.values, values)
        assert table.header == (3, ["a", "b", "c"]) and table.lines[:2] == (4, 5)
    for cell, fault in (("x", "line 3, column b"), ("nan", "line 3, column b"), ("1,2", "line 3")):
        rows[1] = f"1,{cell},3"
        faults = []
        assert read_numbers(write(tmp_path, "a,b,c", *rows), "", "", faults, 50_000) is None
        assert [fault.key for fault in faults] == [fault]
    faults = []
    assert read_numbers(write(tmp_path, "a,b,c", *rows), "", "", faults, 39_999) is None
    assert "at most 39999" in faults[0].expected
    assert (
        read_numbers(write(tmp_path, "a", *("x" for _ in range(5000))), "", "", faults, 5000)
        is None
    )
    assert len(faults) < 500


def test_a_table_that_no_machine_has_memory_for(tmp_path):
    path = tmp_path / "floors.csv"
    with path.open("wb") as stream:
        stream.truncate(10**12)  # sparse
    (fault,) = faults_of(path)
    assert "at most 20 MB" in fault.expected


def test_targets_know_the_buildings(tmp_path):
    path = write(
        tmp_path,
        "building,mode,frequency [Hz],effective_mass [t]",
        "B1,1,1.75,10100",
        "b1,1,1.75,10100",
        "B1,1,1.75,10100",
    )
    faults = []
    assert read_targets(path, faults, KNOWN) is None
    assert [fault.key for fault in faults] == ["line 4, column mode", "line 3, column building"]
    assert "is in line 2" in faults[0].expected
    assert "mean 'B1'?" in faults[1].expected


def test_what_a_spreadsheet_leaves(tmp_path):
    """Rows of commas alone are no rows, and empty cells behind the last column are no cells."""
    rows = ("name,value,unit,source", "a.b,121,MN,figure 9", ",,,", " , ,,")
    assert list(read_published(write(tmp_path, *rows), [])) == ["a.b"]
    for ending in (",", ",,, ,"):
        several = (f"{row}{ending}" for row in rows)
        assert list(read_published(write(tmp_path, *several), [])) == ["a.b"]
    for separator in ("sep=,", '"sep=,"', "SEP=,,,,"):
        assert list(read_published(write(tmp_path, separator, *rows), [])) == ["a.b"]
    faults = []
    without = rows[0].replace("unit", ""), rows[1]
    assert read_published(write(tmp_path, *without), faults) is None
    assert "a column without a name" in [fault.expected for fault in faults]
    faults.clear()
    assert read_published(write(tmp_path, f"{rows[0]},", f"{rows[1]},5"), faults) is None
    assert [fault.key for fault in faults] == ["line 2"]


def test_what_a_spreadsheet_leaves_in_other_codings(tmp_path):
    text = "# kat kütlesi\nname,value,unit,source\na.b,121,MN,şekil 9\n"
    path = tmp_path / "table.csv"
    for coding in ("utf-8-sig", "utf-16", "utf-8"):
        path.write_text(text, encoding=coding)
        assert list(read_published(path, [])) == ["a.b"]
    for coding in ("iso-8859-9", "utf-16-le", "cp1254"):
        path.write_text(text, encoding=coding)
        faults = []
        assert read_published(path, faults) is None
        assert "text in UTF-8" in faults[0].expected
    path.write_text("sep=;\nname;value;unit;source\n")
    faults = []
    assert read_published(path, faults) is None
    assert "semicolons" in faults[0].expected and faults[0].key == "line 2"


def test_published(tmp_path):
    path = write(tmp_path, "name,value,unit,source", "a.b,121,MN,figure 9", "n,36,-,section 3")
    values = read_published(path, [])
    assert (values["a.b"].value, values["a.b"].unit) == (121e6, "N")
    assert (values["n"].value, values["n"].unit, values["n"].source) == (36.0, "-", "section 3")


def test_published_faults(tmp_path):
    path = write(
        tmp_path, "name,value,unit,source", "a,1,MN,x", "a,1,MN,x", "b,1,parsnip,x", "c,1,m,"
    )
    faults = []
    assert read_published(path, faults) is None
    assert [fault.key for fault in faults] == ["line 5, column source", "line 3, column name"]
    path = write(tmp_path, "name,value,unit,source", "a,1,MN,x", "a,1,MN,x", "b,1,parsnip,x")
    faults.clear()
    assert read_published(path, faults) is None
    assert [fault.expected.split(";")[0] for fault in faults] == [
        "duplicate name, the first is in line 2",
        "'parsnip' is not a unit known here",
    ]


def test_a_published_inequality(tmp_path):
    rows = ("a,>110,m/s2,figure 15", "b,< 1.2,mm,figure 8", "c,-3,m,table 1")
    values = read_published(write(tmp_path, "name,value,unit,source", *rows), [])
    found = {name: (one.relation, one.value) for name, one in values.items()}
    assert found == {"a": (">", 110.0), "b": ("<", pytest.approx(1.2e-3)), "c": ("=", -3.0)}


@pytest.mark.parametrize("cell", ["many", ">", ">=110", "> many", "1;2"])
def test_a_published_value_that_is_no_number(tmp_path, cell):
    faults = []
    path = write(tmp_path, "name,value,unit,source", f"a,{cell},m,x")
    assert read_published(path, faults) is None
    (fault,) = faults
    assert (fault.key, fault.value) == ("line 2, column value", cell)
    assert "'> 110'" in fault.expected


def test_floor_from_python_takes_si():
    values = dict.fromkeys(["Jx", "Jy", "Jz", "Ix", "Iy", "Iz", "A", "Avy", "Avx"], 2.0)
    floor = Floor(floor=1, mass=1000.0, storey_height=3.0, **values)
    assert floor.storey_height_min == 3.0

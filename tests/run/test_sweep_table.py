"""The table and the figure of a sweep."""

import csv
import json
import math
from dataclasses import replace

import pytest

from impactfem.plot.words import read_words
from impactfem.run.sweep import Outcome, SweepTable
from impactfem.run.variants import Key, Variant
from impactfem.system.scalar import Scalar

NAME = "mesh.thickness=%s,solver=%s"
FAILED = "grew; without bound"


def table_of(*rows):
    """Thickness, solver and peak of each variant; those that are 0.4 m thick fail."""
    keys = Key("mesh.thickness", ("x",)), Key("solver", ("y",))
    found = []
    for thickness, _, peak in rows:
        force = None if peak is None else 2.0 * peak
        given = (("peak", peak, "m/s2"), ("steps", 7.0, "-"), ("force", force, "N"))
        scalars = [Scalar(f"frs.{name}", value, unit) for name, value, unit in given]
        failed = thickness == 0.4
        error = "grew\nwithout bound" if failed else ""
        found.append(Outcome([] if failed else scalars, error, 0, 0.0))
    variants = [Variant(keys, (f"{row[0]} m", row[1])) for row in rows]
    return SweepTable.of("A case", variants, found, {"frs.force": 5.0})


ROWS = (
    (0.3, "full", 3.0),
    (0.2, "full", 2.0),
    (0.2, "reduced", None),
    (0.3, "reduced", math.inf),
    (0.4, "full", None),
)


@pytest.fixture
def results():
    return table_of(*ROWS)


def test_everything_as_csv_and_json(results, tmp_path):
    files = results.write(tmp_path, ["frs.peak"])
    assert [file.name for file in files] == ["sweep.csv", "sweep.json", "sweep.svg"]
    with files[0].open(newline="", encoding="utf-8") as stream:
        head, *rows = csv.reader(stream)
    names = ["frs.peak [m/s2]", "frs.steps [-]", "frs.force [N]"]
    assert head == ["variant", "mesh.thickness [m]", "solver", *names, "error"]
    assert rows[0] == [NAME % ("0.3m", "full"), "0.3", "full", "3.0", "7.0", "6.0", ""]
    assert rows[2] == [NAME % ("0.2m", "reduced"), "0.2", "reduced", "", "7.0", "", ""]
    assert rows[3][3] == ""  # infinity is no result
    assert rows[4] == [NAME % ("0.4m", "full"), "0.4", "full", "", "", "", FAILED]
    told = json.loads(files[1].read_text(encoding="utf-8"))
    assert told["keys"][0] == {"key": "mesh.thickness", "unit": "m"}
    assert told["units"] == {"frs.peak": "m/s2", "frs.steps": "-", "frs.force": "N"}
    assert told["variants"][0]["values"] == {"mesh.thickness": 0.3, "solver": "full"}
    assert told["variants"][0]["results"]["frs.peak"] == 3.0
    assert told["variants"][0]["error"] is None
    assert told["variants"][4]["error"] == FAILED
    assert told["variants"][4]["results"] == {}


def test_json_has_all_digits(tmp_path):
    table_of((0.3, "full", 1.2345678901234567e-11), (0.2, "full", None)).write(tmp_path, [])
    told = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    found = [variant["results"]["frs.peak"] for variant in told["variants"]]
    assert found == [1.2345678901234567e-11, None]


def test_what_is_shown(results):
    """Without names: what differs, published values first."""
    assert results.chosen([]) == ["frs.force", "frs.peak"]
    assert results.chosen(["frs.*"]) == ["frs.peak", "frs.steps", "frs.force"]
    assert results.chosen(["frs.steps", "frs.s*", "nothing"]) == ["frs.steps"]
    same = table_of(ROWS[0])
    same.published.clear()
    assert same.chosen([]) == ["frs.peak", "frs.steps", "frs.force"]


def test_the_short_table(results):
    (text,) = results.texts(["frs.peak"], 160)
    heads, _, _, _, first, *_, last = (line for line in text.splitlines()[1:] if line.strip())
    assert "mesh." in heads and "frs." in heads and first.split() == ["0.3", "full", "3"]
    assert last.split() == ["0.4", "full", "-", "failed"]
    assert len(list(results.texts([f"frs.{n}" for n in ("peak", "steps", "force")] * 3, 160))) == 2


@pytest.mark.parametrize(("rows", "drawn"), [(slice(0, 2), True), (slice(0, 1), False)])
def test_the_figure(tmp_path, rows, drawn):
    some = table_of(*ROWS[rows])
    path = tmp_path / "a.svg"
    assert some.draw(path, ["frs.peak", "frs.steps", "frs.force"]) is drawn
    assert path.exists() is drawn
    if drawn:
        assert "frs.peak, " in read_words(path).seen


def test_words_are_not_drawn(results, tmp_path):
    values = results.values[["solver"]]
    words = replace(results, keys={"solver": ""}, values=values)
    assert not words.draw(tmp_path / "a.svg", ["frs.peak"])


def test_a_figure_of_before_goes(results, tmp_path):
    results.write(tmp_path, ["frs.peak"])
    assert results.write(tmp_path, [])[-1].name == "sweep.json"
    assert not (tmp_path / "sweep.svg").exists()

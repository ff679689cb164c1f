import csv
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from impactfem.plot.scene import MARGIN, PIXELS, Picture, keys, note, show
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
        assert found.title.startswith("Impacts")


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


CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
DRAW = """
import json, pickle, sys
import numpy as np
from impactfem.plot.scene import (balls, plotter, render)

scene = plotter()
scene.add_mesh(balls(np.array([[1.0, 0.0, 1.0]]), 0.05), color="black", lighting=False)
points = np.array(json.loads(sys.argv[1]))
sys.stdout.buffer.write(pickle.dumps(render(scene, points, (-1.0, -2.0, 1.0))))
"""


@pytest.mark.slow
def test_points_are_where_they_are_drawn():
    # VTK in a process of its own.
    command = [sys.executable, "-c", DRAW, json.dumps(CORNERS.tolist())]
    done = subprocess.run(command, capture_output=True, check=True)
    picture = pickle.loads(done.stdout)
    height, width = picture.image.shape[:2]
    assert width <= PIXELS[0] and height <= PIXELS[1] and max(width, height) >= 900
    places = picture.place(CORNERS)
    # The corners fill the picture but for the margin.
    for axis, size in enumerate((width, height)):
        assert places[:, axis].min() == pytest.approx(MARGIN * size, abs=2.0)
        assert places[:, axis].max() == pytest.approx((1.0 - MARGIN) * size, abs=2.0)
    dark = np.argwhere(picture.image.mean(axis=2) < 100)
    x, y = picture.place(np.array([[1.0, 0.0, 1.0]]))[0]
    assert dark.mean(axis=0) == pytest.approx([y, x], abs=2.0)


@pytest.fixture
def flat():
    """A picture along y, 10 pixels in a metre, with something in its lower left."""
    image = np.full((100, 200, 3), 255, dtype=np.uint8)
    image[60:, :80] = 0
    return Picture(image, np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), (0.0, 10.0), 10.0)


def test_directions_stand_where_less_is_drawn(flat):
    panel = Figure().add_subplot()
    show(panel, flat)
    assert [text.get_text() for text in panel.texts if text.get_text()] == ["x", "y", "z"]
    start = next(text.xyann for text in panel.texts if not text.get_text())
    assert start[0] > 100.0
    ends = np.array([text.xy for text in panel.texts if not text.get_text()]) - start
    # x to the right, z up, y from its end.
    assert ends[0][0] > 0.0 and ends[2][1] < 0.0 and ends[1] == pytest.approx([0.0, 0.0])
    bare = Figure().add_subplot()
    show(bare, flat, triad=False)
    assert not bare.texts


def test_notes_stand_at_their_points(flat):
    panel = Figure().add_subplot()
    note(panel, flat, np.array([2.0, 5.0, 4.0]), "here")
    (text,) = panel.texts
    assert text.xy == pytest.approx((20.0, 60.0)) and text.get_ha() == "right"


def test_entries_of_a_legend():
    made = keys([("walls", "#8fb4d9", "face"), ("beams", "red", "line"), ("points", "k", "ball")])
    assert [entry.get_label() for entry in made] == ["walls", "beams", "points"]
    assert made[2].get_marker() == "o" and made[1].get_linewidth() > 1.0

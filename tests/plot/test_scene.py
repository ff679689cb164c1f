"""Scenes as pictures: where points are in them, and what they are drawn from."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

from impactfem.plot.scene import MARGIN, PIXELS, Picture, keys, note, show

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

"""Figures of curves: the same by matplotlib and by plotly."""

import json
import re

import matplotlib.image
import numpy as np
import pytest

from impactfem.plot import curves, style
from impactfem.plot.curves import SAMPLES, Curve, CurveFigure, Panel, plain, thinned


def test_a_short_history_stays():
    t = np.linspace(0.0, 1.0, SAMPLES)
    found = thinned(t, t**2)
    assert found[0] is t and np.array_equal(found[1], t**2)


@pytest.mark.parametrize("size", [4 * SAMPLES, 12 * SAMPLES + 7])
def test_a_long_history_keeps_its_extremes(size):
    t = np.linspace(0.0, 1.0, size)
    a = np.random.default_rng(3).normal(size=size)
    a[size // 3], a[-1] = 50.0, -40.0
    time, kept = thinned(t, a)
    assert time.size <= 1.1 * SAMPLES and np.all(np.diff(time) > 0.0)
    assert kept.max() == 50.0 and kept.min() == -40.0
    assert np.array_equal(kept, a[np.searchsorted(t, time)])


F = np.geomspace(0.5, 50.0, 30)
SPECTRA = CurveFigure(
    "spectra",
    "Spectra along $e_y$.",
    [
        Panel(
            "frequency [Hz]",
            "acceleration $\\ddot u_y$ [m/s²]",
            [
                Curve(F, F, "floor 1", "red", "--", band=(0.9 * F, 1.1 * F)),
                Curve(F, 2.0 * F, "floor 2", "blue"),
                Curve(F, 50.0 * F, "floor 3", further=True),
                Curve(F[[-1]], F[[-1]], "peak", "black", "", marker="o"),
            ],
            title=title,
            log="x",
            bottom=0.0,
            room=0.5,
            marks=(3.0,),
            hatched=(40.0, 50.0),
            note="no impact",
            reverse=True,
        )
        for title in ("with", "without")
    ],
    alike=True,
)


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """The axes of the figure, as matplotlib has drawn it."""
    kept = []
    real = style.letter
    monkeypatch.setattr(curves, "letter", lambda axes: kept.extend(axes) or real(axes))
    path = SPECTRA.write_png(tmp_path)
    assert path == tmp_path / "spectra.png" and matplotlib.image.imread(path).std() > 0.0
    return kept


def test_by_matplotlib(drawn):
    for axes in drawn:
        assert axes.get_xscale() == "log" and axes.get_xlim() == (0.5, 50.0)
        # What only the page shows counts in no range.
        assert axes.get_ylim()[0] == 0.0 and 150.0 < axes.get_ylim()[1] < 170.0
        texts = [text.get_text() for text in axes.get_legend().get_texts()]
        assert texts == ["peak", "floor 2", "floor 1"]
        assert axes.get_ylabel() == "acceleration $\\ddot u_y$ [m/s²]"
    assert [axes.get_title("left") for axes in drawn] == ["(a)", "(b)"]
    assert [axes.get_title("right") for axes in drawn] == ["with", "without"]


def test_by_plotly():
    text = SPECTRA.to_html()
    assert 'id="plot_spectra"' in text and "cdn" not in text
    read = json.JSONDecoder().raw_decode
    traces, end = read(text, re.search(r'Plotly\.newPlot\(\s*"plot_spectra",\s*', text).end())
    layout, _ = read(text, end + re.match(r",\s*", text[end:]).end())
    shapes = layout["shapes"]
    greys = [(one["x0"], one["x1"]) for one in shapes if one["type"] == "rect"]
    assert greys == [(40.0, 50.0)] * 2 and len(shapes) == 4
    notes = [one["text"] for one in layout["annotations"]]
    assert notes == ["with", "without", "no impact", "no impact"]
    assert len(traces) == 2 * 5
    names = [t["name"] for t in traces if t["showlegend"]]
    assert names == ["floor 1", "floor 2", "floor 3", "peak"]
    assert {t["visible"] for t in traces if t["name"] == "floor 3"} == {"legendonly"}
    assert {t["line"]["dash"] for t in traces if t["name"] == "floor 1" and "mode" in t} == {"dash"}
    assert traces[-1]["mode"] == "markers"


def test_mathematics_as_html():
    assert plain("velocity $\\dot u_y$ [m/s], $K_{Ceq}$") == (
        "velocity u\u0307<sub>y</sub> [m/s], K<sub>Ceq</sub>"
    )

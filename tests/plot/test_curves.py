"""Figures of curves, and the words in their files."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from impactfem.plot import curves, style
from impactfem.plot.curves import SAMPLES, Curve, CurveFigure, Panel, thinned
from impactfem.plot.words import Words, as_html, read_words, spoken
from impactfem.system.errors import ImpactfemError


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
    "Spectra along $e_y$ of <a> & b. All.",
    [
        Panel(
            "frequency [Hz]",
            "acceleration $\\ddot u_y$ [m/s²]",
            [
                Curve(F, F, "floor 1", "red", "--", band=(0.9 * F, 1.1 * F)),
                Curve(F, 2.0 * F, "floor 2", "blue"),
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
    SPECTRA.write(tmp_path / "spectra.svg")
    return kept


def test_panels(drawn):
    for axes in drawn:
        assert axes.get_xscale() == "log" and axes.get_xlim() == (0.5, 50.0)
        assert axes.get_ylim()[0] == 0.0 and 150.0 < axes.get_ylim()[1] < 170.0
        texts = [text.get_text() for text in axes.get_legend().get_texts()]
        assert texts == ["peak", "floor 2", "floor 1"]
        assert axes.get_ylabel() == "acceleration $\\ddot u_y$ [m/s²]"
    assert [axes.get_title("left") for axes in drawn] == ["(a)", "(b)"]
    assert [axes.get_title("right") for axes in drawn] == ["with", "without"]


def test_a_file_is_a_part_of_a_page(drawn, tmp_path):
    """Its text is text, its names are its own, its numbers are short; it is the same every time."""
    text = (tmp_path / "spectra.svg").read_text()
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg") and root.get("role") == "img"
    words = [one.text for one in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"frequency [Hz]", "floor 1", "no impact", "(b)"} <= set(words)
    names = re.findall(r'\bid="([^"]*)"', text)
    assert names and len(set(names)) == len(names)
    assert not re.search(r"<style|<script|\d\.\d{3,}|\d{4}-\d\d-\d\d", text)
    SPECTRA.write(tmp_path / "spectra.svg")
    assert (tmp_path / "spectra.svg").read_text() == text
    SPECTRA.write(tmp_path / "others.svg")
    others = re.findall(r'\bid="([^"]*)"', (tmp_path / "others.svg").read_text())
    assert not set(names) & set(others)


def test_what_is_seen_is_said(drawn, tmp_path):
    words = read_words(tmp_path / "spectra.svg")
    one = (
        "{}: acceleration [m/s²] over frequency [Hz], 2 curves; largest value 100 at 50 (floor 2)."
    )
    both = " ".join(one.format(name) for name in ("with", "without"))
    assert words == Words("Spectra along $e_y$ of <a> & b. All.", both)
    assert words.title == "Spectra along y of <a> & b"


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_words_of_a_picture(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    with style.sheet(path, (1, 1), (2.0, 1.0), "Figure 1: Élan (a).", "Two ‘lines’ & <b>.") as _:
        pass
    assert read_words(path) == Words("Figure 1: Élan (a).", "Two ‘lines’ & <b>.")
    assert read_words(path).title == "Figure 1: Élan"


def test_a_short_logarithmic_axis_has_plain_numbers(tmp_path):
    """Their powers of ten would run into each other."""
    path = tmp_path / "short.svg"
    with style.sheet(path, (1, 1), (6.0, 3.0), "Short.") as (_, (panel,)):
        panel.loglog([1.5, 40.0], [0.2, 0.9])
    root = ElementTree.fromstring(path.read_text())
    ticks = {one.text for one in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"2", "10", "20", "0.3", "0.6"} <= ticks and not any("×" in one for one in ticks)


def test_a_file_without_words(tmp_path):
    (tmp_path / "a.svg").write_text("<svg/>")
    assert read_words(tmp_path / "a.svg") == Words("", "")
    with pytest.raises(ImpactfemError, match=r"cannot read .*b\.png"):
        read_words(tmp_path / "b.png")


def test_mathematics():
    text = "velocity $\\dot u_y$ [m/s], $K_{Ceq}$ along $e_{rx}$ < 1"
    assert as_html(text) == (
        "velocity u\u0307<sub>y</sub> [m/s], K<sub>Ceq</sub> along e<sub>rx</sub> &lt; 1"
    )
    assert spoken(text) == "velocity [m/s], along rx < 1"

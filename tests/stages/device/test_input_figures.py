"""Analyses that differ by their input: which there are, the figure and the tables."""

import math

import pytest
from matplotlib.axes import Axes
from PIL import Image

from impactfem.plot import style
from impactfem.stages.device.input_figures import input_choices, inputs_figure
from impactfem.stages.device.tables import device_tables

from .device_store import WantedDevice, device_folder, device_store

CHOICES = {
    "srss": (0.6, 0.8),
    "cqc": (0.61, 0.81),
    "srss.rotations": (0.7, 0.9),
    "srss.envelope": (0.9, 1.1),
    "srss.envelope.broadened": (0.95, 1.2),
    "srss.given": (math.nan, math.nan),
    "srss.envelope-dampings": (1.1, 1.3),
    "srss.supports-abs": (0.8, 0.9),
}


def test_which_there_are():
    store = device_store(WantedDevice(choices=CHOICES))
    assert input_choices(store, "pump") == {
        "computed spectra": "srss",
        "envelope with further points": "srss.envelope",
        "envelope over all dampings": "srss.envelope-dampings",
        "supports by absolute sum": "srss.supports-abs",
    }
    assert list(input_choices(device_store(WantedDevice()), "pump")) == ["computed spectra"]


def test_figure_shows_the_force_over_the_detailed_one(tmp_path, monkeypatch):
    monkeypatch.setitem(style.SETTINGS, "savefig.dpi", 40.0)
    drawn, right = [], Axes.plot

    def plot(self, x, *args, **options):
        drawn.append((options["label"], [float(value) for value in x]))
        return right(self, x, *args, **options)

    monkeypatch.setattr(Axes, "plot", plot)
    store = device_store(WantedDevice(choices=CHOICES, dampings=2))
    inputs_figure(tmp_path / "inputs.png", store, "pump")
    with Image.open(tmp_path / "inputs.png") as picture:
        assert picture.size[0] > 300
    assert [label for label, _ in drawn] == 2 * store["case"].values.tolist()
    assert drawn[0][1] == pytest.approx([0.6, 0.9, 1.1, 0.8])
    assert drawn[-1][1] == pytest.approx([0.8, 1.1, 1.3, 0.9])


def test_what_was_not_done_is_in_no_table(tmp_path):
    folder = device_folder(tmp_path, choices=CHOICES)
    device_tables(folder, {})
    rows = (folder / "tables" / "device_analyses.csv").read_text()
    assert "srss, envelope, broadened" in rows
    assert "given" not in rows and "nan" not in rows
    verdict = (folder / "tables" / "device_verdict.csv").read_text()
    assert "with envelope with further points: without impact in 0 of" in verdict

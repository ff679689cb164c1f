"""The lines with which a run ends."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.report import console
from impactfem.report.governing import Spectrum
from impactfem.stages.check import severity_counts
from impactfem.stages.verdict import Verdict

FREQUENCY = np.array([1.0, 10.0, 50.0])


def spectrum(building, model="stick", free=True):
    psa = xr.DataArray([1.0, 30.0, 2.0], {"frequency": FREQUENCY}, "frequency")
    return Spectrum(building, model, 3, "", "y", 0.05, psa, 0.5 * psa if free else None)


def verdicts(count):
    """A gap, and devices with capacities and without."""
    gap = Verdict("pounding.required_gap", "gap", "m", "floor 3 of A", 0.03, 0.02)
    given = [
        Verdict(
            "device.zpa", "ZPA", "m/s2", f"pump_{k}", 10.0 + k, 20.0, "devices[0].zpa_limit", 2.0
        )
        for k in range(count)
    ]
    none = Verdict(
        "device.anchor_tension", "tension", "N", "rack", 5e3, None, "devices.anchors", 0.0
    )
    rows = [gap.row("pounding"), none.row("device")]
    return [*rows, *(one.row("B/device") for one in given)]


@pytest.fixture
def lines(monkeypatch, tmp_path):
    def make(count=2, published=0, page=True):
        spectra = [spectrum("A"), spectrum("A", free=False), spectrum("B"), spectrum("A", "pump")]
        monkeypatch.setattr(console, "governing", lambda run: spectra)
        (tmp_path / "report.html").touch()
        run = SimpleNamespace(
            folder=tmp_path if page else tmp_path / "other",
            values={"pounding.impacts": 5.0},
            summary=[
                {
                    "name": console.MAIN_FORCE,
                    "value": 1.07e6,
                    "unit": "N",
                    "note": "pair A.floor_3-B.floor_3",
                }
            ],
            verdicts=verdicts(count),
            checks=[
                {"passed": False, "severity": "invalid"},
                {"passed": False, "severity": "limited"},
                {"passed": True, "severity": "invalid"},
                {"passed": None, "severity": "information"},
            ],
        )
        return console.console_lines(run, published)

    return make


def test_at_most_twelve_lines(lines):
    for count in (0, 3, 30):
        found = lines(count, published=4)
        assert len(found) == min(12, 9 + count)
        assert found[0].split() == " ".join(console.HEADER).split()
        assert found[-1].startswith("report: ")
    # The largest ratio comes first, and what has no capacity last.
    shown = [line for line in lines(30) if line.startswith("ZPA")]
    assert shown[0].split()[-1] == "pump_29" and len(shown) > 3
    assert lines(1)[-3].startswith("anchor tension x n")


def test_columns(lines):
    found = lines()
    places = [found[0].index(word) for word in console.HEADER]
    table = [line for line in found if not line.startswith(("checks", "report"))]
    cells = [
        [line[a:b].strip() for a, b in zip(places, [*places[1:], None], strict=True)]
        for line in table
    ]
    assert cells[1][2:5] == ["30 mm", "20 mm", "exceeded (1.5)"]
    assert cells[2][1].startswith("5, 1.07 MN")
    assert [row[5].partition(",")[0] for row in cells[3:5]] == ["A", "A"]  # and its anchor
    assert cells[3][1:3] == ["30 m/s² at 10 Hz", "15 m/s²"]


def test_checks_by_severity(lines):
    rows = [{"passed": False, "severity": "limited"}, {"passed": None, "severity": "information"}]
    counts = severity_counts(rows)
    assert counts == {"invalid": 0, "limited": 1, "passed": 0, "information": 1}
    assert lines()[-2] == console.checks_line(
        [
            {"passed": False, "severity": "invalid"},
            *rows,
            {"passed": True, "severity": "invalid"},
        ]
    )


def test_no_header_without_results(monkeypatch, tmp_path):
    monkeypatch.setattr(console, "governing", lambda run: [])
    run = SimpleNamespace(folder=tmp_path, values={}, summary=[], verdicts=[], checks=[])
    assert [line.partition(":")[0] for line in console.console_lines(run)] == ["checks", "results"]


def test_a_run_without_a_report(lines, tmp_path):
    assert lines(page=False)[-1] == f"results: {tmp_path / 'other'}"

import json
from dataclasses import dataclass

import pytest
from rich.console import Console

from bench import spectra, suite
from bench.figure import Figure, as_table
from impactfem.system.errors import InputError


@pytest.mark.parametrize(
    ("value", "target", "at_most", "met"),
    [
        (0.2, 0.3, True, True),
        (0.3, 0.3, True, True),
        (0.31, 0.3, True, False),
        (2e9, 1.5e9, False, True),
        (1.5e9, 1.5e9, False, True),
        (1.4e9, 1.5e9, False, False),
        (float("nan"), 0.3, True, False),
        (float("nan"), 0.3, False, False),
        (1.0, None, True, None),
        (1.0, None, False, None),
    ],
)
def test_met(value, target, at_most, met):
    assert Figure("a", value, "s", target, at_most).met is met


def test_table():
    made = [
        Figure("fast", 0.2, "s", 0.3),
        Figure("slow", 1e9, "1/s", 1.5e9, at_most=False),
        Figure("told", 96.0, "-"),
    ]
    console = Console(width=100, record=True, file=None, quiet=False)
    with console.capture() as capture:
        console.print(as_table(made))
    fast, slow, told = [line for line in capture.get().splitlines() if "│" in line][-3:]
    assert "≤ 0.3" in fast and "met" in fast
    assert "≥ 1.5e+09" in slow and "MISSED" in slow
    assert "≤" not in told and "met" not in told


@dataclass
class Rates:
    kernel: float = 3e9
    plain_loop: float = 5e8
    lfilter: float = 2e8


def test_oscillators_are_shown_as_ratios_too(monkeypatch):
    monkeypatch.setattr(spectra, "measure_throughput", Rates)
    made = {figure.name: figure for figure in spectra.spectrum_figures()}
    assert made["oscillator kernel, one core"].met is True
    assert made["kernel over plain loop"].value == pytest.approx(6.0)
    assert made["kernel over lfilter"].value == pytest.approx(15.0)


def test_json(tmp_path, monkeypatch):
    monkeypatch.setattr(spectra, "measure_throughput", Rates)
    pounding = [Figure("pounding", 0.4, "s", 0.3)]
    monkeypatch.setitem(suite.GROUPS, "sticks", lambda: pounding)
    path = tmp_path / "bench.json"
    made = suite.measure(json_file=path)
    entries = json.loads(path.read_text(encoding="utf-8"))
    assert [entry["name"] for entry in entries] == [figure.name for figure in made]
    assert set(entries[0]) == {"name", "value", "unit", "target", "at_most", "met"}
    assert entries[0]["met"] is False and entries[1]["met"] is True and entries[2]["met"] is None


def test_groups(monkeypatch):
    for name in suite.GROUPS:
        monkeypatch.setitem(suite.GROUPS, name, lambda name=name: [Figure(name, 1.0, "-")])
    assert [figure.name for figure in suite.measure()] == list(suite.QUICK)
    assert [figure.name for figure in suite.measure(["building"])] == ["building"]
    expected = "GROUP = 'roof': expected one of the groups sticks, spectra"
    with pytest.raises(InputError, match=expected):
        suite.measure(["roof", "sticks"])

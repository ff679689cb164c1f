"""Drawings of the benchmarks with a page, and the convergence that is drawn from their rows."""

import json
import sys

import pytest

from impactfem.verify.manual import BENCHMARKS

from .pages import ROOT


@pytest.fixture
def figures(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import benchmark_figures as module

    monkeypatch.setattr(module, "FOLDER", tmp_path)
    yield module
    del sys.modules["benchmark_figures"]


def test_written_by_the_command(figures, tmp_path, capsys):
    rows = tmp_path / "rows.json"
    name = "newmark_order"
    entries = [{"benchmark": name, **row.as_dict()} for row in BENCHMARKS[name]()]
    rows.write_text(json.dumps(entries), encoding="utf-8")
    assert figures.main([str(rows)]) == 0
    made = {path.stem: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.svg")}
    assert set(made) == {*figures.DRAWINGS, "newmark_order_convergence"}
    committed = ROOT / "docs" / "benchmarks"
    assert {path.name for path in committed.glob("*.svg")} >= {f"{stem}.svg" for stem in made}
    convergence = made["newmark_order_convergence"]
    assert "order 2.00" in convergence and "time step [s]" in convergence
    assert "diaphragm" in made["scordelis_lo"]
    assert figures.main([]) == figures.main([str(tmp_path)]) == 2
    assert "usage" in capsys.readouterr().err

"""Impacts, whole floors and device forces of two runs."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.plot.words import read_words
from impactfem.report.compared_impacts import (
    FIGURE,
    FLOORS,
    IMPACTS,
    floors_table,
    impacts_figure,
    impacts_table,
    what_pounds,
)
from impactfem.report.sections import ROWS, _section

PAIRS = ("A.floor_2-B.floor_2", "A.floor_1-B.floor_1")


def run(forces, models=None, impulse=5e5, device=1e4, maps=True, size=1.0):
    """A run with an impact of each force [N] on the floors in turn, as the tables read it."""
    count = len(forces)
    every = {
        f"impact_{name}": ("impact", np.full(count, 1.0))
        for name in ("dissipated", "restitution", "building_restitution")
    }
    every |= {
        "impact_pair": ("impact", [PAIRS[k % 2] for k in range(count)]),
        "impact_peak_force": ("impact", np.array(forces, dtype=float)),
        "impact_impulse": ("impact", np.full(count, impulse)),
        "impact_duration": ("impact", np.full(count, 0.02)),
        "impact_first_contact": ("impact", 1.0 + np.arange(count)),
        "impact_end": ("impact", 1.02 + np.arange(count)),
        "pair_required_separation": ("pair", [0.03, 0.01]),
    }
    pounding = xr.Dataset(every, {"pair": list(PAIRS)}, {"shown_direction": "y"})
    time = np.arange(0.0, 1.5, 0.005)
    pulse = np.where((time > 1.0) & (time < 1.02), 1.0, 0.0)
    shares = np.array([forces[0] if forces else 0.0, 1.0])
    points = xr.Dataset(
        {"force": (("time", "pair"), pulse[:, None] * shares)}, {"time": time, "pair": list(PAIRS)}
    )
    frequency = np.array([1.0, 10.0, 200.0])
    psa = size * np.arange(1.0, 7.0)[:, None, None] * np.array([0.0, 1.0, 0.5])[:, None]
    fields = xr.Dataset(
        {
            "psa": (("node", "component", "frequency"), psa * np.array([1.0, 2.0, 9.0])),
            "floor_triangle_floor": ("cell", [1, 2]),
            "floor_triangle_node": (("cell", "corner"), [[0, 1, 2], [3, 4, 5]]),
        },
        {"component": list("xyz"), "frequency": frequency},
    )
    stores = {"pounding.nc": pounding, "forces.nc": points, "transient_maps.nc": fields}
    return SimpleNamespace(
        case={"pounding": {"models": models or {}}},
        values=({"pounding.mean_force_5ms": 0.5 * max(forces)} if forces else {})
        | {
            "device.fy.detailed.impact": device,
            "device.fx.detailed.impact": 1.0,
            "device.fy.detailed.no_impact.light": 7e3,
            "device.rack.relative_difference.impact": 0.1,
            "device.B.fy.detailed.impact": device,
            "device.B.rack.fy.detailed.impact": device,
        },
        further=["B"],
        has=lambda name: maps,
        store=lambda name: stores[name],
    )


def rows(one, other):
    return {row[0]: row[1:] for row in impacts_table([one, other]).rows}


def test_numbers_and_ratios():
    found = rows(run((4e6, 1e6)), run((8e6,), impulse=1e6, device=2e4))
    assert found["impacts"] == (2, 1, None)
    assert found["main impact"] == (PAIRS[0], PAIRS[0], None)
    assert found["main impact: largest force [MN]"] == pytest.approx((4.0, 8.0, 0.5))
    mean = found["largest mean over 5 ms of the force of a pair [MN]"]
    assert mean == pytest.approx((2.0, 4.0, 0.5))
    assert found["all impacts: impulses [kN s]"] == pytest.approx((1000.0, 1000.0, 1.0))
    assert found[f"largest force [MN], {PAIRS[1]}"] == (1.0, 0.0, None)
    assert found["gap that would prevent contact [mm]"] == pytest.approx((30.0, 30.0, 1.0))
    assert found["device with impacts: force along y [kN]"] == pytest.approx((10.0, 20.0, 0.5))
    assert found["device without impact, light: force along y [kN]"] == pytest.approx((7, 7, 1))
    assert found["device rack with impacts: spectrum analysis low by [%]"][2] is None
    assert found["device on B with impacts: force along y [kN]"] == pytest.approx((10, 20, 0.5))
    assert "device rack on B with impacts: force along y [kN]" in found
    assert not any("along x" in name for name in found)


def test_a_run_without_impact(tmp_path):
    found = rows(run(()), run((8e6,)))
    assert found["impacts"] == (0, 1, None)
    assert found["main impact: impulse [kN s]"] == (None, 500.0, None)
    assert impacts_figure(tmp_path, [run(()), run((8e6,))]) == []


def test_whole_floors():
    """Vertices 0 to 2 have 1 to 3 times, 3 to 5 have 4 to 6 times the ordinates; 200 Hz is left."""
    table = floors_table([run((1e6,)), run((1e6,), size=2.0)], 100.0)
    assert [row[:2] for row in table.rows] == [(2, "z"), (2, "y"), (1, "z"), (1, "y")]
    assert table.rows[1][2:] == pytest.approx((12.0, 24.0, 10.0, 10.0, 10.0, 20.0, 0.5))
    assert floors_table([run((1e6,)), run((1e6,), maps=False)], 100.0) is None


def test_the_figure_names_what_pounded(tmp_path):
    direct = run((4e6,), {"A": "structure", "B": "stick"})
    assert (what_pounds(direct.case), what_pounds(run(()).case)) == ("3D models of A", "sticks")
    (path,) = impacts_figure(tmp_path, [direct, run((8e6,))])
    assert path == tmp_path / f"{FIGURE}.svg"
    words = read_words(path)
    assert "this run (3D models of A, from 1 s)" in words.caption and "8 MN at" in words.seen


@pytest.mark.parametrize(
    ("attributes", "title"),
    [
        ({}, "Comparison with another run"),  # by an earlier version
        ({"pounding": "sticks", "other_pounding": "sticks"}, "Comparison with another run"),
        ({"pounding": "3D models of A", "other_pounding": "sticks"}, "Chain against direct"),
    ],
)
@pytest.mark.parametrize("count", [ROWS, ROWS + 1])
def test_the_section(tmp_path, attributes, title, count):
    """Both tables are open where they are short, and listed like others where they are long."""
    tables = [tmp_path / "tables" / f"{name}.csv" for name in (IMPACTS, FLOORS, "other")]
    tables[0].parent.mkdir()
    for path in tables:
        path.write_text("floor\n" + "1\n" * (count if path.stem == FLOORS else 2))
    found = _section(
        SimpleNamespace(
            folder=tmp_path,
            checks=[],
            files_of=lambda name, kind: tables if kind == "tables" else [],
            named=lambda title, stage: title,
            store=lambda name: xr.Dataset(attrs=attributes),
        ),
        "comparison",
        {},
        {"comparison": [{"title": name, "figures": []} for name in ("Impacts", "Floor spectra")]},
        iter(()),
    )
    assert found.title.startswith(title)
    opened = [len(one.rows) for group in found.groups for one in group.facts]
    listed = {one.path.stem: one.count for one in found.tables}
    long = count > ROWS
    assert opened == ([2] if long else [2, count])
    assert listed == {"other": 2} | ({FLOORS: count} if long else {})

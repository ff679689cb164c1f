"""The map of the study: which steps ran, what they found, and what they handed over."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from impactfem.report.flowchart import BOXES, LINKS, Found, flowchart_figure, read_found
from impactfem.report.run_figures import OVERVIEW, overview_pictures
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

VALUES = {
    "motion": {
        "motion.pga": 2.32,
        "motion.time_of_pga": 3.16,
        "motion.sa_max": 7.17,
        "motion.sa_max_frequency": 5.12,
    },
    "building": {
        "building.elements": 113051.0,
        "building.dofs": 1.3e6,
        "building.frequency.1": 1.8,
        "building.frequency.2": 5.8,
    },
    "calibrate": {
        "calibration.epsilon": 0.687,
        "calibration.K_Ceq": 1.1e11,
        "calibration.impact_duration": 0.0165,
    },
    "pounding": {
        "sticks.B1.frequency.1": 1.75,
        "sticks.B1.frequency.2": 5.19,
        "sticks.B2.frequency.1": 1.29,
        "pounding.peak_force.floor_7": 2e7,
        "pounding.peak_force.floor_8": 1.21e8,
        "pounding.impacts": 12.0,
        "pounding.main_impact_force": 1.31e8,
        "pounding.main_impact_time": 3.532,
        "pounding.main_impact_duration": 0.0131,
        "frs.floor_8.peak": 63.8,
        "frs.floor_8.peak_frequency": 72.0,
    },
    "ensemble": {
        "ensemble.members": 100.0,
        "ensemble.median.pounding.peak_force.floor_8": 1.1e8,
        "ensemble.p05.pounding.peak_force.floor_8": 8.5e7,
        "ensemble.p95.pounding.peak_force.floor_8": 1.44e8,
    },
    "transient": {
        "transient.basis_vectors": 212.0,
        "transient.pfa.floor_8": 56.0,
        "transient.pfa.edge_8.max": 110.0,
        "transient.frs.floor_8.peak": 68.0,
        "transient.frs.floor_8.peak_frequency": 91.0,
    },
    "device": {"device.fy.detailed.impact": 66e3, "device.fy.rsa.impact": 64.3e3},
}


NOTES = {"pounding.main_impact_force": "pair B2.floor_8-B3.floor_8"}


def write(folder, *names, stiffness=1.1e11, target=1.8, without=()):
    """Stores with nothing but what the map reads; motion has no scalars, as the stage writes it."""
    for name in names:
        scalars = dict(VALUES[name])
        if name == "motion":
            scalars = {}
        if name == "pounding":
            scalars |= VALUES["motion"]
        kept = [
            Scalar(key, None if key in without else value, "-", NOTES.get(key, ""))
            for key, value in scalars.items()
        ]
        store = with_scalars(xr.Dataset(attrs={"shown_direction": "y"}), kept)
        if name == "motion":
            store = xr.Dataset(attrs={"title": "none"})
        if name == "pounding":
            store["pair_stiffness"] = ("pair", np.array([stiffness]))
            store["target_frequency"] = ("target", np.array([target]))
        if name == "device":
            store = store.assign_coords(device=np.array(["pump", "fan"], dtype=object))
        write_netcdf(folder / f"{name}.nc", store)
    return folder


@pytest.fixture
def texts(monkeypatch):
    """What is written into figures."""
    found = []
    kept, below = Axes.text, Figure.text

    def text(self, x, y, words, *args, **options):
        found.append(words)
        return kept(self, x, y, words, *args, **options)

    def caption(self, x, y, words, *args, **options):
        found.append(words.replace("\n", " "))
        return below(self, x, y, words, *args, **options)

    monkeypatch.setattr(Axes, "text", text)
    monkeypatch.setattr(Figure, "text", caption)
    return found


def test_all_stages(tmp_path, texts):
    (path,) = flowchart_figure(write(tmp_path, *VALUES))
    assert path == tmp_path / "figures" / "figure_04_flowchart.png" and path.is_file()
    written = "\n".join(texts)
    for words in (
        "peak 2.32 m/s² at 3.16 s",
        "113,051 elements, 1,300,000 dofs\nmodes 1.8, 5.8 Hz",
        "ε = 0.687\n$K_{Ceq}$ = 110 GN/m\nimpact of 16.5 ms",
        "B1: 1.75, 5.19 Hz\nB2: 1.29 Hz",
        # The forces by floor are of B1, which is hit less hard.
        "12 impacts\nlargest force 131 MN\npair B2.floor_8-B3.floor_8\nat 3.532 s, for 13.1 ms",
        "100 motions\nforce on floor 8:\n85 to 144 MN (5 to 95 %)",
        "reduced basis of 212 vectors\nmass centre of floor 8: 56 m/s²\n"
        "along its impact edge: 110 m/s²",
        "sticks: 63.8 m/s² at 72 Hz\n3D model: 68 m/s² at 91 Hz",
        "pump, force $F_y$ (and 1 more)\nwith impacts: 66 kN",
    ):
        assert words in written
    assert "not part of this run" not in written and "Dashed" not in written


def test_sticks_alone(tmp_path, texts):
    flowchart_figure(write(tmp_path, "motion", "pounding"))
    assert texts.count("not part of this run") == 6
    assert "Dashed box: not part of this run." in texts[-1] and "Dashed arrow" not in texts[-1]


def test_nothing_at_all(tmp_path, texts):
    flowchart_figure(tmp_path)
    assert texts.count("not part of this run") == len(BOXES)


@pytest.mark.parametrize(
    ("given", "unused"),
    [
        ({}, []),
        ({"stiffness": 1.0e11}, [("wall", "pounding")]),
        ({"target": 1.75}, [("building", "sticks")]),
    ],
)
def test_what_was_handed_over(tmp_path, texts, given, unused):
    found = read_found(write(tmp_path, *VALUES, **given))
    assert [(a, b) for a, b, _ in LINKS if not found.hands_over(a, b)] == unused
    flowchart_figure(tmp_path)
    assert ("Dashed arrow: not used, the case gives the values." in texts[-1]) == bool(unused)


def test_no_impact(tmp_path, texts):
    missing = ("calibration.epsilon", "pounding.main_impact_force")
    flowchart_figure(write(tmp_path, *VALUES, without=missing))
    assert texts.count("no impact") == 2


def test_full_solver_and_many_buildings():
    values = {f"sticks.B{k}.frequency.1": 1.0 * k for k in range(1, 6)}
    found = Found(values, frozenset(), "y", ())
    assert BOXES["sticks"].lines(found)[-1] == "and 2 more buildings"
    assert BOXES["transient"].lines(found) == ["all degrees of freedom in time"]
    assert BOXES["rsa"].lines(found) == ["force $F_y$"]


def test_boxes_do_not_overlap():
    from impactfem.report.flowchart import HEIGHT, WIDTH

    places = [(box.x, box.y) for box in BOXES.values()]
    for k, (x, y) in enumerate(places):
        assert WIDTH / 2 <= x <= 100 - WIDTH / 2 and HEIGHT / 2 <= y <= 100 - HEIGHT / 2
        for u, v in places[k + 1 :]:
            assert abs(x - u) > WIDTH or abs(y - v) > HEIGHT
    assert {box.store for box in BOXES.values()} == set(VALUES)


def test_a_figure_that_cannot_be_written(tmp_path):
    (tmp_path / "figures" / "figure_04_flowchart.png" / "full").mkdir(parents=True)
    with pytest.raises(ImpactfemError, match="cannot write"):
        flowchart_figure(tmp_path)


def test_overview_forgets_a_building_that_is_gone(tmp_path):
    (tmp_path / "figures").mkdir()
    for name in OVERVIEW:
        (tmp_path / "figures" / name).write_text("of a run before")
    assert [path.name for path in overview_pictures(tmp_path)] == ["figure_04_flowchart.png"]
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["figure_04_flowchart.png"]

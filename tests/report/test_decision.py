"""The first screen: spectra that govern, gap, anchors; tables of ensembles and devices."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.report.answers import answers
from impactfem.report.caveats import flags
from impactfem.report.floors import _carried_floors
from impactfem.report.governing import bands_table, governing, spectra_table
from impactfem.report.governing_figure import spectra_figure
from impactfem.stages.stores import open_store

from ..stages.device.device_store import device_folder

F = np.geomspace(1.0, 100.0, 21)
GOVERNING = "Governing floor response spectrum"
AMPLIFICATION = "Amplification due to pounding"
GAP = "Gap required to avoid contact"


def sticks(margin=-0.01, restitution=0.6):
    """Two floors of A and one of B along x, where nothing moves, and y; B has the largest one."""
    peaks = {"A": [3.0, 4.0], "B": [20.0]}
    shape = np.exp(-(np.log(F / 10.0) ** 2))
    psa = np.zeros((1, 3, 2, F.size))
    for k, peak in enumerate([p for floors in peaks.values() for p in floors]):
        psa[0, k, 1] = peak * shape
    dims = ("damping", "station", "direction", "frequency")
    return xr.Dataset(
        {
            "psa": (dims, psa),
            "psa_free": (dims, psa / np.array([1.0, 2.0, 8.0])[None, :, None, None]),
            "pfa": (("station", "direction"), np.ones((3, 2))),
            "zpa": (("station", "direction"), np.full((3, 2), 0.2)),
            "zpa_free": (("station", "direction"), np.full((3, 2), 0.1)),
            "pair_rest_gap": ("pair", [0.03, 0.02]),
            "pair_required_separation": ("pair", [0.01, 0.02 - margin]),
            "pair_margin": ("pair", [0.02, margin]),
            "pair_restitution": ("pair", [restitution, restitution]),
        },
        coords={
            "damping": [0.05],
            "direction": ["x", "y"],
            "frequency": F,
            "pair": ["A.floor_1-B.floor_1", "A.floor_2-B.storey_2_at_0.5"],
            "station": ["A.floor_1", "A.floor_2", "B.floor_1"],
            "station_building": ("station", ["A", "A", "B"]),
            "station_floor": ("station", [1, 2, 1]),
        },
        attrs={"studied_building": "B", "resolved_frequency": F[-1]},
    )


def run_of(folder, **stores):
    """The files of a run with some stages, of which `device` is a folder."""

    def store(name):
        own = name.removesuffix(".nc")
        return open_store(stores[own] / name) if own == "device" else nullcontext(stores[own])

    summary = [
        {
            "name": "pounding.main_impact_band_force",
            "value": 1.759e6,
            "unit": "N",
            "note": "pair A.floor_2-B.storey_2_at_0.5",
        }
    ]
    checks = [{"passed": good, "severity": "limited", "stage": "pounding"} for good in (True, None)]
    laws = {"floor": {"stiffness": 1e9, "restitution": 0.6}}
    run = SimpleNamespace(
        folder=folder,
        ran=lambda stage: stage in stores,
        store=store,
        values={},
        summary=summary,
        checks=checks,
        verdicts=[],
        case={"contact_laws": laws, "pounding": {"models": {}}},
    )
    run.models = {"B1": run}
    return run


def probed(psa, components, frequency, **probes):
    """The response of probes of a 3D model by their kind and floor, meant up to 50 Hz."""
    kinds, floors = zip(*probes.values(), strict=True)
    return xr.Dataset(
        {
            "psa": (("damping", "probe", "component", "frequency"), psa[None]),
            "pfa": (("probe", "component"), np.ones(psa.shape[:2])),
            "zpa": (("probe", "component"), np.full(psa.shape[:2], 0.5)),
        },
        coords={
            "damping": [0.05],
            "component": list(components),
            "frequency": frequency,
            "probe": list(probes),
            "probe_kind": ("probe", list(kinds)),
            "probe_floor": ("probe", list(floors)),
        },
        attrs={"building": "B1", "maximum_frequency": 50.0, "resolved_frequency": 50.0},
    )


def designed(psa, elsewhere):
    """The spectrum of the whole floor 1 along y at 10 Hz and 60 Hz."""
    return xr.Dataset(
        {
            "psa": (("damping", "station", "direction", "frequency"), [[[psa]]]),
            "zpa": (("station", "direction"), [[20.0]]),
            "resolved_zpa": (("station", "direction"), [[10.0]]),
        },
        coords={
            "damping": [0.05],
            "direction": ["y"],
            "frequency": [10.0, 60.0],
            "station_floor": ("station", [1]),
            "elsewhere": elsewhere,
        },
        attrs={"building": "B1", "maximum_frequency": 50.0, "resolved_frequency": 50.0},
    )


def test_the_largest_one_of_each_body(tmp_path):
    """Along x nothing moves; factors are of the peak and at its frequency."""
    found = governing(run_of(tmp_path, pounding=sticks()))
    assert [(one.building, one.floor, one.direction) for one in found] == [
        ("B", 1, "y"),
        ("A", 2, "y"),
    ]
    assert found[0].peak == pytest.approx(20.0) and found[0].at == pytest.approx(10.0)
    assert found[0].peak_ratio == pytest.approx(8.0)
    assert found[0].largest_ratio(2.0)[0] == pytest.approx(8.0)
    (first, _) = spectra_table(found).rows
    assert first[:5] == ["B, floor 1, stick", "y", "5", "100", "20"] and first[-1] == "8"


def test_unresolved_frequencies_do_not_govern(tmp_path):
    """An ordinate above the resolved band is neither a peak, nor a ZPA, nor part of a ratio."""
    store = sticks()
    store["psa"][0, :, :, -1] = 500.0
    for end, peak in ((F[-1], 500.0), (F[-2], 20.0)):
        store.attrs["resolved_frequency"] = end
        run = run_of(tmp_path, pounding=store)
        first = governing(run)[0]
        assert (first.peak, first.end) == pytest.approx((peak, end))
        assert first.zpa == pytest.approx(0.2)


def test_no_ratio_of_a_small_value(tmp_path):
    """Without impact the building hardly moves along y: a tenth of its ZPA along x is the limit."""
    store = sticks()
    store["zpa_free"][:, 0] = 2.0
    for free, ratio in ((0.21, 20.0 / 0.21), (0.19, np.nan)):
        peaks = store["psa"][0, :, 1].max("frequency")
        store["psa_free"][0, :, 1] = store["psa"][0, :, 1] / peaks * free
        one = next(one for one in governing(run_of(tmp_path, pounding=store)) if one.peak > 10.0)
        assert one.peak_ratio == pytest.approx(ratio, nan_ok=True)
        times, at = one.largest_ratio(1.0)
        assert (times > 0.0) == np.isfinite(at) == np.isfinite(ratio)


def by_question(run):
    return {one.question: one for one in answers(run, governing(run))}


@pytest.mark.parametrize(
    ("margin", "required", "mark"), [(-0.01, "30 mm", "warn"), (0.001, "19 mm", "good")]
)
def test_gap_of_the_pair_with_the_smallest_margin(tmp_path, margin, required, mark):
    gap = by_question(run_of(tmp_path, pounding=sticks(margin)))[GAP]
    assert gap.value.startswith(required) and "20 mm" in gap.value and gap.mark == mark


@pytest.mark.parametrize(
    ("pulls", "mark"),
    [((-4e3, 90e3), "warn"), ((-4e3, -1e3), "good"), ((np.nan, np.nan), "")],
)
def test_anchors(tmp_path, pulls, mark):
    run = run_of(tmp_path, pounding=sticks(), device=device_folder(tmp_path, pulls=pulls))
    found = by_question(run)["Anchors"]
    assert (found.mark, found.link) == (mark, "equipment")
    for value in ("66 kN", "× 6.6", "33 kN"):
        assert value in found.text
    assert ("90 kN" in found.text) == (mark == "warn")


@pytest.mark.parametrize("device", [False, True])
def test_its_figure(tmp_path, device):
    stores = {"device": device_folder(tmp_path)} if device else {}
    run = run_of(tmp_path, pounding=sticks(), **stores)
    path = spectra_figure(run, governing(run))
    text = path.read_text(encoding="utf-8")
    assert ("pump" in text) == device
    assert spectra_figure(run, []) is None


def test_what_impacts_alone_move_has_no_factor(tmp_path):
    """B moves along y by its impacts; what it does without them is rounding."""
    store = sticks()
    store["psa_free"][0, 2] = 1e-13 * store["psa"][0, 2]
    run = run_of(tmp_path, pounding=store)
    first, second = governing(run)
    assert first.building == "B" and np.isnan(first.peak_ratio)
    assert second.peak_ratio == pytest.approx(2.0)
    assert by_question(run)[AMPLIFICATION].value == "no ratio"
    assert spectra_table([first, second]).rows[0][-1] == ""


def test_the_amplification_is_that_of_the_governing_floor(tmp_path):
    """Floor 3 governs; on floor 2 the ratio is larger."""
    store = sticks()
    store = store.assign_coords(
        station_building=("station", ["B"] * 3), station_floor=("station", [1, 2, 3])
    )
    store["psa_free"][0, 1] = store["psa"][0, 1] / 9.0
    found = by_question(run_of(tmp_path, pounding=store))
    assert all("floor 3" in found[one].text for one in (GOVERNING, AMPLIFICATION))
    assert found[AMPLIFICATION].value == "× 8"


def test_peaks_in_bands_and_the_damping_of_the_building(tmp_path):
    """The band ends at 50.1 Hz: peaks above 33 Hz are those up to there, above 100 Hz information.

    Rayleigh damping with β alone: ξ = β ω / 2.
    """
    store = sticks().assign_coords(frequency=2.0 * F)
    end = float(store["frequency"][-7])
    store["psa"][0, 2, 1, -2:] = np.array([900.0, 700.0])  # above 100 Hz
    store.attrs |= {"resolved_frequency": end, "resolved_by": "mesh of the slabs"}
    store = store.assign(
        mass_coefficient=("building", [0.0, 0.0]), stiffness_coefficient=("building", [0.0, 1e-3])
    ).assign_coords(building=["A", "B"])
    run = run_of(tmp_path, pounding=store)
    first = governing(run)[0]
    (low, at), (middle, last), (high, above) = first.band_peaks
    assert (low, at, high) == pytest.approx((20.0, 20.0, 900.0)) and above > 100.0
    assert middle == pytest.approx(float(first.psa.sel(frequency=last))) and 33.0 < last <= end
    assert first.structural_damping == pytest.approx(0.5e-3 * 2.0 * np.pi * 20.0)
    assert bands_table([first]).rows[0][-1] == "mesh of the slabs"
    assert "mesh of the slabs" in by_question(run)[GOVERNING].text


@pytest.mark.parametrize("vertices", [0, 2])
def test_whole_floors_govern_where_the_run_has_them(tmp_path, vertices):
    """And points on no floor; the probes of floors are among those of whole floors."""
    peaks = np.array([[[3.0], [30.0]], [[1.5], [15.0]]])
    probes = probed(peaks, "xy", [10.0], centre=("centre", 1), wall=("point", 0))
    found = governing(run_of(tmp_path, transient=probes))
    assert [(one.direction, one.peak, one.place) for one in found] == [
        ("y", 30.0, "mass centre"),
        ("x", 3.0, "mass centre"),
    ]
    design = designed([45.0, 90.0], ["wall"])  # above what the model is meant for there is more
    if vertices:
        design["vertex_node"] = ("vertex", np.zeros(vertices, int))
    first, second = governing(run_of(tmp_path, transient=probes, design=design))
    assert (first.building, first.floor) == ("B1", 1)
    assert (first.peak, first.zpa, second.peak, second.place) == (45.0, 10.0, 1.5, "wall")


@pytest.mark.parametrize("change", [0.04, 0.3])
def test_what_goes_with_the_steps_of_the_pounding_is_told(change):
    """The peak force of unilateral contact."""
    values = {"pounding.doubled_step_force_change": change, "pounding.mean_force_5ms": 7e5}
    name = "pounding.main_impact_band_force"
    entry = {"name": name, "value": 1e6, "unit": "N", "note": "pair A-B"}
    run = SimpleNamespace(
        checks=[], verdicts=[], summary=[entry], ran=lambda _: False, models={}, values=values
    )
    (text,) = (answer.text for answer in answers(run, []) if answer.question == "Largest impact")
    assert "700 kN" in text
    assert ("30 %" in text) == (change > 0.05)


def test_one_motion_of_many(tmp_path):
    """Along the direction of the spectrum that governs, not along the shown one."""
    peaks = np.zeros((100, 1, 2, 2, F.size))
    peaks[:, 0, 0, 0, 3] = 77.0
    peaks[:, 0, 0, 1, 3] = 25.0
    peaks[:, 0, 1] = 36.0
    members = xr.Dataset(
        {"psa": (("motion", "damping", "station", "direction", "frequency"), peaks)},
        coords={
            "direction": ["x", "y"],
            "station_building": ("station", ["B", "A"]),
            "station_floor": ("station", [1, 1]),
        },
        attrs={"studied_building": "B", "shown_direction": "x"},
    )
    run = run_of(tmp_path, pounding=sticks(), ensemble=members)
    spectra = governing(run)
    (text,) = flags(run, spectra)
    assert "100 motions" in text and "1.25 times" in text
    psa = spectra[0].psa * (24.0 / spectra[0].peak)
    (text,) = flags(run, [replace(spectra[0], building="A", floor=1, psa=psa)])
    assert "1.50 times" in text


def test_one_motion_of_many_in_3d(tmp_path):
    """The peak of the mass centre over that of this motion, whatever governs on the floor."""
    peak = np.zeros((2, 3, 2))
    peak[0, 1] = 10.0, 40.0  # above what the model is meant for
    peak[1, 1] = 30.0
    probes = probed(peak, "xyz", [10.0, 60.0], centre_1=("centre", 1), edge_1=("edge", 1))
    design = designed([45.0, 45.0], np.zeros(0, dtype=str))
    dims = ("motion", "damping", "station", "direction")
    design["member_centre_peak"] = (dims, np.full((8, 1, 1, 1), 12.0))
    run = run_of(tmp_path, transient=probes, design=design)
    (text,) = flags(run, governing(run))
    assert "8 motions" in text and "1.20" in text
    (alone,) = (run_of(tmp_path, transient=probes, design=design.drop_dims("motion")),)
    assert flags(alone, governing(alone)) == []


FLOORS = 5


@pytest.fixture
def store():
    """Five floors of which two are hit, with peaks of three motions."""
    peak = np.ones((FLOORS, 2, 3))
    motion = np.array([1.0, 2.0, 3.0])[:, None, None, None, None]
    factor = np.array([1.0, 5.0, 2.0, 3.0, 4.0])[:, None, None]
    return xr.Dataset(
        {
            "psa": (("damping", "station", "direction", "frequency"), peak[None]),
            "member_psa": (
                ("motion", "damping", "station", "direction", "frequency"),
                motion * (factor * peak)[None, None],
            ),
            "station_floor": ("station", np.arange(1, FLOORS + 1)),
            "edge": ("edge", np.array([3, 4, 5])),
            "member_impact_force": (
                ("motion", "edge"),
                np.array([[0, 1, 1], [0, 0, 1], [0, 0, 1]]),
            ),
        },
        coords={"direction": ("direction", ["x", "y"])},
        attrs={"shown_direction": "y"},
    )


def names(rows):
    return [row[0].split(", peak")[0] for row in rows]


def test_all_floors_that_are_hit(store):
    rows, _ = _carried_floors(store)
    assert names(rows) == ["floor 5, y", "floor 4, y", "floor 5, x", "floor 4, x"]
    # Mean of 4, 8 and 12 beside 1 of this motion; the fractile between the two largest.
    assert rows[0][1:3] == ["1", "8"] and 8.0 < float(rows[0][3]) <= 12.0
    assert float(rows[0][4]) == pytest.approx(float(rows[0][3]), abs=0.01)


def test_a_direction_in_which_this_motion_does_not_move(store):
    store["psa"][0, 4, 1] = 0.0
    rows, _ = _carried_floors(store)
    assert rows[0][1] == "0" and rows[0][4] == ""


@pytest.mark.parametrize(
    ("pattern", "doubted"), [("pounding.main_impact_*", True), ("frs.*.pfa", False)]
)
def test_a_failed_check_marks_the_numbers_that_it_concerns(tmp_path, pattern, doubted):
    run = run_of(tmp_path, pounding=sticks())
    failed = {"passed": False, "severity": "invalid", "quantity": "steps in an impact"}
    failed["concerns"] = [pattern]
    run.checks.append(failed)
    found = by_question(run)["Largest impact"]
    assert (found.mark == "warn") == ("steps in an impact" in found.text) == doubted
    failed["passed"] = True
    assert by_question(run)["Largest impact"].mark == ""

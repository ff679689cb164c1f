"""The comparison of the floor spectra of two runs."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.report.comparison import (
    Comparison,
    Side,
    cases_table,
    common_frequencies,
    compare,
    comparison_figure,
    comparison_table,
    directions_table,
    resonance_low,
)
from impactfem.spectra.frequency_list import interpolate_frequency
from impactfem.system.errors import InputError

MESH = ("node_position", "triangle_node", "centre")


@pytest.fixture
def store(transient_folder):
    """Of a run, with its mesh; the sixth point rests."""
    return whole(transient_folder())


def whole(folder):
    """Results and mesh of a run in one."""
    results, building = (
        xr.load_dataset(folder / name, engine="netcdf4") for name in ("transient.nc", "building.nc")
    )
    results.attrs |= {"inputs": "a", "title": "a fine mesh", "case_hash": "b"}
    results["pfa"][:] = 1.0
    if len(results["probe"]) > 5:
        results["pfa"][5] = 0.001
    return results.assign({name: building[name] for name in MESH})


def side(run, name):
    return Side(run, run, f"{name}.toml", Path(f"runs/{name}"))


def compared(one, other, highest=100.0):
    return Comparison(compare(side(one, "one"), side(other, "other"), highest))


def largest(found):
    return found.worst(found.difference)[0]


def on_grid(run, frequency):
    """With other frequencies, and spectra of the same curve there, without what a line adds."""
    curve = 40.0 * np.exp(-(np.log(frequency / 60.0) ** 2)) + 0.1
    other = run.drop_dims("frequency").assign_coords(frequency=frequency)
    shape = (len(run["damping"]), len(run["probe"]), 3, len(frequency))
    dims = ("damping", "probe", "component", "frequency")
    return other.assign(psa=(dims, np.broadcast_to(curve, shape).copy()))


def test_a_known_difference(store):
    """3 % at one point along z and one frequency, 50 % where nothing counts."""
    one = store.copy(deep=True)
    f = store["frequency"].values
    below, above = 17, int(np.searchsorted(f, 100.0)) + 1
    one["psa"][0, 2, 2, below] *= 0.97
    one["psa"][0, 2, 2, above] *= 1.5  # above what is compared
    one["psa"][0, 5] *= 1.5  # at rest
    found = compared(one, store)
    spectrum = store["psa"].values[0, 2, 2]
    of_peak = 0.03 * spectrum[below] / spectrum[found.known].max()
    for apart, expected in ((found.difference, 0.03), (found.over_peak, of_peak)):
        worst, k, frequency = found.worst(apart)
        assert (found.probe[k], found.component[k]) == (2, 2) and found.components[2] == "z"
        assert (worst, frequency) == pytest.approx((expected, f[below]), rel=1e-12)
    assert len(found.probe) == 3 * (len(found.probes) - 1) and 5 not in found.probe
    assert not found.store["distance"].values.any()
    assert largest(compared(one, store, 500.0)) == pytest.approx(0.5)
    # Equal lists: the ordinates are those of the runs.
    np.testing.assert_allclose(found.store["psa"].values, one["psa"].values[0], rtol=1e-14)


def test_points_are_those_of_the_same_name_at_the_same_place(store):
    """Sides of 1.5 to 3.4 m: a point that moved by 0.25 m is compared, one by 4 m is not."""
    keep = list(range(len(store["probe"])))[::-2]
    other = store.isel(probe=keep).copy(deep=True)
    other["probe_position"][0, 0] += 0.25
    far = str(other["probe"].values[1])
    other["probe_position"][1, 0] += 4.0
    other["psa"][0, 1] *= 3.0  # of a place that is another one
    found = compared(store, other)
    names = [n for n in map(str, store["probe"].values) if n in other["probe"] and n != far]
    assert found.probes == names
    assert largest(found) == 0.0
    moved = found.probes.index(str(other["probe"].values[0]))
    assert (
        found.store["distance"].values[moved] == pytest.approx(0.25)
        and np.count_nonzero(found.store["distance"].values) == 1
    )
    rows = {row[0]: row[1:] for row in cases_table(found).rows}
    assert rows["points left out: too far apart"] == (f"{far} (4 m apart)",) * 2
    assert rows["points"] == ("12", "6") and str(rows["points compared"][0]).startswith("5, within")
    alone, nothing = rows["points left out: only here"]
    assert len(str(alone).split(", ")) == 6 and nothing == ""


@pytest.mark.parametrize("change", ["levels", "plan", "floors"])
def test_another_building(store, transient_folder, change):
    """Names of points are the same, positions within an element; the buildings are not."""
    other = store.copy(deep=True)
    if change == "levels":
        other["node_position"][:, 2] *= 1.1
    elif change == "plan":
        other["node_position"][:, 0] *= 1.1
    else:
        other = whole(transient_folder(floors=(1, 2), loads=(2,)))
    with pytest.raises(InputError) as error:
        compared(store, other)
    told = [str(fault) for fault in error.value.faults]
    assert len(told) == 1 and "\n" not in told[0]
    expected = "runs/other: expected a run of the building of runs/one, 3 floors up to 12 m"
    assert told[0].startswith(expected) and "; it has " in told[0]
    # Mesh, materials and modelling may change a little of the shape.
    other = store.copy(deep=True)
    other["node_position"][:, 0] *= 1.04
    assert largest(compared(store, other)) == 0.0


def test_grids_that_share_one_frequency(store):
    """132 and 140 frequencies from 0.5 to 100 Hz of one curve, which differ at all others."""
    one, other = (on_grid(store, np.geomspace(0.5, 100.0, n)) for n in (132, 140))
    one["psa"][0, :, :, -1] = other["psa"][0, :, :, -1]
    shared = np.isclose(one["frequency"].values[:, None], other["frequency"].values).sum()
    assert shared == 2  # both ends; by equality alone nothing of the peak at 60 Hz is seen
    found = compared(one, other)
    assert len(found.frequency) == 132 + 140 - 2 and found.range.startswith("270 frequencies")
    ours, theirs = found.peak[:, 1]
    assert ours == pytest.approx(40.1, rel=1e-3) and theirs == pytest.approx(40.1, rel=1e-3)
    assert largest(found) < 2e-3
    higher = one.copy(deep=True)
    higher["psa"][:] *= 1.2
    assert compared(higher, other).difference.min() > 0.19
    rows = {row[0]: row[1:] for row in cases_table(found).rows}
    assert rows["frequencies up to 100 Hz"] == ("132", "140")
    # Δ = ln(200)/131 in the coarser list: 1 − 1/√(1 + (Δ/0.1)²).
    assert rows["interpolated: sharp peaks may be low by"] == ("7.3 %",) * 2


def test_only_the_range_that_both_have(store):
    one = on_grid(store, np.geomspace(0.5, 34.0, 200))
    found = compared(one, on_grid(store, np.geomspace(1.0, 500.0, 300)))
    assert found.frequency[0] == 1.0 and found.frequency[-1] == 34.0
    assert found.range.endswith("from 1 to 34 Hz")


def test_no_interpolation_across_a_wide_gap(store):
    """30 in a decade are too few to interpolate at 5 %: the finer spectrum goes to them."""
    coarse = on_grid(store, np.geomspace(0.5, 500.0, 91))
    fine = on_grid(store, np.geomspace(0.51, 490.0, 400))
    inside = coarse["frequency"].values[1:-1]
    for found in (compared(coarse, fine), compared(fine, coarse)):
        assert np.array_equal(found.frequency, inside)
        assert largest(found) < 1e-3
    # Nor does either go to the other where both are coarse: nothing is left.
    other = on_grid(store, np.geomspace(0.51, 490.0, 91))
    with pytest.raises(
        InputError, match=r"at least 20 of the frequencies up to 100 Hz .*; found 0"
    ):
        compared(coarse, other)
    # Equal lists need no interpolation, however few they are.
    few = on_grid(store, np.array([1.0, 5.0, 20.0]))
    assert compared(few, few).range == "3 frequencies from 1 to 20 Hz"


@pytest.mark.parametrize("damping", [0.02, 0.05])
def test_interpolation_of_the_sharpest_peak(damping):
    """The steady amplitude of an oscillator, by its formula, between two frequencies of a list."""
    assert list(
        common_frequencies(*(np.array([1.0, 1.0 + s * damping, 2.0]) for s in (0.9, 0.5)), damping)
    ) == [1.0, 1.0 + 0.5 * damping, 2.0]
    gap = damping
    frequency = np.exp([-0.5 * gap, 0.5 * gap])
    steady = 1.0 / np.hypot(1.0 - frequency**2, 2.0 * damping * frequency)
    line = interpolate_frequency(frequency, steady, 1.0)[0]
    low = 1.0 - line * 2.0 * damping
    assert low == pytest.approx(resonance_low(gap, damping), abs=0.001)
    assert low == pytest.approx(0.106, abs=0.001)


def test_the_damping_that_both_have(transient_folder):
    both = [whole(transient_folder(dampings=d)) for d in ((0.02, 0.05), (0.05, 0.07))]
    both[0]["psa"][0] *= 9.0
    found = compared(*both)
    assert found.damping == 0.05 and largest(found) == 0.0


def test_nothing_in_common(store):
    other = store.assign_coords(probe=[f"p{k}" for k in range(len(store["probe"]))], damping=[0.07])
    with pytest.raises(InputError) as error:
        compared(store, other)
    points, dampings = map(str, error.value.faults)
    assert "none of its names" in points
    assert dampings == (
        "runs/other: damping = '7 %': expected a damping of the spectra of runs/one, 5 %"
    )
    moved, still = store.copy(deep=True), store.copy(deep=True)
    moved["probe_position"][:, 0] += 5.0  # a building of the same shape that stands elsewhere
    with pytest.raises(InputError, match=r"runs/other: probe: .*all are 5 m away or more"):
        compared(store, moved)
    still["pfa"][:] = 0.0
    with pytest.raises(InputError, match=r"expected a point that moves in runs/one, too"):
        compared(store, still)


def test_directions(store):
    """Of 10 spectra along z one is 4 % higher, and at one frequency 8 %."""
    one = store.copy(deep=True)
    one["psa"][0, 2, 2] *= 1.04
    one["psa"][0, 2, 2, 3] *= 1.08 / 1.04
    found = compared(one, store)
    spectra, ordinates = len(found.probes) - 1, int(found.known.sum())
    rows = {row[0]: row[1:] for row in directions_table(found).rows}
    assert rows["x"] == rows["y"] == (spectra, 0.0, 0.0, 0.0, 0.0, 1.0, spectra)
    psa = store["psa"].values[0, 2, 2]
    of_peak = max(0.04, 0.08 * psa[3] / psa[found.known].max())
    apart = np.zeros(spectra * ordinates)
    apart[:ordinates] = 0.04
    apart[0] = 0.08
    near = 1.0 - 1.0 / apart.size
    expected = (spectra, 0.04, of_peak, 0.08, np.percentile(apart, 95), near, spectra - 1)
    assert rows["z"] == pytest.approx(expected, rel=1e-9)


def test_table_and_figure(store, tmp_path):
    one = store.copy(deep=True)
    one["psa"] *= 1.02
    found = compared(one, store)
    table = comparison_table(found)
    assert len(table.rows) == len(found.probe)
    names = [name for name, _ in table.columns]
    row = dict(zip(names, table.rows[0], strict=True))
    assert row["largest difference"] == pytest.approx(0.02)
    assert row["largest over the peak"] == pytest.approx(0.02)
    assert float(str(row["peak"])) == pytest.approx(1.02 * float(str(row["peak of the other"])))
    for one_table in (table, directions_table(found)):
        assert "'a fine mesh' (one.toml, runs/one)" in one_table.title
        assert "'a fine mesh' (other.toml, runs/other)" in one_table.title
        assert "and 12 points" in one_table.title
    named = {row[0]: row[1:] for row in cases_table(found).rows}
    assert named["case file"] == ("one.toml", "other.toml")
    assert named["folder"] == ("runs/one", "runs/other")
    comparison_figure(tmp_path / "a.svg", found)
    assert (tmp_path / "a.svg").stat().st_size > 10_000
    comparison_figure(tmp_path / "b.svg", compared(store, store))  # no difference at all

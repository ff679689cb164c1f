"""Floor spectra of two runs beside each other."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.errors import InputError
from impactfem.results.comparison import Comparison, compare
from impactfem.results.comparison_views import (
    comparison_figure,
    comparison_table,
    directions_table,
)
from impactfem.results.transient_view import TransientView

FILES = Path("one.nc"), Path("other.nc")


@pytest.fixture
def store(transient_folder: Callable[..., Path]) -> xr.Dataset:
    """Of a run; the sixth point rests."""
    whole = xr.load_dataset(transient_folder() / "transient.nc", engine="h5netcdf")
    whole.attrs |= {"inputs": "a", "title": "a fine mesh", "case_hash": "b"}
    whole["pfa"][:] = 1.0
    whole["pfa"][5] = 0.001
    return whole


def compared(one: xr.Dataset, other: xr.Dataset, highest: float = 100.0) -> Comparison:
    return Comparison(compare(TransientView(one), TransientView(other), FILES, highest))


def test_a_known_difference(store: xr.Dataset) -> None:
    """3 % at one point along z and one frequency, 50 % where nothing counts."""
    one = store.copy(deep=True)
    f = store["frequency"].values
    below, above = 17, int(np.searchsorted(f, 100.0)) + 1
    one["psa"][0, 2, 2, below] *= 0.97
    one["psa"][0, 2, 2, above] *= 1.5  # above what is compared
    one["psa"][0, 5] *= 1.5  # at rest
    found = compared(one, store)
    largest, probe, component, frequency = found.worst()
    assert largest == pytest.approx(0.03, rel=1e-12)
    assert (found.probes[probe], found.components[component]) == (
        str(store["probe"].values[2]),
        "z",
    )
    assert frequency == pytest.approx(f[below])
    spectrum = store["psa"].values[0, 2, 2]
    of_peak = 0.03 * spectrum[below] / spectrum[found.known].max()
    assert found.worst(of_peak=True) == pytest.approx((of_peak, 2, 2, f[below]), rel=1e-12)
    assert found.counts.sum() == 3 * (len(found.probes) - 1) and not found.counts[5].any()
    assert compared(one, store, 500.0).worst()[0] == pytest.approx(0.5)


def test_a_run_beside_itself(store: xr.Dataset) -> None:
    found = compared(store, store)
    assert found.worst()[0] == 0.0 and not found.distance.any()


def test_points_are_found_by_name_and_frequencies_by_value(store: xr.Dataset) -> None:
    keep = list(range(len(store["probe"])))[::-2]
    other = store.isel(probe=keep, frequency=slice(3, None, 2)).copy(deep=True)
    other["probe_position"][0, 0] += 0.25
    found = compared(store, other)
    assert found.probes == [n for n in map(str, store["probe"].values) if n in other["probe"]]
    assert np.array_equal(found.frequency, other["frequency"].values)
    assert found.worst()[0] == 0.0
    moved = found.probes.index(str(other["probe"].values[0]))
    assert found.distance[moved] == pytest.approx(0.25) and np.count_nonzero(found.distance) == 1


def test_the_damping_that_both_have(transient_folder: Callable[..., Path]) -> None:
    both = [
        xr.load_dataset(transient_folder(dampings=d) / "transient.nc", engine="h5netcdf")
        for d in ((0.02, 0.05), (0.05, 0.07))
    ]
    for whole in both:
        whole.attrs |= {"inputs": "a", "title": "t", "case_hash": "b"}
    both[0]["psa"][0] *= 9.0
    found = compared(*both)
    assert found.damping == 0.05 and found.worst()[0] == 0.0


def test_nothing_in_common(store: xr.Dataset) -> None:
    other = store.copy(deep=True)
    other = other.assign_coords(
        probe=[f"p{k}" for k in range(len(other["probe"]))],
        damping=[0.07],
        frequency=other["frequency"].values * 1.01,
    )
    with pytest.raises(InputError) as error:
        compared(store, other)
    told = [str(fault) for fault in error.value.faults]
    assert len(told) == 3 and all("other.nc" in line for line in told)


def test_nothing_moves(store: xr.Dataset) -> None:
    still = store.copy(deep=True)
    still["pfa"][:] = 0.0
    with pytest.raises(InputError, match=r"expected a point that moves in other\.nc"):
        compared(store, still)


def test_directions(store: xr.Dataset) -> None:
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


def test_table_and_figure(store: xr.Dataset, tmp_path: Path) -> None:
    one = store.copy(deep=True)
    one["psa"] *= 1.02
    found = compared(one, store)
    table = comparison_table(found)
    assert len(table.rows) == found.counts.sum()
    names = [name for name, _ in table.columns]
    row = dict(zip(names, table.rows[0], strict=True))
    assert row["largest difference"] == pytest.approx(0.02)
    assert row["largest over the peak"] == pytest.approx(0.02)
    assert float(str(row["peak"])) == pytest.approx(1.02 * float(str(row["peak of the other"])))
    assert "a fine mesh" in table.title
    comparison_figure(tmp_path / "a.png", found)
    assert (tmp_path / "a.png").stat().st_size > 10_000
    comparison_figure(tmp_path / "b.png", compared(store, store))  # no difference at all

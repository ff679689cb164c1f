"""What a person sees of an ensemble."""

import csv

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.ensemble.figures import bands, ensemble_checks, ensemble_results
from impactfem.stages.ensemble.store import OUTPUTS
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(1)
    f = np.geomspace(0.5, 50.0, 20)
    percentile = np.array([5.0, 16.0, 50.0, 84.0, 95.0])
    psa = 1.0 + rng.random((40, 1, 3, 1, 20))
    bands = np.percentile(psa, percentile, axis=0)
    values = {
        "motion": [f"seed_{k}" for k in range(40)],
        "scalar": ["a.b", "c.d", "e"],
        "unit": ["m", "s", "-"],
        "value": np.column_stack([np.arange(40.0), rng.random(40), np.full(40, np.nan)]),
        "percentile": percentile,
        "station_floor": [1, 2, 3],
        "direction": ["y"],
        "frequency": f,
        "damping": [0.05],
        "psa_percentile": bands,
        "psa_free_percentile": 0.5 * bands,
    }
    attributes = {"shown_direction": "y", "studied_building": "B1"}
    store = dataset(OUTPUTS, values, attributes=attributes)
    write_netcdf(tmp_path / "ensemble.nc", store)
    return tmp_path


def test_files(folder):
    files = ensemble_results(folder, {"a.b": 20.0})
    assert [path.name for path in files] == [
        "ensemble.csv",
        "ensemble_floor_spectra.svg",
        "ensemble_published.svg",
    ]
    assert all(path.stat().st_size > (100 if path.suffix == ".csv" else 5000) for path in files)
    with files[0].open(newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[1][0] == "a.b" and float(rows[1][4]) == pytest.approx(19.5)


def test_without_published_values(folder):
    assert len(ensemble_results(folder, {})) == 2


def test_inside_or_not(folder):
    with xr.open_dataset(folder / "ensemble.nc", engine="h5netcdf") as store:
        table = bands(store, {"a.b": 20.0, "c.d": 5.0})
    assert [(row[0], row[-1]) for row in table.rows] == [("a.b", "yes"), ("c.d", "no")]


def test_checks(folder):
    members = xr.load_dataset(folder / "ensemble.nc", engine="h5netcdf")
    for failed, good in ((0.0, True), (2.0, False)):
        counts = {"ensemble.members": 40.0, "ensemble.failed": failed}
        scalars = [Scalar(name, x, "-") for name, x in counts.items()]
        write_netcdf(folder / "ensemble.nc", with_scalars(members, scalars))
        assert ensemble_checks(folder, {"a.b": 20.0, "c.d": 5.0}) == [
            (good, f"ensemble: 40 motions, {failed:.0f} failed"),
            (None, "ensemble: 1 of 2 published values within 5 to 95 %; outside: c.d"),
        ]
    assert len(ensemble_checks(folder, {})) == 1


@pytest.mark.parametrize(("shift", "count"), [(0.0, 0), (-2.5, 3)])
def test_floors_in_no_pair(folder, shift, count):
    """The scalar of their closest approach: below zero they overlap."""
    members = xr.load_dataset(folder / "ensemble.nc", engine="h5netcdf")
    members["scalar"] = np.array(["pounding.facing_distance_min", "c.d", "e"], dtype=object)
    members["value"][:, 0] += shift
    scalars = [Scalar("ensemble.members", 40.0, "-"), Scalar("ensemble.failed", 0.0, "-")]
    write_netcdf(folder / "ensemble.nc", with_scalars(members, scalars))
    (found,) = (one for one in ensemble_checks(folder, {}) if "contact pair" in one[1])
    text = f"ensemble: in {count} of 40 motions floors overlap that are in no contact pair"
    assert found == (count == 0, text)

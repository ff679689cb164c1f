"""Figures and the table of members of the stage `design`."""

import csv

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.design.device_figures import design_device, member_table
from impactfem.stages.design.figures import design_figures
from impactfem.stages.design.products import design_products_of

from .design_store import WantedDesign, design_store, stick_store

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


@pytest.fixture
def stored(tmp_path):
    def make(asked=None):
        design_store(tmp_path / "design.nc", asked)
        stick_store(tmp_path / "pounding.nc")
        with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
            return store.load()

    return make


def test_a_page_for_each_direction_and_damping(stored, tmp_path):
    store = stored(WantedDesign(still=True))
    files = design_figures(
        tmp_path, design_products_of(store, tmp_path / "pounding.nc", (0.1, 0.15), False)
    )
    assert {path.name for path in files} == {
        f"design_{kind}_{direction}_{damping}pct.png"
        for kind in ("spectra", "ensemble")
        for direction in "yz"
        for damping in (2, 5)
    }
    assert all(path.stat().st_size > 10_000 for path in files)


def test_no_page_of_an_ensemble_that_is_not_there(stored, tmp_path):
    store = stored(WantedDesign(motions=0))
    files = design_figures(
        tmp_path, design_products_of(store, tmp_path / "pounding.nc", 0.15, False)
    )
    assert len(files) == 6 and not any("ensemble" in path.name for path in files)
    assert design_device(tmp_path, store) == []


@pytest.mark.parametrize("devices", [(), ("pump",), ("pump", "rack_1", "rack_2", "cabinet")])
def test_members(stored, tmp_path, devices):
    files = design_device(tmp_path, stored(WantedDesign(devices=devices)))
    assert [path.name for path in files] == [
        "design_members.csv",
        *(["design_device_force.png"] if devices else []),
    ]
    with files[0].open(newline="") as stream:
        rows = list(csv.reader(stream))
    assert len(rows) == 1 + 5 + 4 and len(rows[0]) == 2 + 2 + 2 * len(devices)
    assert [row[0] for row in rows[-4:]] == [
        *("median", "mean", "84 % fractile", "lognormal 84 % fractile"),
    ]


def test_statistics_of_members(stored):
    store = stored()
    table = member_table(store)
    names = [name for name, _ in table.columns]
    column = names.index("Fy of pump, 3D model")
    force = store["member_device_force"].values[:, 0, 1]
    np.testing.assert_allclose([row[column] for row in table.rows[:5]], force, rtol=1e-5)
    assert table.rows[6][column] == pytest.approx(force.mean(), rel=1e-5)
    # A force that one member does not have has no logarithm.
    store["member_device_force"].values[2, 0, 1] = 0.0
    assert member_table(store).rows[-1][column] is None

import logging
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from impactfem.stages.pounding.tables import stick_tables

NAMES = {"modes", "contact_parameters", "impacts", "impact_checks", "separation"}


@pytest.fixture
def store(finished):
    yield xr.load_dataset(finished.folder / "pounding.nc", engine="netcdf4")


@pytest.fixture
def read(finished):
    def table(name, folder=finished.folder):
        return pd.read_csv(folder / "tables" / f"{name}.csv")

    return table


def test_modes(read, store):
    table = read("modes")
    west = table[table["building"] == "west"]
    # Three floors with six components each.
    assert len(west) == 18 and len(table) == 36
    frequency = west["frequency [Hz]"].to_numpy()
    assert frequency == pytest.approx(store["mode_frequency"].values[0], rel=1e-15)
    assert np.all(np.diff(frequency) >= 0.0)
    for _, mine in west.groupby("family"):
        assert mine["number in family"].tolist() == list(range(1, len(mine) + 1))
    # All modes together carry the whole mass of the building, 672 t, in each direction.
    for direction in "xyz":
        assert west[f"effective mass {direction} [t]"].sum() == pytest.approx(672.0)


def test_contact_parameters(read, store):
    table = read("contact_parameters")
    assert table["pair"].tolist() == [f"west.floor_{k}-east.floor_{k}" for k in (1, 2, 3)]
    assert table["gap [mm]"].to_numpy() == pytest.approx([20.0] * 3)
    assert table["restitution requested [-]"].to_numpy() == pytest.approx([0.65] * 3)
    # Two equal floors of 240 t, and of 192 t, on the middle of their edges.
    assert table["effective mass [t]"].to_numpy() == pytest.approx([120.0, 120.0, 96.0])
    # π/Ω_D of K = 1.2e10 N/m, in steps of 0.5 ms.
    mass = np.array([120e3, 120e3, 96e3])
    xi = table["damping ratio [-]"].to_numpy()
    duration = np.pi / np.sqrt(1.2e10 / mass * (1.0 - xi**2))
    assert table["duration of the law [ms]"].to_numpy() == pytest.approx(1e3 * duration)
    assert table["steps in it [-]"].to_numpy() == pytest.approx(duration / 5e-4)
    assert table["dashpot [N s/m]"].to_numpy() == pytest.approx(2 * xi * np.sqrt(1.2e10 * mass))


def test_impacts(read, store):
    table = read("impacts")
    assert table["pair"].tolist() == list(store["impact_pair"].values)
    for column, name, factor in (
        ("peak at [s]", "peak_time", 1.0),
        ("peak force [MN]", "peak_force", 1e-6),
        ("impulse [kN s]", "impulse", 1e-3),
        ("duration [ms]", "duration", 1e3),
        ("penetration [mm]", "penetration", 1e3),
        ("steps [-]", "steps", 1.0),
    ):
        expected = factor * store[f"impact_{name}"].values
        assert table[column].to_numpy() == pytest.approx(expected, rel=1e-12), column
    ratio = (table["separation [m/s]"] / table["approach [m/s]"]).to_numpy()
    assert table["restitution [-]"].to_numpy() == pytest.approx(ratio)


def test_impact_checks(read, store):
    table = read("impact_checks")
    pressure = table["mean bearing pressure [MPa]"].to_numpy()
    # 5 m2 of concrete of 25 MPa.
    assert pressure == pytest.approx(store["impact_peak_force"].values / 5e6)
    assert table["over strength [-]"].to_numpy() == pytest.approx(pressure / 25.0)


def test_separation(read, store):
    table = read("separation")
    margin = table["gap [mm]"] - table["required [mm]"]
    assert table["margin [mm]"].to_numpy() == pytest.approx(margin.to_numpy())
    touched = table["pair"].isin(store["impact_pair"].values)
    assert ((table["touched"] == "yes") == touched).all() and touched.any()


def test_they_are_in_the_log(finished, caplog, tmp_path):
    shutil.copy(finished.folder / "pounding.nc", tmp_path)
    with caplog.at_level(logging.DEBUG, "impactfem"):
        files = stick_tables(tmp_path)
    assert {path.stem for path in files} == NAMES
    for title in ("Modes of the sticks", "Contact parameters", "Impacts", "Required separation"):
        assert title in caplog.text


def test_nothing_touches(finished, tmp_path, read):
    """No pairs and no impacts: tables with a header only."""
    with xr.open_dataset(finished.folder / "pounding.nc", engine="netcdf4") as dataset:
        nothing = dataset.load().isel(pair=slice(0), impact=slice(0)).drop_encoding()
        nothing.to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    stick_tables(tmp_path)
    for name in NAMES - {"modes"}:
        assert read(name, tmp_path).empty
    assert read("modes", tmp_path).equals(read("modes"))

import csv
import logging
import shutil

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.pounding.tables import stick_tables

NAMES = {"modes", "contact_parameters", "impacts", "impact_checks", "separation"}


@pytest.fixture
def store(finished):
    yield xr.load_dataset(finished.folder / "pounding.nc", engine="netcdf4")


@pytest.fixture
def read(finished):
    def columns(name, folder=finished.folder):
        with (folder / "tables" / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
            header, *rows = csv.reader(stream)
        return {key: [row[k] for row in rows] for k, key in enumerate(header)}

    return columns


def numbers(column):
    return [float(cell) if cell else np.nan for cell in column]


def test_modes(read, store):
    table = read("modes")
    west = [k for k, name in enumerate(table["building"]) if name == "west"]
    # Three floors with six components each.
    assert len(west) == 18 and len(table["building"]) == 36
    frequency = np.array(numbers(table["frequency [Hz]"]))[west]
    assert np.array_equal(frequency, store["mode_frequency"].values[0])
    assert np.all(np.diff(frequency) >= 0.0)
    family = [table["family"][k] for k in west]
    number = [int(table["number in family"][k]) for k in west]
    for name in set(family):
        mine = [n for n, f in zip(number, family, strict=True) if f == name]
        assert mine == list(range(1, len(mine) + 1))
    # All modes together carry the whole mass of the building, 672 t, in each direction.
    for direction in "xyz":
        mass = np.array(numbers(table[f"effective mass {direction} [t]"]))[west]
        assert mass.sum() == pytest.approx(672.0)


def test_contact_parameters(read, store):
    table = read("contact_parameters")
    assert table["pair"] == [f"west.floor_{k}-east.floor_{k}" for k in (1, 2, 3)]
    assert numbers(table["gap [mm]"]) == pytest.approx([20.0] * 3)
    assert numbers(table["restitution requested [-]"]) == pytest.approx([0.65] * 3)
    # Two equal floors of 240 t, and of 192 t, on the middle of their edges.
    assert numbers(table["effective mass [t]"]) == pytest.approx([120.0, 120.0, 96.0])
    # π/Ω_D of K = 1.2e10 N/m, in steps of 0.5 ms.
    mass = np.array([120e3, 120e3, 96e3])
    xi = np.array(numbers(table["damping ratio [-]"]))
    duration = np.pi / np.sqrt(1.2e10 / mass * (1.0 - xi**2))
    assert numbers(table["duration of the law [ms]"]) == pytest.approx(1e3 * duration)
    assert numbers(table["steps in it [-]"]) == pytest.approx(duration / 5e-4)
    assert numbers(table["dashpot [N s/m]"]) == pytest.approx(2 * xi * np.sqrt(1.2e10 * mass))


def test_impacts(read, store):
    table = read("impacts")
    assert table["pair"] == list(store["impact_pair"].values)
    for column, name, factor in (
        ("peak at [s]", "peak_time", 1.0),
        ("peak force [MN]", "peak_force", 1e-6),
        ("impulse [kN s]", "impulse", 1e-3),
        ("duration [ms]", "duration", 1e3),
        ("penetration [mm]", "penetration", 1e3),
        ("steps [-]", "steps", 1.0),
    ):
        expected = factor * store[f"impact_{name}"].values
        assert numbers(table[column]) == pytest.approx(expected, rel=1e-12), column
    ratio = np.array(numbers(table["separation [m/s]"])) / numbers(table["approach [m/s]"])
    assert numbers(table["restitution [-]"]) == pytest.approx(ratio)


def test_impact_checks(read, store):
    table = read("impact_checks")
    pressure = np.array(numbers(table["mean bearing pressure [MPa]"]))
    # 5 m2 of concrete of 25 MPa.
    assert pressure == pytest.approx(store["impact_peak_force"].values / 5e6)
    assert numbers(table["over strength [-]"]) == pytest.approx(pressure / 25.0)


def test_separation(read, store):
    table = read("separation")
    gap, required = numbers(table["gap [mm]"]), numbers(table["required [mm]"])
    assert numbers(table["margin [mm]"]) == pytest.approx(np.subtract(gap, required))
    touched = [name in set(store["impact_pair"].values) for name in table["pair"]]
    assert table["touched"] == ["yes" if value else "no" for value in touched]
    assert any(touched)


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
        assert not any(read(name, tmp_path).values())
    assert read("modes", tmp_path) == read("modes")

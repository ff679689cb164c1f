"""Tables of the stage `building`."""

import csv

import numpy as np
import pytest
import xarray as xr

from impactfem.case.members import Bay
from impactfem.stages.building.tables import building_tables
from impactfem.system.files import write_netcdf


@pytest.fixture
def folder(tmp_path):
    modes, floors = np.arange(1, 4), np.array([1, 2])
    mass = np.array([[8e3, 0.0], [0.0, 5e3], [1e3, 0.0]])
    store = xr.Dataset(
        {
            "frequency": ("mode", np.array([2.0, 3.0, 7.0])),
            "effective_mass": (("mode", "direction"), mass),
            "participation": (("mode", "direction"), np.sqrt(mass)),
            "residual": ("mode", np.full(3, 1e-12)),
            "total_mass": ("direction", np.array([1e4, 1e4])),
            "bending_mode": ("bending", np.array([1, 3])),
            "floor_mass": ("floor", np.array([6e3, 4e3])),
            "floor_added_mass": ("floor", np.array([1e3, 0.0])),
        },
        coords={"mode": modes, "floor": floors, "direction": np.array(["x", "y"], dtype=object)},
        attrs={"building": "B1", "bending_direction": "x"},
    )
    write_netcdf(tmp_path / "building.nc", store)
    return tmp_path


def rows(path):
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_tables_beside_the_published_modes(folder):
    files = building_tables(folder, {"building.frequency.1": 1.6})
    assert [path.name for path in files] == [
        "building_bending_modes.csv",
        "building_modes.csv",
        "building_floor_masses.csv",
    ]
    first, second = rows(files[0])
    assert [float(first[k]) for k in list(first)[:5]] == pytest.approx([1, 1, 2.0, 1.6, 25.0])
    assert second["mode of all"] == "3"


def test_each_size_of_opening_is_counted(folder):
    size = {"wall": "a", "storey": 2, "sill": 0.0, "width": 0.9, "height": 2.1}
    bays = [Bay(bay="4", centre=x, **size) for x in (3.0, 6.0, 9.0)]
    bays.append(Bay(bay="4", centre=12.0, **{**size, "width": 1.8}))
    files = building_tables(folder, {}, bays)
    assert files[-1].name == "building_bays.csv"
    found = [[float(cell) for cell in row.values()] for row in rows(files[-1])]
    assert found == [
        pytest.approx([4, 2, 90.0, 210.0, 1.89, 3]),
        pytest.approx([4, 2, 180.0, 210.0, 3.78, 1]),
    ]

"""The checks of the stage `building` in words."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.building.stage import building_checks
from impactfem.system.files import write_netcdf

LINES = [
    "building: floors 300 t, base 100 t; difference of the mass matrix 0 (limit 1e-9)",
    "building: 2 modes from 1.800 to 5.220 Hz, none missed by the Sturm count; largest residual "
    "1e-12 (limit 1e-6)",
    "building: bending modes along y, with their part of the mass: 1.800 Hz (75.0 %)",
]


@pytest.fixture
def checked(tmp_path):
    """The checks of a store that no model made."""

    def check(*, total=4e5, residual=1e-12, bending=(1,), warnings=()):
        store = xr.Dataset(
            {
                "total_mass": ("direction", np.array([total, total])),
                "floor_mass": ("floor", np.array([2e5, 1e5])),
                "residual": ("mode", np.array([1e-14, residual])),
                "frequency": ("mode", np.array([1.8, 5.22])),
                "effective_mass": (("mode", "direction"), np.array([[0.0, 3e5], [3e5, 0.0]])),
                "base_mass": 1e5,
                "mesh_warning": ("mesh_warning", np.array(warnings, dtype=object)),
                "bending_mode": ("bending", np.array(bending, dtype=np.int64)),
            },
            coords={"direction": np.array(["x", "y"], dtype=object), "mode": [1, 2]},
            attrs={"bending_direction": "y"},
        )
        write_netcdf(tmp_path / "building.nc", store)
        return building_checks(tmp_path)

    return check


def test_all_is_well(checked):
    assert checked() == [(True, line) for line in LINES]


@pytest.mark.parametrize(
    ("change", "line", "text"),
    [
        ({"total": 4.04e5}, 0, "the mass matrix 0.0099 (limit 1e-9)"),
        ({"residual": 1e-3}, 1, "largest residual 0.001 (limit 1e-6)"),
        ({"bending": ()}, 2, "with their part of the mass: none"),
    ],
)
def test_what_fails(checked, change, line, text):
    found = checked(**change)
    assert [k for k, (good, _) in enumerate(found) if good is False] == [line]
    assert found[line][1].endswith(text)


def test_what_the_mesh_warned_of(checked):
    assert checked(warnings=("flat elements", "a hole"))[:2] == [
        (False, "mesh: flat elements"),
        (False, "mesh: a hole"),
    ]

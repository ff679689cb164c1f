"""What is said of floors that face each other and are in no contact pair."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.case import Case, load_case
from impactfem.stages.pounding.checks import facing_checks
from impactfem.stages.pounding.tables import _facing

GEOMETRY = Path(__file__).parents[3] / "geometry"


def words(*values: str) -> tuple[str, np.ndarray]:
    return "facing", np.array(values, dtype=object)


def store(nearest: float) -> xr.Dataset:
    return xr.Dataset(
        {
            "facing_a": words("B.floor_4", "C.floor_1", "B.floor_3"),
            "facing_b": words("C.floor_3", "B.storey_2_at_0.36", "C.storey_3_at_0.257"),
            "facing_level": ("facing", [12.0, 4.0, 9.0]),
            "facing_rest_gap": ("facing", [0.03, 0.03, 0.03]),
            "facing_distance_min": ("facing", [nearest, 0.02, nearest + 0.01]),
            "facing_time": ("facing", [4.36, 2.0, 3.0]),
        }
    )


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case(GEOMETRY / "row_of_three.toml")


@pytest.mark.parametrize(
    ("nearest", "good", "text"),
    [
        (
            -0.0138,
            False,
            "facing floors: B.floor_4 and C.floor_3 overlap by 13.8 mm at 4.36 s and are in no "
            "pair, and 1 more do (tables/facing_floors.csv); list them in [[contacts]]",
        ),
        (
            -0.005,
            False,
            "facing floors: B.floor_4 and C.floor_3 overlap by 5 mm at 4.36 s and are in no pair "
            "(tables/facing_floors.csv); list them in [[contacts]]",
        ),
        (
            0.0012,
            True,
            "facing floors: 3 in no pair keep apart; the nearest, B.floor_4 and C.floor_3, by "
            "1.2 mm at 4.36 s",
        ),
    ],
)
def test_checks(tmp_path: Path, case: Case, nearest: float, good: bool, text: str) -> None:
    store(nearest).to_netcdf(tmp_path / "pounding.nc", engine="h5netcdf")
    assert facing_checks(tmp_path, case) == [(good, text)]


def test_all_in_pairs(tmp_path: Path, case: Case) -> None:
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="h5netcdf")
    assert facing_checks(tmp_path, case) == []


def test_a_plan_that_is_not_known(tmp_path: Path, case: Case) -> None:
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="h5netcdf")
    bare = {"length": None, "width": None}
    buildings = tuple(one.model_copy(update=bare) for one in case.buildings)
    other = case.model_copy(update={"buildings": buildings, "contacts": case.contacts[:3]})
    ((good, text),) = facing_checks(tmp_path, other)
    assert good is None
    assert "whether floors of B and C that are in no pair meet cannot be checked" in text


def test_the_table() -> None:
    table = _facing(store(-0.0138))
    assert table.name == "facing_floors"
    assert table.rows[0][:3] == ("B.floor_4", "C.floor_3", 12.0)
    assert table.rows[0][3:6] == pytest.approx((30.0, -13.8, 4.36))
    assert [row[-1] for row in table.rows] == ["yes", "no", "yes"]

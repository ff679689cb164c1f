"""What the page says of an ensemble that went through the 3D model, and of devices."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from impactfem.report import overview
from impactfem.report.overview import _carried_floors, device_verdict
from impactfem.stages.stores import open_store

from ..stages.device.device_store import device_folder

FLOORS = 5


@pytest.fixture
def store() -> xr.Dataset:
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


def names(rows: list[list[str]]) -> list[str]:
    return [row[0].split(", peak")[0] for row in rows]


def test_all_floors_that_are_hit(store: xr.Dataset) -> None:
    rows, note = _carried_floors(store)
    assert names(rows) == ["floor 5, y", "floor 4, y", "floor 5, x", "floor 4, x"]
    # Mean of 4, 8 and 12 beside 1 of this motion; the fractile between the two largest.
    assert rows[0][1:3] == ["1", "8"] and 8.0 < float(rows[0][3]) <= 12.0
    assert float(rows[0][4]) == pytest.approx(float(rows[0][3]), abs=0.01)
    assert "All floors that one of the motions hits along y" in note


def test_where_none_is_hit_those_that_differ_most(store: xr.Dataset) -> None:
    store["member_impact_force"][:] = 0
    rows, note = _carried_floors(store)
    wanted = ["floor 5", "floor 4", "floor 2"]
    assert names(rows) == [f"{floor}, {one}" for one in "yx" for floor in wanted]
    assert note.startswith("The 3 floors on which the 84 % are highest")


def test_a_direction_in_which_this_motion_does_not_move(store: xr.Dataset) -> None:
    store["psa"][0, 4, 1] = 0.0
    rows, _ = _carried_floors(store)
    assert rows[0][1] == "0" and rows[0][4] == ""


def forces(folder: Path, **wanted: object) -> overview.Facts:
    """The table of a device, from a store that no solver made."""
    path = device_folder(folder, **wanted) / "device.nc"
    return device_verdict(SimpleNamespace(store=lambda name: open_store(path)), "pump")


@pytest.mark.parametrize(("share", "difference"), [(0.825, "+17.5"), (1.1, "-10.0")])
def test_the_difference_of_a_device_has_the_sign_of_its_tables(
    tmp_path: Path, share: float, difference: str
) -> None:
    """From the detailed force, over it: positive where the spectra give too little."""
    table = forces(tmp_path, choices={"srss": (share, share)})
    column = list(table.head).index("difference of Fy [%]")
    assert [row[column] for row in table.rows[:-1]] == ["", difference] * 2
    assert "positive where response spectrum analysis (RSA) underestimates" in table.note


def test_a_device_has_all_components_and_every_rigid_part(tmp_path: Path) -> None:
    choices = {"srss": (0.8, 0.9), "srss.gupta": (1.0, np.nan), "srss.lindley-yow": (1.0, 0.95)}
    table = forces(tmp_path, choices=choices, pulls=(-4e3, 90e3))
    assert [row[:2] for row in table.rows] == [
        ["without impact", "3D model"],
        ["without impact", "RSA, srss"],
        ["without impact", "RSA, rigid part by Gupta"],
        ["without impact", "RSA, rigid part by Lindley-Yow"],
        ["with impacts", "3D model"],
        ["with impacts", "RSA, srss"],
        # Gupta's was not done here.
        ["with impacts", "RSA, rigid part by Lindley-Yow"],
        ["factor of the impacts", "3D model"],
    ]
    detailed = dict(zip(table.head, table.rows[4], strict=True))
    assert (detailed["Fy [kN]"], detailed["Fz [kN]"]) == ("66.00", "33.00")
    assert (detailed["Mx [kN m]"], detailed["net tension [kN]"]) == ("33.00", "90.00")
    assert table.rows[5][-1] == "99.00"
    factors = dict(zip(table.head, table.rows[-1], strict=True))
    assert (factors["Fy [kN]"], factors["net tension [kN]"]) == ("6.6", "")
    assert "without impact: RSA underestimates Fy by 20.0 %; of that rigid part of" in table.note
    assert "Net tension at the anchor: yes:" in table.note


def test_a_device_whose_weight_is_not_known(tmp_path: Path) -> None:
    table = forces(tmp_path, pulls=(np.nan, np.nan))
    assert {row[-1] for row in table.rows[:-1]} == {"not known"}
    assert "Net tension at the anchor:" not in table.note

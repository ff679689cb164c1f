"""The frequency of the stick beside that of the 3D model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.transient.checks import stick_against_model
from impactfem.system.files import write_netcdf

Checked = Callable[..., list[Check]]


@pytest.fixture
def checked(tmp_path: Path) -> Checked:
    """The check of a stick with this frequency along y beside a 3D model of 2 Hz."""

    def check(frequency: float, direction: str = "y") -> list[Check]:
        # Mode 1 of the 3D model twists and moves a twentieth of the mass along y.
        building = xr.Dataset(
            {
                "frequency": ("mode", np.array([1.5, 2.0, 3.0, 7.0])),
                "effective_mass": (
                    ("mode", "direction"),
                    np.array([[0.0, 5.0], [0.0, 70.0], [80.0, 0.0], [0.0, 15.0]]),
                ),
            },
            coords={"direction": ["x", "y"]},
            attrs={"building": "wing"},
        )
        # The tower, which has one mode fewer, stands before the wing.
        sticks = xr.Dataset(
            {
                "building": ("building", ["tower", "wing"]),
                "mode_frequency": (
                    ("building", "mode"),
                    np.array([[9.0, 9.5, np.nan], [frequency, 3.0, 5.0 * frequency]]),
                ),
                "mode_effective_mass": (
                    ("building", "mode_direction", "mode"),
                    np.array(
                        [
                            [[90.0, 0.0, np.nan], [0.0, 90.0, np.nan]],
                            [[0.0, 80.0, 0.0], [75.0, 0.0, 20.0]],
                        ]
                    ),
                ),
                "mode_direction": ("mode_direction", ["x", "y"]),
            },
            attrs={"shown_direction": direction},
        )
        write_netcdf(tmp_path / "building.nc", building)
        write_netcdf(tmp_path / "pounding.nc", sticks)
        return stick_against_model(tmp_path)

    return check


@pytest.mark.parametrize(("frequency", "off"), [(2.1, "+5 %"), (1.62, "-19 %"), (2.38, "+19 %")])
def test_near_enough(checked: Checked, frequency: float, off: str) -> None:
    ((good, text),) = checked(frequency)
    assert good is True
    assert text == (
        f"transient: the stick of wing sways along y at {frequency:.3g} Hz, its 3D model at 2 Hz: "
        f"{off}, 20 % allowed"
    )


@pytest.mark.parametrize("frequency", [5.66, 2.42, 1.41])
def test_another_building(checked: Checked, frequency: float) -> None:
    ((good, text),) = checked(frequency)
    assert good is False
    assert f"at {frequency:.3g} Hz, its 3D model at 2 Hz" in text and "from_structure" in text


def test_along_the_direction_that_is_shown(checked: Checked) -> None:
    ((good, text),) = checked(5.66, "x")
    assert good is True and "along x at 3 Hz, its 3D model at 3 Hz: +0 %" in text
    assert checked(5.66, "z") == []

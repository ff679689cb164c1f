"""The checks of the stage `device` in words."""

import logging

import numpy as np
import pytest
import xarray as xr

from impactfem.files import write_netcdf
from impactfem.results.check import log_checks
from impactfem.results.device_checks import device_checks

from .device_store import WantedDevice, device_folder, device_store

LINES = [
    "device: Fy of pump on the floor: 10 kN without impact, 66 kN with impacts",
    "device: does pounding lower the difference: yes, the difference falls: RSA is 35.0 % too low "
    "without impact, RSA is 5.0 % too low with impacts, where the force is 6.6 times as large",
    "device: without impact: rotations raise RSA by 49.2 %, 91 % of what it lacks; RSA is 3.0 % "
    "too low with them; with impacts: rotations raise RSA by 1.05 %, 20 % of what it lacks; RSA "
    "is 4.0 % too low with them",
    "device: pump is anchored to 5 nodes of floor 3, at least 3 asked",
    "device: action and reaction at the anchor of pump within 1.0e-12, 1e-08 asked",
    "device: transfer functions of the reduced basis of 250 vectors within 0.2 %, 0.5 % asked",
    "device: damping own: the restitution of the contact laws; largest impact force 120 MN",
    "device: damping under-damped: ε = 0.89, calibrated; largest impact force 120 MN",
    "device: damping damped: ε = 0.67, calibrated; largest impact force 120 MN",
    "device: damping over-damped: ε = 0.41, calibrated; largest impact force 120 MN",
]


def logged(folder, caplog):
    with caplog.at_level(logging.INFO, "impactfem"):
        log_checks(device_checks(folder))
    return [(record.levelname, record.getMessage()) for record in caplog.records]


def warned(found):
    return [text for level, text in found if level == "WARNING"]


def test_all_is_well(tmp_path, caplog):
    assert logged(device_folder(tmp_path), caplog) == [("INFO", line) for line in LINES]


def test_what_has_no_limit_is_neither_met_nor_missed(tmp_path):
    found = device_checks(device_folder(tmp_path))
    assert [text for good, text in found if good is None] == [*LINES[:3], *LINES[6:]]
    assert [text for good, text in found if good] == LINES[3:6]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            {"imbalance": 1e-7},
            "action and reaction at the anchor of pump within 1.0e-07, 1e-08 asked; with the "
            "damping own without impact",
        ),
        (
            {"scalars": {"basis_error": 0.02}},
            "transfer functions of the reduced basis of 250 vectors within 2 %, 0.5 % asked",
        ),
        (
            {"nodes": 1},
            "pump is anchored to 1 node of floor 3, at least 3 asked, which spread it over the "
            "slab: refine the mesh around its anchor",
        ),
    ],
)
def test_a_number_that_fails_is_a_warning(tmp_path, caplog, change, line):
    found = logged(device_folder(tmp_path, **change), caplog)
    assert warned(found) == [f"warning: device: {line}"]
    assert len(found) == len(LINES)


def test_the_load_of_the_largest_imbalance(tmp_path, caplog):
    store = device_store(WantedDevice())
    store["imbalance"][2, 1, 0] = 1e-5
    write_netcdf(tmp_path / "device.nc", store)
    (text,) = warned(logged(tmp_path, caplog))
    assert text.endswith("within 1.0e-05, 1e-08 asked; with the damping damped with impacts")


def test_a_base_without_a_free_spring(tmp_path, caplog):
    found = logged(device_folder(tmp_path, imbalance=np.nan), caplog)
    text = "device: pump has no free spring, its base forces cannot be compared"
    assert found[4] == ("INFO", text)
    assert (None, text) in device_checks(tmp_path)


def test_no_impact(tmp_path, caplog):
    found = logged(device_folder(tmp_path, impact_force=0.0, dampings=2), caplog)
    assert warned(found) == [
        "warning: device: damping own: the restitution of the contact laws; no impact happens, "
        "both loads are the same",
        "warning: device: damping under-damped: ε = 0.89, calibrated; no impact happens, both "
        "loads are the same",
    ]


def test_a_given_restitution(tmp_path, caplog):
    store = device_store(WantedDevice())
    store["epsilon_calibrated"] = xr.zeros_like(store["epsilon_calibrated"])
    write_netcdf(tmp_path / "device.nc", store)
    assert ("INFO", LINES[7].replace("calibrated", "given")) in logged(tmp_path, caplog)


def test_what_the_analyses_assumed(tmp_path, caplog):
    found = logged(device_folder(tmp_path, notes="pump: one\npump: two"), caplog)
    assert found[len(LINES) :] == [("INFO", "device: pump: one"), ("INFO", "device: pump: two")]


def test_several_devices_without_rotations(tmp_path, caplog):
    wanted = {"devices": ("pump", "fan"), "choices": {"srss": (0.65, 0.95)}}
    found = [text for _, text in logged(device_folder(tmp_path, **wanted), caplog)]
    assert any(text.startswith("device: Fy of fan on the floor: 20 kN") for text in found)
    assert not any("rotations" in text for text in found)

"""The checks of the stage `device`: id, value, limits."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.device.stage import device_checks
from impactfem.system.files import write_netcdf

from .device_store import WantedDevice, device_folder, device_store

IDS = [
    "device.force",
    *["device.rsa_error"] * 2,
    "device.anchor_nodes",
    "device.net_tension",
    "device.imbalance",
    "device.basis_error",
    *["device.impact_force"] * 4,
]
VALUES = [5.0, -21.0, 1e-12, 0.002, 120.0, 120.0, 120.0, 120.0]


def test_all_is_well(tmp_path):
    """Force and errors of response spectrum analysis have no limit."""
    checks = device_checks(device_folder(tmp_path))
    assert [check.id for check in checks] == IDS
    assert [check.passed for check in checks] == [None] * 3 + [True] * 8
    known = [check.value for check in checks[3:]]
    assert known[0] == 5.0 and known[1] <= 0.0
    assert known[2:] == pytest.approx(VALUES[2:])
    assert "66 kN with impacts" in checks[0].detail
    assert "ε = 0.89, calibrated" in checks[8].detail
    # The detailed force is 10 and 66 kN, and the spectra find 65 and 95 %.
    assert [check.value for check in checks[1:3]] == pytest.approx([0.35, 0.05])


def changed(**variables):
    """A store with other values: of the third damping, with impacts."""
    store = device_store(WantedDevice())
    for name, value in variables.items():
        store[name][2, 1, 0, ...] = value
    return store


@pytest.mark.parametrize(
    ("wanted", "name", "value", "places"),
    [
        ({"imbalance": 1e-7}, "imbalance", 1e-7, ["pump, damping own, without impact"]),
        (changed(imbalance=1e-5), "imbalance", 1e-5, ["pump, damping damped, with impacts"]),
        ({"basis_error": 0.02}, "basis_error", 0.02, ["250 vectors"]),
        ({"nodes": 1}, "anchor_nodes", 1.0, ["pump on floor 3"]),
        (
            {"impact_force": 0.0, "dampings": 2},
            "impact_force",
            0.0,
            ["damping own", "damping under-damped"],
        ),
        ({"pulls": (5e3, 90e3)}, "net_tension", 90.0, ["pump"]),
        # The rocking of one of the dampings is enough.
        (changed(net_tension=1.0), "net_tension", 1e-3, ["pump"]),
    ],
)
def test_a_number_that_fails(tmp_path, wanted, name, value, places):
    store = wanted if isinstance(wanted, xr.Dataset) else device_store(WantedDevice(**wanted))
    write_netcdf(tmp_path / "device.nc", store)
    checks = device_checks(tmp_path)
    failed = [check for check in checks if check.passed is False]
    assert [check.place for check in failed] == places
    assert {check.id for check in failed} == {f"device.{name}"}
    assert [check.value for check in failed] == pytest.approx([value] * len(failed))
    assert len(checks) == len(IDS) - 4 + store.sizes["case"]


@pytest.mark.parametrize(
    ("wanted", "name", "text"),
    [
        ({"imbalance": np.nan}, "imbalance", "no free spring"),
        ({"pulls": (np.nan, np.nan)}, "net_tension", "weight of the device is not known"),
        ({"notes": ("pump: one", "pump: two")}, "assumption", "pump: two"),
        ({"devices": ("pump", "fan")}, "force", "20 kN without impact, 132 kN with"),
    ],
)
def test_for_information(tmp_path, wanted, name, text):
    checks = device_checks(device_folder(tmp_path, **wanted))
    found = [c.detail for c in checks if c.passed is None and c.id == f"device.{name}"]
    assert any(text in detail for detail in found)


def test_a_given_restitution(tmp_path):
    store = device_store(WantedDevice())
    store["epsilon_calibrated"] = xr.zeros_like(store["epsilon_calibrated"])
    write_netcdf(tmp_path / "device.nc", store)
    assert any("ε = 0.89, given" in check.detail for check in device_checks(tmp_path))

"""The checks of the stage `device`: id, value, limits."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.device.stage import device_checks
from impactfem.system.files import write_netcdf

from .device_store import WantedDevice, device_folder, device_store

IDS = [
    "device.force",
    *["device.rsa_error"] * 3,
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
    assert [check.passed for check in checks] == [None] * 4 + [True] * 8
    known = [check.value for check in checks[4:]]
    assert known[0] == 5.0 and known[1] <= 0.0
    assert known[2:] == pytest.approx(VALUES[2:])
    assert "10 kN without impact, 66 kN with impacts" in checks[0].detail
    assert "ε = 0.89, calibrated" in checks[9].detail


def changed(**variables):
    """A store with other values: of the third damping, with impacts."""
    store = device_store(WantedDevice())
    for name, value in variables.items():
        store[name][2, 1, 0] = value
    return store


@pytest.mark.parametrize(
    ("wanted", "name", "value", "places"),
    [
        ({"imbalance": 1e-7}, "imbalance", 1e-7, ["pump, damping own, without impact"]),
        (changed(imbalance=1e-5), "imbalance", 1e-5, ["pump, damping damped, with impacts"]),
        ({"scalars": {"basis_error": 0.02}}, "basis_error", 0.02, ["250 vectors"]),
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


def test_without_rotations(tmp_path):
    checks = device_checks(device_folder(tmp_path, choices={"srss": (0.65, 0.95)}))
    assert not any("rotations" in check.detail for check in checks)


def following(tmp_path, ratios, shares, summed=None):
    """What is said without impact of modes with these pseudo-accelerations over the ZPA."""
    store = device_store(WantedDevice(dampings=1, choices=shares))
    zpa = float(np.abs(store["anchor_acceleration"][0, 0, 0, 1]).max())
    store["mode_psa"][0, 0, 0, 1, 1:4:2] = zpa * np.array(ratios)
    if summed is not None:  # of the detailed force, by the masses
        F = (store["mode_psa"][0, 0, 0, 1, 1:4:2] * store["effective_mass"][0, 1, 1:4:2]).sum()
        store["effective_mass"][0, 1] *= summed * float(store["largest_force"][0, 0, 0, 1]) / F
    # The peak of the floor's spectrum, at 40 Hz, goes below the first mode.
    store["psa"][0, 0, 0, 1] = np.geomspace(2.0, 1.0, store.sizes["frequency"])
    write_netcdf(tmp_path / "device.nc", store)
    return next(c.detail for c in device_checks(tmp_path) if "without impact: RSA" in c.detail)


RIGID = {"srss": (0.82, 0.9), "srss.gupta": (0.99, 0.9), "srss.lindley-yow": (1.0, 0.91)}


def test_modes_that_follow_the_floor_explain_what_is_lacking(tmp_path):
    text = following(tmp_path, (1.05, 1.0), {**RIGID, "srss.rotations": (0.821, 0.9)})
    assert text.startswith(
        "without impact: RSA underestimates Fy by 18.0 %; of that rigid part of the "
        "modes (Gupta) 94 %, rigid part of the modes (Lindley-Yow) 100 %, rotations of the floor "
        "0.56 %; "
    )
    assert "1.05 at 30.5 Hz, 1.00 at 82.9 Hz: they follow the floor, and their forces" in text
    assert text.endswith(
        "most of it comes from what of the modes follows the floor in step and is "
        "combined as if it did not"
    )


@pytest.mark.parametrize(
    ("summed", "end"),
    [
        (1.0, "comes from what of the modes follows the floor in step and is combined as if it"),
        (0.9, "none of these explains it: 17.9 % of the force is left"),
    ],
)
def test_the_sum_with_signs_explains_without_a_rigid_part(tmp_path, summed, end):
    """Where no rigid method was asked for; a sum that is itself too small explains nothing."""
    ratios = (1.05, 1.0)
    shares = {"srss": (0.82, 0.9), "srss.rotations": (0.821, 0.9)}
    text = following(tmp_path, ratios, shares, summed)
    assert "they follow the floor" in text and end in text


def test_modes_that_do_not_follow_are_not_said_to(tmp_path):
    """The words come from the numbers: the same store with an amplified mode says the contrary."""
    shares = {**RIGID, "srss.gupta": (0.83, 0.9), "srss.lindley-yow": (0.81, 0.9)}
    text = following(tmp_path, (0.8, 3.3), shares)
    assert "(Gupta) 5.6 %, rigid part of the modes (Lindley-Yow) -5.6 %" in text
    assert "not all of them follow the floor" in text
    assert text.endswith("none of these explains it: 17.0 % of the force is left")


def test_a_method_that_was_not_done_is_left_out(tmp_path):
    text = following(tmp_path, (1.0, 1.0), {**RIGID, "srss.gupta": (np.nan, np.nan)})
    assert "Gupta" not in text and "(Lindley-Yow) 100 %" in text

"""The checks of the stage `device` in words."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.device.stage import device_checks
from impactfem.system.files import write_netcdf

from .device_store import WantedDevice, device_folder, device_store

LINES = [
    "device: Fy of pump on the floor: 10 kN without impact, 66 kN with impacts",
    "device: pump: without impact: RSA underestimates Fy by 35.0 %; of that rotations of the "
    "floor 91 %; pseudo-acceleration of the modes over the floor's ZPA: 2.00 at 30.5 Hz, 4.00 at "
    "82.9 Hz: not all of them follow the floor; so most of it comes from rotations of the floor",
    "device: pump: with impacts: RSA underestimates Fy by 5.0 %; of that rotations of the "
    "floor 20 %; pseudo-acceleration of the modes over the floor's ZPA: 3.03 at 30.5 Hz, 6.06 at "
    "82.9 Hz: not all of them follow the floor; none of these explains it: 4.0 % of the force is "
    "left",
    "device: pump: RSA error of Fy: -35.0 % without impact, -5.0 % with impacts (force x 6.6): "
    "smaller with impacts",
    "device: pump on floor 3: nodes that it is anchored to 5 (at least 3)",
    "device: pump: its weight holds it down; net tension at the anchor: no: without impact none, "
    "24 kN of the weight left; with impacts none, 21 kN of the weight left (weight 15 kN, n "
    "anchors evenly on a circle of radius 0.5 m)",
    "device: pump: difference of action and reaction at the anchor 1e-12 (limit 1e-8)",
    "device: error of the reduced basis of 250 vectors 0.2 % (limit 0.5 %)",
    "device: damping own: the restitution of the contact laws; largest impact force 120 MN at the "
    "steps of the 3D model",
    "device: damping under-damped: ε = 0.89, calibrated; largest impact force 120 MN at the steps "
    "of the 3D model",
    "device: damping damped: ε = 0.67, calibrated; largest impact force 120 MN at the steps "
    "of the 3D model",
    "device: damping over-damped: ε = 0.41, calibrated; largest impact force 120 MN at the steps "
    "of the 3D model",
]


HELD = "its weight holds it down"


def test_all_is_well(tmp_path):
    """What has no limit is neither met nor missed."""
    wanted = [(True if 4 <= k < 8 else None, line) for k, line in enumerate(LINES)]
    assert device_checks(device_folder(tmp_path)) == wanted


def changed(**variables):
    """A store with other values: of the third damping, with impacts."""
    store = device_store(WantedDevice())
    for name, value in variables.items():
        store[name][2, 1, 0] = value
    return store


NO_IMPACT = "no impact happens, both loads are the same"
IMBALANCE = "pump: difference of action and reaction at the anchor"


@pytest.mark.parametrize(
    ("wanted", "lines"),
    [
        ({"imbalance": 1e-7}, [f"{IMBALANCE} 1e-7 (limit 1e-8), damping own, without impact"]),
        (changed(imbalance=1e-5), [f"{IMBALANCE} 1e-5 (limit 1e-8), damping damped, with impacts"]),
        (
            {"scalars": {"basis_error": 0.02}},
            ["error of the reduced basis of 250 vectors 2 % (limit 0.5 %)"],
        ),
        (
            {"nodes": 1},
            [
                "pump on floor 3: nodes that it is anchored to 1 (at least 3); fewer do not "
                "spread it over the slab: refine the mesh around its anchor"
            ],
        ),
        (
            {"impact_force": 0.0, "dampings": 2},
            [
                f"damping own: the restitution of the contact laws; {NO_IMPACT}",
                f"damping under-damped: ε = 0.89, calibrated; {NO_IMPACT}",
            ],
        ),
        (
            {"pulls": (5e3, 90e3)},
            [
                "pump: it needs anchors in tension; net tension at the anchor: yes: without impact "
                "5 kN/n in the most loaded one, 15 kN of the weight left; with impacts 90 kN/n in "
                "the most loaded one, all of the base lifted by 70 kN (weight 15 kN, n anchors "
                "evenly on a circle of radius 0.5 m)"
            ],
        ),
        # The rocking of one of the dampings is enough, whatever the words say of the first.
        (
            changed(net_tension=1.0),
            [LINES[5].removeprefix("device: ").replace(HELD, "it needs anchors in tension")],
        ),
    ],
)
def test_a_number_that_fails(tmp_path, wanted, lines):
    store = wanted if isinstance(wanted, xr.Dataset) else device_store(WantedDevice(**wanted))
    write_netcdf(tmp_path / "device.nc", store)
    found = device_checks(tmp_path)
    assert [text for good, text in found if good is False] == [f"device: {line}" for line in lines]
    assert len(found) == len(LINES) - 4 + store.sizes["case"]


@pytest.mark.parametrize(
    ("wanted", "line"),
    [
        ({"imbalance": np.nan}, "pump has no free spring, its base forces cannot be compared"),
        ({"pulls": (np.nan, np.nan)}, "the weight of pump is not known, nor its tension"),
        ({"notes": ("pump: one", "pump: two")}, "pump: two"),
        ({"devices": ("pump", "fan")}, "Fy of fan on the floor: 20 kN without impact, 132 kN with"),
    ],
)
def test_what_is_said_of_no_limit(tmp_path, wanted, line):
    found = device_checks(device_folder(tmp_path, **wanted))
    assert any(good is None and text.startswith(f"device: {line}") for good, text in found)


def test_a_given_restitution(tmp_path):
    store = device_store(WantedDevice())
    store["epsilon_calibrated"] = xr.zeros_like(store["epsilon_calibrated"])
    write_netcdf(tmp_path / "device.nc", store)
    assert (None, LINES[9].replace("calibrated", "given")) in device_checks(tmp_path)


def test_without_rotations(tmp_path):
    found = device_checks(device_folder(tmp_path, choices={"srss": (0.65, 0.95)}))
    assert not any("rotations" in text for _, text in found)


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
    return next(text for _, text in device_checks(tmp_path) if "without impact: RSA" in text)


RIGID = {"srss": (0.82, 0.9), "srss.gupta": (0.99, 0.9), "srss.lindley-yow": (1.0, 0.91)}


def test_modes_that_follow_the_floor_explain_what_is_lacking(tmp_path):
    text = following(tmp_path, (1.05, 1.0), {**RIGID, "srss.rotations": (0.821, 0.9)})
    assert text.startswith(
        "device: pump: without impact: RSA underestimates Fy by 18.0 %; of that rigid part of the "
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

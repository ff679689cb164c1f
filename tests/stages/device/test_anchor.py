"""Anchors: the model of the device that figures show."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case import DeviceSetup
from impactfem.case.device_tables import DeviceMode
from impactfem.device.from_case import device_of
from impactfem.device.modes import device_modes
from impactfem.stages.device.analysis import Support
from impactfem.stages.device.anchor import Anchor, anchor_of_device, mode_shapes
from impactfem.stages.device.store import filled
from impactfem.stages.results import values

SPRINGS = {"x": "1.4e8 N/m", "y": "1.2e8 N/m", "z": "rigid"}
SPRINGS |= {"rx": "3e7 N m/rad", "ry": "2.5e7 N m/rad", "rz": "rigid"}
BEAM = {"length": "0.3 m", "bending": ["8e7 N m2", "7e7 N m2"], "mass": "40 kg", "elements": 3}


def setup(**changed):
    values = {
        "name": "pump",
        "point": ["1 m", "2 m", "3 m"],
        "radius": "0.5 m",
        "modes": None,
        "mass": "1500 kg",
        "mass_height": "0.46 m",
        "shape": {"type": "cylinder", "radius": "0.5 m", "length": "1 m"},
        "stiffness": SPRINGS,
        "damping": {"ratio": "2 %", "frequencies": ["30 Hz", "80 Hz"]},
    }
    return DeviceSetup.model_validate(values | changed)


def of_modes():
    rows = [{"frequency": "20 Hz", "effective_mass": "800 kg", "direction": "y"}]
    modes = tuple(DeviceMode.model_validate(row) for row in rows)
    return setup(name="fan", modes=modes, mass=None, mass_height=None, shape=None, stiffness=None)


def variables(*setups):
    """Variables of `device.nc` of anchors with these devices."""
    plate = SimpleNamespace(point=(1.0, 2.0, 3.0), floor=1, followers=(1, 2))
    anchors = [
        anchor_of_device(Support(k, 1, one.name, several=False), one, device_of(one), plate)
        for k, one in enumerate(setups)
    ]
    columns = filled(values(Anchor, anchors))
    return {name: np.array(column, dtype=float) for name, column in columns.items()}


@pytest.mark.parametrize("beam", [None, BEAM | {"mass": "0 kg"}])
def test_shapes_carry_the_mass_of_the_body(beam):
    one = setup(beam=beam, maximum_frequency="1 MHz")
    shapes = mode_shapes(one, device_of(one))
    at_centre = shapes[:, -1]
    # φᵀ M φ = 1, with all of the mass in the body: 1500 kg and a solid cylinder's inertia.
    across = 1500.0 * (3.0 * 0.5**2 + 1.0) / 12.0
    mass = np.array([1500.0, 1500.0, 1500.0, across, across, 0.5 * 1500.0 * 0.5**2])
    assert (at_centre**2 @ mass) == pytest.approx(1.0)
    # Participation by the momentum of the body.
    participation = device_modes(device_of(one)).participation
    momentum = 1500.0 * at_centre[:, :2].T
    assert momentum == pytest.approx(participation[:2], abs=1e-6)


def test_a_body_without_a_beam_is_rigid():
    one = setup()
    shapes = mode_shapes(one, device_of(one))
    base, centre = shapes[:, 0], shapes[:, 1]
    assert base[:, 3:] == pytest.approx(centre[:, 3:])
    assert centre[:, 0] == pytest.approx(base[:, 0] + 0.46 * base[:, 4])
    assert centre[:, 1] == pytest.approx(base[:, 1] - 0.46 * base[:, 3])


def test_a_beam_bends_and_the_body_above_it_does_not():
    one = setup(beam=BEAM)
    shapes = mode_shapes(one, device_of(one))
    assert shapes.shape[1] == 5
    top, centre = shapes[:, 3], shapes[:, 4]
    assert centre[:, 0] == pytest.approx(top[:, 0] + 0.16 * top[:, 4])
    first = int(np.abs(shapes[:, -1, 0]).argmax())
    # The rotation of the beam grows from its base upwards in the first mode.
    turned = np.abs(shapes[first, :4, 4])
    assert np.all(np.diff(turned) > 0.0)


def test_variables_of_several_devices():
    found = variables(setup(beam=BEAM), setup(name="box"), of_modes())
    assert found["level_height"].shape == (3, 5)
    assert found["level_height"][0] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.46])
    assert found["level_height"][1, :2].tolist() == [0.0, 0.46]
    assert np.isnan(found["level_height"][1, 2:]).all()
    assert found["base_stiffness"][0].tolist() == [1.4e8, 1.2e8, math.inf, 3e7, 2.5e7, math.inf]
    assert found["beam_bending"][0].tolist() == [8e7, 7e7]
    assert np.isnan(found["beam_length"][1:]).all()
    assert found["body_inertia"][0].tolist() == [218.75, 218.75, 187.5]
    assert (found["body_mass"][0], found["body_radius"][0], found["body_length"][0]) == (
        1500.0,
        0.5,
        1.0,
    )
    # A device from modes has none of all this.
    shown = [name for name in found if name.partition("_")[0] in ("base", "body", "beam", "level")]
    assert len(shown) == 10 and all(np.isnan(found[name][2]).all() for name in shown)
    assert found["weight"][:2] == pytest.approx([1540.0 * 9.80665, 1500.0 * 9.80665])
    assert np.isnan(found["weight"][2])


def test_a_mass_centre_at_the_end_of_the_beam_is_one_level():
    one = setup(beam=BEAM | {"length": "0.46 m"})
    assert mode_shapes(one, device_of(one)).shape[1] == 4
    assert variables(one)["level_height"][0, -1] == pytest.approx(0.46)


def test_inertia_in_place_of_a_shape():
    found = variables(setup(shape=None, inertia=["200 kg m2", "210 kg m2", "180 kg m2"]))
    assert found["body_inertia"][0].tolist() == [200.0, 210.0, 180.0]
    assert np.isnan(found["body_radius"][0])


def test_modes_above_the_highest_frequency_are_left_out():
    every = mode_shapes(one := setup(maximum_frequency="1 MHz"), device_of(one))
    low = mode_shapes(one := setup(maximum_frequency="50 Hz"), device_of(one))
    assert (len(every), len(low)) == (4, 2)
    assert low == pytest.approx(every[:2])

from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.anchor_force import anchor_force
from impactfem.device.body import Body
from impactfem.device.from_modes import TableMode, from_modes
from impactfem.device.modes import device_modes
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError

TABLE = (
    TableMode(30.51, "y", 1218.9, 0.65),
    TableMode(82.90, "y", 327.0, -0.28, damping=0.05),
    TableMode(40.0, "z", 800.0),
)
BODY = Body.at_height(1600.0, 0.46, 300.0, 300.0, 190.0)


def test_the_table_comes_back():
    found = device_modes(from_modes("pump", TABLE, 0.02))
    assert found.frequency == pytest.approx([30.51, 40.0, 82.90])
    assert found.effective_mass[1] == pytest.approx([1218.9, 0.0, 327.0])
    assert found.effective_mass[2] == pytest.approx([0.0, 800.0, 0.0])
    assert found.height[[0, 2]] == pytest.approx([0.65, -0.28])
    assert found.damping == pytest.approx([0.02, 0.02, 0.05])
    law = Rayleigh.through(0.02, 30.0, 80.0)
    assert device_modes(from_modes("pump", TABLE, law)).damping[1] == pytest.approx(law.ratio(40.0))


def test_what_the_modes_leave_follows_rigidly():
    found = device_modes(from_modes("pump", TABLE, 0.02, BODY))
    rest = np.diag(found.rigid_mass)
    assert rest[:3] == pytest.approx([1600.0, 1600.0 - 1545.9, 800.0])
    assert np.diag(device_modes(from_modes("pump", TABLE, 0.02)).rigid_mass)[1] == pytest.approx(
        0.0
    )


def test_a_table_of_all_modes_is_the_device(pump, shaking):
    """Modes of the pump, written into a table, push the anchor as the pump does."""
    device = pump()
    modes = device_modes(device)
    rows = []
    for i in range(modes.frequency.size):
        axis = int(np.argmax(modes.share[:2, i]))
        mass = modes.effective_mass[axis, i]
        rows.append(
            TableMode(modes.frequency[i], "xy"[axis], mass, modes.height[i], modes.damping[i])
        )
    table = from_modes("table", rows, 0.02, Body.at_height(1500.0, 0.46, 220.0, 240.0, 190.0))
    motion = shaking()
    wanted = anchor_force(device, motion, 1e-3).force
    found = anchor_force(table, motion, 1e-3).force
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())


def test_more_than_the_mass_is_refused():
    """The paper: 1545.9 kg in the modes of a device of 1500 kg."""
    body = Body.at_height(1500.0, 0.46, 220.0, 240.0, 190.0)
    with pytest.raises(ImpactfemError, match=r"carry 1545.9 kg along y, more than the 1500 kg"):
        from_modes("pump", TABLE, 0.02, body)
    low = Body.at_height(1600.0, 0.0, 1.0, 1.0, 1.0)
    with pytest.raises(ImpactfemError, match="its mass is indefinite"):
        from_modes("pump", TABLE, 0.02, low)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"direction": "w"}, "direction 'w': expected one of"),
        ({"frequency": 0.0}, "frequency 0.0 Hz"),
        ({"effective_mass": -1.0}, "effective mass -1.0 kg"),
        ({"height": float("inf")}, "height inf m"),
        ({"damping": 1.0}, "expected 0 <= ratio < 1"),
    ],
)
def test_bad_rows_are_refused(change, words):
    with pytest.raises(ImpactfemError, match=words):
        from_modes("pump", [replace(TABLE[0], **change)], 0.02)


def test_an_empty_table_is_refused():
    with pytest.raises(ImpactfemError, match="its table holds no mode"):
        from_modes("pump", [], 0.02)

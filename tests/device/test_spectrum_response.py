import numpy as np
import pytest

from impactfem.device.modes import device_modes
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.system.errors import ImpactfemError

SPECTRUM = AnchorSpectrum(
    "y", np.array([1.0, 20.0, 500.0]), np.array([0.0, 0.2]), np.array(2 * [[9.0, 9.0, 4.0]]), 4.0
)


@pytest.fixture
def response(pump):
    return spectrum_analysis(pump(), [SPECTRUM])


def test_shares_add_up_to_one(response):
    share = response.inputs[0].share
    assert share[1].sum() == pytest.approx(1.0)
    # Nothing acts along x under y but round-off.
    assert response.value("force x") < 1e-9 * response.value("force y")


def test_table_of_modes(response, pump):
    columns, rows = response.mode_table("force y")
    names = [name for name, _ in columns]
    modes = device_modes(pump())
    mine = np.flatnonzero(modes.effective_mass[1] > 1.0)
    assert len(rows) == mine.size + 1 and all(len(row) == len(names) for row in rows)
    assert dict(columns)["force y"] == "N"
    for i, row in zip(mine, rows[:-1], strict=True):
        cell = dict(zip(names, row, strict=True))
        assert cell["mode"] == i + 1
        assert cell["frequency"] == pytest.approx(modes.frequency[i])
        assert cell["effective mass"] == pytest.approx(modes.effective_mass[1, i], abs=1e-6)
        # Displacement beside acceleration.
        wanted = cell["pseudo-acceleration"] / modes.omega[i] ** 2
        assert cell["displacement"] == pytest.approx(wanted)
    assert rows[-1][1] == "missing mass" and rows[-1][2] is None
    assert sum(row[-1] for row in rows) == pytest.approx(1.0)


def test_an_unknown_quantity_is_refused(response):
    with pytest.raises(ImpactfemError, match="device pump: no quantity 'weight' was computed"):
        response.value("weight")
    with pytest.raises(ImpactfemError, match="there are force x"):
        response.mode_table("weight")

import numpy as np
import pytest

from impactfem.building.shell_model import UX, UY
from impactfem.verify.waves import waves


def test_speeds_by_hand():
    """E = 33 GPa, ν = 0.2, ρ = 2500 kg/m3: the paper has 2345 m/s and 6.7 ms."""
    assert waves.SHEAR.speed == pytest.approx(2345.0, abs=0.5)
    assert waves.PLATE.speed == pytest.approx(3708.0, abs=0.5)
    assert pytest.approx(15.6) == waves.SECOND - waves.FIRST
    assert 15.6 / waves.SHEAR.speed == pytest.approx(6.7e-3, abs=0.05e-3)
    assert (waves.SHEAR.restrained, waves.PLATE.restrained) == (UX, UY)


@pytest.mark.parametrize("delay", [40.0, 55.3, 61.75])
def test_delay_of_a_pulse(delay):
    time = np.arange(200.0)
    first, second = (np.exp(-(((time - t) / 12.0) ** 2)) for t in (50.0, 50.0 + delay))
    assert waves._lag(first, 0.7 * second) == pytest.approx(delay, abs=2e-3)


def test_a_wrong_modulus_is_seen(altered, failed):
    altered(waves, E=1.01)
    assert "speed, standing plate wave, 8 elements a wavelength" in failed(waves.wave_speed_order())


def test_a_strip_with_free_long_edges_carries_other_waves(monkeypatch):
    """Stretched as a bar, √(E/ρ), 2 % slower; and bent instead of sheared."""
    monkeypatch.setattr(waves.Wave, "restrained", property(lambda self: 5))
    delay, _ = waves._pulse(waves.PLATE)
    speed = (waves.SECOND - waves.FIRST) / delay
    assert speed == pytest.approx(np.sqrt(33e9 / 2500.0), rel=0.005)
    assert abs(speed / waves.PLATE.speed - 1.0) > 0.015


def test_the_crossings_are_not_each_others():
    """A row that compared the plate wave with the paper's 6.7 ms would fail."""
    rows = {row.quantity: row for row in waves.slab_pulses()}
    normal = rows["time to cross 15.6 m, edge-normal pulse"]
    in_plane = rows["time to cross 15.6 m, in-plane shear pulse"]
    assert in_plane.reference == 6.7e-3 and "paper's crossing" in in_plane.source
    assert normal.computed < 0.65 * in_plane.reference

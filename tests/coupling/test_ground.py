import numpy as np
import pytest

from impactfem.coupling.ground import Ground, interpolate_ground


def test_interpolate_ground():
    ramp, late = np.array([0.0, 1.0, 3.0]), np.array([2.0, 2.0])
    ground = interpolate_ground([(1, 0.1, ramp), (1, 0.1, late), (2, 0.2, -ramp)], 0.05, 8)
    assert ground.shape == (8, 3) and not ground[:, 0].any()
    # Linear between samples, the two along y added, zero after each record's end.
    assert ground[:4, 1] == pytest.approx([2.0, 2.5, 3.0, 2.0])
    assert ground[5:, 1] == pytest.approx(0.0)
    assert ground[:, 2] == pytest.approx([0.0, -0.25, -0.5, -0.75, -1.0, -1.5, -2.0, -2.5])
    assert not interpolate_ground([], 0.05, 3).any()


def test_interpolate_ground_keeps_the_first_and_the_last_sample():
    """A time that rounding puts before the first or behind the last sample is that sample's."""
    before, behind = 0, 0
    for dt in (0.005, 0.01, 1.0 / 3.0, 0.3358e-3):
        for finer in (1, 3, 7, 20):
            for n in (4, 7, 31, 61):
                steps = finer * (n - 1)
                behind += dt / finer * steps > dt * (n - 1)
                samples = np.full(n, 2.5)
                ground = interpolate_ground([(0, dt, samples)], dt / finer, steps + 2)[:, 0]
                assert ground[:-1] == pytest.approx(2.5) and ground[-1] == 0.0
                for k in (3, 7):
                    delay = dt * k / finer
                    before += dt / finer * k < delay
                    late = interpolate_ground([(0, dt, samples)], dt / finer, k + 1, delay)[:, 0]
                    assert not late[:-1].any() and late[-1] == 2.5
    assert before > 0 and behind > 0
    late = interpolate_ground([(0, 0.1, np.ones(4))], 0.1 * (1 + 1e-6), 4)[:, 0]
    assert late[2] == 1.0 and late[3] == 0.0


@pytest.mark.parametrize("delay", [0.0, 0.06, 0.0371, 0.5])
def test_a_delayed_ground_is_the_integral_of_its_line(delay):
    """Straight between samples 0.1 s apart, at steps of 0.03 s, against sums of fine steps."""
    samples = np.array([0.7, 1.0, -2.0, 0.5, 1.5, -0.5])
    histories, τ = [(1, 0.1, samples), (1, 0.1, samples), (0, 0.1, -samples)], {"a": 0.02}
    ground = Ground.under(histories, 0.03, 40, {**τ, "b": 0.02 + delay, "c": 0.02})
    fine = np.arange(0.0, 1.2, 1e-5)
    a = np.interp(fine, 0.1 * np.arange(6), samples, right=0.0)
    v = np.concatenate([[0.0], np.cumsum(0.5e-5 * (a[1:] + a[:-1]))])
    u = np.concatenate([[0.0], np.cumsum(0.5e-5 * (v[1:] + v[:-1]))])
    time = 0.03 * np.arange(40)
    expected = [
        np.interp(time - 0.02 - delay, fine, x, left=0.0)
        - np.interp(time - 0.02, fine, x, left=0.0)
        for x in (u, v, a)
    ]
    assert set(ground.relative) == ({"b"} if delay else set())
    if delay:
        found = ground.relative["b"]
        assert found[:, :, 1] == pytest.approx(2.0 * np.array(expected), abs=5e-4)
        assert found[:2, :, 1] == pytest.approx(2.0 * np.array(expected[:2]), abs=2e-5)
        assert found[:, :, 0] == pytest.approx(-0.5 * found[:, :, 1]) and not found[:, :, 2].any()
        # After the end the velocity that the record leaves moves one ground away from the other.
        assert found[0, -1, 1] == pytest.approx(-2.0 * v[-1] * delay, abs=2e-5)
        along = ground.opened("b", "a", np.array([0.0, 1.0, 0.0]))
        assert along == pytest.approx(-found[:2, :, 1])
        assert not ground.opened("b", None, np.array([0.0, 1.0, 0.0])).any()

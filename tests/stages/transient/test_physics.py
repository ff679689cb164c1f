"""The numbers beside the paper's, from curves and pulses that are known."""

import math

import numpy as np
import pytest

from impactfem.coupling.force_history import around_peak
from impactfem.dynamics.damping import UNDAMPED
from impactfem.reduction.loads import project
from impactfem.stages.transient.findings import findings
from impactfem.stages.transient.physics import (
    SILENT,
    arrivals,
    crossing_time,
    far_highest_below,
    force_spectra,
    longest_above,
    power_spectrum,
)
from impactfem.stages.transient.selection import shown

F = np.geomspace(1.0, 500.0, 60)


@pytest.fixture
def numbers(stores):
    def compute(change=lambda store: None, **wanted):
        store, sticks = stores(**wanted)
        change(store)
        return findings(store, sticks, UNDAMPED)

    return compute


def test_where_the_near_one_overtakes():
    far = F**0.5
    near = far * (F / 75.0) ** 0.3
    assert far_highest_below(near, far, F) == pytest.approx(75.0)
    # What the rigid floor does at low frequencies does not count.
    wiggle = np.where(F < 5.0, 1.001 * far, near)
    assert far_highest_below(wiggle, far, F) == pytest.approx(75.0)
    assert far_highest_below(2.0 * far, far, F) is None
    assert far_highest_below(0.5 * far, far, F) == pytest.approx(500.0)


def test_the_widest_interval_above():
    first = np.ones_like(F)
    bump = np.log(F / 36.0) * np.log(F / 152.0)
    assert longest_above(first, np.exp(0.01 * bump), F) == pytest.approx((36.0, 152.0), rel=2e-3)
    assert longest_above(first, 2.0 * first, F) is None
    assert longest_above(2.0 * first, first, F) == pytest.approx((1.0, 500.0))
    two = np.where((F > 2.0) & (F < 4.0) | (F > 100.0) & (F < 110.0), 0.5, 2.0)
    low, high = longest_above(first, two, F)
    assert 1.5 < low < 2.2 and 3.6 < high < 4.5


def test_spread(numbers):
    def changed(store):
        store["sd"][:] = 0.02
        on_line = (store["probe_kind"] == "line").values
        store["sd"][:, on_line, :, 0] = np.linspace(0.10, 0.11, on_line.sum())[None, :, None]

    found = numbers(changed)
    assert found["displacement_spread"] == pytest.approx(0.01 / 0.11)
    # The probes beside the line have 0.02 m there.
    floor = found["displacement_spread_floor"]
    assert floor == pytest.approx(0.09 / 0.11)


def travelling(speed, distance, time, lasts=0.012, before=0.0):
    """A smooth pulse that pushes along −1 and travels without a change."""
    phase = (time - 0.5 - distance[:, None] / speed) / lasts
    return before - 40.0 * np.where((phase > 0) & (phase < 1), np.sin(np.pi * phase) ** 2, 0.0)


@pytest.mark.parametrize("speed", [1972.0, 3785.0])
def test_crossing_of_a_travelling_pulse(speed):
    time, distance = 1e-3 * np.arange(2000), np.linspace(0.0, 15.6, 9)
    impact = (0.5, 0.512)
    found = arrivals(time, travelling(speed, distance, time, before=3.0), -1.0, impact)
    finer = 1e-5 * np.arange(100_000)
    exact = arrivals(finer, travelling(speed, distance, finer, before=3.0), -1.0, impact)
    for name in ("peak", "half"):
        sampled, known = getattr(found, name), getattr(exact, name)
        assert crossing_time(distance, sampled) == pytest.approx(15.6 / speed, rel=0.005)
        assert crossing_time(distance, known) == pytest.approx(15.6 / speed, rel=1e-4)
    # sin² has its peak in the middle, and half of it at a quarter.
    assert exact.peak[0] == pytest.approx(0.506, abs=1e-6)
    assert exact.half[0] == pytest.approx(0.503, abs=1e-6)


def test_a_precursor_is_not_the_wave():
    """A tenth of the wave runs ahead twice as fast: the foot takes its speed for the wave's."""
    time, distance, c = 1e-3 * np.arange(2000), np.linspace(0.0, 15.6, 9), 1972.0
    both = travelling(c, distance, time) + 0.2 * travelling(3.0 * c, distance, time)
    found = arrivals(time, both, -1.0, (0.5, 0.512))
    assert crossing_time(distance, found.peak) == pytest.approx(15.6 / c, rel=0.05)
    # The measure that was in use before: when a tenth of the peak is reached.
    pushed = both[:, :1] - both
    foot = time[np.argmax(pushed >= 0.1 * pushed.max(axis=1, keepdims=True), axis=1)]
    fast = crossing_time(distance, foot)
    assert fast is not None and fast < 0.8 * 15.6 / c


def test_a_reflection_is_not_the_wave():
    """Without damping the wave and what comes back from the far edge add up to twice as much."""
    time, distance, c = 1e-4 * np.arange(20_000), np.linspace(0.0, 15.6, 9), 1972.0
    both = travelling(c, distance, time) + travelling(c, 31.2 - distance, time)
    found = arrivals(time, both, -1.0, (0.5, 0.512), 15.6 / c)
    assert found.peak[-1] - found.peak[0] == pytest.approx(15.6 / c, rel=1e-3)
    # Where both are one, near the far edge, the peak stands still, and the slope is less steep.
    assert crossing_time(distance, found.peak) == pytest.approx(15.6 / c, rel=0.2)
    # In a longer window the largest value of a point is no arrival.
    largest = time[np.argmax(-both, axis=1)]
    assert largest[4] > largest[5] > found.peak[4]


def test_a_slab_that_takes_longer_to_cross_than_the_impact():
    time, distance = 1e-3 * np.arange(2000), np.linspace(0.0, 60.0, 9)
    histories = travelling(1000.0, distance, time, 0.006)
    short = arrivals(time, histories, -1.0, (0.5, 0.506))
    assert np.isnan(short.peak[-1])
    whole = arrivals(time, histories, -1.0, (0.5, 0.506), crossing=0.055)
    assert crossing_time(distance, whole.peak) == pytest.approx(0.06, rel=0.005)


def test_no_crossing():
    time, distance = 1e-3 * np.arange(2000), np.linspace(0.0, 15.6, 9)
    impact = (0.5, 0.512)
    still = arrivals(time, np.full((9, 2000), 3.0), -1.0, impact)
    assert np.isnan(still.peak).all() and np.isnan(still.half).all()
    assert crossing_time(distance, still.peak) is None
    together = arrivals(time, travelling(1e9, distance, time), -1.0, impact).peak
    assert crossing_time(distance, np.full(9, together[0])) is None
    backwards = arrivals(time, travelling(2000.0, distance[::-1], time), -1.0, impact).peak
    assert crossing_time(distance, backwards) is None
    one = np.where(np.arange(9) == 4, 0.5, math.nan)
    assert crossing_time(distance, one) is None


@pytest.mark.parametrize(("factor", "ratio"), [(1.0, 4.0), (0.2, 100.0), (0.0, None)])
def test_ratio_of_forces(numbers, factor, ratio):
    """The upper force has twice the lower one's amplitude, which has a factor here."""

    def changed(store):
        store["impact_force"][:, 0] *= factor

    found = numbers(changed).get("psd_ratio")
    assert found is None if ratio is None else found == pytest.approx(ratio, rel=1e-6)


def test_densities_do_not_depend_on_the_ringing_of_resampled_forces():
    """Of one pulse at two steps, with the alternating samples around it: the same impulse and T."""
    time = 1e-4 * np.arange(4001)
    inside = (time > 0.2) & (time < 0.218)
    pulse = np.where(inside, 1e6 * np.sin(np.pi * (time - 0.2) / 0.018) ** 2, 0.0)[:, None]
    found = []
    for step in (0.5e-3, 2e-3):
        force = project(time, pulse, step, round(0.4 / step))
        assert (force < -1.0).any()  # they ring
        found.append(force_spectra(force, step))
    fine, coarse = found
    assert fine.duration == pytest.approx(0.018, abs=2.1e-3) == coarse.duration
    low = [one.density[0, np.searchsorted(one.frequency, 5.0)] for one in found]
    T = coarse.duration / fine.duration
    assert low[1] * T == pytest.approx(low[0], rel=0.02)


def test_of_a_store(numbers):
    found = numbers()
    for name in ("wave_crossing", "wave_crossing_half", "wave_far_edge"):
        assert found[name] == pytest.approx(6.0 / 2000.0, rel=0.03), name
    assert found["measured_wave_speed"] == pytest.approx(2000.0, rel=0.03)
    assert np.isnan(found["wave_reversal"])  # a half sine without a reflection
    # The store's spectra grow from one probe to the next, and peak near 60 Hz.
    assert found["far_highest_below"] == pytest.approx(422.0, rel=0.02)
    assert found["near_highest_at"] == pytest.approx(60.0, rel=0.1)
    assert (found["exceeding_floor"], found["exceeded_floor"]) == (2, 3)
    assert np.isnan(found["exceeds_from"])
    # 20.1 m/s2 near 20 Hz for the sticks; 45.1 m/s2 near 60 Hz.
    assert found["peak_over_sticks"] == pytest.approx(45.1 / 20.1, rel=0.03)
    assert found["peak_frequency_over_sticks"] == pytest.approx(3.0, rel=0.2)
    assert not any("over_sticks" in name for name in numbers(model="structure"))
    assert found["transfer_floor"] == [2, 3]
    # 1 + ln(f / 0.5), up to the highest frequency below 450 Hz of the store.
    largest = 1e-6 * (1.0 + math.log(434.0 / 0.5))
    assert found["transfer_peak"] == pytest.approx([largest, largest], rel=0.01)
    assert found["edges_over_inside"] == pytest.approx(1.0, abs=0.02)
    assert (found["largest_psa_floor"], found["resolved_frequency"]) == (3, 100.0)


def test_missing_findings(numbers):
    free = numbers(loads=())
    assert not {n for n in free if "wave" in n or "psd" in n or "transfer" in n}
    assert "near_highest_at" in free
    full = numbers(solver="full", loads=(3,))
    assert not {n for n in full if "psd" in n or "transfer" in n}
    assert "wave_crossing" in full
    one = numbers(floors=(1,), loads=(1,))
    assert not {n for n in one if "exceed" in n or "psd" in n}
    assert numbers(direction="x")["wave_crossing"] == pytest.approx(6.0 / 2000.0, rel=0.03)


DT = 1e-4


def half_sine(time, force, lasts):
    return np.where((time >= 0) & (time <= lasts), force * np.sin(np.pi * time / lasts), 0.0)


def half_sine_density(frequency, force, lasts, duration):
    """2 |F(f)|² / T; the Fourier transform of half a sine in closed form."""
    x = 2.0 * frequency * lasts
    shape = np.cos(0.5 * np.pi * x) / (1.0 - x**2)
    return 2.0 * (force * 2.0 * lasts / np.pi * shape) ** 2 / duration


def test_power_of_a_sine():
    time = DT * np.arange(100_000)
    frequency, density = power_spectrum(3.0 * np.sin(2.0 * np.pi * 40.0 * time), DT)
    assert frequency[np.argmax(density)] == pytest.approx(40.0)
    # The integral of the density is the mean square.
    assert density.sum() * frequency[1] == pytest.approx(4.5, rel=1e-3)


def test_a_record_shorter_than_a_segment():
    frequency, density = power_spectrum(np.ones(50), 0.01)
    assert len(frequency) == len(density) == 26


def test_density_of_an_impact():
    time = DT * np.arange(20_000)
    force = np.stack([half_sine(time - 0.3, 5e6, 0.013), half_sine(time - 1.1, 1e6, 0.008)], axis=1)
    spectra = force_spectra(force, DT)
    # The density at 0 Hz has no other side.
    low = (spectra.frequency > 0.0) & (spectra.frequency < 60.0)
    for k, (peak, lasts) in enumerate(((5e6, 0.013), (1e6, 0.008))):
        exact = half_sine_density(spectra.frequency[low], peak, lasts, spectra.duration)
        assert spectra.density[k, low] == pytest.approx(exact, rel=2e-3)
    assert spectra.duration == pytest.approx(0.013, abs=2 * DT)
    # Parseval: the mean power over the duration.
    total = spectra.density.sum(axis=1) * spectra.frequency[1]
    assert total == pytest.approx((force**2).sum(axis=0) * DT / spectra.duration, rel=1e-6)


def test_only_the_main_impact_counts():
    time = DT * np.arange(20_000)
    alone = half_sine(time - 0.3, 5e6, 0.013)
    more = alone + half_sine(time - 1.1, 4e6, 0.013)
    larger = alone + half_sine(time - 1.1, 6e6, 0.013)
    of = [force_spectra(f[:, None], DT).density[0, 0] for f in (alone, more, larger)]
    assert of[1] == pytest.approx(of[0]) and of[2] == pytest.approx(1.44 * of[0], rel=1e-3)


def test_tension_at_the_end_of_an_impact_belongs_to_it():
    force = np.array([0.0, 2.0, 0.0, 1.0, 5.0, 3.0, -1.0, 0.0, 4.0])
    spectra = force_spectra(force[:, None], DT)
    assert spectra.duration == pytest.approx(3 * DT)
    # At 0 Hz the density is that of the sum of the samples, with no other side.
    assert spectra.density[0, 0] == pytest.approx(8.0**2 * DT / 3)


def test_the_power_of_the_main_impacts(stores):
    """Parseval: the densities add up to the mean square over the same time."""
    given = shown(stores()[0])
    loads = given["edge_force"].transpose("edge", "time").values
    spectra = force_spectra(loads.T, float(given["time"][1] - given["time"][0]))
    ends = [around_peak(np.abs(load), SILENT) for load in loads]
    longest = max(last - first for first, last in ends)
    for density, load, (first, last) in zip(spectra.density, loads, ends, strict=True):
        power = np.sum(load[first:last] ** 2) / longest
        assert power > 0.0
        assert np.sum(density) * spectra.frequency[1] == pytest.approx(power, rel=1e-9)

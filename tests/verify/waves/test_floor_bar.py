"""A floor as a bar: the rows, which test_manual has pass, fail for another bar or measure."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.transient.physics import arrivals, crossing_time
from impactfem.verify.row import Rows
from impactfem.verify.waves import floor_bar as benchmark
from impactfem.verify.waves.bar import Bar, EdgeWall


@pytest.fixture(scope="module")
def strip():
    from impactfem.building.floor import floor_bar

    parts = benchmark._strip(beams=False)
    return parts, floor_bar(parts, 1, 1)


def failed(write, *arguments):
    """Quantities that do not pass of the rows that a part of the benchmark writes."""
    rows = Rows("")
    write(rows, *arguments)
    assert rows
    return {row.quantity for row in rows if not row.passed}


def test_rows_by_hand_and_of_the_solver(strip):
    from impactfem.building.floor import floor_bar

    with_beams = floor_bar(benchmark._strip(beams=True), 1, 1)
    assert not failed(benchmark._by_hand, with_beams)
    assert not failed(benchmark._solver_rows)
    # Without its beams, or without what it carries, it is another bar.
    assert len(failed(benchmark._by_hand, strip[1])) == 2


def test_pulse(strip):
    parts, bar = strip
    bare = replace(bar, slab_mass=bar.slab_mass / 4.0)
    assert len(failed(benchmark._pulse_rows, parts, bare)) == 5


def test_wall(strip):
    parts, bar = strip
    stiff = replace(bar, stiffness=2.0 * bar.stiffness)
    assert {"time at the wall, damped", "time at the wall, hardly damped"} <= failed(
        benchmark._wall_rows, parts, stiff
    )


def paper_bar():
    return Bar(15.6, 623.7e9, 2652.75e3, (180.6e3, 180.6e3), Rayleigh(0.8378, 1.061e-3))


def test_the_foot_of_a_damped_wave_is_not_the_wave():
    """Floor 8 as a bar under its impact: a tenth of the peak runs ahead of the peak, by far."""
    bar = paper_bar()
    time = 1e-3 * np.arange(200)
    force = np.where((time > 0.05) & (time < 0.062), np.sin(np.pi * (time - 0.05) / 0.012), 0.0)
    distance = np.linspace(0.0, 15.6, 9)
    line = benchmark._at(bar, bar.pushed(1.2e8 * force, 1e-3, 20), distance)
    speed = np.sqrt(623.7e9 / (bar.mass / 15.6))
    found = crossing_time(distance, arrivals(time, line, 1.0, (0.05, 0.062), 15.6 / speed).peak)
    assert found == pytest.approx(15.6 / speed, rel=0.15)
    fine = np.linspace(0.0, 0.199, 20_000)
    pushed = np.array([np.interp(fine, time, one) for one in line])
    feet = fine[np.argmax(pushed >= 0.1 * pushed.max(axis=1, keepdims=True), axis=1)]
    foot = crossing_time(distance, feet)
    assert foot is not None and foot < 0.6 * 15.6 / speed


def test_a_wall_below_an_end_has_its_own_frequency():
    """Clamped below, free to turn at an end that does not move: 3.927² / (2π h²) √(EI/m)."""
    wall = EdgeWall(4.8, 17.3e9, 319e3)
    held = Bar(15.6, 1e14, 1e3, (1e12, 1e12), wall=wall)
    known = 3.9266**2 / (2.0 * np.pi * 4.8**2) * np.sqrt(17.3e9 / (319e3 / 4.8))
    assert held.frequencies(4)[2:] == pytest.approx([known, known], rel=1e-3)


@pytest.mark.parametrize(
    ("damping", "epsilon"),
    [
        (Rayleigh(0.838, 2.12e-4), 0.770),
        (Rayleigh(0.838, 1.06e-3), 0.575),
        (Rayleigh(0.559, 3.18e-3), 0.352),
    ],
)
def test_the_bar_of_the_page_at_the_wall(damping, epsilon):
    """The numbers of docs/floor-as-a-bar.md; they hardly depend on the step."""
    bar = Bar(15.6, 623.7e9, 2652.75e3, (180.6e3, 180.6e3), damping)
    for step in (0.34e-3 / 8.0, 0.34e-3 / 16.0):
        impulse, lasts = bar.against_wall(0.168, step)
        assert impulse / (bar.mass * 0.168) - 1.0 == pytest.approx(epsilon, abs=0.012)
        assert 14e-3 < lasts < 18e-3

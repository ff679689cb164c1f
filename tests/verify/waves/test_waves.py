"""Waves: rows that test_manual has pass fail for another bar, damping, load or energy."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import response
from impactfem.stages.transient.physics import arrivals, crossing_time
from impactfem.system.files import in_source_tree
from impactfem.verify.row import Rows
from impactfem.verify.waves import MovingModel, forced, in_time, paper, peak
from impactfem.verify.waves import floor_bar as benchmark
from impactfem.verify.waves.bar import Bar, EdgeWall
from impactfem.verify.waves.forced import DAMPED


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
    assert not failed(benchmark._bar_rows, with_beams)
    # Without its beams it is another bar.
    assert len(failed(benchmark._bar_rows, strip[1])) == 2


def test_pulse(strip):
    parts, bar = strip
    bare = replace(bar, slab_mass=bar.slab_mass / 4.0)
    assert len(failed(benchmark._pulse_rows, parts, bare)) == 5


def test_wall(strip):
    parts, bar = strip
    stiff = replace(bar, stiffness=2.0 * bar.stiffness)
    seen = {f"time at the wall, {label}" for label in ("damped", "hardly damped")}
    assert seen <= failed(benchmark._wall_rows, parts, stiff)


FLOOR_8 = 15.6, 623.7e9, 2652.75e3, (180.6e3, 180.6e3)


def test_the_foot_of_a_damped_wave_is_not_the_wave():
    """Floor 8 as a bar under its impact: a tenth of the peak runs ahead of the peak, by far."""
    bar = Bar(*FLOOR_8, Rayleigh(0.8378, 1.061e-3))
    time = 1e-3 * np.arange(200)
    force = np.where((time > 0.05) & (time < 0.062), np.sin(np.pi * (time - 0.05) / 0.012), 0.0)
    distance = np.linspace(0.0, 15.6, 9)
    line = bar.pushed(1.2e8 * force, 1e-3, distance)
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
    bar = Bar(*FLOOR_8, damping)
    for step in (0.34e-3 / 8.0, 0.34e-3 / 16.0):
        impulse, lasts = bar.against_wall(0.168, step)
        assert impulse / (bar.mass * 0.168) - 1.0 == pytest.approx(epsilon, abs=0.012)
        assert 14e-3 < lasts < 18e-3


def test_another_damping_is_seen(scaled, failed):
    scaled(forced, "response", "ratio", 1.001)
    found = failed(forced.modal_equation())
    pulse = "largest difference over the peak, an oscillating pulse, "
    assert found == {pulse + name for name in DAMPED if name != "undamped"}


def test_a_wrong_damping_of_the_strip_is_seen(monkeypatch, failed):
    monkeypatch.setattr(forced, "Rayleigh", lambda alpha, beta=0.0: Rayleigh(1.1 * alpha, beta))
    seen = {f"largest deflection, overdamped, {solver}" for solver in ("full", "reduced")}
    assert seen <= failed(forced.strip_pulse())


def test_a_force_on_the_nearest_node_alone_is_seen(monkeypatch, failed):
    def nearest(x, at):
        forces = np.zeros((len(at), len(x)))
        forces[np.arange(len(at)), np.rint(at / x[1]).astype(int)] = 1.0
        return forces

    monkeypatch.setattr(forced, "ELEMENTS", 4)
    monkeypatch.setattr(forced, "nodal_forces", nearest)
    assert failed(forced.travelling_force())


def test_one_term_of_the_series_is_the_published_solution():
    time = 1e-3 * np.arange(401)
    at, highest = peak(time, in_time.series(time, 1))
    assert highest == pytest.approx(3.523e-3, abs=1.1e-6)
    assert at == pytest.approx(0.210, abs=0.5e-3)
    assert in_time.series(np.inf, 1) == pytest.approx(1.817e-3, abs=0.5e-6)


def test_a_wrong_damping_is_seen(monkeypatch, failed):
    """In the model alone: the static deflection stays."""
    series = in_time.series
    right = {count: series(1e-3 * np.arange(401), count) for count in (1, 60)}
    monkeypatch.setattr(in_time, "RAYLEIGH", Rayleigh(alpha=0.45, beta=1.339e-3))
    monkeypatch.setattr(in_time, "series", lambda t, n=60: right[n] if np.ndim(t) else series(t, n))
    found = failed(in_time.nafems_13t())
    assert {"peak, full", "peak, part in the first mode, full"} <= found
    assert "static" not in found


def test_another_damping_is_no_second_order(wrong, failed):
    def other(right, self, loads, step, damping):
        return right(self, loads, step, Rayleigh(1.001 * damping.alpha, damping.beta))

    wrong(MovingModel, "full", other)
    found = failed(in_time.newmark_order_3d())
    assert "fitted order of the full model's displacement in the step" in found
    assert "displacement, reduced model from the full one, both by Newmark" in found


def test_a_load_between_the_samples_is_seen(wrong, failed):
    def smooth(right, parts):
        loads = right(parts)
        loads[1::2] *= 1.0 + 1e-6 * (parts > 1)
        return loads

    wrong(in_time, "_loads", smooth)
    found = failed(in_time.newmark_order_3d())
    assert "velocity, exact integration from itself at an eighth of the step" in found


def test_a_lost_energy_is_seen(wrong, failed):
    def lossy(right, *arguments):
        history = right(*arguments)
        damped = history.energy.damped * (1.0 - 1e-7)
        return replace(history, energy=replace(history.energy, damped=damped))

    wrong(MovingModel, "full", lossy)
    assert len(failed(in_time.energy_identity_3d())) == 2


def test_an_undamped_strip_is_seen(monkeypatch, failed):
    monkeypatch.setattr(in_time, "STRIP_RAYLEIGH", Rayleigh())
    assert failed(in_time.energy_identity_3d()) == {
        "damped part of the energy at the end, at least a tenth"
    }


def test_the_window_holds_what_matters():
    """Strong motion up to 5 s, main impact at 5.1 s; the lightest damping comes first."""
    assert paper.WINDOW > 5.2
    betas = [damping.beta for damping in paper.TABLE_8.values()]
    assert betas == sorted(betas) == [2.12e-4, 1.06e-3, 3.18e-3]
    case = load_case(in_source_tree(paper.CASE))
    assert case.transient.maximum_frequency >= paper.HIGHEST
    assert 0.05 in case.spectra.damping
    found = case.spectra.frequency_values
    assert found[0] == pytest.approx(0.5) and found[-1] > paper.HIGHEST


@pytest.mark.slow
def test_on_a_coarse_mesh(monkeypatch, wrong, tmp_path):
    """A few steps of one damping; then with another one of the reduced model."""
    case = tmp_path / "coarse.toml"
    case.write_text(
        f'extends = "{in_source_tree(paper.CASE)}"\n'
        '[buildings.B1.structure.mesh]\nsize = "5 m"\n'
        '[transient]\nmaximum_frequency = "60 Hz"\ntolerance = 0.05\n'
        '[calibration]\nmode = "given"\n',
        encoding="utf-8",
    )
    monkeypatch.setattr(paper, "HIGHEST", 60.0)
    monkeypatch.setattr(paper, "TABLE_8", {"damped": Rayleigh(0.838, 1.06e-3)})
    rows = paper.paper_reduced_against_full(case, 0.1, 1000)
    # Nothing is hit so early.
    hit = "floors that are hit in the window, at least 1 (yes = 1)"
    assert {row.quantity for row in rows if not row.passed} == {hit}
    assert len(rows) == 2 + 5 + 1

    def other(right, basis, loads, damping, **options):
        return right(basis, loads, Rayleigh(damping.alpha, 1.5 * damping.beta), **options)

    wrong(response, "modal_histories", other)
    rows = paper.paper_reduced_against_full(case, 0.1, 10**6)
    failed = {row.quantity for row in rows if not row.passed}
    assert "free degrees of freedom, at least 1000000 (yes = 1)" in failed
    assert len([quantity for quantity in failed if "floor spectrum" in quantity]) == 4


@pytest.mark.slow
def test_the_paper_s_floor_as_a_bar_on_a_coarse_mesh(tmp_path):
    case = tmp_path / "coarse.toml"
    case.write_text(
        f'extends = "{in_source_tree(paper.CASE)}"\n'
        '[buildings.B1.structure.mesh]\nsize = "2.5 m"\n',
        encoding="utf-8",
    )
    rows = benchmark.paper_floor_as_a_bar(case)
    assert len(rows) == 9 and all(row.passed for row in rows)

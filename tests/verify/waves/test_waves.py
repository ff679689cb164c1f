"""Waves: rows that test_manual has pass fail for another bar, damping, load or energy."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import response
from impactfem.system.files import in_source_tree
from impactfem.verify.waves import MovingModel, forced, in_time, paper, peak
from impactfem.verify.waves.forced import DAMPED


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

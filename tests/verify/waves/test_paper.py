import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import response
from impactfem.system.files import in_source_tree
from impactfem.verify.waves import paper


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


def test_errors_of_spectra():
    truth = np.ones((2, 3, 4))
    spectra = truth.copy()
    spectra[0, 1, 2] = 1.006
    spectra[1, 0] = 0.0
    moved = np.ones((2, 3), dtype=bool)
    moved[1, 0] = False
    errors = paper.spectrum_errors(spectra, truth, moved)
    assert errors[0, 1] == pytest.approx(0.006) and errors[0, 1] > paper.WITHIN
    assert np.count_nonzero(errors) == 1


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

    def make(right):
        return lambda basis, loads, damping, **options: right(
            basis, loads, Rayleigh(damping.alpha, 1.5 * damping.beta), **options
        )

    wrong(response, "modal_histories", make)
    rows = paper.paper_reduced_against_full(case, 0.1, 10**6)
    failed = {row.quantity for row in rows if not row.passed}
    assert "free degrees of freedom, at least 1000000 (yes = 1)" in failed
    assert len([quantity for quantity in failed if "floor spectrum" in quantity]) == 4

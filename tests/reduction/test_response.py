"""The response of the reduced frame at nodes: histories, spectra, transfer functions and band."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from impactfem.building.links import Displacements
from impactfem.dynamics.damping import ModeRatios, RatioTable, Rayleigh
from impactfem.dynamics.newmark import in_full_order
from impactfem.reduction.error_band import effectivity
from impactfem.reduction.response import (
    LARGER,
    SAFETY,
    SMALLER,
    Analysis,
    Transfer,
    modal_histories,
    node_response,
    node_spectra,
    response_band,
    spectrum_difference,
)
from impactfem.spectra import response_spectra
from impactfem.stages.transient.full_run import FullModel, Resumption, run_full

from ..stages.transient.conftest import HIGHEST, TOLERANCE

FORCES = ("floor 2", "floor 1")

if TYPE_CHECKING:
    from impactfem.stages.transient.compute import FullRun

    FullRuns = dict[str, tuple[Rayleigh, FullRun]]

LOOSE = 0.2


@pytest.mark.parametrize("name", ["the case's", "light"])
def test_spectra_are_those_of_the_full_model(frame, loads, basis, full_runs, spectra, name):
    """All probes and directions, both by Newmark at the same step, from one basis."""
    damping, full = full_runs[name]
    truth = node_spectra(full.response, spectra)
    assert truth.zpa.min() > 0.0 and truth.frequency[-1] == pytest.approx(HIGHEST)
    history = modal_histories(basis, loads, damping, scheme="newmark")
    found = node_spectra(node_response(basis, history, loads, frame.nodes), spectra)
    assert found.psa == pytest.approx(truth.psa, rel=TOLERANCE)
    # The other scheme is not that near: what is compared is no matter of course.
    exact = modal_histories(basis, loads, damping)
    other = node_spectra(node_response(basis, exact, loads, frame.nodes), spectra)
    assert np.abs(other.psa / truth.psa - 1.0).max() > TOLERANCE


def test_twenty_modes_off_the_curve_of_rayleigh(frame, loads, basis, spectra, tmp_path):
    """From the same basis, up to 100 Hz, as the full model with C of low rank in addition."""
    law = ModeRatios(tuple(0.01 + 0.02 * (np.arange(20) % 3)), frame.damping)
    base, modal = in_full_order(law, frame.K, frame.model.mass, HIGHEST)
    assert base == frame.damping and modal.images.shape[1] == 20
    full = frame.full(loads, base, tmp_path, modal=modal)
    truth = node_spectra(full.response, spectra)
    shown = truth.frequency <= 100.0
    found = {}
    for name, damping in {"law": law, "rayleigh": base}.items():
        history = modal_histories(basis, loads, damping, scheme="newmark")
        found[name] = node_spectra(node_response(basis, history, loads, frame.nodes), spectra).psa
    apart = {name: np.abs(psa / truth.psa - 1.0)[..., shown] for name, psa in found.items()}
    assert apart["law"].max() < 1e-3 and apart["rayleigh"].max() > 0.1
    assert full.energy.residual < 1e-9


def test_rayleigh_as_a_table_of_its_own_curve(frame, loads, basis):
    own = frame.damping
    frequency = np.unique(np.sqrt(np.maximum(basis.model.eigenvalue, 1e-6))) / (2.0 * np.pi)
    law = RatioTable(tuple(frequency), tuple(own.ratio(frequency)))
    one, same = (modal_histories(basis, loads, damping) for damping in (own, law))
    size = np.abs(one.acceleration).max()
    assert np.abs(same.acceleration - one.acceleration).max() < 1e-10 * size
    bounds = [Transfer.of(basis, frame.nodes, law, HIGHEST, FORCES).bound for law in (own, law)]
    # The rigorous bound is known of Rayleigh damping alone.
    assert np.isfinite(bounds[0]).all() and np.isinf(bounds[1]).all()


def test_histories_are_those_of_the_full_model(frame, loads, basis, full_runs):
    damping, full = full_runs["light"]
    history = modal_histories(basis, loads, damping, scheme="newmark")
    found = node_response(basis, history, loads, frame.nodes)
    for name in ("displacement", "acceleration"):
        mine, truth = getattr(found, name), getattr(full.response, name)
        assert mine.shape == truth.shape == (1601, len(frame.nodes), 3)
        assert np.abs(mine - truth).max() < 0.005 * np.abs(truth).max()


def test_rotations_are_those_of_the_full_model(frame, loads, basis, tmp_path):
    """Where the ground does not rotate; and a rotation is no displacement."""
    moved = Displacements(frame.model, frame.nodes, rotations=True)
    pulses = replace(loads, ground=0.0 * loads.ground)
    full = run_full(
        FullModel(frame.model, frame.K, frame.light),
        pulses,
        frame.patterns(pulses),
        moved,
        Resumption(tmp_path, "frame", 10**6),
    ).response
    history = modal_histories(basis, pulses, frame.light, scheme="newmark")
    found = node_response(basis, history, pulses, frame.nodes, rotations=True)
    for name in ("displacement", "acceleration"):
        mine, truth = getattr(found, name), getattr(full, name)
        assert mine.shape == truth.shape and np.abs(truth).max() > 0.0
        assert np.abs(mine - truth).max() < 0.01 * np.abs(truth).max()
    # The ground moves no node's angle of its own.
    shaken = node_response(basis, history, loads, frame.nodes, rotations=True)
    assert np.array_equal(shaken.acceleration, found.acceleration)
    apart = node_response(basis, history, pulses, frame.nodes).displacement - full.displacement
    assert np.abs(apart).max() > 0.5 * np.abs(full.displacement).max()
    with pytest.raises(KeyError, match="not made for"):
        other = np.setdiff1d(basis.nodes, basis.certified)[:1]
        node_response(basis, history, pulses, other, rotations=True)


def test_loads_that_the_basis_does_not_have(loads, basis):
    other = replace(loads, edges=(loads.edges[0], replace(loads.edges[1], name="floor 7")))
    with pytest.raises(KeyError, match="no load floor 7"):
        modal_histories(basis, other, (0.1, 1e-4))


def test_basis_with_more_loads_than_there_are(frame, loads, basis):
    """A motion without impacts on floor 1, and in another order of the loads."""
    fewer = replace(loads, edges=loads.edges[:1], force=loads.force[:, :1])
    zero = replace(loads, force=loads.force * [1.0, 0.0])
    swapped = replace(loads, edges=loads.edges[::-1], force=loads.force[:, ::-1])

    def response(of):
        history = modal_histories(basis, of, frame.damping)
        return node_response(basis, history, of, frame.nodes).acceleration

    assert response(fewer) == pytest.approx(response(zero), abs=1e-9)
    assert response(swapped) == pytest.approx(response(loads), abs=1e-9)
    assert np.abs(response(fewer) - response(loads)).max() > 1.0


def test_records_of_the_spectra(frame, loads, basis):
    """Node by node, x y z each, in the damping and at the frequencies that are asked for."""
    asked = frame.case.spectra.model_copy(update={"damping": (0.02, 0.1)})
    history = modal_histories(basis, loads, frame.damping)
    response = node_response(basis, history, loads, frame.nodes[:3])
    found = node_spectra(response, asked)
    assert found.psa.shape == (2, 9, len(asked.frequency_values))
    one = response_spectra(
        response.acceleration[:, 1, 2], loads.time_step, asked.frequency_values, [0.1]
    )
    assert found.psa[1, 5] == pytest.approx(one.psa[0, 0], rel=1e-12)
    assert found.zpa[5] == np.abs(response.acceleration[:, 1, 2]).max()


def test_against_a_direct_solution(frame, loads, basis, csc):
    """(K + iωC − ω²M) x = f solved by SciPy, acceleration −ω² x over the force 1 N."""
    alpha, beta = frame.light.alpha, frame.light.beta
    found = Transfer.of(basis, frame.nodes, frame.light, HIGHEST, FORCES)
    assert found.loads == ("floor 2", "floor 1")  # the ground is no force
    assert found.value.shape == (len(found.frequency), 2, len(frame.nodes), 3)
    assert found.frequency[[0, -1]] == pytest.approx([0.5, HIGHEST])
    K, M = csc(frame.K), csc(frame.model.mass)
    rows = (frame.model.rows(frame.nodes)[:, None] + np.arange(3)).ravel()
    forces = frame.patterns(loads)[:, 1:].astype(complex)
    for k in (50, 313, 450, 599):
        w = 2.0 * np.pi * found.frequency[k]
        dynamic = K * (1.0 + 1j * w * beta) + M * (1j * w * alpha - w**2)
        truth = (-(w**2) * splu(dynamic.tocsc()).solve(forces)[rows]).T.reshape(2, -1, 3)
        apart = np.abs(found.value[k] - truth).max(axis=(1, 2))
        assert np.all(apart < TOLERANCE * np.abs(truth).max(axis=(1, 2)))
        # The phase counts: its conjugate is another response.
        other = np.abs(found.value[k].conj() - truth).max(axis=(1, 2))
        assert np.all(other > TOLERANCE * np.abs(truth).max(axis=(1, 2)))


def test_without_forces(frame, loads):
    ground = replace(loads, edges=(), force=loads.force[:, :0])
    found = Transfer.of(
        frame.basis(ground, tolerance=0.1), frame.nodes, frame.damping, 50.0, FORCES
    )
    assert found.loads == () and found.value.shape == (600, 0, len(frame.nodes), 3)


def test_bound_holds(frame, loads, basis):
    """The rigorous bound against a direct solution, at frequencies where it is sharp and not."""
    exact = frame.basis(loads, tolerance=1e-6)
    nodes = frame.nodes
    coarse = frame.basis(loads, tolerance=0.1)
    ours, truth = (Transfer.of(b, nodes, frame.light, HIGHEST, FORCES) for b in (coarse, exact))
    error = np.abs(ours.value - truth.value)
    rounding = 1e-9 * np.abs(truth.value).max()
    assert (error - ours.bound).max() < rounding
    assert error.max() > 0.0 and np.isfinite(ours.bound).all()
    # A better basis has a smaller one, wherever it is more than rounding, as at low frequencies;
    # of other nodes nothing is known.
    better = Transfer.of(basis, nodes, frame.light, HIGHEST, FORCES).bound
    known = ours.bound > rounding
    assert known.any() and np.all(better[known] < ours.bound[known])
    other = np.setdiff1d(coarse.nodes, nodes)[:1]
    assert np.isinf(coarse.bound(other, np.array([10.0]), frame.light)).all()


def test_largest_difference_around_a_frequency():
    frequency = 2.0 ** (np.arange(25) / 12.0)  # twelve an octave: two to either side in a third
    used = np.ones((2, 25))
    other = used.copy()
    other[0, 10], other[0, 20], other[1, 0] = 1.3, 0.6, 2.0
    found = spectrum_difference(used, [other], frequency, 1.0 / 3.0)
    expected = np.zeros((2, 25))
    expected[0, 8:13], expected[0, 18:23], expected[1, :3] = 0.3, 0.4, 1.0
    assert found == pytest.approx(expected, abs=1e-12)


def test_the_worst_of_several_models_counts():
    frequency = np.array([1.0, 10.0])
    used, others = np.zeros((1, 2)), [np.array([[1.0, 0.0]]), np.array([[0.5, -3.0]])]
    assert spectrum_difference(used, others, frequency, 1.0 / 3.0).tolist() == [[1.0, 3.0]]


@pytest.mark.parametrize("tolerance", [LOOSE, TOLERANCE])
@pytest.mark.parametrize("name", ["the case's", "light"])
def test_band_is_the_error_to_within_a_factor(frame, loads, full_runs, spectra, name, tolerance):
    """Between 1 and 10 times at 95 % of all thirds of octaves; the safety factor is needed.

    So on accelerations, at any time. Both models by Newmark at the same step.
    """
    damping, full = full_runs[name]
    basis = frame.basis(loads, tolerance=tolerance, larger=True)
    history = modal_histories(basis, loads, damping, scheme="newmark")
    response = node_response(basis, history, loads, frame.nodes)
    psa, truth = (node_spectra(one, spectra).psa for one in (response, full.response))
    analysis = Analysis(basis, loads, damping, "newmark")
    case = analysis, frame.nodes, response, psa, spectra
    bands = {kind: response_band(*case, kind=kind) for kind in (LARGER, SMALLER)}

    def effect(kind=LARGER, factor=1.0):
        frequency = np.array(spectra.frequency_values)
        return effectivity(bands[kind].psa[0], factor * psa[0], truth[0], frequency)

    found = effect()
    assert found.good >= 0.95, found.misses
    largest = np.abs(response.acceleration - full.response.acceleration).max(axis=0)
    told = largest > 1e-4 * np.abs(full.response.acceleration).max(axis=0)
    ratio = bands[LARGER].acceleration[told] / largest[told]
    assert np.all((ratio >= 1.0) & (ratio <= 10.0))
    if name == "light":
        assert len(found.ratio) > 50
        # Smaller models tell their own error; without a safety factor much would be missed.
        assert effect(SMALLER).good < 0.8
        assert np.mean(found.ratio < SAFETY[LARGER]) > 0.1
        # A band around wrong spectra does not hold what they lack.
        assert np.mean(effect(factor=1.05).ratio >= 1.0) < 0.3


def test_basis_without_larger_models(frame, loads, basis, spectra):
    response = node_response(basis, modal_histories(basis, loads, frame.light), loads, frame.nodes)
    psa = node_spectra(response, spectra).psa
    case = frame.nodes, response, psa, spectra
    analysis = Analysis(basis, loads, frame.light)
    with pytest.raises(ValueError, match="without larger models"):
        response_band(analysis, *case)
    assert response_band(analysis, *case, kind=SMALLER).psa.shape == psa.shape
    alone = replace(basis, models=basis.models[:1])
    with pytest.raises(ValueError, match="without smaller models"):
        response_band(replace(analysis, basis=alone), *case, kind=SMALLER)

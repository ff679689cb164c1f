from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics.columns import inner
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import reduced as room
from impactfem.reduction.error_band import nested_models
from impactfem.reduction.reduced import modes_near, reduced_model, residual_norms, shift_of
from impactfem.system.errors import SolutionError

from .conftest import SHIFT

OMEGA = 2.0 * np.pi * np.geomspace(1.0, 200.0, 40)
# α [1/s] and β [s]: some 5 % to 50 %, 1 % to 6 %, of the mass alone, of the stiffness alone.
DAMPINGS = [Rayleigh(*pair) for pair in ((1.5, 8e-4), (0.5, 1e-4), (12.0, 0.0), (0.0, 3e-4))]


def worst(found, exact):
    """Largest error at a frequency over the largest response there, by pattern."""
    return (np.abs(found - exact).max(axis=1) / np.abs(exact).max(axis=1)).max(axis=0)


@pytest.mark.parametrize("damping", DAMPINGS)
def test_one_basis_for_all_dampings(membrane, krylov, damping):
    model, made = membrane(), krylov(40)
    omega = OMEGA[2.0 * np.pi * 80.0 > OMEGA]
    exact = model.transfer(omega, damping, model.loads)
    error = [
        worst(reduced_model(made, size).transfer(made.V, omega, damping), exact).max()
        for size in (30, 60, 90, 120)
    ]
    heavy = damping == DAMPINGS[0]
    limits = (0.5, 3e-3, 1e-6, 1e-10) if heavy else (5.0, 1.0, 0.05, 1e-7)
    assert np.all(np.array(error) < limits), error
    # It is the Krylov vectors that do it: as many others do not.
    V = np.linalg.qr(np.random.default_rng(3).standard_normal((168, 90)))[0]
    D = np.stack([V.T @ model.dynamic(w, damping) @ V for w in omega])
    other = V @ np.linalg.solve(D, np.broadcast_to(V.T @ model.loads, (len(omega), 90, 3)))
    assert worst(other, exact).max() > 1.0


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("shift", [SHIFT, 30.0])
def test_the_whole_space_is_exact(membrane, krylov, damping, shift):
    model, made = membrane(), krylov(80, shift=shift)
    assert made.size == 168
    reduced = reduced_model(made)
    assert reduced.eigenvalue == pytest.approx(model.eigenvalue, rel=1e-8)
    exact = model.transfer(OMEGA, damping, model.loads)
    assert worst(reduced.transfer(made.V, OMEGA, damping), exact).max() < 1e-8
    shapes = reduced.shapes(made.V)
    assert np.abs(shapes.T @ model.M @ shapes - np.eye(168)).max() < 1e-11
    assert worst(shapes @ reduced.amplitude(OMEGA, damping), exact).max() < 1e-8
    # A shift that is not the basis' gives another spectrum, and no such response.
    wrong = replace(reduced, eigenvalue=reduced.eigenvalue + 0.01 * shift)
    assert worst(wrong.transfer(made.V, OMEGA, damping), exact).max() > 1e-6


@pytest.mark.parametrize("steps", [1, 7, 20])
def test_a_nested_model_is_that_of_a_smaller_basis(krylov, steps):
    large, small = krylov(30), krylov(steps)
    nested, own = reduced_model(large, small.size), reduced_model(small)
    assert nested.eigenvalue == pytest.approx(own.eigenvalue, rel=1e-9)
    one = nested.transfer(large.V, OMEGA, Rayleigh(0.5, 1e-4))
    assert worst(one, own.transfer(small.V, OMEGA, Rayleigh(0.5, 1e-4))).max() < 1e-9
    other = reduced_model(large, small.size + 3).transfer(large.V, OMEGA, Rayleigh(0.5, 1e-4))
    assert worst(one, other).max() > 1e-6


def test_sizes_of_nested_models(membrane, krylov):
    made = krylov(10)

    def nested_size(made, share):
        return len(nested_models(made, [share])[1].coordinates)

    assert nested_size(made, 0.8) == 24 and nested_size(made, 0.0) == 3
    assert nested_size(made, 0.99) == 27
    late = membrane().loads[:, ::-1] @ np.array([[1.0], [2.0], [3.0]]) ** 2
    late[5] += 1.0
    made.add(late)
    # What held the loads before does not hold all of them now.
    with pytest.raises(SolutionError, match="reduced basis holds"):
        nested_size(made, 0.8)
    with pytest.raises(SolutionError, match=r"first 30 vectors .* not"):
        reduced_model(made, 30)
    made.grow(2)
    assert made.sizes[-3:] == (34, 38, 42)
    assert nested_size(made, 0.1) == 34
    with pytest.raises(SolutionError, match="43 vectors of a reduced"):
        reduced_model(made, 43)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("later", [False, True])
def test_residual(membrane, krylov, damping, later):
    model = membrane()
    loads = model.loads
    if later:
        made = krylov(6, loads=loads[:, :1])
        made.add(loads[:, 1:])
        made.grow(5)
    else:
        made = krylov(8)
    reduced = reduced_model(made)
    gram = inner(made.M, made.Q, made.shifted_tail())
    norms = residual_norms(gram, reduced, OMEGA, damping)
    assert made.Q.shape[1] == reduced.tail.shape[0] == 3
    shifted = model.K + SHIFT * model.M
    for k in (0, 15, 30, 39):
        omega = OMEGA[k]
        x = reduced.transfer(made.V, np.array([omega]), damping)[0]
        r = loads - model.dynamic(omega, damping) @ x
        sigma = 1j * omega * (1j * omega + damping.alpha) / (1.0 + 1j * omega * damping.beta)
        assert shift_of(omega, damping) == pytest.approx(sigma, rel=1e-14)
        z = reduced.amplitude(np.array([omega]), damping)[0]
        away = -(sigma - SHIFT) * (1.0 + 1j * omega * damping.beta)
        # Rounding of K x, beside which the residual is small at low frequencies.
        rounding = 1e-13 * np.abs(model.K @ (made.V @ reduced.coordinates @ z)).max()
        scale = np.abs(r).max()
        formula = away * (shifted @ made.Q @ (reduced.tail @ z))
        # Kernels of BLAS round the products differently: up to 1.5e-12 of r beyond K x is known.
        assert np.abs(r - formula).max() < rounding + 5e-12 * scale
        norm = np.sqrt(np.sum(r.conj() * np.linalg.solve(shifted, r), axis=0).real)
        assert norms[k] == pytest.approx(norm, rel=1e-10, abs=rounding)
        if k == 30:
            # Without part of the tail, with σ + σ0, or without 1 + iωβ it is another one.
            part = shifted @ made.Q[:, :2] @ (reduced.tail[:2] @ z)
            assert np.abs(r - away * part).max() > 1e-3 * scale
            other = formula * (sigma + SHIFT) / (sigma - SHIFT)
            assert np.abs(r - other).max() > 1e-3 * scale
            other = formula / (1.0 + 1j * omega * damping.beta)
            assert damping.beta == 0.0 or np.abs(r - other).max() > 1e-2 * scale


def test_the_residual_falls_and_ends(krylov):
    norms = []
    for steps in (5, 15, 30, 80):
        made = krylov(steps)
        gram = inner(made.M, made.Q, made.shifted_tail())
        found = residual_norms(gram, reduced_model(made), OMEGA, Rayleigh(1.5, 8e-4))
        norms.append(found.max())
    assert norms[0] > 10.0 * norms[1] > 1000.0 * norms[2] and norms[3] == 0.0


@pytest.fixture
def searches(monkeypatch):
    """How often modes are looked for from nothing."""
    seen, modes = [], room.modes

    def counted(*arguments, **further):
        seen.append(1)
        return modes(*arguments, **further)

    monkeypatch.setattr(room, "modes", counted)
    return seen


def test_modes_near_known_ones(membrane, petsc, searches):
    """Of a membrane that is stiffer on one side, from those of the even one."""
    model = membrane()
    stiffer = np.linspace(1.0, 1.3, len(model.K)) ** 0.5
    K = stiffer[:, None] * model.K * stiffer
    known = scipy.linalg.eigh(model.K, model.M)[1][:, :6]
    exact, shapes = scipy.linalg.eigh(K, model.M)
    found = modes_near(petsc(K), petsc(model.M), known, 6)
    assert (2.0 * np.pi * found.frequency) ** 2 == pytest.approx(exact[:6], rel=1e-11)
    assert np.abs(shapes[:, :6].T @ model.M @ found.shapes) == pytest.approx(np.eye(6), abs=1e-5)
    assert np.all(found.residual <= 1e-7) and not searches
    # The known ones are no such modes.
    ritz = np.einsum("nk,nk->k", known, K @ known)
    assert np.all(np.abs(ritz / exact[:6] - 1.0) > 1e-3)
    # Of the modes themselves the space does not grow, and is enough.
    same = modes_near(petsc(K), petsc(model.M), shapes[:, :6], 6)
    assert (2.0 * np.pi * same.frequency) ** 2 == pytest.approx(exact[:6], rel=1e-11)
    assert not searches
    # A looser tolerance is less accurate.
    loose = modes_near(petsc(K), petsc(model.M), known, 6, tolerance=1e-2)
    assert 1e-7 < loose.residual.max() <= 1e-2 and not searches


@pytest.mark.parametrize("count", [3, 40])
def test_modes_that_known_ones_do_not_lead_to(chain, petsc, searches, count):
    """Two parts that nothing joins, modes of one known: those of the other are found, too."""
    parts = chain(30), 1.05 * chain(25)
    K, M = scipy.linalg.block_diag(*parts), np.eye(55)
    known = np.vstack([np.linalg.eigh(parts[0])[1][:, :2], np.zeros((25, 2))])
    found = modes_near(petsc(K), petsc(M), known, count)
    exact = np.linalg.eigvalsh(K)[:count]
    assert (2.0 * np.pi * found.frequency) ** 2 == pytest.approx(exact, rel=1e-10)
    assert len(searches) == 1

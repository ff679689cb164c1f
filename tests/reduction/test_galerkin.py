"""Vectors that complete a basis for contacts and local loads."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from impactfem.reduction import galerkin, orthonormal
from impactfem.reduction.galerkin import (
    LOCAL,
    GalerkinModes,
    append_chain,
    append_contacts,
    append_forces,
    append_responses,
)

SHIFT = (2.0 * np.pi * 5.0) ** 2


@pytest.fixture
def completed(membrane, krylov, monkeypatch):
    """Vectors for the membrane whose far side may be held, so many responses at once."""

    def make(at_once=16, contacts=True):
        model = membrane()
        monkeypatch.setattr(galerkin, "AT_ONCE", at_once)
        basis = krylov(7, model, loads=model.loads[:, :1], shift=SHIFT)
        G = np.eye(len(model.K))[:, -(model.ny + 1) :]
        if contacts:
            append_contacts(basis, sp.csr_matrix(G))
        return model, G, basis

    return make


def held_frequencies(K, M, G, count):
    """Of the structure with Gᵀ x = 0 [rad/s]."""
    Z = scipy.linalg.null_space(G.T)
    return np.sqrt(scipy.linalg.eigh(Z.T @ K @ Z, Z.T @ M @ Z, eigvals_only=True)[:count])


def reduced_held(basis, G, count):
    modes = GalerkinModes.of(basis)
    gamma = modes.rows(sp.csr_matrix(G))
    return held_frequencies(np.diag(modes.eigenvalue), np.eye(len(gamma)), gamma, count)


def test_free_and_held_modes(completed):
    """The lowest modes along x of the free structure, and of the one that is held as well."""
    model, G, basis = completed()
    V = basis.vectors.columns(0, basis.vectors.count)
    assert np.abs(V.T @ model.M @ V - np.eye(V.shape[1])).max() < 1e-12
    free = np.sqrt(GalerkinModes.of(basis).eigenvalue[0])
    assert free == pytest.approx(np.sqrt(model.eigenvalue[0]), rel=1e-9)
    exact = held_frequencies(model.K, model.M, G, 1)
    assert reduced_held(basis, G, 1) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("chunk", [5, 64])
def test_modes_without_products_of_the_krylov_space(membrane, krylov, monkeypatch, chunk):
    """φᵀ K φ = λ and φᵀ M φ = 1 on all vectors, wherever the tail is in memory."""
    monkeypatch.setattr(orthonormal, "CHUNK", chunk)
    monkeypatch.setattr(orthonormal, "ROWS", 1)
    model = membrane()
    basis = krylov(6, model, loads=np.eye(len(model.K))[:, [3, 30, 77]], shift=SHIFT)
    append_responses(basis, np.eye(len(model.K))[:, [12, 50]])
    append_forces(basis, np.eye(len(model.K))[:, [20, 21, 22, 40]], 4.0 * SHIFT)
    # One force twice, and none.
    forces = np.eye(len(model.K))[:, [20, 21, 22, 20, 41, 0]]
    forces[:, -1] = 0.0
    append_forces(basis, forces, 100.0 * SHIFT)
    modes = GalerkinModes.of(basis)
    shapes = basis.vectors.columns(0, basis.vectors.count) @ modes.coordinates
    frequency = np.sqrt(modes.eigenvalue)
    stiffness = shapes.T @ model.K @ shapes / frequency / frequency[:, None]
    one = np.eye(basis.size + 3 + 4 + 4 + 4)
    assert shapes.T @ model.M @ shapes == pytest.approx(one, abs=1e-11)
    for L in (model.loads, sp.csr_matrix(model.loads)):
        assert modes.rows(L) == pytest.approx(shapes.T @ model.loads, rel=1e-10, abs=1e-10)
    rows = basis.vectors.rows(np.array([[3, 9]]), 2, basis.vectors.count)
    whole = np.vstack([np.zeros((2, len(one))), np.eye(len(one))[2:]])
    assert basis.vectors.combination(whole)[[3, 9], 2:] == pytest.approx(rows[0], rel=1e-10)
    assert stiffness == pytest.approx(one, abs=1e-8)


def test_nothing_after_vectors_that_stay_as_they_are(membrane, krylov):
    """Also where none of them brought in a direction of its own: they are stored all the same."""
    model = membrane()
    vectors = krylov(6, model).vectors
    count, inside = vectors.count, np.array(vectors.columns(0, 3), order="F")
    vectors.append_kept(2.0 * inside, LOCAL)
    assert vectors.count == count and vectors.stored == count + 3
    with pytest.raises(ValueError, match="the last ones"):
        vectors.append(np.array(model.loads, order="F"))


def test_the_free_basis_alone_does_not_hold(completed):
    model, G, basis = completed(contacts=False)
    exact = held_frequencies(model.K, model.M, G, 1)
    assert abs(reduced_held(basis, G, 1)[0] / exact[0] - 1.0) > 0.05


def test_each_contact_force_at_the_shift(completed):
    """H = (K + σ0 M)⁻¹ G lies in the space."""
    model, G, basis = completed()
    H = np.linalg.solve(model.K + SHIFT * model.M, G)
    V = basis.vectors.columns(0, basis.vectors.count)
    assert np.abs(H - V @ (V.T @ model.M @ H)).max() < 1e-10 * np.abs(H).max()


def test_each_contact_force_at_further_shifts(completed):
    """(K + σ M)⁻¹ G is in the space for the shifts that are requested, and for no other."""
    model, G, basis = completed(contacts=False)
    append_forces(basis, sp.csr_matrix(G), SHIFT)
    shifts = [9.0 * SHIFT, 81.0 * SHIFT]

    def outside():
        V, found = basis.vectors.columns(0, basis.vectors.count), []
        for shift in shifts:
            X = np.linalg.solve(model.K + shift * model.M, G)
            left = X - V @ (V.T @ model.M @ X)
            size = [np.sqrt(np.einsum("ij,ij->j", x, model.M @ x)) for x in (left, X)]
            found.append((size[0] / size[1]).max())
        return found

    assert min(outside()) > 10.0 * LOCAL
    append_forces(basis, sp.csr_matrix(G), shifts[0])
    assert outside()[0] < LOCAL < 10.0 * LOCAL < outside()[1]
    append_forces(basis, G, shifts[1])
    assert max(outside()) < LOCAL


@pytest.mark.parametrize("at_once", [1, 5, 100])
def test_blocks_of_any_size(completed, at_once):
    """What the space is made for; the last vectors of the held chain are mostly rounding."""
    (_, G, one), (_, _, other) = completed(), completed(at_once)
    assert reduced_held(other, G, 1) == pytest.approx(reduced_held(one, G, 1), rel=1e-9)
    free = [GalerkinModes.of(basis).eigenvalue[0] for basis in (one, other)]
    assert free[1] == pytest.approx(free[0], rel=1e-12)


def test_local_loads(completed):
    model, _, basis = completed(contacts=False)
    F = np.eye(len(model.K))[:, [30, 77]]
    append_responses(basis, F)
    A = np.linalg.inv(model.K + SHIFT * model.M)
    V = basis.vectors.columns(0, basis.vectors.count)
    for X in (A @ F, A @ model.M @ A @ F):
        assert np.abs(X - V @ (V.T @ model.M @ X)).max() < 1e-10 * np.abs(X).max()
    third = A @ model.M @ A @ model.M @ A @ F
    assert np.abs(third - V @ (V.T @ model.M @ third)).max() > 1e-6 * np.abs(third).max()


@pytest.mark.parametrize("steps", [2, 12])
def test_chain_of_loads_that_come_later(completed, steps):
    """What each image A W has outside comes in, and no vector is lost to rounding on the way."""
    model, _, basis = completed(contacts=False)
    before, F = basis.vectors.count, np.eye(len(model.K))[:, [30, 77]]
    append_chain(basis, F, steps=steps)
    V = basis.vectors.columns(0, basis.vectors.count)
    assert V.shape[1] == before + 2 * steps
    assert np.abs(V.T @ model.M @ V - np.eye(V.shape[1])).max() < 1e-13
    A = np.linalg.inv(model.K + SHIFT * model.M)

    def outside(X):
        return np.abs(X - V @ (V.T @ model.M @ X)).max() / np.abs(X).max()

    assert outside(A @ F) < 1e-10
    assert outside(A @ model.M @ V[:, before:-2]) < 1e-10
    assert outside(A @ model.M @ V[:, -2:]) > 1e-3


def test_chain_of_the_responses_themselves_runs_out(completed):
    """The negative of the test before: of A ... A H ever less is outside, at last rounding."""
    model, _, basis = completed(contacts=False)
    before, F = basis.vectors.count, np.eye(len(model.K))[:, [30, 77]]
    append_responses(basis, F, steps=12)
    assert basis.vectors.count < before + 24

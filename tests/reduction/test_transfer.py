"""Transfer functions from the impact forces to accelerations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from impactfem.building.floor import edge_load
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.error_band import SAFETY
from impactfem.reduction.transfer import transfer_functions

from ..stages.transient.conftest import HIGHEST, TOLERANCE

if TYPE_CHECKING:
    from impactfem.reduction.loads import Loads
    from impactfem.reduction.reduced_basis import ReducedBasis

    from ..stages.transient.conftest import Frame


def test_against_a_direct_solution(
    frame: Frame, loads: Loads, basis: ReducedBasis, csc: Callable[[Any], csc_matrix]
) -> None:
    """(K + iωC − ω²M) x = f solved by SciPy, acceleration −ω² x over the force 1 N."""
    alpha, beta = frame.light.alpha, frame.light.beta
    found = transfer_functions(basis, frame.nodes, frame.light, HIGHEST)
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


def test_resonance(frame: Frame, basis: ReducedBasis) -> None:
    """Almost without damping forces along y are largest at the first mode along y, the second."""
    found = transfer_functions(basis, frame.nodes, Rayleigh(beta=1e-6), HIGHEST)
    size = np.abs(found.value[:, 0]).max(axis=(1, 2))
    low = found.frequency < 1.5 * basis.model.frequency[1]
    peak = found.frequency[low][np.argmax(size[low])]
    assert peak == pytest.approx(basis.model.frequency[1], rel=0.006)


def test_reciprocity(frame: Frame, loads: Loads) -> None:
    """Force on one edge, acceleration at the other as the force weighs it: either way the same."""
    edges = [edge_load(frame.parts.mesh, floor, 0.3) for floor in (2, 1)]
    every = np.unique(np.concatenate([edge.nodes for edge in edges]))
    basis = frame.basis(loads, nodes=np.union1d(every, frame.nodes))
    found = transfer_functions(basis, every, frame.light, HIGHEST)
    at = [np.searchsorted(every, edge.nodes) for edge in edges]
    weighed = [
        -found.value[:, :, nodes, 1] @ edge.forces for nodes, edge in zip(at, edges, strict=True)
    ]
    there, back = weighed[1][:, 0], weighed[0][:, 1]
    assert np.abs(there - back).max() < SAFETY * basis.difference * np.abs(there).max()
    # The responses to the two forces themselves differ.
    assert np.abs(weighed[0][:, 0] - weighed[1][:, 1]).max() > 0.1 * np.abs(there).max()


def test_without_forces(frame: Frame, loads: Loads) -> None:
    ground = replace(loads, edges=(), force=loads.force[:, :0])
    found = transfer_functions(frame.basis(ground, tolerance=0.1), frame.nodes, frame.damping, 50.0)
    assert found.loads == () and found.value.shape == (600, 0, len(frame.nodes), 3)


def test_bound_holds(frame: Frame, loads: Loads, basis: ReducedBasis) -> None:
    """The rigorous bound against a direct solution, at frequencies where it is sharp and not."""
    exact = frame.basis(loads, tolerance=1e-6)
    nodes = frame.nodes
    coarse = frame.basis(loads, tolerance=0.1)
    ours, truth = (transfer_functions(b, nodes, frame.light, HIGHEST) for b in (coarse, exact))
    error = np.abs(ours.value - truth.value)
    rounding = 1e-9 * np.abs(truth.value).max()
    assert (error - ours.bound).max() < rounding
    assert error.max() > 0.0 and np.isfinite(ours.bound).all()
    # A better basis has a smaller one, wherever it is more than rounding, as at low frequencies;
    # of other nodes nothing is known.
    better = transfer_functions(basis, nodes, frame.light, HIGHEST).bound
    known = ours.bound > rounding
    assert known.any() and np.all(better[known] < ours.bound[known])
    other = np.setdiff1d(coarse.nodes, nodes)[:1]
    assert np.isinf(coarse.bound(other, np.array([10.0]), frame.light)).all()

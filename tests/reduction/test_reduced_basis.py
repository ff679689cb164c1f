"""The reduced basis of the frame: what it must reach, its file, and where it may be looked at."""

import math
from dataclasses import fields

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from impactfem.reduction.archive import from_arrays, to_arrays
from impactfem.reduction.error_band import NESTED_SAFETY
from impactfem.reduction.probes import recorded_nodes
from impactfem.reduction.reduced import ReducedModel
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.system.errors import SolutionError
from impactfem.system.files import read_archive, write_archive

from ..stages.transient.conftest import HIGHEST, TOLERANCE


def displacements(basis, nodes, f, damping):
    """Under the loads exp(iωt), shape (3 n, number of loads)."""
    z = basis.model.amplitude(np.array([2.0 * math.pi * f]), damping)[0]
    return basis.of(basis.model, nodes).reshape(3 * len(nodes), -1) @ z


@pytest.mark.parametrize("f", [1.0, 31.0, 97.0, HIGHEST])
def test_transfer_functions_are_those_of_the_full_model(frame, loads, basis, csc, f):
    """Solved directly by SciPy, at the probes, for the damping it was made for and a larger one."""
    K, M = csc(frame.K), csc(frame.model.mass)
    rows = (frame.model.rows(frame.nodes)[:, None] + np.arange(3)).ravel()
    loose = frame.basis(loads, tolerance=0.9)
    for damping in (frame.light, frame.damping):
        s = 2j * math.pi * f
        dynamic = K * (1.0 + s * damping.beta) + M * (s * s + s * damping.alpha)
        truth = splu(dynamic.tocsc()).solve(frame.patterns(loads).astype(complex))[rows]
        fine, coarse = (
            np.abs(displacements(one, frame.nodes, f, damping) - truth).max(axis=0)
            / np.abs(truth).max(axis=0)
            for one in (basis, loose)
        )
        assert fine.max() < basis.difference < TOLERANCE
        # Fewer vectors are not enough at the end of the range and lightly damped.
        assert f < HIGHEST or damping != frame.light or coarse.max() > TOLERANCE


def test_estimate_is_that_of_the_nested_models(frame, basis):
    """Growing goes on until it is met, and not much further."""
    assert basis.difference <= TOLERANCE
    sizes = [len(model.coordinates) for model in basis.models]
    assert sizes == sorted(sizes, reverse=True) and len(set(sizes)) == len(sizes) > 1
    omega = 2.0 * math.pi * np.geomspace(0.5, HIGHEST, int(12 * math.log2(HIGHEST / 0.5)) + 1)
    third = np.round(3.0 * np.log2(omega / (2.0e3 * math.pi)))
    responses, outside = [], []
    for model in basis.models:
        z = model.amplitude(omega, frame.light)
        shapes = basis.of(model, frame.nodes).reshape(-1, len(model.eigenvalue))
        responses.append(shapes @ z)
        outside.append(np.linalg.norm(model.tail @ z, axis=1))
    worst = 0.0
    for number in np.unique(third):
        among = third == number
        largest = np.abs(responses[0][among]).max(axis=(0, 1))
        for y, w in zip(responses[1:], outside[1:], strict=True):
            apart = np.abs(responses[0] - y)[among].max(axis=(0, 1))
            faster = np.minimum(1.0, outside[0][among].max(axis=0) / w[among].max(axis=0))
            worst = max(worst, NESTED_SAFETY * (faster * apart / largest).max())
    assert worst == pytest.approx(basis.difference, rel=1e-6)


def test_looser_tolerances_and_heavier_damping_take_fewer_vectors(frame, loads, basis):
    told = []
    loose = frame.basis(loads, tolerance=0.5, progress=told.append)
    tight = frame.basis(loads, tolerance=1e-4)
    assert len(loose.model.eigenvalue) < len(tight.model.eigenvalue)
    assert tight.difference < 1e-4 < loose.difference < 0.5
    assert all(0.0 <= part <= 1.0 for part in told)
    heavy = frame.basis(loads, damping=frame.damping)
    assert len(heavy.model.eigenvalue) < len(basis.model.eigenvalue)


def test_too_few_vectors(frame, loads):
    message = (
        r"27 vectors of the reduced basis leave an error of \d+\.\d+% at the probes, 0\.50% is "
        r"required: allow more with transient\.largest_basis, or lower transient\.maximum_frequency"
    )
    with pytest.raises(SolutionError, match=message):
        frame.basis(loads, largest=20)


def test_lowest_modes_are_those_of_the_building(frame, basis):
    """Of the modes that the loads reach."""
    from impactfem.dynamics.modes import modes

    known = modes(frame.K, frame.model.mass, 3).frequency
    reduced = np.sqrt(np.maximum(basis.model.eigenvalue, 0.0)) / (2.0 * math.pi)
    apart = np.abs(known[:, None] - reduced).min(axis=1)
    assert apart == pytest.approx(np.zeros(3), abs=1e-6)


def test_nodes(frame, basis):
    assert np.array_equal(basis.nodes, recorded_nodes(frame.parts.mesh, frame.nodes))
    twice = np.array([basis.nodes[7], basis.nodes[3], basis.nodes[7]])
    shapes = basis.of(basis.model, twice)
    assert shapes.shape == (3, 3, len(basis.model.eigenvalue))
    assert shapes[0] == pytest.approx(shapes[2], rel=1e-9, abs=1e-12)
    assert np.abs(shapes[0] - shapes[1]).max() > 0.1 * np.abs(shapes[0]).max()
    assert basis.of(basis.model, twice[:0]).shape == (0, 3, len(basis.model.eigenvalue))
    inside = np.setdiff1d(np.arange(len(frame.parts.mesh.nodes)), basis.nodes)
    for node in (inside[0], inside[-1], 10**6):
        with pytest.raises(KeyError, match="not made for"):
            basis.of(basis.model, np.array([basis.nodes[0], node]))


def test_clamped_nodes_do_not_move(frame, loads):
    clamped = frame.parts.mesh.base[:2]
    nodes = np.unique(np.concatenate([frame.nodes, clamped]))
    basis = frame.basis(loads, probes=nodes, nodes=nodes, tolerance=0.1)
    assert not basis.of(basis.model, clamped).any()
    assert basis.of(basis.model, frame.nodes).any()


def test_archive(basis, tmp_path):
    path = tmp_path / "basis.npz"
    write_archive(path, "key", to_arrays(basis))
    content = read_archive(path, "key")
    assert content is not None
    found = from_arrays(ReducedBasis, content)
    assert (found.loads, found.difference) == (basis.loads, basis.difference)
    assert np.array_equal(found.nodes, basis.nodes)
    assert np.array_equal(found.vectors, basis.vectors)
    assert len(found.models) == len(basis.models)
    for one, other in zip(found.models, basis.models, strict=True):
        for field in fields(ReducedModel):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name))

"""The reduced model of the frame against the full one, in time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from impactfem.reduction.response import modal_histories, node_response, node_spectra
from impactfem.spectra import response_spectra

from ..stages.transient.conftest import HIGHEST, TOLERANCE

if TYPE_CHECKING:
    from impactfem.case import Spectra
    from impactfem.reduction.loads import Loads
    from impactfem.reduction.reduced_basis import ReducedBasis
    from impactfem.stages.transient.full_run import FullRun

    from ..stages.transient.conftest import Array, Frame


@pytest.mark.parametrize("name", ["the case's", "light"])
def test_spectra_are_those_of_the_full_model(
    frame: Frame,
    loads: Loads,
    basis: ReducedBasis,
    full_runs: dict[str, tuple[tuple[float, float], FullRun]],
    spectra: Spectra,
    name: str,
) -> None:
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


def test_histories_are_those_of_the_full_model(
    frame: Frame,
    loads: Loads,
    basis: ReducedBasis,
    full_runs: dict[str, tuple[tuple[float, float], FullRun]],
) -> None:
    damping, full = full_runs["light"]
    history = modal_histories(basis, loads, damping, scheme="newmark")
    found = node_response(basis, history, loads, frame.nodes)
    for name in ("displacement", "acceleration"):
        mine, truth = getattr(found, name), getattr(full.response, name)
        assert mine.shape == truth.shape == (1601, len(frame.nodes), 3)
        assert np.abs(mine - truth).max() < 0.005 * np.abs(truth).max()


def test_full_model_comes_to_the_exact_integration_with_order_two(
    frame: Frame, tmp_path: Path
) -> None:
    """Loads that are straight lines over 4 ms, so that all steps see the same ones.

    The highest modes are damped, and the reduced model is far nearer to the truth than the step.
    """
    coarse = frame.loads(4e-3, 100)
    basis = frame.basis(coarse, tolerance=1e-6, damping=frame.damping)
    nodes, damping = frame.nodes, frame.damping

    def finer(factor: int) -> Loads:
        grid = np.arange(100 * factor + 1) / factor

        def straight(values: Array) -> Array:
            return np.column_stack([np.interp(grid, np.arange(101), v) for v in values.T])

        return replace(
            coarse,
            time_step=coarse.time_step / factor,
            ground=straight(coarse.ground),
            force=straight(coarse.force),
        )

    exact = node_response(basis, modal_histories(basis, coarse, damping), coarse, nodes)
    factors, errors = np.array([2, 4, 8]), []
    for factor in factors:
        loads = finer(int(factor))
        full = frame.full(loads, damping, tmp_path / str(factor)).response
        apart = full.displacement[::factor] - exact.displacement
        errors.append(np.sqrt(np.mean(apart**2) / np.mean(exact.displacement**2)))
    order = -np.polyfit(np.log(factors), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.03), errors
    # The exact scheme itself has no error of the step at all.
    loads = finer(8)
    again = node_response(basis, modal_histories(basis, loads, damping), loads, nodes)
    assert again.displacement[::8] == pytest.approx(exact.displacement, abs=1e-12)
    assert again.acceleration[::8] == pytest.approx(exact.acceleration, abs=1e-7)


def test_superposition(frame: Frame, tmp_path: Path) -> None:
    """In full order: each load alone, added, is all of them; doubled, it is twice as much."""
    loads = frame.loads(1e-3, 430)
    nothing = np.zeros_like(loads.force)
    alone = [replace(loads, force=nothing)]
    for k in range(2):
        force = nothing.copy()
        force[:, k] = loads.force[:, k]
        alone.append(replace(loads, ground=np.zeros_like(loads.ground), force=force))
    parts = [
        frame.full(one, frame.damping, tmp_path / str(k)).response for k, one in enumerate(alone)
    ]
    both = replace(loads, ground=2.0 * loads.ground, force=2.0 * loads.force)
    whole = frame.full(both, frame.damping, tmp_path / "all").response
    for name in ("displacement", "acceleration"):
        added = sum(getattr(part, name) for part in parts)
        scale = np.abs(added).max()
        assert 2.0 * added == pytest.approx(getattr(whole, name), abs=1e-8 * scale)
        assert np.abs(getattr(parts[0], name)).max() > 1e-3 * scale


def test_loads_that_the_basis_does_not_have(loads: Loads, basis: ReducedBasis) -> None:
    other = replace(loads, edges=(loads.edges[0], replace(loads.edges[1], name="floor 7")))
    with pytest.raises(KeyError, match="no load floor 7"):
        modal_histories(basis, other, (0.1, 1e-4))


def test_basis_with_more_loads_than_there_are(
    frame: Frame, loads: Loads, basis: ReducedBasis
) -> None:
    """A motion without impacts on floor 1, and in another order of the loads."""
    fewer = replace(loads, edges=loads.edges[:1], force=loads.force[:, :1])
    zero = replace(loads, force=loads.force * [1.0, 0.0])
    swapped = replace(loads, edges=loads.edges[::-1], force=loads.force[:, ::-1])

    def response(of: Loads) -> Array:
        history = modal_histories(basis, of, frame.damping)
        return node_response(basis, history, of, frame.nodes).acceleration

    assert response(fewer) == pytest.approx(response(zero), abs=1e-9)
    assert response(swapped) == pytest.approx(response(loads), abs=1e-9)
    assert np.abs(response(fewer) - response(loads)).max() > 1.0


def test_records_of_the_spectra(frame: Frame, loads: Loads, basis: ReducedBasis) -> None:
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

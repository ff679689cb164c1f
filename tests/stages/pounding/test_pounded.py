"""The pounding of a case's sticks under given motions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import Case, load_case
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.pounding import interpolate_ground, simulate
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.stages.pounding.pounded import pounded


@pytest.fixture(scope="module")
def case(new_case: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Case:
    return load_case(new_case(tmp_path_factory.mktemp("pounded")))


@pytest.fixture(scope="module")
def motions(case: Case) -> tuple[GroundMotion, ...]:
    return ground_motions(case.motions)


def test_by_hand(case: Case, motions: tuple[GroundMotion, ...]) -> None:
    found = pounded(case, calibration_of(case), motions, 1.5)
    dt = case.pounding.time_step
    assert found.time[-1] >= 1.5 > found.time[-1] - 2.0 * dt
    motion = motions[0].accelerogram
    along = "xyz".index(motions[0].direction)
    ground = interpolate_ground(
        [(along, motion.time_step, motion.acceleration)], dt, len(found.time)
    )
    assert np.any(ground[:, along]) and not np.any(np.delete(ground, along, axis=1))
    known = simulate(system_of(case, calibration_of(case)), ground, dt)
    assert np.any(found.force) and np.array_equal(found.force, known.force)
    history = ForceHistory.of_response(found)
    assert history.pairs == tuple(contact.name for contact in case.contacts)
    assert np.array_equal(history.force, known.force)
    assert np.array_equal(history.time, found.time)


def test_update_of_the_case(case: Case, motions: tuple[GroundMotion, ...]) -> None:
    pounding = case.pounding.model_copy(update={"update": "lagged"})
    lagged = case.model_copy(update={"pounding": pounding})
    forces = [pounded(one, None, motions, 1.5).force for one in (case, lagged)]
    assert not np.allclose(*forces)

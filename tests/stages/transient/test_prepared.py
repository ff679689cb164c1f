"""Loads of the 3D building as its case has them."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case.motions import WavePassage
from impactfem.case.transient import Transient
from impactfem.coupling.force_history import ForceHistory
from impactfem.stages.transient.prepared import case_loads
from one_building import building_of


def test_waves_reach_the_3d_building_later(frame):
    """By the way to its axis over their velocity; its neighbour has the motion of the case."""
    (building,) = (one for one in frame.case.buildings if one.name == "F")
    other = building.model_copy(update={"name": "G", "axis": (0.0, -8.0), "structure": None})
    waves = WavePassage(apparent_velocity="100 m/s", direction=(0, 1))
    transient = Transient.model_construct(time_step=1e-3)
    changed = {"buildings": (other, building), "wave_passage": waves, "transient": transient}
    case = frame.case.model_copy(update=changed)
    later = (building.axis[1] + 8.0) / 100.0
    assert case.delays == pytest.approx({"G": 0.0, "F": later})
    time = np.array([0.0, 1.0])
    motion = SimpleNamespace(history=(1, 0.5, np.array([0.0, 1.0, 0.0])))
    still = ForceHistory(time, (), np.zeros((2, 0)))
    found = case_loads(building_of(case), frame.parts.mesh, [motion], still, case.path, 1.0)
    at = found.time_step * np.arange(len(found.ground))
    expected = np.interp(at - later, [0.0, 0.5, 1.0], [0.0, 1.0, 0.0])
    assert found.ground[:, 1] == pytest.approx(expected, abs=1e-12)

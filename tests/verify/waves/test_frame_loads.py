from dataclasses import replace

import numpy as np

from impactfem.verify.waves import frame_loads
from impactfem.verify.waves.shell_motion import MovingModel


def test_the_loads_are_small_before_their_pulses():
    loads = frame_loads._amplitudes()
    assert loads[0].tolist() == [0.0, 0.0, 0.0]
    assert np.abs(loads[:, :2]).max(axis=0).tolist() == [1e6, 0.5e6]
    assert np.abs(loads[-1, :2]).max() < 1e-9


def test_the_weights_are_those_of_the_loads():
    frame = frame_loads.shipped_frame()
    assert np.allclose(frame.weights.sum(axis=1), 1.0)
    at_probes = frame.moving.loads[frame.moving.probes]
    assert np.allclose(at_probes[:, :2], -frame.weights.T)


def test_another_mean_is_not_reciprocal(monkeypatch, failed):
    right = frame_loads.shipped_frame

    def uneven():
        frame = right()
        weights = frame.weights * np.linspace(0.8, 1.2, frame.weights.shape[1])
        return replace(frame, weights=weights)

    monkeypatch.setattr(frame_loads, "shipped_frame", uneven)
    found = failed(frame_loads.reciprocity())
    assert "acceleration of edge 2 by a pulse on edge 1 from the reverse, full" in found
    assert "acceleration of edge 2 by a pulse on edge 1 from the reverse, reduced" in found


def test_a_response_that_is_not_linear_is_seen(monkeypatch, failed):
    right = MovingModel.full

    def stiffening(self, loads, *others):
        history = right(self, loads, *others)
        motion = {k: v * (1.0 - 1e-7 * np.abs(v / v.max())) for k, v in history.motion.items()}
        return replace(history, motion=motion)

    monkeypatch.setattr(MovingModel, "full", stiffening)
    found = failed(frame_loads.superposition())
    assert found == {
        f"{name} under all loads from the sum over each, full"
        for name in ("displacement", "acceleration")
    }

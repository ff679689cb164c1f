import numpy as np

from impactfem.dynamics.history import State


def test_a_copy_is_its_own():
    state = State(3, *np.arange(10.0).reshape(5, 2), damped=1.0, input=2.0)
    other = state.copy()
    for name in ("displacement", "velocity", "acceleration", "momentum", "restoring"):
        values = getattr(state, name)
        before = values.copy()
        values += 1.0
        assert np.array_equal(getattr(other, name), before)
    assert (other.step, other.damped, other.input) == (3, 1.0, 2.0)

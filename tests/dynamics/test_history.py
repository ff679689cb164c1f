import numpy as np
import pytest
from petsc4py import PETSc

from impactfem.dynamics.columns import combined, inner, product, row_of_largest
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import Recorder, State, joined
from impactfem.system.errors import SolutionError


@pytest.fixture
def recorder(petsc):
    def make(*arguments):
        return Recorder(petsc(np.eye(4)), *arguments, time_step=0.5)

    return make


def state(step, value):
    u = value + np.arange(4.0)
    return State(step, u, 10.0 * u, 100.0 * u, np.zeros(4), np.zeros(4))


def test_parts_and_history(recorder):
    recording = recorder([2, 0, 2], ("acceleration", "displacement"), 2)
    recording.put(state(5, 1.0), (1.0, 2.0, 3.0, 4.0))
    now = state(6, 2.0)
    recording.put(now, (5.0, 6.0, 7.0, 8.0))
    part = recording.reduce(now)
    assert (now.damped, now.input) == (10.0, 12.0)
    now.step = 7
    recording.put(now, (0.0, 0.0, 1.0, 1.0))
    recording.reduce(now)
    assert part.time.tolist() == [2.5, 3.0]
    assert part.motion["displacement"].tolist() == [[3.0, 1.0, 3.0], [4.0, 2.0, 4.0]]
    history = joined(recording.parts)
    assert history.time.tolist() == [2.5, 3.0, 3.5]
    assert list(history.motion) == ["acceleration", "displacement"]
    assert history.motion["acceleration"].tolist() == [[300, 100, 300], *[[400, 200, 400]] * 2]
    assert history.energy.kinetic.tolist() == [1.0, 5.0, 0.0]
    assert history.energy.elastic.tolist() == [2.0, 6.0, 0.0]
    assert history.energy.damped.tolist() == [3.0, 10.0, 11.0]
    assert history.energy.input.tolist() == [4.0, 12.0, 13.0]


def test_nothing_recorded(recorder):
    recording = recorder([], (), 3)
    now = state(0, 0.0)
    recording.put(now, (0.0, 0.0, 0.0, 0.0))
    assert recording.reduce(now).motion == {}


@pytest.mark.parametrize(
    ("probes", "record", "said"),
    [([4], ["velocity"], "row 4"), ([-1], ["velocity"], "row -1"), ([0], ["speed"], "speed")],
)
def test_what_cannot_be_recorded(recorder, probes, record, said):
    with pytest.raises(SolutionError, match=f"cannot record {said}"):
        recorder(probes, record, 10)


def test_numbers_that_are_none(recorder):
    recording = recorder([0], ("velocity",), 3)
    now = state(9, np.nan)
    recording.put(now, (0.0, 0.0, 0.0, 0.0))
    with pytest.raises(SolutionError, match="finite before step 9"):
        recording.reduce(now)


def test_products(petsc):
    rng = np.random.default_rng(1)
    A, X = rng.standard_normal((5, 5)), rng.standard_normal((5, 3))
    assert product(petsc(A), X) == pytest.approx(A @ X, rel=1e-13)
    assert product(petsc(A), np.asfortranarray(X)).flags.f_contiguous
    assert inner(petsc(A), X, X) == pytest.approx(X.T @ X, rel=1e-13)


def test_row_of_largest(petsc):
    A = petsc(np.eye(4))
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 2.0])) == 1
    # Nearly the same counts as the same: the first.
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-9])) == 1
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-3])) == 3


def dense(A):
    return A.convert("dense").getDenseArray()


def test_combined(petsc, chain):
    K, M = petsc(chain(4)), petsc(np.diag([1.0, 2.0, 3.0, 4.0]))
    S = combined(2.0, K, -0.5, M)
    assert dense(S) == pytest.approx(2.0 * chain(4) - 0.5 * np.diag([1.0, 2.0, 3.0, 4.0]))
    assert dense(K) == pytest.approx(chain(4))


def test_a_mass_off_the_pattern_is_refused(petsc, chain):
    with pytest.raises(PETSc.Error):
        combined(1.0, petsc(np.eye(4)), 1.0, petsc(chain(4)))


def test_residual_of_a_start_with_energy():
    """Relative to the energy stored, where no work is done; a part of a history has one too."""
    stored, nothing = np.array([8.0, 6.0]), np.zeros(2)
    damped = np.array([3.0, 4.9])
    assert Energy(stored, nothing, damped, nothing).residual == pytest.approx(0.1 / 8.0)


BALANCED = {
    "kinetic": [5.0, 3.0, 1.0],
    "elastic": [0.0, 2.0, 3.0],
    "damped": [0.0, 0.5, 1.0],
    "numerical": [0.0, 0.5, 1.0],
    "input": [0.0, 1.0, 2.0],
    "contact": [0.0, 0.0, -1.0],
}


def energy(**parts):
    names = {**dict.fromkeys(BALANCED, (0.0, 0.0, 0.0)), **parts}
    return Energy(**{name: np.array(values) for name, values in names.items()})


@pytest.mark.parametrize("name", ["damped", "numerical", "input", "contact"])
def test_a_balance_of_all_parts(name):
    """2 J come in, 5 J are there; 1 J each goes to the damping, the rule and the contact."""
    assert energy(**BALANCED).residual == energy(**BALANCED).gained == 0.0
    wrong = {**BALANCED, name: np.add(BALANCED[name], [0.0, 0.0, 0.5])}
    assert energy(**wrong).residual == pytest.approx(0.1)


def test_what_the_contact_gains():
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, -1.0, -0.8]).gained == pytest.approx(0.05)
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, 0.4, 0.4]).gained == pytest.approx(0.1)
    assert energy(input=[0.0, -9.0, 0.0]).scale == 9.0
    nothing = energy()
    assert nothing.gained == nothing.residual == nothing.scale == 0.0

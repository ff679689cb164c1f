"""Gap, floor acceleration and storey drift against limits."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case.capacities import Limits
from impactfem.stages.pounding.limits import code_gap, level_floors, pounding_verdicts
from impactfem.stages.pounding.peaks import storey_drifts
from impactfem.stages.pounding.store import write_sticks

# Debian's h5py on the NumPy 1.26 of the virtual environment.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


@pytest.mark.parametrize(
    ("rule", "level", "gap"),
    [
        # Displacements of 60 and 80 mm: the root of the sum of their squares is 100 mm.
        ("en1998", False, 0.100),
        ("en1998", True, 0.070),
        ("asce7", False, 0.100),
        ("asce7", True, 0.100),
    ],
)
def test_gap_of_the_codes_by_hand(rule, level, gap):
    assert code_gap(rule, 0.06, 0.08, level=level) == pytest.approx(gap, rel=1e-12)


def test_gap_at_a_wall_is_the_displacement():
    assert code_gap("en1998", 0.06, 0.0, level=False) == pytest.approx(0.06)


@pytest.mark.parametrize(
    ("a", "b", "level"),
    [
        ((3.0, 6.0), (3.05, 6.0, 9.0), True),
        ((3.0, 6.0), (3.2, 6.0), False),
        ((3.0, 6.0), (3.0, 6.0), True),
        # A floor of the higher building between the roof of the lower one and the floor below.
        ((3.0, 6.0), (3.0, 4.5, 6.0), False),
        ((3.0, 6.0), (2.95, 6.05, 6.1), False),
    ],
)
def test_level_floors(a, b, level):
    buildings = [SimpleNamespace(levels=dict(enumerate(one, 1))) for one in (a, b)]
    assert level_floors(*buildings) == level == level_floors(*reversed(buildings))


@pytest.fixture(scope="module")
def folder(study, tmp_path_factory):
    path = tmp_path_factory.mktemp("limits")
    write_sticks(path / "pounding.nc", study, "key")
    return path


@pytest.fixture
def verdicts(study, folder):
    def found(**limits):
        case = study.case.model_copy(update={"limits": Limits(**limits)})
        return {one.id.partition(".")[2]: one for one in pounding_verdicts(case, folder)}

    return found


@pytest.mark.parametrize(("rule", "factor"), [("en1998", 0.7), ("asce7", 1.0)])
def test_gap_of_a_run(study, verdicts, rule, factor):
    """By the largest displacements without contact of the floors of each pair."""
    one = verdicts(gap=rule)["code_gap"]
    gaps = []
    for pair in study.system.pairs:
        ends = [
            np.abs(study.free.u[:, study.system.floor_dofs(end.building)[end.floor - 1, 1]]).max()
            for end in (pair.a, pair.b)
        ]
        gaps.append(factor * np.sqrt(ends[0] ** 2 + ends[1] ** 2))
    assert level_floors(*study.case.buildings)
    assert one.demand == pytest.approx(max(gaps), rel=1e-9)
    assert one.capacity == study.system.pairs[0].gap and one.key == "limits.gap"
    # The time history, with its phases, requires at most the sum of both.
    required = verdicts()["required_gap"]
    assert required.demand == pytest.approx(study.required_separation)
    assert required.key == ""


def test_limits_that_pass_and_fail(verdicts):
    without = verdicts()
    for name, kind in (("storey_drift", "storey_drift"), ("floor_acceleration",) * 2):
        demand = without[kind].demand
        assert without[kind].passed is None and without[kind].key == f"limits.{name}"
        assert verdicts(**{name: 1.01 * demand})[kind].passed is True
        assert verdicts(**{name: 0.99 * demand})[kind].passed is False
    assert without["code_gap"].demand is None


def test_drift_of_a_storey_by_hand(study):
    """10 mm and 30 mm at the first two floors of a storey height h each: 20 mm / h."""
    stick = study.system.sticks[0]
    u = np.zeros_like(study.response.u)
    dofs = study.system.floor_dofs(stick.name)
    u[5, dofs[:2, 0]], u[5, dofs[2, 0]] = (0.010, 0.030), 0.030
    heights = np.diff([stick.base, *stick.positions[:3, 2]])
    found = storey_drifts(replace(study.response, u=u), stick)
    assert found == pytest.approx(np.array([0.010, 0.020, 0.0]) / heights)


def test_rotation_of_the_base_is_no_drift(study):
    stick = study.system.sticks[0]
    base = np.zeros((len(study.response.u), 6))
    base[:, 3] = 1e-3
    u = np.zeros_like(study.response.u)
    for dofs, z in zip(study.system.floor_dofs(stick.name), stick.positions[:, 2], strict=False):
        u[:, dofs[1]] = -1e-3 * (z - stick.base)
    turned = replace(study.response, u=u, bases={stick.name: SimpleNamespace(u=base)})
    assert storey_drifts(turned, stick) == pytest.approx(np.zeros(3), abs=1e-12)
    assert storey_drifts(replace(turned, bases={}), stick) == pytest.approx(np.full(3, 1e-3))

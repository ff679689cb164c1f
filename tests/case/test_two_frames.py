"""The second shipped case, as it is in geometry/."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import Case, RecordMotion, load_case
from impactfem.records import read_record

GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case(GEOMETRY / "two_frames.toml")


def test_points_in_contact_are_level_and_the_gap_apart(case: Case) -> None:
    """A point of a storey lies in its flexible part, between the rigid zones of its floors."""
    for contact in case.contacts:
        a, b = case.building(contact.a.building), case.building(contact.b.building)
        distance = (b.axis[1] + contact.b.offset[1]) - (a.axis[1] + contact.a.offset[1])
        assert distance == pytest.approx(contact.gap, abs=1e-12)
        assert contact.a.floor is not None
        height = a.elevations[contact.a.floor - 1]
        if contact.b.floor is not None:
            assert b.elevations[contact.b.floor - 1] == pytest.approx(height)
            continue
        assert contact.b.storey is not None and contact.b.relative_height is not None
        below = (0.0, *b.elevations)[contact.b.storey - 1]
        low = below + (b.rigid_above if contact.b.storey > 1 else 0.0)
        high = b.elevations[contact.b.storey - 1] - b.rigid_below
        # Three digits of the relative height.
        assert low + contact.b.relative_height * (high - low) == pytest.approx(height, abs=2e-3)


def test_only_the_roof_of_b_is_level_with_a_floor_of_a(case: Case) -> None:
    a, b = (np.array(case.building(name).elevations) for name in "AB")
    near = np.abs(a[:, None] - b).min(axis=0)
    assert near[-1] < 1e-9
    assert np.all(near[:-1] > 0.4)


def test_masses_and_inertias_of_the_floors(case: Case) -> None:
    """Plates of 18 m by 12 m and 18 m by 10 m."""
    for name, width in (("A", 12.0), ("B", 10.0)):
        for floor in case.building(name).floors:
            assert floor.Jx == pytest.approx(floor.mass * width**2 / 12.0, rel=0.01)
            assert floor.Jy == pytest.approx(floor.mass * 18.0**2 / 12.0, rel=0.01)
            assert floor.Jz == pytest.approx(floor.Jx + floor.Jy, rel=0.01)


@pytest.mark.parametrize("direction", ["x", "y"])
def test_motions_say_that_they_are_synthetic(case: Case, direction: str) -> None:
    (motion,) = (m for m in case.motions if m.direction == direction)
    assert isinstance(motion, RecordMotion)
    assert "NOT A RECORD OF AN EARTHQUAKE" in read_record(motion.file).origin


def test_motions_can_be_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["two_frames_motion.py", str(tmp_path)])
    runpy.run_path(str(GEOMETRY / "two_frames_motion.py"), run_name="__main__")
    made = {d: read_record(tmp_path / f"two_frames_{d}.AT2").acceleration for d in "xy"}
    for direction, acceleration in made.items():
        shipped = read_record(GEOMETRY / f"two_frames_{direction}.AT2").acceleration
        assert acceleration == pytest.approx(shipped, abs=1e-6)
    assert np.abs(made["x"] - made["y"]).max() > 1.0

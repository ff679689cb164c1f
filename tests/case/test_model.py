"""What a case says of itself: the direction and the floor that its results are told of."""

from __future__ import annotations

from pathlib import Path

import pytest

from impactfem.case import Case, load_case

GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def frames() -> Case:
    return load_case(GEOMETRY / "two_frames.toml")


def turned(case: Case, *normals: tuple[float, float, float]) -> Case:
    """The case with contacts along these normals only."""
    contacts = tuple(case.contacts[0].model_copy(update={"normal": n}) for n in normals)
    return case.model_copy(update={"contacts": contacts})


def test_results_are_told_along_the_pounding(frames: Case) -> None:
    """The first motion is along x, the buildings pound along y."""
    assert [motion.direction for motion in frames.motions] == ["x", "y"]
    assert frames.shown_direction == "y"
    assert turned(frames, (-1.0, 0.0, 0.0)).shown_direction == "x"
    assert turned(frames, (0.6, 0.8, 0.0)).shown_direction == "y"


def test_without_a_motion_along_the_pounding_the_first_one_is_told(frames: Case) -> None:
    assert turned(frames).shown_direction == "x"
    assert turned(frames, (0.0, 0.0, 1.0)).shown_direction == "x"
    alone = frames.model_copy(update={"motions": frames.motions[:1]})
    assert alone.shown_direction == "x"


def test_waves_are_looked_at_where_the_building_may_be_struck(frames: Case) -> None:
    assert frames.wave_floor == 5
    assert frames.model_copy(update={"contacts": frames.contacts[1:]}).wave_floor == 4
    assert turned(frames).wave_floor == 6
    assert load_case(GEOMETRY / "npp_pair.toml").wave_floor == 8


def test_without_a_structure_there_are_no_waves(frames: Case) -> None:
    with pytest.raises(ValueError, match="no structure"):
        _ = frames.model_copy(update={"structure": None}).wave_floor

"""The gaps that are given beside those by axis and offset."""

from math import inf, nan

import pytest

from impactfem.stages.pounding.checks import distance_check


@pytest.mark.parametrize(
    ("gap", "distance", "good"),
    [
        # A millimetre, or a tenth of the gap.
        (0.005, 0.0059, True),
        (0.005, 0.0061, False),
        (0.04, 0.0437, True),
        (0.04, 0.0443, False),
        (0.0, -0.0009, True),
        # Metres for inches.
        (1.2, 0.03, False),
    ],
)
def test_one_pair(gap: float, distance: float, good: bool) -> None:
    ((found, text),) = distance_check(["a-b"], [gap], [distance])
    assert found is good
    if good:
        assert text == "contact: 1 gaps are those of axes and offsets"
    else:
        assert f"the points of a-b are {distance:.4g} m apart" in text
        assert f"its gap is {gap:.4g} m; the gap counts" in text


def test_the_worst_is_named() -> None:
    names, gaps = ["a-b", "b-c", "c-d", "d-e"], [0.01, 0.01, 0.01, 0.01]
    ((good, text),) = distance_check(names, gaps, [0.03, 0.5, 0.01, nan])
    assert good is False
    assert "the points of b-c are 0.5 m apart" in text and text.endswith("so it is for 1 more")


@pytest.mark.parametrize("distances", [[], [nan, nan]])
def test_nothing_is_known(distances: list[float]) -> None:
    names, gaps = ["a-b"] * len(distances), [inf] * len(distances)
    assert distance_check(names, gaps, distances) == []

"""Where the sides of a plan are struck, by hand."""

import math

import pytest

from impactfem.case.facade import Facade, moved_into_plan, rectangle, struck

LENGTH, WIDTH = 46.2, 15.6


@pytest.mark.parametrize(
    ("normal", "point", "edge", "side", "s"),
    [
        ((0, 1), (23.1, 15.6), "y+", "", 23.1),
        ((0, 1), (23.1, 15.6), "y-", "y+", 23.1),  # another side than the impact edge
        ((0, -1), (23.1, 0.1), "y+", "y-", 23.1),
        ((0, 1), (0.0, 15.6), "y+", "", 0.0),  # a corner
        ((0, 1), (27.1, 7.8), "y+", "", 27.1),  # from within: the side that it leads to
        ((1, 0), (46.2, 9.8), "y+", "x+", 9.8),
        ((3, 4), (24.1, 15.6), "y+", "", 24.1),  # oblique: at the point itself
        ((3, 4), (23.1, 7.8), "y+", "", 28.95),  # and along it from within, 7.8 m x 3/4 further
        ((3, 4), (24.1, 15.2), "y+", "", 24.4),
        ((1e-6, 1), (23.1, 7.8), "y+", "", 23.1),  # meant at right angles
        ((1, 0.99), (46.2, 15.6), "y+", "x+", 15.6),  # a corner between two sides
        ((0.99, 1), (46.2, 15.6), "y+", "", 46.2),
    ],
)
def test_a_rectangle(normal, point, edge, side, s):
    size = math.hypot(*normal)
    found = struck(rectangle(LENGTH, WIDTH, edge), point, (normal[0] / size, normal[1] / size, 0.0))
    assert found is not None
    assert (found[0].side, found[1]) == (side, pytest.approx(s, abs=1e-4 if size < 1.1 else 1e-12))


@pytest.mark.parametrize(
    ("normal", "point"),
    [
        ((0.0, 1.0), (46.3, 15.6)),  # beyond a corner
        ((1.0, 0.0), (23.1, 15.6)),  # along the side that the point is on
        ((0.0, -1.0), (23.1, 15.6)),  # into the building
    ],
)
def test_what_is_struck_nowhere(normal, point):
    assert struck(rectangle(LENGTH, WIDTH, "y+"), point, (*normal, 0.0)) is None


def test_an_inner_side_of_an_angled_plan():
    """The side that the point is on; from within the outermost one."""
    sides = [
        Facade("y+", (0.0, 4.0), (6.0, 4.0), (0.0, 1.0, 0.0)),
        Facade("y+#2", (0.0, 9.0), (3.0, 9.0), (0.0, 1.0, 0.0)),
    ]
    for y, expected in ((4.0, "y+"), (2.0, "y+#2"), (9.0, "y+#2")):
        found = struck(sides, (2.0, y), (0.0, 1.0, 0.0))
        assert found is not None and found[0].side == expected


def test_a_stick_in_other_coordinates_is_in_the_middle():
    plan = (0.0, 0.0), (LENGTH, WIDTH)
    assert moved_into_plan((20.0, 5.0), (1.0, 2.0, 0.0), *plan) == (21.0, 7.0)
    assert moved_into_plan((20.0, 25.0), (1.0, 2.0, 0.0), *plan) == pytest.approx((24.1, 9.8))

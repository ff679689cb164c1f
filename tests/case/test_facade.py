"""Sides that are struck, and distances of pairs."""

import math

import pytest

from impactfem.case import load_case
from impactfem.case.contact_checks import pair_distance
from impactfem.case.facade import Facade, axis_in_plan, rectangle, struck

from .faults import refused

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


MIDDLE = (0.5 * LENGTH, 0.5 * WIDTH)


@pytest.mark.parametrize(
    ("axis", "offsets", "expected"),
    [
        ((20.0, 5.0), [], (20.0, 5.0)),  # within the plan
        ((20.0, 25.0), [], MIDDLE),
        ((20.0, 5.0), [(1.0, -5.0)], (20.0, 5.0)),  # on the side as it stands
        # Within the plan by chance: on its side from the middle alone.
        ((20.0, 5.0), [(1.0, -7.8)], MIDDLE),
        ((20.0, 5.0), [(1.0, -7.8), (1.0, 7.8)], MIDDLE),
        # All points say it together: one as it stands is enough, and so is one on neither.
        ((20.0, 5.0), [(1.0, -7.8), (1.0, 10.6)], (20.0, 5.0)),
        ((20.0, 5.0), [(1.0, -7.8), (0.0, 0.0)], (20.0, 5.0)),
    ],
)
def test_the_axis_of_a_stick_in_the_plan(axis, offsets, expected):
    sides = rectangle(LENGTH, WIDTH, "y-")
    points = [(sides, (x, y, 0.0), (0.0, 1.0 if y > 0.0 else -1.0, 0.0)) for x, y in offsets]
    found = axis_in_plan(axis, (0.0, 0.0), (LENGTH, WIDTH), points)
    assert found == pytest.approx(expected)


AXES = 'axis = ["23.1 m", "7.8 m"]', 'axis = ["23.1 m", "23.41 m"]'
NORMAL = "normal = [0, 1, 0]"


@pytest.mark.parametrize(
    ("edits", "distance"),
    [
        ([], 0.01),
        ([(None, AXES[1], 'axis = ["23.1 m", "24.4 m"]')], 1.0),
        # Within what counts as rounding, to either side.
        ([(None, AXES[1], 'axis = ["23.1 m", "23.3995 m"]')], -0.0005),
        # 45 degrees: the same points are nearer along it.
        ([(None, NORMAL, "normal = [1, 1, 0]")], 0.01 / math.sqrt(2.0)),
        # No plan, and a normal along which heights count, too.
        ([(None, AXES[1], AXES[0])], math.nan),
        ([(None, NORMAL, "normal = [0, 1, 0.01]")], math.nan),
    ],
)
def test_distance(broken, edits, distance):
    case = load_case(broken(*edits, (None, "title = ", 'allow = "gap"\ntitle = ')))
    found = [pair_distance(contact, case) for contact in case.contacts]
    assert found == pytest.approx([distance] * 8, abs=1e-12, nan_ok=True)


def test_a_normal_from_b_to_a_is_refused(broken):
    path = broken((None, NORMAL, "normal = [0, -1, 0]"))
    refused(path, "contacts[0].normal", "of_contacts -0.01 m")


def test_buildings_in_one_another_are_refused(broken):
    path = broken((None, AXES[1], 'axis = ["23.1 m", "22.4 m"]'))
    refused(path, "contacts[0]", "of_contacts -1 m")

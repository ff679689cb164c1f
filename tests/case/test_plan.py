"""Plans as polygons: sides, insets, overlaps, and the lengths over which plans face each other."""

import math

import pytest

from impactfem.case.plan import (
    area,
    counterclockwise,
    inset,
    moved,
    opposites,
    overlap,
    plan_fault,
    rectangle_plan,
    sides_of,
)

L = ((0.0, 0.0), (10.0, 0.0), (10.0, 4.0), (4.0, 4.0), (4.0, 9.0), (0.0, 9.0))
"""An angle: a wing of 10 m x 4 m, and one of 4 m x 5 m upwards at its left end."""
T = ((-1.0, 10.0), (12.0, 10.0), (12.0, 13.0), (8.0, 13.0), (8.0, 18.0), (-1.0, 18.0))


def turned(polygon, angle, about=(0.0, 0.0)):
    c, s = math.cos(angle), math.sin(angle)
    x0, y0 = about
    return tuple(
        (x0 + c * (x - x0) - s * (y - y0), y0 + s * (x - x0) + c * (y - y0)) for x, y in polygon
    )


def test_rectangles_that_face_each_other():
    a, b = rectangle_plan(46.2, 15.6), rectangle_plan(30.0, 10.0, (10.0, 12.81))
    (found,) = opposites(a, b)
    # From -5 m to 23.1 m.
    assert (found.normal, found.length) == ((0.0, 1.0, 0.0), pytest.approx(28.1, abs=1e-12))
    assert (found.gap, found.gap_slope) == (pytest.approx(0.01, abs=1e-12), 0.0)
    assert found.a == pytest.approx((9.05, 7.8))
    assert found.b == pytest.approx((9.05, 7.81))
    (back,) = opposites(b, a)
    assert (back.normal, back.a, back.b) == ((-0.0, -1.0, 0.0), found.b, found.a)


def test_no_common_length():
    a = rectangle_plan(10.0, 10.0)
    assert opposites(a, rectangle_plan(10.0, 10.0, (10.5, 10.5))) == ()  # corner to corner
    assert opposites(a, rectangle_plan(10.0, 10.0, (10.0, 10.5))) == ()  # a line of no length


def test_an_angle_against_a_tee():
    """Closed form: the T of a flange 13 m x 3 m below and a web 9 m x 5 m stands above the L."""
    found = opposites(L, T)
    # The short wing of the L, 4 m at 1 m; the long wing, from x = 4 m to 10 m, at 6 m.
    assert [(one.length, one.gap) for one in found] == [
        (pytest.approx(4.0), pytest.approx(1.0)),
        (pytest.approx(6.0), pytest.approx(6.0)),
    ]
    assert [one.a for one in found] == [pytest.approx((2.0, 9.0)), pytest.approx((7.0, 4.0))]
    # The L turned upside down beside the web: web against its right, flange against its bottom.
    wing = moved(((0.0, 0.0), (3.0, 0.0), (3.0, 9.0), (0.0, 9.0)), (8.5, 13.2))
    near = opposites(wing, T)
    assert sorted((one.normal[:2], one.length, one.gap) for one in near) == [
        ((-1.0, 0.0), pytest.approx(4.8), pytest.approx(0.5)),
        ((0.0, -1.0), pytest.approx(3.0), pytest.approx(0.2)),
    ]


def test_a_wing_hides_what_is_behind_it():
    """Within the court of a U nothing outside is met; the wings are."""
    u = ((0, 0), (12, 0), (12, 8), (9, 8), (9, 3), (3, 3), (3, 8), (0, 8))
    u = tuple((float(x), float(y)) for x, y in u)
    found = opposites(u, rectangle_plan(12.0, 4.0, (6.0, 10.5)))
    assert sorted((one.a[0], one.length, one.gap) for one in found) == [
        (pytest.approx(1.5), 3.0, pytest.approx(0.5)),
        (pytest.approx(6.0), 6.0, pytest.approx(5.5)),
        (pytest.approx(10.5), 3.0, pytest.approx(0.5)),
    ]
    # A third building in the court hides a part of it.
    third = (rectangle_plan(2.0, 2.0, (5.0, 5.0)),)
    court = opposites(u, rectangle_plan(12.0, 4.0, (6.0, 10.5)), third)
    assert sorted(one.length for one in court) == pytest.approx([1.0, 3.0, 3.0, 3.0])


@pytest.mark.parametrize("angle", [1.0, 5.0, 29.0])
def test_skew_facades(angle):
    """The upper building turned about its lower left corner: the gap is that of two lines."""
    ψ = math.radians(angle)
    a = rectangle_plan(100.0, 10.0)
    b = turned(((0.0, 5.2), (20.0, 5.2), (20.0, 15.2), (0.0, 15.2)), ψ, (0.0, 5.2))
    (found,) = opposites(a, b)
    half = 0.5 * ψ
    # The normal is the bisector; along it both sides rise by tan ψ/2, one down and one up.
    assert found.normal == pytest.approx((-math.sin(half), math.cos(half), 0.0), abs=1e-14)
    assert found.length == pytest.approx(20.0 * math.cos(half), rel=1e-13)
    # Counted to the left of the normal.
    assert found.gap_slope == pytest.approx(-2.0 * math.tan(half), rel=1e-12)
    # At the corner the line along n meets the side of a after 0.2 m / cos ψ/2.
    assert found.least_gap == pytest.approx(0.2 / math.cos(half), abs=1e-8)
    apart = [q - p for p, q in zip(found.a, found.b, strict=True)]
    assert math.hypot(*apart) == pytest.approx(found.gap, abs=1e-8)


def test_sides_too_skew_do_not_face_each_other():
    b = turned(rectangle_plan(20.0, 10.0, (0.0, 20.0)), math.radians(40.0), (0.0, 20.0))
    assert opposites(rectangle_plan(20.0, 10.0), b) == ()


def test_an_inset():
    assert area(inset(L, 1.0)) == pytest.approx(8.0 * 2.0 + 2.0 * 5.0)
    assert inset(L, 2.0) is None  # both wings are 4 m wide
    assert inset(L, 0.0) is L


def test_overlapping_plans():
    a = rectangle_plan(10.0, 10.0)
    assert overlap(a, rectangle_plan(2.0, 2.0))
    assert overlap(rectangle_plan(2.0, 2.0), a)
    assert overlap(a, rectangle_plan(10.0, 2.0, (5.0, 0.0)))
    assert overlap(a, rectangle_plan(20.0, 2.0))  # a cross: no corner inside the other plan
    assert not overlap(a, rectangle_plan(10.0, 10.0, (0.0, 10.0)))  # they touch
    assert not overlap(L, rectangle_plan(4.0, 3.0, (7.0, 6.5)))  # in the angle of the L


def test_sides_of_a_plan():
    assert [one.side for one in sides_of(L)] == ["y-", "x+", "y+", "x+#2", "y+#2", "x-"]
    assert all(one.start < one.end for one in sides_of(L))


@pytest.mark.parametrize(
    ("corners", "word"),
    [
        (((0.0, 0.0), (1.0, 0.0)), "three corners"),
        (((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)), "corner 2"),
        (((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)), "corners 1 and 3"),
        (((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), "area"),
    ],
)
def test_corners_that_are_no_plan(corners, word):
    assert word in plan_fault(corners)
    assert plan_fault(L) == ""


def test_clockwise_corners_are_turned_round():
    assert counterclockwise(L[::-1]) == L
    assert counterclockwise(L) == L

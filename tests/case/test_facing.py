"""Floors that face each other and are in no pair; sides that are struck, distances of pairs."""

import math
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.contact_checks import pair_distance
from impactfem.case.facade import Facade, axis_in_plan, rectangle, struck
from impactfem.case.facing import facing_floors

from .faults import refused

GEOMETRY = Path(__file__).parents[2] / "geometry"
ROOFS, LOW = "B.floor_4-C.floor_3", "B.floor_1-C.storey_1_at_0.833"


@pytest.fixture(scope="module")
def row():
    """A, B and C in a row along y; each floor in a pair with each neighbour."""
    return load_case(GEOMETRY / "row_of_three.toml")


def without(case, *names):
    assert set(names) <= {contact.name for contact in case.contacts}
    kept = tuple(contact for contact in case.contacts if contact.name not in names)
    return case.model_copy(update={"contacts": kept})


def of_b_and_c(case):
    return [c.name for c in case.contacts if {c.a.building, c.b.building} == {"B", "C"}]


def changed(case, name, **keys):
    """One building with other keys."""
    buildings = tuple(
        one.model_copy(update=keys) if one.name == name else one for one in case.buildings
    )
    return case.model_copy(update={"buildings": buildings})


def turned(case):
    """The same row along x: x and y of all that lies in plan are exchanged."""

    def turn(point):
        x, y, z = point.offset
        return point.model_copy(update={"offset": (y, x, z)})

    def plan(one):
        return {"axis": one.axis[::-1], "length": one.width, "width": one.length}

    contacts = tuple(
        c.model_copy(update={"a": turn(c.a), "b": turn(c.b), "normal": (1.0, 0.0, 0.0)})
        for c in case.contacts
    )
    buildings = tuple(one.model_copy(update=plan(one)) for one in case.buildings)
    return case.model_copy(update={"contacts": contacts, "buildings": buildings})


def names(case):
    found = facing_floors(case)
    assert found.overlapping == found.unknown == ()
    return [one.name for one in found.pairs]


@pytest.mark.parametrize("name", ["npp_pair", "two_frames", "frame", "row_of_three"])
def test_the_shipped_cases_are_silent(name):
    found = facing_floors(load_case(GEOMETRY / f"{name}.toml"))
    assert found.lines() == found.unknown_lines == []


def test_columns_behind_the_edge():
    """Floors of B reach A's columns nowhere, as these stand back; where they do not, they are."""
    case = load_case(GEOMETRY / "two_frames.toml")
    assert [one.gap for one in facing_floors(case).pairs] == pytest.approx([1.54] * 3)
    flush = changed(case, "A", setback=0.0)
    assert [(one.a.label, one.b.storey) for one in facing_floors(flush).near] == [
        ("B.floor_1", 2),
        ("B.floor_2", 3),
        ("B.floor_3", 4),
    ]


@pytest.mark.parametrize("make", [lambda case: case, turned])
def test_a_missing_pair_is_found(row, make):
    case = make(without(row, ROOFS))
    (found,) = facing_floors(case).pairs
    assert found.name == ROOFS
    assert (found.gap, found.level, found.half) == pytest.approx((0.03, 12.0, 6.0))
    assert found.reach == pytest.approx(0.025 * 24.0)  # a drift of both
    assert found.normal == ((0.0, 1.0, 0.0) if case.contacts[0].normal[1] else (1.0, 0.0, 0.0))
    (line,) = facing_floors(case).lines()
    assert line.startswith(
        "contacts: floors that face each other and are in no pair: B.floor_4 and C.floor_3 (30 mm "
        "apart at 12 m); list them in [[contacts]]"
    )
    assert names(make(row)) == []


def test_floors_against_storeys(row):
    """Both ways, with the heights that the pairs of the case have."""
    missing = of_b_and_c(row)
    assert sorted(names(without(row, *missing))) == [
        LOW,
        "B.floor_2-C.storey_2_at_0.543",
        "B.floor_3-C.storey_3_at_0.257",
        ROOFS,
        "C.floor_1-B.storey_2_at_0.36",
        "C.floor_2-B.storey_3_at_0.76",
    ]
    (line,) = facing_floors(without(row, *missing)).lines(most=2)
    assert "4 more; list them" in line


def test_the_plan_by_offsets_alone(row):
    """Without length and width: from the offsets of the pairs that are listed."""
    case = row
    for name in "ABC":
        case = changed(case, name, length=None, width=None)
    (found,) = facing_floors(without(case, ROOFS)).pairs
    assert (found.name, found.gap) == (ROOFS, pytest.approx(0.03))
    # With no pair of C its plan is not known: a line says which keys would give it.
    silent = facing_floors(without(case, *of_b_and_c(row)))
    assert (silent.pairs, silent.overlapping) == ((), ())
    (line,) = silent.unknown_lines
    assert "cannot be checked" in line
    assert "plan of B and C:" in line
    # In line with B: how long B is does not matter.
    listed = without(case, *of_b_and_c(row)).contacts
    in_line = changed(case, "C", axis=(7.0, 24.05)).model_copy(update={"contacts": listed})
    (line,) = facing_floors(in_line).unknown_lines
    assert "plan of C: length" in line
    # One width is enough for the gap, as the axes are nearly in line and B's is known.
    known = changed(without(case, *of_b_and_c(row)), "C", width=12.0, length=12.0)
    assert ROOFS in {one.name for one in facing_floors(known).pairs}


def test_the_plan_of_a_generated_mesh():
    case = load_case(GEOMETRY / "npp_pair.toml").model_copy(update={"contacts": ()})
    (line,) = facing_floors(case).unknown_lines
    assert "plan of B2:" in line
    known = changed(case, "B2", length=46.2, width=15.6)
    gaps = [one.gap for one in facing_floors(known).pairs]
    assert gaps == pytest.approx([0.01] * 8)


def test_a_floor_with_a_size_of_its_own(row):
    """A roof that stands back by a metre; the first floor that is wider than the others."""
    case = without(row, ROOFS)
    floors = list(case.building("C").floors)
    floors[2] = floors[2].model_copy(update={"width": 10.0})
    (found,) = facing_floors(changed(case, "C", floors=tuple(floors))).pairs
    assert found.gap == pytest.approx(1.03)
    assert found not in facing_floors(changed(case, "C", floors=tuple(floors))).near


def test_buildings_that_overlap_in_projection_in_part_or_not_at_all(row):
    case = without(row, *of_b_and_c(row))
    aside = changed(case, "C", axis=(19.0, 24.05))  # from x = 13 m on, B ends at 14 m
    found = facing_floors(aside).pairs
    assert {one.half for one in found} == {0.5}
    # 13 m - 7 m from the axis of B to 14 m, 12 m / 2 before that of C.
    assert found[0].a.offset[0] == pytest.approx(6.5)
    assert found[0].b.offset[0] == pytest.approx(-5.5)
    assert names(changed(case, "C", axis=(21.0, 24.05))) == []


def test_the_building_between_stands_in_the_way(row):
    """A and C face each other above B's roof only."""
    case = without(row, *(contact.name for contact in row.contacts))
    ends = {(one.a.building, one.b.building) for one in facing_floors(case).pairs}
    assert ends == {("A", "B"), ("B", "C"), ("C", "B")}
    low = changed(case, "B", floors=case.building("B").floors[:2])
    found = [
        one for one in facing_floors(low).pairs if {one.a.building, one.b.building} == {"A", "C"}
    ]
    assert [one.name for one in found] == [
        "A.floor_3-C.storey_3_at_0.257",
        "C.floor_2-A.storey_3_at_0.76",
    ]
    assert [one.gap for one in found] == pytest.approx([8.05] * 2)
    assert not set(found) & set(facing_floors(low).near)


def test_a_pair_at_another_height_is_no_pair(row):
    """Three metres apart: the floor still faces what is at its own level."""
    contacts = tuple(
        c.model_copy(update={"a": c.a.model_copy(update={"floor": 3})}) if c.name == ROOFS else c
        for c in row.contacts
    )
    assert names(row.model_copy(update={"contacts": contacts})) == [ROOFS]


def test_one_building_in_the_other(row):
    case = changed(without(row, *of_b_and_c(row)), "C", axis=(8.0, 20.0))
    found = facing_floors(case)
    assert found.pairs == ()
    assert {round(one.gap, 3) for one in found.overlapping} == {-4.02}


def test_nothing_above_the_roof_and_below_the_base(row):
    case = without(row, *of_b_and_c(row))
    assert names(changed(case, "C", base=12.3)) == []
    # Slabs that overlap by less than their height: the edges meet.
    assert names(changed(case, "C", base=0.2))[0] != ROOFS
    assert ROOFS in names(changed(case, "C", base=0.2))


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
    case = load_case(broken(*edits))
    found = [pair_distance(contact, case) for contact in case.contacts]
    assert found == pytest.approx([distance] * 8, abs=1e-12, nan_ok=True)


def test_a_normal_from_b_to_a_is_refused(broken):
    path = broken((None, NORMAL, "normal = [0, -1, 0]"))
    refused(path, "contacts[0].normal", "of_contacts -0.01 m")


def test_buildings_in_one_another_are_refused(broken):
    path = broken((None, AXES[1], 'axis = ["23.1 m", "22.4 m"]'))
    refused(path, "contacts[0]", "of_contacts -1 m")

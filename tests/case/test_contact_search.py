"""The contact search: shipped cases, levels, precedence, cost; floors that are in no pair."""

import itertools
import math
import shutil
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.contact_search import facing_floors, searched
from impactfem.case.contact_toml import contacts_text
from impactfem.case.contacts import ContactSearch, expand
from impactfem.case.load import read_case
from impactfem.case.plan import opposites
from impactfem.coupling.from_case import system_of
from impactfem.system.errors import InputError

from .faults import refused
from .texts import replaced

GEOMETRY = Path(__file__).parents[2] / "geometry"
ROOFS, LOW = "B.floor_4-C.floor_3", "B.floor_1-C.storey_1_at_0.75"
SHIPPED = sorted(
    path.relative_to(GEOMETRY)
    for path in (*GEOMETRY.glob("*.toml"), *GEOMETRY.glob("validation/*.toml"))
    if "[[buildings]]" in (text := path.read_text()) or "extends" in text
)
SEARCH = ContactSearch.model_construct(
    law="x", storey_law=None, buildings=None, largest_gap=None, points=1
)
# Explicit pairs that the search does not make, and pairs of the search that are not explicit.
BY_HAND = {
    # A part of the facing floors: those that may touch (see the comments of the files).
    "npp_pair_coupled.toml": {f"B1.floor_{k}-B2.floor_{k}" for k in (1, 2, 3)},
    "npp_pair_coupled_eccentric.toml": {f"B1.floor_{k}-B2.floor_{k}" for k in (1, 2, 3)},
}
# Cases of published solutions: buildings with one axis, so without plans, or rigid walls; and
# pairs of corners, which are two points of one line.
WITHOUT_PLANS = {"validation/sdnd102.toml", "validation/sdnl104.toml", "validation/sdnl105.toml"}
AREAS_BY_HAND = {
    # The four columns of B, each with the width of its side; the search knows the strip alone.
    f"A.floor_{k}-B.storey_{k}_at_{height}"
    for k, height in ((4, "0.1905"), (3, "0.381"), (2, "0.5714"), (1, "0.8077"))
}


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
    assert found.overlapping == found.unknown == []
    return [one.name for one in found.pairs]


def automatic(case, **keys):
    bare = case.model_copy(update={"contacts": ()})
    return expand(searched(bare, SEARCH.model_copy(update=keys)))


@pytest.mark.parametrize("file", SHIPPED, ids=str)
def test_the_search_makes_the_pairs_of_the_shipped_cases(file):
    case = read_case(GEOMETRY / file)[0]
    if case is None or not case.contacts:
        return
    if str(file) in WITHOUT_PLANS:
        assert automatic(case) == ()
        return
    found = {contact.name: contact for contact in automatic(case)}
    given = {contact.name: contact for contact in case.contacts if "#" not in contact.name}
    assert found.keys() - given.keys() == BY_HAND.get(str(file), set())
    assert given.keys() <= found.keys()
    for name, one in given.items():
        other = found[name]
        assert other.gap == pytest.approx(one.gap, abs=1e-9)
        assert other.normal == pytest.approx(one.normal)
        if one.bearing_area is not None and name not in AREAS_BY_HAND:
            assert other.bearing_area == pytest.approx(one.bearing_area, rel=1e-12)
        # With one pair for each line they are at its middle.
        if not any(contact.name == f"{name}#2" for contact in case.contacts):
            assert other.a.offset == pytest.approx(one.a.offset)
            assert other.b.offset == pytest.approx(one.b.offset)


def test_two_points_have_the_torsion_and_the_area_of_the_line():
    case = load_case(GEOMETRY / "npp_pair.toml")
    found = [one for one in automatic(case, points=2) if one.a.floor == 8]
    assert [one.name for one in found] == [f"B1.floor_8-B2.floor_8{end}" for end in ("", "#2")]
    assert sum(one.bearing_area for one in found) == pytest.approx(13.86)
    for n in (2, 3, 5):
        line = [one for one in automatic(case, points=n) if one.a.floor == 8]
        assert sum(one.share for one in line) == pytest.approx(1.0)
        assert sum(one.share * one.along**2 for one in line) == pytest.approx(46.2**2 / 12.0)
        # To the left of the normal y+ is x-.
        assert [one.a.offset[0] for one in line] == pytest.approx([-one.along for one in line])


def test_explicit_pairs_take_precedence(row):
    missing = without(row, *of_b_and_c(row))
    found = expand(searched(missing, SEARCH))
    assert {(one.a.building, one.b.building) for one in found} == {("B", "C")}
    assert searched(row, SEARCH) == ()


def test_buildings_and_largest_gap(row):
    assert {one.a.building for one in automatic(row, buildings=("B", "C"))} == {"B"}
    assert {one.a.building for one in automatic(row, largest_gap=0.025)} == {"A"}
    assert automatic(row, largest_gap=0.01) == ()


def test_laws_of_floors_and_storeys(row):
    given = {one.name: one.law for one in row.contacts}
    found = automatic(row, law="slab", storey_law="column")
    assert {one.name: one.law for one in found} == given


def test_work_of_a_search_over_two_hundred_floors(row):
    """Two towers of 100 floors at different heights: plans are compared four times.

    Floor on floor, floor on storey both ways; a number, as times depend on the machine.
    """
    floor = row.building("A").floors[0]
    towers = []
    for name, height, y in (("A", 3.0, 0.0), ("B", 3.3, 10.02)):
        floors = tuple(
            floor.model_copy(update={"floor": k, "storey_height": height}) for k in range(1, 101)
        )
        keys = {"name": name, "floors": floors, "axis": (0.0, y), "length": 12.0, "width": 10.0}
        towers.append(row.building("A").model_copy(update=keys))
    case = row.model_copy(update={"buildings": tuple(towers), "contacts": ()})
    opposites.cache_clear()
    found = facing_floors(case).pairs
    assert len(found) > 150
    assert opposites.cache_info().misses <= 4
    assert all(one.level < 300.0 + 1.0 for one in found)


def test_depths_that_overlap_are_floors(row):
    """C raised: its floors meet floors of B as long as depths overlap, then storeys."""
    case = without(row, *(one.name for one in row.contacts))
    for base, meets in ((0.3, True), (0.54, True), (0.56, False)):
        found = {one.name for one in facing_floors(changed(case, "C", base=base)).pairs}
        assert (ROOFS in found) == meets
    (roofs,) = (
        one for one in facing_floors(changed(case, "C", base=0.3)).pairs if one.name == ROOFS
    )
    # Both at the mean of their levels.
    assert (roofs.level, roofs.a.offset[2]) == pytest.approx((12.15, 0.15))
    assert roofs.b.offset[2] == pytest.approx(-0.15)


def test_a_plan_of_corners_and_of_some_floors(row):
    """C as an L with its angle towards B: two lines for each floor; its roof a rectangle."""
    angle = ((-6.0, -6.0), (0.0, -6.0), (0.0, -2.0), (6.0, -2.0), (6.0, 6.0), (-6.0, 6.0))
    case = changed(without(row, *of_b_and_c(row)), "C", plan=angle, length=None, width=None)
    found = [one for one in facing_floors(case).pairs if one.name == LOW]
    assert [(one.gap, 2.0 * one.half) for one in found] == [
        (pytest.approx(0.03), pytest.approx(6.0)),
        (pytest.approx(4.03), pytest.approx(6.0)),
    ]
    assert [one.b.offset[0] for one in found] == pytest.approx([-3.0, 3.0])
    # The far wing is out of reach of a drift.
    assert [one.name for one in expand(searched(case, SEARCH))].count(LOW) == 1


def test_skew_facades_open_along_the_line(row):
    """C turned by 3 degrees: gaps of the points lie on a line, and distances are those gaps."""
    ψ = math.radians(3.0)
    corners = ((-5.0, -6.0), (5.0, -6.0), (5.0, 6.0), (-5.0, 6.0))
    plan = tuple(
        (math.cos(ψ) * x - math.sin(ψ) * y, math.sin(ψ) * x + math.cos(ψ) * y) for x, y in corners
    )
    case = changed(row, "C", plan=plan, length=None, width=None, axis=(7.0, 24.4))
    case = case.model_copy(update={"contacts": ()})
    line = [one for one in automatic(case, points=3, largest_gap=1.0) if one.line == ROOFS]
    assert len(line) == 3
    slopes = [
        (two.gap - one.gap) / (two.along - one.along) for one, two in itertools.pairwise(line)
    ]
    assert slopes == pytest.approx([-2.0 * math.tan(0.5 * ψ)] * 2, rel=1e-7)
    for one in line:
        apart = sum(
            n * (q + y - p - x)
            for n, p, q, x, y in zip(
                one.normal,
                case.building("B").axis,
                case.building("C").axis,
                one.a.offset,
                one.b.offset,
                strict=False,
            )
        )
        assert apart == pytest.approx(one.gap, abs=1e-8)


@pytest.mark.parametrize("name", ["npp_pair", "two_frames", "frame", "row_of_three"])
def test_the_shipped_cases_are_silent(name):
    found = facing_floors(load_case(GEOMETRY / f"{name}.toml"))
    assert found.lines() == found.unknown_lines == []


def test_columns_behind_the_edge():
    """Floors of B reach A's columns nowhere, as these stand back; where they do not, they are."""
    case = load_case(GEOMETRY / "two_frames.toml")
    assert [one.gap for one in facing_floors(case).pairs] == pytest.approx([1.54] * 3)
    flush = changed(case, "A", setback=0.0)
    assert [(one.a.storey, one.b.label) for one in facing_floors(flush).near] == [
        (2, "B.floor_1"),
        (3, "B.floor_2"),
        (4, "B.floor_3"),
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
    assert "B.floor_4 and C.floor_3 (30 mm" in line
    assert "type [contact_search]" in line
    assert names(make(row)) == []


def test_floors_against_storeys(row):
    """Both ways, with the heights that the pairs of the case have."""
    missing = of_b_and_c(row)
    assert sorted(names(without(row, *missing))) == [
        LOW,
        "B.floor_2-C.storey_2_at_0.5",
        "B.floor_3-C.storey_3_at_0.25",
        ROOFS,
        "B.storey_2_at_0.3333-C.floor_1",
        "B.storey_3_at_0.6667-C.floor_2",
    ]
    (line,) = facing_floors(without(row, *missing)).lines(most=2)
    assert "4 more" in line


def test_a_building_without_a_plan(row):
    """No pairs; a line says which keys would give them."""
    case = changed(without(row, ROOFS), "C", length=None)
    found = facing_floors(case)
    assert (found.pairs, found.overlapping) == ([], [])
    (line,) = found.unknown_lines
    assert "plan of C: type length and width" in line


def test_a_floor_with_a_size_of_its_own(row):
    """A roof that stands back by a metre."""
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
    assert ends == {("A", "B"), ("B", "C")}
    low = changed(case, "B", floors=case.building("B").floors[:2])
    found = [one for one in facing_floors(low).pairs if one.a.building == "A" != one.b.building]
    found = [one for one in found if one.b.building == "C"]
    assert {one.name for one in found} == {
        "A.floor_3-C.storey_3_at_0.25",
        "A.storey_3_at_0.6667-C.floor_2",
    } | {one.name for one in found if one.half < 6.0}
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
    assert found.pairs == []
    assert [(one, other) for one, other, _ in found.overlapping] == [("B", "C")]


def test_nothing_above_the_roof_and_below_the_base(row):
    case = without(row, *of_b_and_c(row))
    assert names(changed(case, "C", base=12.3)) == []


@pytest.fixture
def bare(tmp_path):
    """The row of three in a folder of its own, its pairs from [contact_search]."""
    for file in GEOMETRY.glob("row_of_three_*.csv"):
        shutil.copy(file, tmp_path)
    text = (GEOMETRY / "row_of_three.toml").read_text(encoding="utf-8")
    first, last = text.index("\n[[contacts]]") + 1, text.index("[pounding]")
    path = tmp_path / "row.toml"
    section = '[contact_search]\nlaw = "slab"\nstorey_law = "column"\npoints = 1\n\n'
    path.write_text(text[:first] + section + text[last:], encoding="utf-8")
    return path


def test_the_section_makes_the_pairs(bare, row):
    case = load_case(bare)
    made = {one.name: one for one in case.contacts}
    assert made.keys() == {one.name for one in row.contacts}
    for one in row.contacts:
        other = made[one.name]
        assert (other.law, other.gap) == (one.law, pytest.approx(one.gap))
        assert other.place == "contact_search"
    assert names(case) == []


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ("points = 1", "points = 0", "contact_search.points", "greater_than_equal 1"),
        ('law = "slab"', 'law = "slap"', "contact_search.law", "unknown_name slab"),
        ("points = 1", 'buildings = ["A"]', "contact_search.buildings", "too_short 2"),
        ("points = 1", 'buildings = ["A", "A"]', "contact_search.buildings", "once"),
        ("points = 1", 'buildings = ["A", "D"]', "contact_search.buildings[1]", "unknown_name A"),
        ("points = 1", 'largest_gap = "-1 m"', "contact_search.largest_gap", "greater_than_equal"),
        # Nothing within reach: how far the nearest floors are apart.
        ("points = 1", 'largest_gap = "1 cm"', "contact_search", "of_search 20 mm"),
        ('length = "14 m"\nwidth = "8 m"', "", "contact_search", "of_search B"),
        ('length = "14 m"\nwidth = "8 m"', 'plan = [["0 m", "0 m"], ["1 m", "0 m"]]',
         "buildings[1].plan", "plan 2"),
        ('width = "8 m"', 'plan = [["0 m", "0 m"], ["1 m", "0 m"], ["0 m", "1 m"]]',
         "buildings[1].plan", "one_plan"),
        ('width = "8 m"', 'width = "8 m"\nplans = [{ floors = 9, plan = '
         '[["0 m", "0 m"], ["1 m", "0 m"], ["0 m", "1 m"]] }]', "buildings[1].plans",
         "plans_of_floors 9"),
    ],
)  # fmt: skip
def test_sections_that_are_refused(bare, old, new, key, expected):
    text = bare.read_text(encoding="utf-8")
    assert text.count(old) >= 1
    bare.write_text(text.replace(old, new, 1), encoding="utf-8")
    refused(bare, key, expected)


LINE = """[[contacts]]
a = { building = "A", floor = 3, offset = ["0 m", "5 m", "0 m"] }
b = { building = "B", floor = 3, offset = ["0 m", "-4 m", "0 m"] }
normal = [0, 1, 0]
gap = "2 cm"
law = "slab"
"""


def test_an_explicit_line(bare):
    """It takes precedence, and is cut in points as those of the search."""
    text = bare.read_text(encoding="utf-8")
    line = LINE + 'length = "14 m"\npoints = 3\ndepth = "25 cm"\n\n[contact_search]'
    bare.write_text(text.replace("[contact_search]", line), encoding="utf-8")
    case = load_case(bare)
    found = [one for one in case.contacts if one.name.startswith("A.floor_3-B.floor_3")]
    assert [one.table for one in found] == [0, 0, 0]
    assert [one.share for one in found] == pytest.approx([5 / 18, 8 / 18, 5 / 18])
    assert sum(one.bearing_area for one in found) == pytest.approx(14.0 * 0.25)
    assert len(case.contacts) == 9 + 2


@pytest.mark.parametrize(
    ("more", "key", "expected"),
    [
        ("points = 2", "points", "points_of_a_line"),
        ('depth = "25 cm"', "depth", "depth_of_a_line"),
        ("gap_slope = 0.01", "gap_slope", "open_along_the_line"),
        ('length = "14 m"\ngap_slope = 0.01', "gap_slope", "open_along_the_line 0.00286"),
        ('length = "0 m"', "length", "greater_than 0"),
    ],
)
def test_lines_that_are_refused(bare, more, key, expected):
    text = bare.read_text(encoding="utf-8")
    bare.write_text(
        text.replace("[contact_search]", f"{LINE}{more}\n\n[contact_search]"), encoding="utf-8"
    )
    refused(bare, f"contacts[0].{key}", expected)


SKEW = (
    'plan = [["-6 m", "-6.4 m"], ["6 m", "-6 m"], ["6 m", "6 m"], ["0 m", "6 m"], ["-6 m", "2 m"]]'
)


@pytest.mark.parametrize("points", [1, 2, 3])
@pytest.mark.parametrize(
    ("plan", "y"), [('length = "12 m"\nwidth = "12 m"', "24.05 m"), (SKEW, "24.5 m")]
)
def test_the_text_is_the_same_case(bare, plan, y, points):
    text = bare.read_text(encoding="utf-8").replace("points = 1", f"points = {points}")
    text = replaced(text, ('length = "12 m"\nwidth = "12 m"', plan))
    text = replaced(text, ('"24.05 m"', f'"{y}"'))
    bare.write_text(text, encoding="utf-8")
    case = load_case(bare)
    pasted = contacts_text(case)
    first, last = text.index("[contact_search]"), text.index("[pounding]")
    bare.write_text(text[:first] + pasted + text[last:], encoding="utf-8")
    again = load_case(bare)
    assert len(again.contacts) == len(case.contacts) == 9 * points
    for one, other in zip(case.contacts, again.contacts, strict=True):
        skip = {"a", "b", "normal", "table", "gap"}
        assert one.model_dump(exclude=skip) == other.model_dump(exclude=skip)
        assert one.a.label == other.a.label and one.b.label == other.b.label
        for ends in ((one.a.offset, other.a.offset), (one.b.offset, other.b.offset)):
            assert ends[0] == pytest.approx(ends[1], abs=1e-12)
        assert one.normal == pytest.approx(other.normal, abs=1e-15)
        assert one.gap == pytest.approx(other.gap, abs=1e-15)
    # Nothing is left to search.
    assert contacts_text(again).startswith("# All floors")


def test_the_text_without_the_section(row):
    """By the first contact law; of floors that are in no pair."""
    text = contacts_text(without(row, ROOFS))
    assert 'floor = 4, offset = ["1 m", "4 m", "0 m"]' in text
    assert text.count("[[contacts]]") == 1
    with pytest.raises(InputError, match="contact law"):
        contacts_text(row.model_copy(update={"contact_laws": {}}))
    with pytest.raises(InputError, match="plan of C"):
        contacts_text(changed(without(row, ROOFS), "C", length=None))


@pytest.mark.parametrize("shown", ["20 mm", "30 mm", 'type gap = "20 mm"', 'allow = ["gap"]'])
def test_a_gap_of_another_geometry(bare, shown):
    """Both numbers, once for each table; 1 mm is rounding."""
    text = bare.read_text(encoding="utf-8")
    line = replaced(LINE, ("floor = 3", "floor = [2, 3]"))
    wider = replaced(text, ("[contact_search]", line + "\n[contact_search]"))
    bare.write_text(replaced(wider, ('gap = "2 cm"', 'gap = "3 cm"')), encoding="utf-8")
    refused(bare, "contacts[0].gap", f"of_contacts {shown}")
    for gap in ("21 mm", "19 mm"):
        bare.write_text(replaced(wider, ('gap = "2 cm"', f'gap = "{gap}"')), encoding="utf-8")
        load_case(bare)
    bare.write_text(replaced(wider, ('gap = "2 cm"', 'gap = "21.1 mm"')), encoding="utf-8")
    refused(bare, "contacts[0].gap", "of_contacts 21.1 mm")
    allowed = ('gap = "2 cm"', 'gap = "3 cm"'), ("title = ", 'allow = "gap"\ntitle = ')
    bare.write_text(replaced(wider, *allowed), encoding="utf-8")
    assert load_case(bare).contacts[0].gap == pytest.approx(0.03)
    unknown = (("title = ", 'allow = "gaps"\ntitle = '),)
    bare.write_text(replaced(wider, *unknown), encoding="utf-8")
    refused(bare, "allow", "literal_error")


@pytest.mark.parametrize("points", [1, 2, 3])
def test_points_of_a_stick_share_the_law(bare, points):
    """Sum of stiffness and moment of a small turn θ about the middle, K L² θ / 12 from two on."""
    text = bare.read_text(encoding="utf-8").replace("points = 1", f"points = {points}")
    bare.write_text(text, encoding="utf-8")
    case = load_case(bare)
    pairs = {pair.name: pair for pair in system_of(case, None).pairs}
    line = [one for one in case.contacts if one.line == ROOFS]
    assert len(line) == points and {one.pair for one in line} == {ROOFS}
    given = case.contact_laws["slab"].stiffness
    stiffness = [pairs[one.name].law.stiffness for one in line]
    assert sum(stiffness) == pytest.approx(given)
    length = 12.0 if points > 1 else 0.0
    turned = sum(K * one.along**2 for K, one in zip(stiffness, line, strict=True))
    assert turned == pytest.approx(given * length**2 / 12.0, rel=1e-12, abs=1e-6)
    # Of a central impact, whatever the number of points is.
    masses = [pairs[one.name].law.mass for one in line]
    assert sum(masses) == pytest.approx(_central_mass(case))


def _central_mass(case):
    middle = case.model_copy(
        update={"contacts": automatic(case, law="slab", storey_law="column", points=1)}
    )
    return next(pair for pair in system_of(middle, None).pairs if pair.name == ROOFS).law.mass

"""Names of physical groups."""

import pytest

from impactfem.building.mesh import Mark, Part, parse_group, usable_name


@pytest.mark.parametrize(
    ("group", "expected"),
    [
        ("floor_1", Part("floor", 1)),
        ("floor_8_acroterion", Part("floor", 8, "acroterion")),
        ("storey_3_gable_west", Part("storey", 3, "gable_west")),
        ("beam_8_transverse_4", Part("beam", 8, "transverse_4")),
        ("column_12_2", Part("column", 12, "2")),
        ("edge_2", Mark("edge", 2)),
        ("centre_10", Mark("centre", 10)),
        ("base", Mark("base")),
    ],
)
def test_a_name_is_read_and_written(group, expected):
    meaning = parse_group(group)
    assert meaning == expected
    assert meaning.group == group


@pytest.mark.parametrize(
    "group",
    ["floor", "floor_0", "floor_01", "Floor_1", "floor_1_", "floor_1__a", "floor_1_é", "floor_-1",
     "wall_1", "edge_1_north", "edge_0", "base_1", "number 7", "", "floor_1\n"],
)  # fmt: skip
def test_another_name_is_none_of_the_scheme(group):
    assert parse_group(group) is None


def test_only_walls_and_columns_are_scaled():
    scaled = {family: Part(family, 1).scaled for family in ("floor", "storey", "beam", "column")}
    assert scaled == {"floor": False, "storey": True, "beam": False, "column": True}


def test_dimensions():
    assert [Part(f, 1).dimension for f in ("floor", "storey", "beam", "column")] == [2, 2, 1, 1]


def test_parts_are_sorted_by_number_not_by_text():
    assert sorted([Part("floor", 10), Part("floor", 9)])[0].level == 9


def test_what_a_generated_name_may_be():
    assert usable_name("gable_west")
    assert not usable_name("gable west")
    assert not usable_name("")
    assert not usable_name("west_")

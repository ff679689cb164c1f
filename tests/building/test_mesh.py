import numpy as np
import pytest

from impactfem.building.mesh import (
    Mark,
    Part,
    areas,
    parse_group,
    radius_ratio,
    rigid_body,
)


@pytest.mark.parametrize(
    ("group", "expected"),
    [
        ("floor_1", Part("floor", 1)),
        ("floor_8_parapet", Part("floor", 8, "parapet")),
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


# 3-4-5: inscribed circle 1, circumscribed 2.5. Legs 1, 1: (2 - √2)/2 and √2/2.
TRIANGLES = [
    ([(0, 0, 0), (1, 0, 0), (0.5, np.sqrt(0.75), 0)], 1.0, np.sqrt(3.0) / 4.0),
    ([(0, 0, 0), (0, 3, 0), (0, 0, 4)], 0.8, 6.0),
    ([(5, 0, 0), (6, 0, 0), (5, 0, 1)], 2.0 * np.sqrt(2.0) - 2.0, 0.5),
    ([(0, 0, 0), (1, 1, 1), (2, 2, 2)], 0.0, 0.0),
    ([(0, 0, 0), (0, 0, 0), (0, 0, 0)], 0.0, 0.0),
]


@pytest.mark.parametrize(("points", "ratio", "area"), TRIANGLES)
def test_known_triangles(points, ratio, area):
    nodes, triangles = np.array(points, dtype=float), np.array([[0, 1, 2, 0, 0, 0]])
    assert radius_ratio(nodes, triangles) == pytest.approx(ratio, abs=1e-12)
    assert areas(nodes, triangles) == pytest.approx(area, abs=1e-12)


def test_by_hand():
    """A turn by b about x0 moves x by b × (x − x0)."""
    motions = rigid_body(np.array([[3.0, 5.0, 9.0]]), np.array([1.0, 1.0, 1.0]))
    # The arm is (2, 4, 8).
    assert motions[:3, :3].tolist() == np.eye(3).tolist()
    assert motions[3:, 3:].tolist() == np.eye(3).tolist()
    assert not motions[3:, :3].any()
    assert motions[:3, 3].tolist() == [0.0, -8.0, 4.0]
    assert motions[:3, 4].tolist() == [8.0, 0.0, -2.0]
    assert motions[:3, 5].tolist() == [-4.0, 2.0, 0.0]


def test_families():
    """Slabs and walls are surfaces; the storey factor acts on walls and columns."""
    parts = [Part(family, 1) for family in ("floor", "storey", "beam", "column")]
    assert [part.dimension for part in parts] == [2, 2, 1, 1]
    assert [part.scaled for part in parts] == [False, True, False, True]
    # Sorted by number and not by text.
    assert sorted([Part("floor", 10), Part("floor", 9)])[0].level == 9

import re
from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.mesh import Mark, Part, areas, parse_group, radius_ratio, rigid_body
from impactfem.building.mesh_checks import (
    check_mesh,
    lines_through_triangles,
    nodes_on_lines,
    nodes_on_triangles,
)
from impactfem.system.errors import InputError

PLACE = r"\(-?\d+\.\d{3}, -?\d+\.\d{3}, -?\d+\.\d{3}\) m"
SLAB, WALL, BEAM = Part("floor", 1), Part("storey", 1), Part("beam", 1)


@pytest.fixture
def drawing(new_panels):
    """An empty one; its mesh stands on all nodes at z = 0."""
    made = new_panels(alternate=False)
    made.mesh = lambda: made.parts(base=made.at((2, 0.0))).mesh
    return made


@pytest.fixture
def table(drawing):
    """A slab of 4 m by 2 m at 3 m, on a wall at x = 0."""
    drawing.panel((0, 0, 3), (4, 0, 0), (0, 2, 0), (2, 2), SLAB)
    drawing.panel((0, 0, 0), (0, 2, 0), (0, 0, 3), (2, 2), WALL)
    return drawing


def refused(mesh, expected):
    with pytest.raises(InputError, match=expected) as caught:
        check_mesh(mesh, "own.msh")
    assert {fault.file for fault in caught.value.faults} == {"own.msh"}
    return caught.value.faults


def test_a_sound_mesh(table):
    table.cell(BEAM, (0, 0, 3), (2, 0, 3))
    table.cell(BEAM, (4, 2, 3), (4, 2, 0))  # a post beside the wall, with a foot of its own
    check_mesh(table.mesh(), "own.msh")


def test_millimetres(small_mesh):
    large = replace(small_mesh, nodes=1e3 * small_mesh.nodes)
    faults = refused(large, rf"measures 8000 x 5000 x 6400, with a node at {PLACE}.*millimetres")
    assert len(faults) == 1
    check_mesh(replace(small_mesh, nodes=100.0 * small_mesh.nodes), "own.msh")


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_coordinates_that_are_no_numbers(small_mesh, number):
    nodes = small_mesh.nodes.copy()
    nodes[3, 1] = number
    faults = refused(
        replace(small_mesh, nodes=nodes),
        r"cells with coordinates that are not finite.*expected num",
    )
    groups = {"beam_1_rim", "floor_1", "storey_1_south", "storey_2_south"}
    assert {fault.key for fault in faults} == groups


ALONG = (BEAM, (0, 0, 3), (2, 0, 3))
TWICE = rf"2 cells share all vertices.*at {PLACE}"


def column(top):
    return [(Part("column", 1), (1.3, 0.6, 0), (1.3, 0.6, top))]


@pytest.mark.parametrize(
    ("cells", "expected", "group"),
    [
        ([(SLAB, (4, 0, 3), (5, 0, 3), (6, 0, 3))], r"1 collapsed tri.*at \(5\.000, 0", "floor_1"),
        ([(BEAM, (4, 0, 3), (4, 0, 3))], r"1 lines without a length.*at \(4\.000, 0", "beam_1"),
        ([ALONG, (SLAB, (2, 0, 3), (2, 1, 3), (0, 0, 3))], TWICE, "floor_1"),
        ([ALONG, (BEAM, (2, 0, 3), (0, 0, 3))], TWICE, "beam_1"),
        (
            [(Part("storey", 2), (1.2, 0.4, 0), (1.5, 0.5, 0), (1.3, 0.45, 7.3))],
            rf"2 nodes lie on floor_1, or their lines pass.*{PLACE}",
            "storey_2",
        ),
        # Along sides of triangles, and twice as long.
        (
            [(BEAM, (0, 0, 3), (4, 2, 3))],
            r"2 nodes lie on beam_1, .* \(1\.000, 0\.500, 3",
            "floor_1",
        ),
        ([(BEAM, (0, 0, 3), (1.3, 0.4, 3))], "2 nodes lie on floor_1, .*the first at", "beam_1"),
        (column(3.0), r"1 node lies on floor_1.*at \(1\.300, 0\.600, 3\.000\)", "column_1"),
        (column(5.0), "1 node lies on floor_1, or its lines pass through it", "column_1"),
    ],
)
def test_cells_that_are_refused(table, cells, expected, group):
    for part, *points in cells:
        table.cell(part, *points)
    faults = refused(table.mesh(), expected)
    assert group in {fault.key for fault in faults if re.search(expected, fault.expected)}


@pytest.mark.parametrize("part", ["triangles", "lines"])
def test_a_side_that_is_not_straight(small_mesh, part):
    nodes = small_mesh.nodes.copy()
    if part == "triangles":
        middle = small_mesh.triangles[small_mesh.triangles_of("storey", 1)[0], 3]
    else:
        middle = small_mesh.lines[small_mesh.lines_of("column", 1)[0], 2]
    nodes[middle, 1] += 1e-4
    refused(
        replace(small_mesh, nodes=nodes),
        rf"_1_\w+: .*not straight, the first at {PLACE}: .*0\.0001 m",
    )
    nodes[middle, 1] -= 1e-4 - 1e-8
    check_mesh(replace(small_mesh, nodes=nodes), "own.msh")


def test_duplicate_nodes(drawing):
    drawing.panel((0, 0, 3), (4, 0, 0), (0, 2, 0), (2, 2), SLAB)
    own = len(drawing.points)
    drawing.panel((0, 0, 0), (0, 2, 0), (0, 0, 3), (2, 2), WALL)
    mesh = drawing.mesh()
    # The wall gets nodes of its own where it meets the slab.
    shared = np.unique(mesh.triangles[mesh.triangles_of("storey")])
    shared = shared[shared < own]
    number = np.arange(len(mesh.nodes))
    number[shared] = len(mesh.nodes) + np.arange(len(shared))
    triangles = mesh.triangles.copy()
    walls = mesh.triangles_of("storey")
    triangles[walls] = number[triangles[walls]]
    nodes = np.vstack([mesh.nodes, mesh.nodes[shared]])
    torn = replace(mesh, nodes=nodes, triangles=triangles)
    (fault,) = refused(torn, rf"{len(shared)} pairs of nodes in one place, the first at {PLACE}")
    assert fault.key == "floor_1, storey_1"


@pytest.mark.parametrize(("gap", "sound"), [(0.9e-3, False), (1.1e-3, True)])
def test_how_near_is_one_place(table, gap, sound):
    # A second table beside the first, on a wall of its own.
    for part, b in ((WALL, (0, 0, 3)), (SLAB, (3, 0, 0))):
        corner = (4 + gap, 0, 0 if part == WALL else 3)
        table.panel(corner, (0, 2, 0), b, (2, 2), part)
    if sound:
        check_mesh(table.mesh(), "own.msh")
    else:
        refused(table.mesh(), "pairs of nodes in one place")


def test_hanging_nodes_on_an_edge(drawing):
    """The wall has three sides where the slab has two."""
    drawing.panel((0, 0, 3), (4, 0, 0), (0, 2, 0), (2, 2), SLAB)
    drawing.panel((0, 0, 0), (0, 2, 0), (0, 0, 3), (3, 2), WALL)
    faults = refused(drawing.mesh(), rf"storey_1: \d+ nodes lie on floor_1, .*first at {PLACE}")
    assert {fault.key for fault in faults} == {"floor_1", "storey_1"}


def test_a_wall_under_the_middle_of_a_slab(table):
    table.panel((0.7, 0.3, 0), (0.9, 0.7, 0), (0, 0, 3), (2, 2), WALL)
    faults = refused(table.mesh(), rf"storey_1: 5 nodes lie on floor_1, .*the first at {PLACE}")
    assert {fault.key for fault in faults} == {"floor_1", "storey_1"}


def test_a_wall_that_hangs_on_nothing(table):
    table.panel((1, 1, 4), (2, 0, 0), (0, 0, 1), (1, 1), Part("storey", 2, "north"))
    table.cell(Part("beam", 2), (1, 1, 4), (1, 0, 4))
    (fault,) = refused(table.mesh(), rf"11 nodes, one at {PLACE}, are not connected to the base")
    assert fault.key == "beam_2, storey_2_north"
    assert fault.expected.endswith("a mechanism")


def test_a_base_that_holds_nothing_else(table):
    mesh = table.mesh()
    (fault,) = refused(replace(mesh, base=mesh.base[:0]), "not connected to the base")
    assert fault.key == "floor_1, storey_1"
    check_mesh(replace(mesh, base=mesh.base[:1]), "own.msh")


NEAR = 1e-3


def with_middles(points, cells):
    """Six-node triangles, or three-node lines, of plain ones."""
    nodes = [tuple(map(float, p)) for p in points]
    made = []
    for cell in cells:
        pairs = [(0, 1), (1, 2), (2, 0)] if len(cell) == 3 else [(0, 1)]
        middles = []
        for a, b in pairs:
            middle = tuple(0.5 * (np.array(nodes[cell[a]]) + np.array(nodes[cell[b]])))
            if middle not in nodes:
                nodes.append(middle)
            middles.append(nodes.index(middle))
        made.append([*cell, *middles])
    return np.array(nodes), np.array(made)


SQUARE = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]


@pytest.mark.parametrize(
    ("point", "on"),
    [
        ((0.5, 0.4, 0.0), [0]),  # inside the first one
        ((0.5, 0.0, 0.0), [0]),  # on a side, hanging
        ((0.5, 0.5, 0.0), [0, 1]),  # on the side they share
        ((0.5, 0.4, 0.0009), [0]),
        ((0.5, 0.4, 0.0011), []),
        ((0.5, -0.0009, 0.0), [0]),
        ((0.5, -0.0011, 0.0), []),
        ((3.0, 0.0, 0.0), []),
    ],
)
def test_a_node_on_triangles(point, on):
    nodes, triangles = with_middles([*SQUARE, point], [(0, 1, 2), (0, 2, 3)])
    assert nodes_on_triangles(nodes, triangles, NEAR).tolist() == [[t, 4] for t in on]


@pytest.mark.parametrize(
    ("point", "on"),
    [((0.5, 0.0, 0.0), True), ((1.0, 0.0, 0.0009), True), ((1.5, 0.0011, 0.0), False),
     ((2.5, 0.0, 0.0), False), ((-0.0011, 0.0, 0.0), False)],
)  # fmt: skip
def test_a_node_on_a_line(point, on):
    nodes, lines = with_middles([(0, 0, 0), (2, 0, 0), point], [(0, 1)])
    assert nodes_on_lines(nodes, lines, NEAR).tolist() == ([[0, 2]] if on else [])


@pytest.mark.parametrize(
    ("start", "end", "through"),
    [
        ((0.5, 0.4, -1.0), (0.6, 0.4, 1.0), True),
        ((1.0, 0.6, 0.01), (0.9, 0.6, 1.0), False),  # above it
        ((3.0, 0.4, -1.0), (3.0, 0.4, 1.0), False),  # beside it
        ((0.5, 0.4, 0.0), (0.5, 0.4, 1.0), False),  # ends on it: a node on the triangle
        ((0.1, 0.1, 0.0), (1.9, 0.2, 0.0), False),  # lies in it
    ],
)
def test_a_line_through_a_triangle(start, end, through):
    nodes, triangles = with_middles(SQUARE, [(0, 1, 2), (0, 2, 3)])
    own = len(nodes)
    middle = 0.5 * (np.array(start) + np.array(end))
    nodes = np.vstack([nodes, start, end, middle])
    found = lines_through_triangles(nodes, triangles, np.array([[own, own + 1, own + 2]]), NEAR)
    assert found.tolist() == ([[0, own + 2]] if through else [])


def test_the_search_leaves_nothing_out():
    """Random triangles of very different sizes: the tree finds what a search of all pairs does."""
    random = np.random.default_rng(3)
    corners = random.uniform(0.0, 4.0, (60, 1, 3)) + random.normal(size=(60, 3, 3)) * (
        10.0 ** random.uniform(-1.5, 0.5, (60, 1, 1))
    )
    nodes, triangles = with_middles(corners.reshape(-1, 3), np.arange(180).reshape(60, 3).tolist())
    found = lines_through_triangles(nodes, triangles, np.zeros((0, 3), dtype=int), 1e-9)
    expected = set()
    for t, triangle in enumerate(triangles):
        p = nodes[triangle[:3]]
        for other in triangles:
            for a, b, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5)):
                start, end = nodes[other[a]], nodes[other[b]]
                # start + s (end - start) = p0 + u (p1 - p0) + v (p2 - p0)
                system = np.column_stack([start - end, p[1] - p[0], p[2] - p[0]])
                if abs(np.linalg.det(system)) < 1e-12 or set(triangle) & {other[a], other[b]}:
                    continue
                s, u, v = np.linalg.solve(system, start - p[0])
                if 0 < s < 1 and u > 0 and v > 0 and u + v < 1:
                    expected.add((t, int(other[m])))
    assert len(expected) > 5
    assert set(map(tuple, found.tolist())) == expected


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

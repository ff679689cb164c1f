"""Plans of slabs: closed outer boundaries with their corners, from the axis."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.building.outline import mesh_plans
from impactfem.case.load import load_case
from impactfem.case.plan import area
from impactfem.run.check import checked
from impactfem.system.errors import InputError
from impactfem.system.files import in_source_tree

L_SHAPE = [(i, j) for i in range(4) for j in range(3) if i < 2 or j < 1]
L_CORNERS = ((0, 0), (4, 0), (4, 1), (2, 1), (2, 3), (0, 3))


def slabs(*floors, turn=0.0):
    """A mesh whose floors have these unit squares, of two triangles with middles each."""
    nodes, triangles, owner = {}, [], []

    def node(x, y, k):
        return nodes.setdefault((x, y, 3.0 * k), len(nodes))

    for k, squares in enumerate(floors, 1):
        for i, j in squares:
            for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))):
                p = [(i + x, j + y) for x, y in corners]
                middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pairwise([*p, p[0]])]
                triangles.append([node(x, y, k) for x, y in (*p, *middles)])
                owner.append(k)
    c, s = np.cos(turn), np.sin(turn)
    x = np.array(list(nodes), dtype=float) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    owner = np.array(owner)
    return SimpleNamespace(
        nodes=x,
        triangles=np.array(triangles),
        floors=range(1, len(floors) + 1),
        slab=lambda floor: np.flatnonzero(owner == floor),
        triangles_of=lambda kind: np.arange(len(triangles)),
    )


def plans(mesh, axis):
    return mesh_plans(mesh, SimpleNamespace(axis=axis))


def test_an_l_shape_and_floors_alike():
    """From an axis within the plan; without one the middle of the mesh is the axis."""
    other = [square for square in L_SHAPE if square[0] < 2]
    found = plans(slabs(L_SHAPE, L_SHAPE, other), (1.0, 1.0))
    assert list(found.values()) == [[1, 2], [3]]
    first, second = found
    assert first == tuple((x - 1.0, y - 1.0) for x, y in L_CORNERS)
    assert area(first) == pytest.approx(8.0) and area(second) == pytest.approx(6.0)
    (moved,) = plans(slabs(L_SHAPE), (50.0, 1.0))
    assert moved == tuple((x - 2.0, y - 1.5) for x, y in L_CORNERS)


def test_turned_slabs():
    turn = 0.3
    (found,) = plans(slabs(L_SHAPE, turn=turn), (0.5, 1.0))
    assert len(found) == 6 and area(found) == pytest.approx(8.0, abs=0.01)
    sides = np.diff(np.array([*found, found[0]]), axis=0)
    lengths = sorted(np.linalg.norm(sides, axis=1).round(2))
    assert lengths == [1.0, 2.0, 2.0, 2.0, 3.0, 4.0]


def test_a_slab_with_a_hole_has_a_plan_and_one_of_two_parts_has_none():
    ring = [(i, j) for i in range(4) for j in range(4) if (i, j) != (1, 1)]
    (found,) = plans(slabs(ring), (2.0, 2.0))
    assert found == ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
    for apart in ([(0, 0), (1, 1)], [(0, 0), (2, 1)]):
        assert plans(slabs(apart), (1.0, 1.0)) == {}


def test_check_gives_the_plan_of_a_mesh_to_type(tmp_path):
    """A search without length and width: with the plan in the message it finds the same pairs."""
    source = in_source_tree("geometry/two_frames.toml")
    for file in source.parent.glob("two_frames*"):
        (tmp_path / file.name).symlink_to(file)
    text = source.read_text(encoding="utf-8")
    start = text.index("[[contacts]]")
    search = '[contact_search]\nlaw = "slab"\nstorey_law = "column"\n\n'
    text = text[:start] + search + text[text.index("[pounding]", start) :]
    size = 'length = "18 m"\nwidth = "12 m"\n'
    path = tmp_path / "bare.toml"
    path.write_text(text, encoding="utf-8")
    expected = load_case(path).contacts
    assert len({contact.pair for contact in expected}) == 5
    path.write_text(text.replace(size, "", 1), encoding="utf-8")
    with pytest.raises(InputError) as error:
        checked(path, mesh=True)
    faults = {fault.key: fault for fault in error.value.faults}
    fault = faults["buildings[0].plan"]
    assert fault.kind == "plan_of_mesh" and set(faults) == {"contact_search", fault.key}
    typed = fault.expected[fault.expected.index("plan = ") : fault.expected.index(", the outline")]
    path.write_text(text.replace(size, f"{typed}\n", 1), encoding="utf-8")
    assert load_case(path).contacts == expected

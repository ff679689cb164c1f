"""Lines along which 3D models touch: what both sides take, gaps, storeys, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.facade import facades
from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.read_mesh import read_mesh
from impactfem.case import load_case
from impactfem.reduction.contact_line import contact_lines, warn_of_narrow
from impactfem.reduction.edge_force import EdgeForce, smooth
from impactfem.reduction.sides import PairEnd, Sides
from impactfem.run.check import check
from impactfem.system.errors import InputError
from two_models import in_3d


def test_what_varies_smoothly_along_lines_of_points():
    """Up to a degree on each line, and no more than it has points; nothing for no points."""
    forces = [EdgeForce("", 8, (0.0, 1.0), "", 1.0, s) for s in (-6.0, -2.0, 1.0, 6.0)]
    forces += [EdgeForce("", 7, (0.0, 1.0), "", 1.0, s) for s in (-6.0, 0.0)]
    found = smooth(forces, 2)
    assert found.shape == (6, 3 + 2) and np.linalg.matrix_rank(found) == 5
    assert not found[:4, 3:].any() and not found[4:, :3].any()
    assert np.allclose(found[:4, :2].T, [np.ones(4), [-1.0, -1.0 / 3.0, 1.0 / 6.0, 1.0]])
    quadratic = np.linalg.lstsq(found[:4, :3], [36.0, 4.0, 1.0, 36.0], rcond=None)
    assert np.allclose(found[:4, :3] @ quadratic[0], [36.0, 4.0, 1.0, 36.0])
    assert smooth(forces[:1], 2).shape == (1, 1) and smooth([], 2).shape == (0, 0)


def with_meshes(path):
    """A case with the meshes of its buildings by name."""
    case, meshes = load_case(path), {}
    for name, building in case.modelled.items():
        file = path.with_name(f"{name}.msh")
        generate(geometry_of(building), file, source=str(path))
        meshes[name] = read_mesh(file)
    return case, meshes


WIDE = ('gap = "1 mm"', 'gap = "10 cm"')


def bent(meshes, out):
    """The meshes, with the nodes of A moved along y by a function of x and y."""
    nodes = meshes["A"].nodes.copy()
    nodes[:, 1] += out(nodes[:, 0], nodes[:, 1])
    return meshes | {"A": replace(meshes["A"], nodes=nodes)}


def test_both_sides_of_a_line_take_the_same_force_and_moment(tmp_path):
    """On meshes that do not match, of another length and shifted along each other."""
    plan = 'length = "{} m"\nwidth = "4 m"\nslab_thickness = "20 cm"\nwalls = "walls.csv"\n'
    plan += 'columns = "columns.csv"\nimpact_edge = "y+"'
    changes = [
        (plan.format(6), plan.format(7)),
        ('impact_edge = "y-"\nsize = "2 m"', 'impact_edge = "y-"\nsize = "1.3 m"'),
        ('offset = ["0 m", "2 m", "0 m"]', 'offset = ["1.4 m", "2 m", "0 m"]'),
        ('axis = ["3 m", "6.001 m"]', 'axis = ["5 m", "6.001 m"]'),
        ('offset = ["0 m", "-2 m", "0 m"]', 'offset = ["-0.6 m", "-2 m", "0 m"]'),
    ]
    case, meshes = with_meshes(in_3d(tmp_path, *changes))
    lines = contact_lines(case, meshes)
    assert [line.name for line in lines] == [contact.name for contact in case.contacts]
    for line in lines:
        # A reaches from -2.6 m to 4.4 m of the pair, B from -3.6 m to 2.4 m.
        assert np.ptp(line.position) == pytest.approx(5.0) == line.weight.sum()
        share, w, _ = line.joined(2)
        assert w.sum() == pytest.approx(5.0) and np.allclose(share.sum(axis=0), 1.0)
        arms = []
        for end in (line.a, line.b):
            mesh = meshes[end.point.building]
            facade, _ = facades(mesh, end.point.floor, "")[""]
            middle = end.hats.mean(axis=1)
            for force, s in zip(end.forces, middle, strict=True):
                load = force.load(mesh)
                along = (mesh.nodes[load.nodes] - [*facade.start, 0.0]) @ facade.along
                assert load.forces.sum() == pytest.approx(1.0, abs=1e-12)
                assert load.forces @ along == pytest.approx(s, abs=1e-12 * facade.length)
            # From the point of the pair.
            arms.append(middle - (4.4 if end is line.a else 2.4))
        assert np.allclose(*arms, rtol=0.0, atol=1e-12)
        assert not np.allclose(arms[0] + 0.01, arms[1], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ([('B = "structure"', 'C = "structure"')], "pounding.models.C"),
        ([('B = "structure"', 'B = "shell"')], "'stick' or 'structure'"),
        ([('A = "structure", B = "structure"', 'A = "stick"')], "a law with a restitution"),
        ([('models =', 'update = "lagged"\nmodels =')], "expected 'implicit'"),
        ([('[transient]\n', '[transient]\neccentricity = "1 m"\n')], "where edges touch"),
        ([('floor = [1, 2], off', 'storey = [1, 2], relative_height = 0.5, off')],
         "a floor on one side"),
    ],
)  # fmt: skip
def test_models_that_are_refused(tmp_path, changes, expected):
    with pytest.raises(InputError, match=expected):
        load_case(in_3d(tmp_path, *changes))


PAIR = """[[contacts]]
a = {{ building = "A", floor = [1, 2], offset = ["{0} m", "2 m", "0 m"] }}
b = {{ building = "B", floor = [1, 2], offset = ["{0} m", "-2 m", "0 m"] }}
normal = [0, 1, 0]
gap = "{1} mm"
law = "{2}"
"""
TURNED = """[[contacts]]
a = { building = "B", floor = [1, 2], offset = ["1 m", "-2 m", "0 m"] }
b = { building = "A", floor = [1, 2], offset = ["1 m", "2 m", "0 m"] }
normal = [0, -1, 0]
gap = "1 mm"
law = "floor"
"""
OTHER = '[contact_laws.other]\ntype = "unilateral"\n'


def before(more):
    """The change that puts further sections ahead of that on the pounding."""
    return "[pounding]\n", f"{more}[pounding]\n"


def test_the_gap_is_straight_between_the_pairs_of_an_edge(tmp_path, caplog):
    """1 mm in the middle and 1.2 mm at 2 m are 0.7 mm at -3 m, less than both."""
    case, meshes = with_meshes(in_3d(tmp_path, before(PAIR.format(2, 1.2, "floor"))))
    lines = contact_lines(case, meshes)
    assert len(lines) == 2 and all(len(line.pair_names) == 2 for line in lines)
    for line in lines:
        at = line.a.point.offset[0] - line.normal[1] * line.position
        assert line.gap == pytest.approx(1e-3 + 1e-4 * at, abs=1e-12)
        # At the corners, not a third of a hat inside; of fewer points, too.
        assert np.sort(line.gap[[0, -1]]) == pytest.approx([0.7e-3, 1.3e-3])
        assert line.joined(4)[2][[0, -1]] == pytest.approx(line.gap[[0, -1]])
    warn_of_narrow(lines, case)
    assert caplog.text.count("the gap is 0.7") == 2
    assert "pairs is 1 mm" in caplog.text


def test_a_line_contact_has_its_length(tmp_path):
    """Of 6 m in common, 2.5 m about x = 1 m, by two Gauss points, with a gap that grows."""
    more = 'gap = "1 mm"\nlength = "2.5 m"\ngap_slope = 1e-4\n'
    moved = [(f'["0 m", "{sign}2 m"', f'["1 m", "{sign}2 m"') for sign in ("", "-")]
    case, meshes = with_meshes(in_3d(tmp_path, ('gap = "1 mm"\n', more), *moved))
    lines = contact_lines(case, meshes)
    assert [len(line.pair_names) for line in lines] == [2, 2]
    for line in lines:
        x = line.a.point.offset[0] - line.normal[1] * line.position
        assert np.sort(x[[0, -1]]) == pytest.approx([-0.25, 2.25])
        assert line.weight.sum() == pytest.approx(2.5)
        # The gap grows to the left of y+, which is x-.
        assert line.gap == pytest.approx(1e-3 - 1e-4 * (x - 1.0), abs=1e-9)


@pytest.mark.parametrize(("there", "overlap"), [(1.65, False), (1.7, True)])
def test_a_corner_that_overlaps_is_refused(tmp_path, there, overlap):
    """1 mm in the middle and 1.7 mm at 2 m are -0.05 mm at -3 m; a third of a hat inside, more."""
    case, meshes = with_meshes(in_3d(tmp_path, before(PAIR.format(2, there, "floor"))))
    if not overlap:
        assert min(line.gap.min() for line in contact_lines(case, meshes)) == pytest.approx(25e-6)
        return
    with pytest.raises(InputError, match=r"-?3 m along .* -5e-05 m"):
        contact_lines(case, meshes)


@pytest.mark.parametrize("slope", [0.03, -0.03])
def test_a_side_that_is_not_parallel(tmp_path, slope):
    """A's side turns about the pair in its middle: both corners have the gap that they have."""
    case, meshes = with_meshes(in_3d(tmp_path, WIDE))
    for line in contact_lines(case, bent(meshes, lambda x, y: slope * (x - 3.0) * y / 4.0)):
        x = line.a.point.offset[0] - line.normal[1] * line.position  # from the middle
        assert x[[0, -1]] == pytest.approx([3.0, -3.0])
        assert line.gap == pytest.approx(0.1 - slope * x, abs=1e-9)
    with pytest.raises(InputError, match=r"overlap: -?3 m along them"):
        contact_lines(case, bent(meshes, lambda x, y: slope * (x - 3.0) * y / 3.0))


@pytest.mark.parametrize("pairs", [1, 2])
def test_an_edge_that_is_not_straight(tmp_path, pairs):
    """It stands out 20 mm in its middle, where the pair is: at the corners the gap is larger."""
    more = [before(PAIR.format(2, 100 + 20 * (2 / 3) ** 2, "floor"))] * (pairs - 1)
    case, meshes = with_meshes(in_3d(tmp_path, WIDE, *more))
    meshes = bent(meshes, lambda x, y: 0.02 * (1.0 - ((x - 3.0) / 3.0) ** 2) * y / 4.0)
    for line in contact_lines(case, meshes):
        x = line.a.point.offset[0] - line.normal[1] * line.position
        assert line.gap.max() == pytest.approx(0.12, abs=1e-9)
        assert line.gap == pytest.approx(0.1 + 0.02 * (x / 3.0) ** 2, abs=1e-6)


def test_a_bulge_between_the_points_is_one(tmp_path):
    """30 mm in the middle, where the pair of 10 cm is and no vertex: the others are at 13 cm."""
    case, meshes = with_meshes(in_3d(tmp_path, WIDE))
    meshes = bent(meshes, lambda x, y: 0.03 * ((np.abs(x - 3.0) < 0.5) & (y > 3.9)))
    for line in contact_lines(case, meshes):
        assert line.gap.min() == pytest.approx(0.1, abs=1e-6)
        assert np.sort(line.gap)[1] == pytest.approx(0.13, abs=1e-6)
        assert line.weight.sum() == pytest.approx(np.ptp(line.position))


@pytest.mark.parametrize("off", [1e-5, 1e-3])
def test_a_side_that_is_a_little_off_a_line_is_one(tmp_path, off):
    """That of no group, too: in pieces, only one of which would be touched."""
    _case, meshes = with_meshes(in_3d(tmp_path, WIDE))
    moved = bent(meshes, lambda x, y: -off * ((np.abs(x - 2.0) < 1.5) & (y < 0.1)))
    found = facades(moved["A"], 1)
    assert [*found] == [*facades(meshes["A"], 1)]
    assert found["y-"][0].length == pytest.approx(6.0, abs=1e-5)


def test_no_word_where_no_gap_is_smaller_than_given(tmp_path, caplog):
    case, meshes = with_meshes(in_3d(tmp_path, before(PAIR.format(2, 1, "floor"))))
    warn_of_narrow(contact_lines(case, meshes), case)
    assert "1 m apart along" not in caplog.text


STOREY = 'storey = [1, 2], relative_height = 0.5, offset = ["0 m", "{} m"'
ON_STOREY = 'floor = [1, 2], offset = ["0 m", "-2 m"'
# A floor beside the middle of a storey.
BESIDE = ('allow = "gap"', 'allow = ["gap", "depth"]')


def test_a_floor_meets_what_stands_in_a_storey(tmp_path):
    """A wall 1.5 m behind the edge, by a pair at its face; there is nothing at the ends."""
    changes = BESIDE, (ON_STOREY, STOREY.format(-0.5)), ('gap = "1 mm"', 'gap = "1.501 m"')
    case, meshes = with_meshes(in_3d(tmp_path, *changes))
    for line in contact_lines(case, meshes):
        assert line.position == pytest.approx([-1.0, 1.0])
        assert line.gap == pytest.approx([1.501, 1.501])
        mesh = meshes["B"]
        for force, place in zip(line.b.forces, line.b.hats[:, 1], strict=True):
            load = force.load(mesh)
            assert load.forces.sum() == pytest.approx(1.0, abs=1e-12)
            assert load.forces @ mesh.nodes[load.nodes, 0] == pytest.approx(place, abs=1e-9)
            assert mesh.nodes[load.nodes, 1] == pytest.approx(1.5)
        # In the middle between the floors.
        assert line.b.forces[0].height == pytest.approx(3.0 * (line.b.point.level - 0.5))


@pytest.mark.parametrize("depth", [0.1, 0.4])
def test_a_line_contact_meets_a_strip_of_a_storey(tmp_path, depth):
    """The same wall, each point on its part of a strip as deep as the slab."""
    more = f'gap = "1.501 m"\nlength = "6 m"\ndepth = "{depth} m"\npoints = 1\n'
    changes = BESIDE, (ON_STOREY, STOREY.format(-0.5)), ('gap = "1 mm"\n', more)
    case, meshes = with_meshes(in_3d(tmp_path, *changes))
    lines = contact_lines(case, meshes)
    assert len(lines) == 2
    mesh = meshes["B"]
    for line in lines:
        assert line.position == pytest.approx([-1.0, 1.0])
        # Parts of the length w_i = 2 m, next to each other.
        assert np.diff(line.b.hats[:, [0, 2]]).ravel() == pytest.approx([2.0, 2.0])
        for force, place in zip(line.b.forces, line.b.hats[:, 1], strict=True):
            assert force.depth == depth
            load = force.load(mesh)
            x, _, z = mesh.nodes[load.nodes].T
            assert load.forces.sum() == pytest.approx(1.0, abs=1e-12)
            assert load.forces @ x == pytest.approx(place, abs=1e-11)
            assert load.forces @ z == pytest.approx(force.height, abs=1e-11)
    # Read from the file of forces, each point has the same pattern.
    point = line.b.point
    end = PairEnd(point.building, point.level, 0.5, -line.normal, point.offset, depth=depth)
    sides = Sides(case.modelled["B"], mesh)
    facade, _ = sides.met(case.path, line.name, end)
    for force, hat in zip(line.b.forces, line.b.hats.tolist(), strict=True):
        assert sides.point_force(replace(end, hat=tuple(hat)), facade) == force


@pytest.mark.parametrize("aside", [0.0, 0.4, 3.0])
def test_a_floor_meets_columns_where_they_stand(tmp_path, aside):
    """At the corners of the façade, wherever the pair is, with the floor at these points."""
    changes = [BESIDE, (ON_STOREY, STOREY.format(-2))]
    for sign in ("", "-"):
        changes.append((f'["0 m", "{sign}2 m"', f'["{aside} m", "{sign}2 m"'))
    case, meshes = with_meshes(in_3d(tmp_path, *changes))
    for line in contact_lines(case, meshes):
        assert np.sort(aside - line.position) == pytest.approx([-3.0, 3.0])
        assert line.weight == pytest.approx([2.0, 2.0])  # of [transient] patch_width
        for end in (line.a, line.b):
            mesh = meshes[end.point.building]
            for force, hat in zip(end.forces, end.hats, strict=True):
                assert np.ptp(hat) == 0.0
                load = force.load(mesh)
                assert load.forces.sum() == pytest.approx(1.0, abs=1e-12)
                s = mesh.nodes[load.nodes, 0]  # which faces along y count from x = 0
                assert load.forces @ s == pytest.approx(hat[1], abs=1e-12)
        assert np.sort(line.b.hats[:, 1]) == pytest.approx([0.0, 6.0])


COLUMN = "column,storeys,x [m],y [m],width_x [m],width_y [m]\n"


@pytest.mark.parametrize("normal", ["[0, 1, 0]", "[0.26, 0.9656086163658649, 0]"])
def test_a_floor_meets_walls_and_columns(tmp_path, normal):
    """One point of each, in order; columns inside and at the far side are not met.

    A column beside a wall, within half of a patch of it, takes the force of its own point.
    """
    path = in_3d(tmp_path, BESIDE, (ON_STOREY, STOREY.format(-2)))
    path.write_text(path.read_text().replace("normal = [0, 1, 0]", f"normal = {normal}"))
    wall = "wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]\n"
    (tmp_path / "walls.csv").write_text(
        f"{wall}front,1-2,0.5,0,4,0,0.2\nback,1-2,2,2.5,4,2.5,0.2\n"
    )
    places = [(0, 0), (6, 0), (0, 4), (6, 4), (2.6, 2), (5, 2)]
    rows = [f"c{k},1-2,{x},{y},0.4,0.4" for k, (x, y) in enumerate(places)]
    (tmp_path / "columns.csv").write_text(COLUMN + "\n".join(rows) + "\n")
    case, meshes = with_meshes(path)
    mesh = meshes["B"]
    for line in contact_lines(case, meshes):
        walls = mesh.triangles[mesh.triangles_of("storey", line.b.point.level)]
        met = []
        for force, of_column in zip(line.b.forces, line.columns, strict=True):
            load = force.load(mesh)
            met.append(load.forces @ mesh.nodes[load.nodes, 0])
            assert load.forces.sum() == pytest.approx(1.0, abs=1e-12)
            assert np.isin(load.nodes, walls).any() != of_column
            assert np.allclose(mesh.nodes[load.nodes, 1], 0.0)
            if of_column:
                assert np.ptp(mesh.nodes[load.nodes, 0]) == 0.0
        assert np.array(met)[line.columns] == pytest.approx([6.0, 0.0])
        assert np.all(np.diff(met) < 0.0) and 2 <= (~line.columns).sum() < len(met)
        for every in (1, 2):
            share, w, _ = line.joined(every)
            assert np.isfinite(share).all() and w.sum() == pytest.approx(line.weight.sum())
            assert share.sum(axis=0) == pytest.approx(np.ones(len(w)))
            alone = np.isin(share, [0.0, 1.0]).all(axis=0) & share[line.columns].any(axis=0)
            assert alone.sum() == 2


def test_check_finds_lines_that_are_refused(tmp_path):
    """Without [transient] too, whose own checks look at each building alone."""
    path = in_3d(tmp_path, ('["0 m", "-2 m", "0 m"]', '["1 m", "-2 m", "0 m"]'))
    with pytest.raises(InputError, match="1 m apart along"):
        check(path, mesh=True)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("[0, 1, 0]\n[[mot", "[1, 0, 0]\n[[mot", "loads[0].direction"),
        ("[transient]\n", '[transient]\neccentricity = "1 m"\n', "transient.eccentricity"),
        ("push.csv", "push.csv", ""),
    ],
)
def test_check_says_a_fault_once(tmp_path, old, new, key):
    """What the file has wrong is not found again in the mesh."""
    load = '[[loads]]\nfile = "push.csv"\ndirection = [0, 1, 0]\n[[motions]]\n'
    (tmp_path / "push.csv").write_text("time [s],A.floor_2 [MN]\n0,0\n0.1,1\n0.2,0\n")
    path = in_3d(tmp_path, ("[[motions]]\n", load), (old, new))
    if not key:
        check(path, mesh=True)
        return
    with pytest.raises(InputError) as caught:
        check(path, mesh=True)
    assert [fault.key for fault in caught.value.faults] == [key]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ([('["0 m", "-2 m", "0 m"]', '["9 m", "-2 m", "0 m"]')], "on the side of the floor"),
        ([('["0 m", "2 m", "0 m"] }', '["0 m", "1 m", "1 m"] }')], "above the floor's mass centre"),
        ([before(TURNED)], "the same building as a"),
        ([before(PAIR.format(1, 1, "other") + OTHER)], "expected 'floor', the law of"),
        ([before(PAIR.format(1, 5, "floor"))], "sides that do not overlap"),
        ([before(PAIR.format(1e-7, 2, "floor"))], "one gap at one place"),
        ([BESIDE, (ON_STOREY, STOREY.format(-1))], "stand 0.5 m behind the point of the pair"),
        ([BESIDE, (ON_STOREY, STOREY.format(0.5))], "stand 1 m in front of the point of the pair"),
    ],
)
def test_lines_that_are_refused(tmp_path, changes, expected):
    with pytest.raises(InputError, match=expected):
        contact_lines(*with_meshes(in_3d(tmp_path, *changes)))

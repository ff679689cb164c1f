"""Forces of pairs on the sides of a 3D building: where they act, and what they turn."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from impactfem.building.facade import facades
from impactfem.building.floor import contact_edge
from impactfem.building.mesh import Part
from impactfem.case import Contact, ContactPoint
from impactfem.case.calibration import WallImpactSetup
from impactfem.case.transient import Transient
from impactfem.coupling.force_history import ForceHistory
from impactfem.reduction.edge_force import EdgeForce, floor_shares
from impactfem.reduction.forces import check_contacts, checked_forces
from impactfem.reduction.loads import make_loads
from impactfem.reduction.sides import PairEnd, Sides
from impactfem.system.errors import InputError
from one_building import building_of

from ..building.conftest import assembled, csr, panels  # noqa: F401

TIME = np.linspace(0.0, 0.1, 101)
STEP = 1e-3
MIDDLE = np.array([3.0, 2.0, 6.0])
"""Of floor 2 of the frame, 6 m x 4 m."""
# Unit vectors out of the building, and offsets from the middle of the floor.
CORNERS = [((0, 1, 0), (-3, 2, 0)), ((0, 1, 0), (3, 2, 0))]
PAIRS = {
    "corners": CORNERS,
    "one beside the middle": [((0, 1, 0), (1.1, 2, 0))],
    "two sides": [((0, 1, 0), (0.5, 2, 0)), ((0, -1, 0), (-1, -2, 0))],
    "across": [((1, 0, 0), (3, -0.7, 0)), ((-1, 0, 0), (-3, 0.2, 0))],
    "oblique": [((0.6, 0.8, 0), (1, 2, 0)), ((-0.6, 0.8, 0), (0, 2, 0)), ((0, 1, 0), (0, 2, 0))],
}


def contact(number, normal, offset, storey=None):
    """A point of F on floor 2, or in the middle of its storey, and one of a building G."""
    place = {"floor": 2, "storey": None, "relative_height": None}
    if storey is not None:
        place = {"floor": None, "storey": storey, "relative_height": 0.5}
    a, b = (
        ContactPoint(building=name, offset=tuple(map(float, of)), **place)
        for name, of in (("F", offset), ("G", (0, 0, 0)))
    )
    unit = tuple(float(x) for x in normal)
    return Contact(
        name=f"p{number}", a=a, b=b, normal=unit, gap=0.0, law="floor", bearing_area=None
    )


def case_of(frame, pairs, storey=None, **transient):
    """The frame with pairs; its axis is the middle of its plan, in other coordinates."""
    wall = WallImpactSetup.model_construct(building="F", floors=(1, 2), contact_spacing=None)
    contacts = tuple(contact(j, *pair, storey) for j, pair in enumerate(pairs))
    update = {"contacts": contacts, "transient": Transient(time_step=STEP, **transient)}
    return frame.case.model_copy(update=update | {"wall_impact": wall})


def forces_of(pairs):
    """A different force of each pair."""
    force = [1e5 * (j + 1) * np.sin(np.pi * (j + 1) * TIME / 0.1) ** 2 for j in range(len(pairs))]
    return ForceHistory(TIME, tuple(f"p{j}" for j in range(len(pairs))), np.array(force).T)


def by_hand(pairs, force):
    """Σ f and Σ (x − x_m) × f about the middle of the floor, of −F n at each point, (n_t, 6)."""
    f = -force[:, :, None] * np.array([normal for normal, _ in pairs], dtype=float)
    turned = np.cross(np.array([offset for _, offset in pairs], dtype=float)[None], f)
    return np.concatenate([f.sum(axis=1), turned.sum(axis=1)], axis=1)


def in_3d(frame, case, pairs, impulses=None, change=lambda shares: shares):
    """The same of the loads of the 3D model, by virtual work."""
    history, shares = checked_forces(
        forces_of(pairs), Path("f.nc"), building_of(case), frame.parts.mesh, 0.1, impulses=impulses
    )
    loads = make_loads([], history, [change(one) for one in shares], STEP, 100)
    motion = frame.model.rigid_body(MIDDLE)
    return loads, loads.force @ (motion.T @ loads.patterns(frame.model, frame.parts.mesh)).T


SPREADS = [{}, {"spread": "patch", "patch_width": 1.3}, {"spread": "calibrated"}]


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("asked", SPREADS, ids=lambda one: one.get("spread", "uniform"))
def test_resultant_and_moment_of_every_pair_arrive(frame, name, asked):
    pairs, impulses = PAIRS[name], {1: np.arange(9.0), 2: np.arange(9.0) ** 2}
    case = case_of(frame, pairs, **asked)
    if "spread" in asked and asked["spread"] == "calibrated" and name in ("two sides", "across"):
        with pytest.raises(InputError, match=r"transient\.spread = 'calibrated'"):
            in_3d(frame, case, pairs, impulses)
        return
    loads, found = in_3d(frame, case, pairs, impulses)
    hand = by_hand(pairs, forces_of(pairs).force)
    assert np.abs(found - hand).max() < 1e-12 * np.abs(hand).max()
    # And as they are shown: on each side the force along its pairs, and its moment along the side.
    force, moment = loads.resultants
    assert np.abs(force.sum(axis=1) - forces_of(pairs).force.sum(axis=1)).max() < 1e-6
    if name == "corners":
        assert loads.places == ("floor 2",)
        F = forces_of(pairs).force
        assert moment[:, 0] == pytest.approx(3.0 * (F[:, 1] - F[:, 0]), abs=1e-6)


def without_moment(shares):
    return tuple((one, factor) for one, factor in shares if one.resultant != 0.0)


def other_sign(shares):
    return tuple((one, factor if one.resultant != 0.0 else -factor) for one, factor in shares)


@pytest.mark.parametrize("change", [without_moment, other_sign])
def test_a_moment_that_is_lost_or_turned_is_seen(frame, change):
    pairs = CORNERS
    _, found = in_3d(frame, case_of(frame, pairs), pairs, change=change)
    hand = by_hand(pairs, forces_of(pairs).force)
    assert np.abs(found - hand)[:, :5].max() < 1e-12 * np.abs(hand).max()
    assert np.abs(found - hand)[:, 5].max() > 0.5 * np.abs(hand[:, 5]).max()


@pytest.mark.parametrize(
    ("pair", "axis", "at"),
    [
        (((0, 1, 0), (0, 2, 0)), 1, 4.0),
        (((0, -1, 0), (0, -2, 0)), 1, 0.0),
        (((1, 0, 0), (3, 0, 0)), 0, 6.0),
        (((-1, 0, 0), (-3, 0, 0)), 0, 0.0),
    ],
)
def test_the_side_is_that_of_the_pair(frame, pair, axis, at):
    """Resultant and moment do not tell opposite sides from each other: the nodes do."""
    mesh = frame.parts.mesh
    (((one, factor),),) = checked_forces(
        forces_of([pair]), Path("f.nc"), building_of(case_of(frame, [pair])), mesh, 0.1
    )[1]
    assert factor == 1.0
    assert mesh.nodes[one.load(mesh).nodes, axis] == pytest.approx(at)
    assert mesh.nodes[one.load(mesh).nodes, 2] == pytest.approx(6.0)


def test_a_patch_is_as_wide_as_it_is_asked_to_be(frame):
    mesh, pairs = frame.parts.mesh, [((0, 1, 0), (-0.4, 2, 0))]
    case = case_of(frame, pairs, spread="patch", patch_width=1.5)
    (((one, _),),) = checked_forces(forces_of(pairs), Path("f.nc"), building_of(case), mesh, 0.1)[1]
    load = one.load(mesh)
    x = mesh.nodes[load.nodes[load.forces != 0.0], 0]
    # Elements are 0.75 m long.
    assert x.min() > 2.6 - 0.75 - 0.75 and x.max() < 2.6 + 0.75 + 0.75
    assert load.forces.sum() == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("storey", [None, 2])
def test_pairs_at_one_place_but_for_rounding_share_their_pattern(frame, storey):
    """A pattern is found by its name: two of one name are refused."""
    pairs = [((-1, 0, 0), (-3, y, 0)) for y in (0.3, 0.3 + 1e-12, 0.4)]
    case = case_of(frame, pairs, storey=storey, spread="patch", patch_width=1.5)
    loads, found = in_3d(frame, case, pairs)
    assert len(loads.edges) == len(check_contacts(building_of(case), frame.parts.mesh)) == 2
    hand = by_hand(pairs, forces_of(pairs).force)[:, [0, 1, 5]]
    assert np.abs(found[:, [0, 1, 5]] - hand).max() < 1e-9 * np.abs(hand).max()


@pytest.mark.parametrize(
    ("normal", "offset", "width", "at"),
    [
        ((-1, 0, 0), (-3, 0.3, 0), 1.5, (0.0, 2.3)),  # the wall at x = 0
        ((-0.8, 0.6, 0), (-3, 0.3, 0), 1.5, (0.0, 2.3)),
        ((0, 1, 0), (3, 2, 0), 1.5, (6.0, 4.0)),  # a column, at x = 6 m
        ((0, -1, 0), (-3, -2, 0), 2.0, (0.0, 0.0)),  # a wall on edge
    ],
)
def test_inside_a_storey(frame, normal, offset, width, at):
    """No moment about the point, halfway up storey 2."""
    pairs = [(normal, offset)]
    case = case_of(frame, pairs, storey=2, patch_width=width)
    z = 0.5 * (3.0 + 6.0)
    loads, _ = in_3d(frame, case, pairs)
    assert [one.place.split()[0] for one in loads.edges] == ["storey"]
    patterns = loads.patterns(frame.model, frame.parts.mesh)
    work = frame.model.rigid_body(np.array([*at, z])).T @ patterns
    # A force on nodes along a line cannot turn about it.
    assert work[:, 0] == pytest.approx([*(-np.array(normal)), 0, 0, 0], abs=1e-12)


@pytest.mark.parametrize(
    ("normal", "offset", "width", "expected"),
    [
        ((0, 1, 0), (0, 2, 0), 2.0, "no node of its walls and columns is within 1 m"),
        ((0, 1, 0), (2.8, 2, 0), 2.0, "do not take its moment"),  # 20 cm beside a column
    ],
)
def test_a_storey_with_nothing_there(frame, normal, offset, width, expected):
    case = case_of(frame, [(normal, offset)], storey=2, patch_width=width)
    with pytest.raises(InputError) as caught:
        in_3d(frame, case, [(normal, offset)])
    (fault,) = caught.value.faults
    assert expected in fault.expected and "patch_width" in fault.expected
    assert fault.value == "storey 2 of F at 0.5 of its height"


def lines(case, length, along, depth=0.2):
    """The pairs of a case as points of lines of a length, at these positions of them [m]."""
    contacts = tuple(
        one.model_copy(update={"length": length, "along": s, "depth": depth, "line": one.name})
        for one, s in zip(case.contacts, along, strict=True)
    )
    return case.model_copy(update={"contacts": contacts})


@pytest.mark.parametrize(
    ("normal", "t", "half"), [((0, 1, 0), (-1, 0), 3.0), ((1, 0, 0), (0, 1), 2.0)]
)
@pytest.mark.parametrize("depth", [0.05, 0.2, 1.0])
def test_a_line_against_a_storey_is_a_strip(frame, normal, t, half, depth):
    """Resultant and moment of each Gauss point, and of both, about the middle of the strip."""
    s = half / np.sqrt(3.0)
    middle = (0.0, 2.0) if normal[1] else (3.0, 0.0)
    pairs = [(normal, (middle[0] + a * t[0], middle[1] + a * t[1], 0.0)) for a in (-s, s)]
    case = lines(case_of(frame, pairs, storey=2), 2.0 * half, (-s, s), depth)
    loads, _ = in_3d(frame, case, pairs)
    assert len(loads.edges) == 2 and all(one.depth == depth for one in loads.edges)
    z = 0.5 * (3.0 + 6.0)
    patterns = loads.patterns(frame.model, frame.parts.mesh)
    centre = np.array([3.0 + middle[0], 2.0 + middle[1], z])
    work = frame.model.rigid_body(centre).T @ patterns
    for k, a in enumerate((-s, s)):
        push = -np.array(normal, dtype=float)
        moment = np.cross([a * t[0], a * t[1], 0.0], push)
        # A force on nodes behind the side has the same line of action.
        assert work[:3, k] == pytest.approx(push, abs=1e-12)
        assert work[3:, k] == pytest.approx(moment, abs=1e-12 * 2.0 * half)
    # Both columns of the side take a part: a uniform load for equal forces.
    nodes = loads.edges[0].load(frame.parts.mesh).nodes
    along = frame.parts.mesh.nodes[nodes, :2] @ np.abs(t)
    assert np.ptp(along) == pytest.approx(2.0 * half)
    equal = sum(one.load(frame.parts.mesh).forces for one in loads.edges)
    assert equal[along > along.mean()].sum() == pytest.approx(1.0)


def test_a_strip_with_nothing_there(frame):
    pairs = [((0, 1, 0), (0, 2, 0))]
    with pytest.raises(InputError, match="no wall or column from 2 to 4 m"):
        in_3d(frame, lines(case_of(frame, pairs, storey=2), 2.0, [0.0]), pairs)
    # On one column: no moment along the side.
    pairs = [((0, 1, 0), (2, 2, 0))]
    with pytest.raises(InputError, match="do not take its moment"):
        in_3d(frame, lines(case_of(frame, pairs, storey=2), 2.0, [0.0]), pairs)


def test_a_line_on_a_part_of_a_side(frame):
    """Of a floor: on its common length alone; of its whole length as any other pair."""
    s = 1.0 / np.sqrt(3.0)
    pairs = [((0, 1, 0), (1.0 - a, 2, 0)) for a in (-s, s)]  # to the left of y+ is x-
    case = lines(case_of(frame, pairs), 2.0, (-s, s))
    loads, found = in_3d(frame, case, pairs)
    hand = by_hand(pairs, forces_of(pairs).force)
    assert np.abs(found - hand).max() < 1e-12 * np.abs(hand).max()
    mesh = frame.parts.mesh
    total = sum(one.load(mesh).forces for one in loads.edges)
    x = mesh.nodes[loads.edges[0].load(mesh).nodes, 0]
    size = np.diff(np.unique(x)).max()
    loaded = x[np.abs(total) > 1e-12]
    assert 3.0 - 2.0 * size <= loaded.min() and loaded.max() <= 5.0 + 2.0 * size
    whole = lines(case_of(frame, pairs), 6.0, (-1.0 - s, -1.0 + s))
    assert {one.name for one in in_3d(frame, whole, pairs)[0].edges} == {
        "floor 2",
        "floor 2 turning",
    }


@pytest.mark.parametrize("spacing", [None, 1.6])
def test_patterns_of_the_calibrated_spread_are_the_contacts_of_the_wall(frame, spacing):
    """A point of contact enters the basis in one way, whatever its force comes from."""
    mesh, pairs = frame.parts.mesh, [((0, 1, 0), (0.4, 2, 0))]
    case = case_of(frame, pairs, spread="calibrated")
    wall = case.wall_impact.model_copy(update={"contact_spacing": spacing})
    case = case.model_copy(update={"wall_impact": wall})
    edge = contact_edge(mesh, 2, spacing)
    impulse = 1.0 + np.arange(len(edge.position))
    _, (shares,) = checked_forces(
        forces_of(pairs), Path("f.nc"), building_of(case), mesh, 0.1, impulses={2: impulse}
    )
    assert check_contacts(building_of(case), mesh) == tuple(one for one, _ in shares)
    for (one, _), column in zip(shares, edge.means.T.toarray(), strict=True):
        load = one.load(mesh)
        assert np.array_equal(load.nodes, edge.nodes)
        assert load.forces == pytest.approx(column, abs=1e-14)
    with pytest.raises(InputError, match="floor 2 took no"):
        checked_forces(
            forces_of(pairs), Path("f.nc"), building_of(case), mesh, 0.1, impulses={2: 0 * impulse}
        )
    # Where the impulse of the wall acts in the middle of the pair nothing is added to it.
    middle = sum(
        f * (3.0 + one.moment) for (one, _), f in zip(shares, impulse / impulse.sum(), strict=True)
    )
    central = [((0, 1, 0), (middle - 3.0, 2, 0))]
    case = case.model_copy(update={"contacts": (contact(0, *central[0]),)})
    _, (shares,) = checked_forces(
        forces_of(pairs), Path("f.nc"), building_of(case), mesh, 0.1, impulses={2: impulse}
    )
    assert [factor for _, factor in shares] == pytest.approx(impulse / impulse.sum())


def test_central_pairs_have_one_pattern(frame):
    """Equal to the load of before, and the moment of a mirrored pair of equal forces is none."""
    mesh, pairs = frame.parts.mesh, [((0, 1, 0), (0, 2, 0))]
    sides = Sides(building_of(case_of(frame, pairs)), mesh)
    direction = (0.0, -1.0, 0.0)
    history, shares = checked_forces(forces_of(pairs), Path("f.nc"), sides.building, mesh, 0.1)
    assert shares == [((EdgeForce("floor 2", 2, direction), 1.0),)]
    case = case_of(frame, CORNERS)
    equal = replace(forces_of(CORNERS), force=np.ones((101, 2)))
    history, shares = checked_forces(equal, Path("f.nc"), building_of(case), mesh, 0.1)
    assert make_loads([], history, shares, STEP, 100).names == ("floor 2",)


def test_accidental_eccentricity_is_added(frame):
    pairs = [((0, 1, 0), (1, 2, 0))]
    _, found = in_3d(frame, case_of(frame, pairs, eccentricity=0.6), pairs)
    hand = by_hand([((0, 1, 0), (1.6, 2, 0))], forces_of(pairs).force)
    assert np.abs(found - hand).max() < 1e-12 * np.abs(hand).max()


def test_a_point_above_the_slab_is_no_force_in_it(frame):
    case = case_of(frame, [((0, 1, 0), (0, 2, 0.2))])
    assert next(iter(case.contacts)).a.offset[2] == 0.2
    with pytest.raises(InputError, match=r"0\.2 m above the floor"):
        in_3d(frame, case, [((0, 1, 0), (0, 2, 0.2))])


@pytest.mark.parametrize("asked", SPREADS[:2], ids=["uniform", "patch"])
def test_a_free_slab_turns_by_the_moment_integral(panels, assembled, csr, asked):  # noqa: F811
    """It is hit off its centre: the mean rotation rᵀ M u / J is ∫∫ F e dt dt / J."""
    a, b, t, e = 6.0, 4.0, 0.3, 1.9
    panels.panel((0, 0, 3), (a, 0, 0), (0, b, 0), (4, 3), Part("floor", 1), t)
    parts = panels.parts(edges={1: panels.sides_at((1, b))})
    model, mesh = assembled(parts), parts.mesh
    facade, _ = facades(mesh, 1, "")[""]
    transient = Transient(time_step=1.0, **asked)
    shares = floor_shares(1, facade, (0.0, -1.0, 0.0), 0.5 * a + e, transient)
    f = sum(factor * one.vector(model, mesh) for one, factor in shares)
    # Newmark's average acceleration on the free slab; F = F0 sin² πt/T.
    M, K = csr(model.mass), csr(model.stiffness(1.0))
    F0, T, n = 1e6, 0.02, 2000
    h = T / n
    F = F0 * np.sin(np.pi * np.arange(n + 1) / n) ** 2
    solve = splu((M + 0.25 * h**2 * K).tocsc()).solve
    u, v, acceleration = np.zeros((3, len(f)))
    r = model.rigid_body((0.5 * a, 0.5 * b, 3.0))[:, 5]
    J, found = float(r @ M @ r), []
    for k in range(n):
        ahead = u + h * v + 0.25 * h**2 * acceleration
        v = v + 0.5 * h * acceleration
        acceleration = solve(f * F[k + 1] - K @ ahead)
        u, v = ahead + 0.25 * h**2 * acceleration, v + 0.5 * h * acceleration
        found.append(float(r @ M @ u) / J)
    time = h * np.arange(1, n + 1)
    omega = 2.0 * np.pi / T
    exact = -e * F0 / 2.0 * (time**2 / 2.0 - (1.0 - np.cos(omega * time)) / omega**2) / J
    assert np.abs(np.array(found) - exact).max() < 1e-6 * np.abs(exact).max()
    # A plate's J by hand; the elements have some inertia about their normals, too.
    m = 2500.0 * a * b * t
    assert pytest.approx(m * (a**2 + b**2) / 12.0, rel=2e-3) == J


@pytest.mark.parametrize("storey", [1, 2])
@pytest.mark.parametrize("up", [0.0, 1.0])
def test_heights_of_a_mesh_that_counts_from_elsewhere(frame, storey, up):
    """The middle of a storey stays where it is, where the whole mesh is higher than the table."""
    mesh = frame.parts.mesh
    levels = {floor: z + up for floor, z in mesh.elevations.items()}
    higher = SimpleNamespace(nodes=mesh.nodes + np.array([0.0, 0.0, up]), elevations=levels)
    case = case_of(frame, [((0, 1, 0), (1, 2, 0))], storey)
    end = PairEnd.of(case.contacts[0].a, np.array([0.0, 1.0, 0.0]))
    middle = Sides(building_of(case), mesh).elevation(end)
    assert Sides(building_of(case), higher).elevation(end) == pytest.approx(middle + up)
    assert middle == pytest.approx({1: 1.5, 2: 4.5}[storey])

"""Impact forces against the building that they are to act on."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.mesh import outward_normal
from impactfem.case import Contact, ContactPoint, load_case
from impactfem.coupling.force_history import ForceHistory, PairEnds, read_forces
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.forces import check_contacts, checked_forces, pair_ends
from impactfem.system.errors import InputError
from one_building import building_of

from .conftest import slabs

GEOMETRY = Path(__file__).parents[2] / "geometry"
PATH = Path("forces.nc")
DURATION = 2.0
OUT = {"x-": (-1, 0, 0), "x+": (1, 0, 0), "y-": (0, -1, 0), "y+": (0, 1, 0)}


@pytest.fixture(scope="module")
def case():
    """Eight floors of B1 and B2 against each other; the 3D model is that of B1."""
    return load_case(GEOMETRY / "npp_pair.toml")


@pytest.fixture(scope="module")
def alone():
    """One building F with a 3D model, and no contacts."""
    return load_case(GEOMETRY / "frame.toml")


@pytest.fixture
def history(case):
    """What the sticks of the case write, up to 2 s."""
    time = np.linspace(0.0, DURATION, 201)
    pairs = tuple(contact.name for contact in case.contacts)
    force = np.outer(np.sin(np.pi * time) ** 2, np.arange(1.0, 9.0))
    floors = tuple(range(1, 9))
    on_floors = np.full(8, np.nan)
    ends = PairEnds(
        building_a=("B1",) * 8,
        building_b=("B2",) * 8,
        floor_a=floors,
        floor_b=floors,
        relative_height_a=on_floors,
        relative_height_b=on_floors,
        normal=np.tile([0.0, 1.0, 0.0], (8, 1)),
    )
    return ForceHistory(time, pairs, force, case.content_hash(), "the same", ends)


def foreign(**said):
    """Two pairs of another program: floors 1 and 2 of F against a rigid wall beyond its edge."""
    time = np.linspace(0.0, DURATION, 11)
    ends = PairEnds(
        building_a=("F", "F"),
        building_b=("", ""),
        floor_a=(1, 2),
        floor_b=(0, 0),
        normal=np.tile([0.0, 1.0, 0.0], (2, 1)),
    )
    return ForceHistory(time, ("low", "high"), np.ones((11, 2)), ends=replace(ends, **said))


def with_contacts(case, *contacts):
    return case.model_copy(update={"contacts": contacts})


def point(building, floor, storey=None):
    height = None if storey is None else 0.25
    return ContactPoint(
        building=building, floor=floor, storey=storey, relative_height=height, offset=(0, 0, 0)
    )


def contact(a, b, normal=(0, 1, 0)):
    name = f"{a.label}-{b.label}"
    return Contact(name=name, a=a, b=b, normal=normal, gap=0.01, law="floor", bearing_area=None)


def forces_of(case, duration=DURATION):
    """Forces of all pairs of a case, from a file that names them only."""
    pairs = tuple(contact.name for contact in case.contacts)
    return ForceHistory(np.array([0.0, duration]), pairs, np.ones((2, len(pairs))))


def faults_of(history, case, mesh):
    with pytest.raises(InputError) as caught:
        checked_forces(history, PATH, building_of(case), mesh, DURATION)
    assert {fault.file for fault in caught.value.faults} == {PATH}
    return [(fault.key, fault.value) for fault in caught.value.faults]


def test_forces_of_the_sticks(history, case, caplog):
    found, edges = checked_forces(history, PATH, building_of(case), slabs(8), DURATION, "the same")
    assert found.pairs == history.pairs
    assert np.array_equal(found.force, history.force)
    # A feels −F n: it is pushed away from its neighbour.
    assert edges == [((EdgeForce(f"floor {k}", k, (0.0, -1.0, 0.0)), 1.0),) for k in range(1, 9)]
    assert caplog.records == []


def test_a_csv_file_names_the_pairs_only(history, case, tmp_path):
    path = tmp_path / "forces.csv"
    backwards = history.of(range(7, -1, -1))
    backwards.write_csv(path)
    found, edges = checked_forces(read_forces(path), path, building_of(case), slabs(8), DURATION)
    assert found.ends == PairEnds()
    assert [edge.floor for ((edge, _),) in edges] == list(range(8, 0, -1))
    assert found.force == pytest.approx(backwards.force, rel=1e-8)


def test_the_second_building_of_a_pair(case):
    """B feels +F n; here B1 is b, and a lies beyond its edge at y = 0."""
    other = with_contacts(case, contact(point("B2", 3), point("B1", 3)))
    for side, name in (("y-", ""), ("y+", "y-")):
        _, (shares,) = checked_forces(
            forces_of(other), PATH, building_of(other), slabs(8, side), DURATION
        )
        ((edge, factor),) = shares
        assert (edge.floor, edge.side, edge.direction, factor) == (3, name, (0.0, 1.0, 0.0), 1.0)


def test_pairs_of_others_do_not_act(case):
    other = with_contacts(
        case,
        contact(point("B2", 1), point("B3", 1), (1, 0, 0)),
        contact(point("B1", 2), point("B2", 2)),
    )
    history = forces_of(other)
    found, (((edge, _),),) = checked_forces(history, PATH, building_of(other), slabs(8), DURATION)
    assert (found.pairs, edge.floor) == (("B1.floor_2-B2.floor_2",), 2)
    # And they may be left out.
    _, (((edge, _),),) = checked_forces(
        history.of([1]), PATH, building_of(other), slabs(8), DURATION
    )
    assert edge.floor == 2


def test_two_pairs_on_one_edge_are_the_same_load(case):
    """Along the normal of the edge: those of pairs may differ a little, one name is one load."""
    first = contact(point("B1", 2), point("B2", 2))
    second = first.model_copy(update={"name": f"{first.name}#2", "normal": (1e-5, 1.0, 0.0)})
    both = with_contacts(case, first, second)
    _, (one, other) = checked_forces(forces_of(both), PATH, building_of(both), slabs(8), DURATION)
    assert one == other


def test_no_pairs(case):
    none = with_contacts(case)
    found, edges = checked_forces(forces_of(none), PATH, building_of(none), slabs(8), DURATION)
    assert (found.pairs, found.force.shape, edges) == ((), (2, 0), [])


def test_wrong_and_missing_pairs(history, case):
    pairs = ("B1.floor_1-B2.flor_1", *history.pairs[1:7])
    wrong = replace(history.of(range(7)), pairs=pairs)
    with pytest.raises(InputError) as caught:
        checked_forces(wrong, PATH, building_of(case), slabs(8), DURATION)
    first, second, third = map(str, caught.value.faults)
    assert first == (
        "forces.nc: pair = 'B1.floor_1-B2.flor_1': expected a pair of the case; "
        "did you mean 'B1.floor_1-B2.floor_1'?"
    )
    for text, floor in ((second, 1), (third, 8)):
        assert (
            f"pair: missing; expected a column with the forces of the pair B1.floor_{floor}-"
            in text
        )


def test_points_of_lines_without_their_places(history, case):
    """A CSV of 3D models that touch: what is expected instead is said, once."""
    first, *others = history.pairs
    points = [f"{first} at {x:.4f} m" for x in (-1.0, 1.0)]
    given = replace(history, pairs=(*points, *others[1:]), ends=PairEnds())
    (fault,) = pair_ends(given, PATH, building_of(case), DURATION)[1]
    assert (fault.key, fault.value) == ("pair", points[0])
    assert fault.expected.startswith("expected forces.nc of that run")
    # Of pairs of points a CSV says enough, and a name of no pair is none of a line.
    assert pair_ends(replace(history, ends=PairEnds()), PATH, building_of(case), DURATION)[1] == []
    strange = replace(history, pairs=("left at 1.0 m", *others), ends=PairEnds())
    faults = pair_ends(strange, PATH, building_of(case), DURATION)[1]
    assert all("forces.nc" not in fault.expected for fault in faults)


@pytest.mark.parametrize(
    ("side", "values", "key"),
    [
        ("building_a", ("B1", "B2", *("B1",) * 6), "building_a"),
        ("building_b", ("B2", "B3", *("B2",) * 6), "building_b"),
        ("floor_a", (1, 3, 3, 4, 5, 6, 7, 8), "floor_a"),
        ("floor_b", (1, 1, 3, 4, 5, 6, 7, 8), "floor_b"),
        ("relative_height_a", np.where(np.arange(8) == 1, 0.5, np.nan), "relative_height_a"),
        ("relative_height_b", np.where(np.arange(8) == 1, 0.5, np.nan), "relative_height_b"),
        ("normal", np.roll(np.tile([0.0, 1.0, 0.0], (8, 1)), 1, axis=1), "normal"),
    ],
)
def test_a_file_that_contradicts_the_case(history, case, side, values, key):
    other = replace(history, ends=replace(history.ends, **{side: values}))
    faults = faults_of(other, case, slabs(8))
    assert f"pair {history.pairs[1]}, {key}" in dict(faults), faults
    assert len(faults) == (8 if side == "normal" else 1)


def test_too_short(history, case):
    mesh = slabs(8)
    # Less than one of their steps.
    checked_forces(history, PATH, building_of(case), mesh, DURATION + 0.009)
    with pytest.raises(InputError, match=r"forces up to 2\.02 s"):
        checked_forces(history, PATH, building_of(case), mesh, 2.02)


def test_every_fault_at_once(history, case):
    wrong = replace(history.of(range(7)), pairs=("left", *history.pairs[1:7]))
    mesh = slabs(5)
    with pytest.raises(InputError) as caught:
        checked_forces(wrong, PATH, building_of(case), mesh, 3.0)
    found = [(fault.key, fault.value) for fault in caught.value.faults]
    assert found == [
        ("pair", "left"),
        ("pair", None),
        ("pair", None),
        ("time", "up to 2 s"),
        ("pair B1.floor_6-B2.floor_6", "floor 6 of B1"),
        ("pair B1.floor_7-B2.floor_7", "floor 7 of B1"),
    ]


def test_contacts_by_the_mesh_alone(case):
    """As `check` sees them, before there are forces."""
    named = [f"floor {k}" for k in range(4, 9)]
    assert [one.name for one in check_contacts(building_of(case), slabs(8))] == named
    # Without groups of edges the sides of the slabs are known all the same.
    bare = check_contacts(building_of(case), slabs(8, edges={7, 8}))
    assert [one.name for one in bare] == [f"{k} y+" for k in named[:3]] + named[3:]
    with pytest.raises(InputError) as caught:
        check_contacts(building_of(case), slabs(7))
    fault, named = caught.value.faults
    assert (named.key, named.value) == ("transient.floors", [4, 5, 6, 7, 8])
    key = "pair B1.floor_8-B2.floor_8"
    assert (fault.file, fault.key, fault.value) == (case.path, key, "floor 8 of B1")
    with pytest.raises(InputError, match=r"floor 4 has no"):
        check_contacts(building_of(with_contacts(case)), slabs(8, edges={5, 6, 7, 8}))
    other = with_contacts(case, contact(point("B1", None, 3), point("B2", 2)))
    with pytest.raises(InputError, match=r"storey 3 of B1 .*: expected"):
        check_contacts(building_of(other), slabs(8))
    check_contacts(
        building_of(with_contacts(case, contact(point("B1", 2), point("B2", None, 3)))), slabs(8)
    )


@pytest.mark.parametrize(
    ("normal", "expected"),
    [((0.0, 0.8, 0.6), "a horizontal normal"), ((0.0, 0.0, -1.0), "a horizontal normal")],
)
def test_normals_that_are_not_horizontal(case, normal, expected):
    other = with_contacts(case, contact(point("B1", 2), point("B2", 2), normal))
    with pytest.raises(InputError) as caught:
        checked_forces(forces_of(other), PATH, building_of(other), slabs(8), DURATION)
    (fault,) = caught.value.faults
    assert expected in fault.expected
    assert fault.key == "pair B1.floor_2-B2.floor_2, normal out of B1"


@pytest.mark.parametrize(
    ("offset", "axis", "found"),
    [
        ((0.0, 2.0, 0.0), (23.1, 7.8), 0.0),  # the axis is not within the plan: it is the middle
        ((0.5, 2.0, 0.0), (23.1, 7.8), 0.5),
        # Within the plan, whose edge goes from x = 0 to 6 m: its middle is 3 m.
        ((1.0, 2.0, 0.0), (2.0, 2.0), 0.0),
        ((0.0, 2.0, 0.0), (2.0, 2.0), -1.0),
        ((3.1, 2.0, 0.0), (3.0, 2.0), "(0, 4) to (6, 4) m"),
        ((0.0, 2.0, 0.3), (3.0, 2.0), "0.3 m above the floor's mass centre"),
    ],
)
def test_where_the_edge_is_struck(case, offset, axis, found):
    first = case.buildings[0].model_copy(update={"axis": axis})
    end = point("B1", 5).model_copy(update={"offset": offset})
    other = with_contacts(case, contact(end, point("B2", 5))).model_copy(
        update={"buildings": (first, *case.buildings[1:])}
    )
    if isinstance(found, float):
        _, (shares,) = checked_forces(
            forces_of(other), PATH, building_of(other), slabs(8), DURATION
        )
        assert sum(factor * one.moment for one, factor in shares) == pytest.approx(found)
        assert {one for one, _ in shares} <= set(check_contacts(building_of(other), slabs(8)))
        return
    with pytest.raises(InputError) as caught:
        check_contacts(building_of(other), slabs(8))
    (fault,) = caught.value.faults
    assert fault.key == "pair B1.floor_5-B2.floor_5, offset on B1"
    assert found in fault.expected
    assert [key for key, _ in faults_of(forces_of(other), other, slabs(8))] == [fault.key]


@pytest.mark.parametrize(
    ("change", "inputs", "warned"),
    [
        ({}, "", False),  # the hash of the case
        ({"case_hash": "", "inputs": ""}, "", False),
        ({"case_hash": "", "inputs": ""}, "the same", False),
        ({"case_hash": "another"}, "the same", False),  # what the sticks do not depend on changed
        ({"case_hash": "another", "inputs": ""}, "the same", True),
        ({"case_hash": "another"}, "", True),
        ({"inputs": "another"}, "the same", True),
    ],
)
def test_another_case(history, case, caplog, change, inputs, warned):
    other = replace(history, **change)
    with caplog.at_level(logging.WARNING, "impactfem"):
        found, _ = checked_forces(other, PATH, building_of(case), slabs(8), DURATION, inputs)
    assert found.pairs == history.pairs
    assert [record.getMessage() for record in caplog.records] == [
        "warning: forces.nc was made from another case, or by another version"
    ] * warned


def test_pairs_of_another_program(alone):
    found, edges = checked_forces(foreign(), PATH, building_of(alone), slabs(2), DURATION)
    assert found.pairs == ("low", "high")
    assert [(edge.floor, edge.direction) for ((edge, _),) in edges] == [
        (1, (0.0, -1.0, 0.0)),
        (2, (0.0, -1.0, 0.0)),
    ]


@pytest.mark.parametrize(
    ("said", "key", "value"),
    [
        ({"normal": None}, "normal", None),
        ({"building_b": None, "floor_a": None}, "building_b, floor_a", None),
        ({"building_a": ("G", "G")}, "building_a, building_b", ["G"]),
        ({"building_b": ("", "F")}, "pair high, building_b", "F"),
        ({"floor_a": (1, 3)}, "pair high", "floor 3 of F"),
        ({"relative_height_a": np.array([0.5, np.nan])}, "pair low",
         "storey 1 of F at 0.5 of its height"),
        ({"normal": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])},
         "pair high, normal out of F", "(0, 0, 1)"),
        ({"offset_a": np.array([[0.0, 2.0, 0.0], [9.0, 2.0, 0.0]])},
         "pair high, offset on F", "(9, 2, 0)"),
    ],
)  # fmt: skip
def test_pairs_of_another_program_at_fault(alone, said, key, value):
    assert faults_of(foreign(**said), alone, slabs(2)) == [(key, value)]


@pytest.mark.parametrize("side", OUT)
def test_outward_normal(side):
    assert outward_normal(slabs(2, side), 2).tolist() == list(OUT[side])
    turned = outward_normal(slabs(2, side, turn=0.3), 1)
    x, y, _ = OUT[side]
    c, s = np.cos(0.3), np.sin(0.3)
    assert turned == pytest.approx([c * x - s * y, s * x + c * y, 0.0], abs=1e-9)

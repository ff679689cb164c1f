from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from impactfem.building.mesh import Part
from impactfem.building.parts import FloorMassError, Strips, floor_masses
from impactfem.building.section import E_Y, E_Z, BeamSection, Material
from impactfem.system.errors import SolutionError

RHO = 2500.0
# The house of conftest by hand, 2500 kg/m3. Storeys of 3.0 and 3.5 m; walls 4 m by 0.5 m and
# 2 m by 0.4 m; columns 0.4 m by 0.6 m; slabs 12 m2 by 0.3 m; a beam of 4 m, 0.3 m by 0.5 m; an
# parapet of 4 m by 0.6 m by 0.2 m.
STANDING = 4 * 0.5 + 2 * 0.4 + 0.4 * 0.6
STOREYS = RHO * np.array([3.0, 3.5]) * STANDING
FIRST = RHO * (12 * 0.3 + 4 * 0.3 * 0.5) + 0.5 * STOREYS.sum()
SECOND = RHO * (12 * 0.3 + 4 * 0.6 * 0.2) + 0.5 * STOREYS[1]


def of(parts, asked=None, *moved):
    asked = None if asked is None else np.array(asked)
    return floor_masses(parts.mesh, parts.sections, parts.materials, asked, *moved)


def test_the_house_by_hand(house):
    found = of(house)
    assert found.parts == pytest.approx([FIRST, SECOND], rel=1e-12)
    assert found.base == pytest.approx(0.5 * STOREYS[0], rel=1e-12)
    assert not found.added.any() and not found.on_triangles.any()


def test_parts_of_a_denser_material(house, assembled):
    """Columns of steel: they weigh more by (7850 − 2500) kg/m3, half of it on each floor."""
    steel = Material(200e9, 0.3, 7850.0)
    beams = tuple(
        steel if part.family == "column" else own
        for part, own in zip(house.mesh.beam_parts, house.materials.beams, strict=True)
    )
    mixed = replace(house, materials=replace(house.materials, beams=beams))
    found, more = of(mixed), (7850.0 - RHO) * 0.4 * 0.6
    assert found.parts == pytest.approx([FIRST + more * 3.25, SECOND + more * 1.75], rel=1e-12)
    assert found.floors.sum() + found.base == pytest.approx(assembled(mixed).total[0, 0], rel=1e-12)


def test_a_wall_with_a_hole_by_the_lever_rule(house):
    """Without its lower half, a storey's wall weighs on the floor above: 3/4 of the rest."""
    mesh = house.mesh
    inner = np.isin(np.arange(len(mesh.triangles)), mesh.triangles_of("storey", 2))
    low = mesh.nodes[mesh.triangles[:, :3], 2].mean(axis=1) < 3.0 + 1.75
    kept = ~(inner & low)
    halved = replace(mesh, triangles=mesh.triangles[kept], triangle_part=mesh.triangle_part[kept])
    found = of(replace(house, mesh=halved))
    walls = RHO * 3.5 * (4 * 0.5 + 2 * 0.4)
    # Each floor had half of the walls; now a quarter and three quarters of the upper half.
    assert found.parts[0] == pytest.approx(FIRST - 0.5 * walls + 0.125 * walls, rel=1e-12)
    assert found.parts[1] == pytest.approx(SECOND - 0.5 * walls + 0.375 * walls, rel=1e-12)


def test_added_mass_moves_the_centres_of_mass(house, assembled):
    """By e, of all that belongs to a floor: the static moment grows by M e."""
    asked, e = [60e3, 50e3], (0.15, -0.1)
    even, moved = of(house, asked), of(house, asked, e)
    assert moved.floors == pytest.approx(asked, rel=1e-13)
    heavy, before = (
        assembled(replace(house, added_mass=one.on_triangles)).total for one in (moved, even)
    )
    assert heavy[0, 0] == pytest.approx(before[0, 0], rel=1e-12)
    # Of translations along z with rotations about x and y: Σ m y and -Σ m x.
    moment = heavy[2, 3:5] - before[2, 3:5]
    assert moment == pytest.approx(sum(asked) * np.array([e[1], -e[0]]), rel=1e-9)
    with pytest.raises(SolutionError, match="cannot move by 3 m"):
        of(house, asked, (3.0, 0.0))
    # Also where no mass is added: by what the slabs weigh.
    e = (0.015, -0.01)
    alone = of(house, None, e)
    assert alone.added.tolist() == [0.0, 0.0]
    nothing = np.zeros_like(alone.on_triangles)
    total, bare = (
        assembled(replace(house, added_mass=x)).total for x in (alone.on_triangles, nothing)
    )
    moment = total[2, 3:5] - bare[2, 3:5]
    assert moment == pytest.approx(alone.floors.sum() * np.array([e[1], -e[0]]), rel=1e-9)


def test_added_mass_gives_what_is_asked(house, assembled):
    asked = [60e3, 50e3]
    found = of(house, asked)
    assert found.floors == pytest.approx(asked, rel=1e-13)
    assert found.added == pytest.approx(np.array(asked) - [FIRST, SECOND], rel=1e-10)
    heavy = assembled(replace(house, added_mass=found.on_triangles))
    assert heavy.total[0, 0] == pytest.approx(sum(asked) + found.base, rel=1e-12)
    # Even on the slabs: the centre of the added mass is that of the slabs, (2, 1.5).
    moment = heavy.total[:3, 3:] - assembled(house).total[:3, 3:]
    assert moment[2, 4 - 3] == pytest.approx(-found.added.sum() * 2.0, rel=1e-9)
    assert moment[2, 3 - 3] == pytest.approx(found.added.sum() * 1.5, rel=1e-9)


def test_added_mass_in_strips():
    """Across a slab, of 12 m by 6 m, by hand: even W²/12, strips of w along the edges
    ((W/2)² + (W/2)(W/2 − w) + (W/2 − w)²)/3, in the middle w²/12. Cut triangles lose no mass."""
    points = np.mgrid[0:12:13j, 0:6:13j].reshape(2, -1).T
    cells = Delaunay(points).simplices
    corners = points[cells]
    sides = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.abs(np.linalg.det(sides))
    away = (0.5 * (corners + np.roll(corners, 1, axis=1))[..., 1] - 3.0) ** 2  # at mid sides

    def gyration(*strips):
        share = area * Strips(1, *strips).density(corners, area)
        assert share.sum() == pytest.approx(1.0, rel=1e-12)
        return share @ away.mean(axis=1)

    edge = (3.0**2 + 3.0 * 2.0 + 2.0**2) / 3.0
    assert gyration(0.0, 0.0, 1.0) == pytest.approx(3.0, rel=1e-12)
    assert gyration(1.0, 0.0, 1.0) == pytest.approx(edge, rel=1e-12)
    assert gyration(0.0, 1.0, 1.0) == pytest.approx(1.0 / 12.0, rel=1e-12)
    mixed = 0.2 * edge + 0.5 / 12.0 + 0.3 * 3.0
    assert gyration(0.2, 0.5, 1.0) == pytest.approx(mixed, rel=1e-12)
    assert gyration(0.2, 0.5, 1.2) != pytest.approx(mixed, rel=0.01)  # sides within triangles
    assert gyration(0.0, 1.0, 1.2) == pytest.approx(1.2**2 / 12.0, rel=0.3)
    with pytest.raises(SolutionError, match="slab's 6 m"):
        gyration(0.5, 0.0, 2.1)
    # A triangle with a corner at the strip's far side: 1 − (2/3)² of it is within a third.
    lone = Strips(1, 0.0, 1.0, 2.0).density(np.array([[[0, 0], [0, 6], [1, 0]]]), np.array([3.0]))
    assert lone == pytest.approx([1.0 / 3.0], rel=1e-12)


def test_added_mass_is_on_slabs_alone(house):
    found = of(house, [60e3, 50e3])
    mesh = house.mesh
    slabs = np.array([p in (Part("floor", 1), Part("floor", 2)) for p in mesh.shell_parts])
    loaded = found.on_triangles > 0.0
    assert loaded.tolist() == slabs[mesh.triangle_part].tolist()
    assert set(np.round(found.on_triangles[loaded], 6)) == set(np.round(found.added / 12.0, 6))


def test_floors_that_cannot_have_the_mass_are_refused(house):
    with pytest.raises(SolutionError, match=r"\(floor 1: 35\.2 t, floor table 35\.0 t\)"):
        of(house, [35e3, 50e3])
    # All floors at once, and what else cannot be.
    with pytest.raises(FloorMassError) as caught:
        of(house, [35e3, 10e3], (3.0, 0.0))
    assert [key for _, key in caught.value.wrong] == ["mass_eccentricity", "floor_masses"]
    (moved, _), (heavy, _) = caught.value.wrong
    assert "floor 1, 35.2 t" in moved
    assert "floor 1: 35.2 t" in heavy and "floor 2: 23.5 t, floor table 10.0 t" in heavy
    mesh = house.mesh
    kept = mesh.triangle_part != mesh.shell_parts.index(Part("floor", 2))
    part = mesh.triangle_part[kept]
    open_roof = replace(mesh, triangles=mesh.triangles[kept], triangle_part=part)
    with pytest.raises(SolutionError, match="floor 2"):
        of(replace(house, mesh=open_roof), [60e3, 50e3])


def test_masses_without_beams(house):
    mesh = house.mesh
    bare = replace(house, mesh=replace(mesh, lines=mesh.lines[:0], line_part=mesh.line_part[:0]))
    beams = RHO * (4 * 0.3 * 0.5 + 3.25 * 0.24)
    assert of(bare).parts[0] == pytest.approx(FIRST - beams, rel=1e-12)


sides = st.floats(0.05, 5.0)


def torsion_constant(a, b):
    return BeamSection.rectangle(a, b).J


# Timoshenko and Goodier, Theory of Elasticity, section 109: J = k1 a³ b.
@pytest.mark.parametrize(
    ("ratio", "k1"),
    [(1.0, 0.1406), (1.2, 0.166), (1.5, 0.196), (2.0, 0.229), (2.5, 0.249), (3.0, 0.263),
     (4.0, 0.281), (5.0, 0.291), (10.0, 0.312)],
)  # fmt: skip
def test_torsion_constant_of_the_handbook(ratio, k1):
    a = 0.3
    assert torsion_constant(a, ratio * a) == pytest.approx(k1 * ratio * a**4, rel=2.5e-3)


@given(sides, sides)
def test_torsion_constant_does_not_know_width_from_depth(a, b):
    assert torsion_constant(a, b) == torsion_constant(b, a)
    assert torsion_constant(a, b) < a * b * (a**2 + b**2) / 12.0  # the polar moment bounds it


def test_rectangle():
    section = BeamSection.rectangle(0.75, 0.85)
    assert pytest.approx(0.6375) == section.A
    assert pytest.approx(0.75 * 0.85**3 / 12.0) == section.I1
    assert pytest.approx(0.85 * 0.75**3 / 12.0) == section.I2
    assert (section.k1, section.k2) == (5.0 / 6.0, 5.0 / 6.0)


def test_depth_of_a_beam_is_vertical_and_width_of_a_column_along_x():
    beam, column = BeamSection.beam(0.2, 0.28, -0.1), BeamSection.column(0.8, 1.2)
    assert (beam.reference, beam.offset) == (E_Z, (0.0, 0.0, -0.1))
    assert (column.reference, column.offset) == (E_Y, (0.0, 0.0, 0.0))
    # Moving along y bends the side along y.
    assert pytest.approx(0.8 * 1.2**3 / 12.0) == column.I1


def test_a_beam_along_its_reference_has_no_frame():
    directions = [[0.0, 0.0, -2.0], [0.0, 1e-3, 1.0], [0.0, 1e-2, 1.0], [1.0, 0.0, 0.0]]
    found = BeamSection.beam(0.3, 0.5).along_reference(directions)
    assert found.tolist() == [True, True, False, False]

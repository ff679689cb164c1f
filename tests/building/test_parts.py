from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.parts import floor_masses
from impactfem.building.section import Material
from impactfem.system.errors import SolutionError

RHO = 2500.0
# The house of conftest by hand, 2500 kg/m3. Storeys of 3.0 and 3.5 m; walls 4 m by 0.5 m and
# 2 m by 0.4 m; columns 0.4 m by 0.6 m; slabs 12 m2 by 0.3 m; a beam of 4 m, 0.3 m by 0.5 m; an
# parapet of 4 m by 0.6 m by 0.2 m.
STANDING = 4 * 0.5 + 2 * 0.4 + 0.4 * 0.6
STOREYS = RHO * np.array([3.0, 3.5]) * STANDING
FIRST = RHO * (12 * 0.3 + 4 * 0.3 * 0.5) + 0.5 * STOREYS.sum()
SECOND = RHO * (12 * 0.3 + 4 * 0.6 * 0.2) + 0.5 * STOREYS[1]


def of(parts, asked=None):
    asked = None if asked is None else np.array(asked)
    return floor_masses(parts.mesh, parts.sections, parts.materials, asked)


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


def test_added_mass_is_on_slabs_alone(house):
    found = of(house, [60e3, 50e3])
    mesh = house.mesh
    slabs = np.array([p in (Part("floor", 1), Part("floor", 2)) for p in mesh.shell_parts])
    loaded = found.on_triangles > 0.0
    assert loaded.tolist() == slabs[mesh.triangle_part].tolist()
    assert set(np.round(found.on_triangles[loaded], 6)) == set(np.round(found.added / 12.0, 6))


def test_floors_that_cannot_have_the_mass_are_refused(house):
    with pytest.raises(SolutionError, match=r"floor 1 weighs 35.2 t by its parts .* the 35.0 t"):
        of(house, [35e3, 50e3])
    mesh = house.mesh
    kept = mesh.triangle_part != mesh.shell_parts.index(Part("floor", 2))
    part = mesh.triangle_part[kept]
    open_roof = replace(mesh, triangles=mesh.triangles[kept], triangle_part=part)
    with pytest.raises(SolutionError, match="floor 2 has no flat slab"):
        of(replace(house, mesh=open_roof), [60e3, 50e3])


def test_masses_without_beams(house):
    mesh = house.mesh
    bare = replace(house, mesh=replace(mesh, lines=mesh.lines[:0], line_part=mesh.line_part[:0]))
    beams = RHO * (4 * 0.3 * 0.5 + 3.25 * 0.24)
    assert of(bare).parts[0] == pytest.approx(FIRST - beams, rel=1e-12)

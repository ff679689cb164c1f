"""A floor as a bar: stiffness, masses and speed against sums by hand."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.building import geometry
from impactfem.building.floor import bar_axis, floor_bar
from impactfem.building.generate import generate
from impactfem.building.parts import BuildingParts, floor_masses
from impactfem.building.read_mesh import read_mesh
from impactfem.building.section import Material, Materials

E, NU, RHO = 30e9, 0.2, 2500.0
LX, LY, HEIGHT, SLAB, MASSES = 6.0, 9.0, 4.0, 0.25, np.array([120e3, 150e3])
SIZE = geometry.MeshSize(floor=1.5, storey=1.5, beam=1.5, column=1.5)
EVERY = (1, 2)
GABLE = geometry.Wall("gable", EVERY, (0.0, 0.0), (0.0, LY), 0.2)
FACADE = geometry.Wall("facade", EVERY, (0.0, LY), (LX, LY), 0.3)
COLUMN = geometry.Column("post", EVERY, (LX, 0.0), 0.4, 0.5)
ALONG = geometry.Beam("along", EVERY, (3.0, 0.0), (3.0, LY), 0.3, 0.5)
ACROSS = geometry.Beam("across", EVERY, (0.0, 4.5), (LX, 4.5), 0.2, 0.4)
SKEW = geometry.Beam("skew", EVERY, (0.0, 0.0), (LX, LY), 0.2, 0.3)


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """A building of two floors, with the beams that are given."""
    made = {}

    def make(*beams, edge="y+"):
        if (beams, edge) not in made:
            path = tmp_path_factory.mktemp("bar") / "building.msh"
            built = geometry.Geometry(
                length=LX,
                width=LY,
                levels=(0.0, HEIGHT, 2 * HEIGHT),
                slab_thickness=SLAB,
                walls=(GABLE, FACADE),
                bays=(),
                beams=beams,
                columns=(COLUMN,),
                acroterion=geometry.Acroterion(0.6, 0.2),
                impact_edge=edge,
                size=SIZE,
            )
            generate(built, path)
            mesh = read_mesh(path)
            sections = built.sections(mesh.shell_parts, mesh.beam_parts)
            concrete = Material(E, NU, RHO)
            materials = Materials(
                (concrete,) * len(mesh.shell_parts), (concrete,) * len(mesh.beam_parts)
            )
            masses = floor_masses(mesh, sections, materials, MASSES)
            made[beams, edge] = BuildingParts(mesh, sections, materials, masses.on_triangles)
        return made[beams, edge]

    return make


def test_sums_by_hand(parts):
    bar = floor_bar(parts(ALONG, ACROSS), 1, 1)
    assert bar.length == LY
    assert bar.stiffness == pytest.approx(E * (LX * SLAB / (1.0 - NU**2) + 0.3 * 0.5))
    # Two half storeys: the gable and the column are spread, the facade is at the upper end.
    gable, facade, post = (RHO * HEIGHT * a for a in (0.2 * LY, 0.3 * LX, 0.2))
    # The column stands in the edge y = 0.
    assert bar.end_mass == pytest.approx((post, facade))
    assert bar.standing_mass == pytest.approx(gable)
    total = bar.slab_mass + bar.standing_mass + sum(bar.end_mass)
    assert total == pytest.approx(MASSES[0])
    assert bar.speed == pytest.approx(np.sqrt(bar.stiffness / (bar.slab_mass / LY)))
    assert bar.crossing == pytest.approx(LY / bar.speed)


def test_upstands_of_the_top_floor(parts):
    """The acroterion stands on the edges: two sides at the ends, two along the bar."""
    bar, below = (floor_bar(parts(ALONG, ACROSS), k, 1) for k in (2, 1))
    upstand = RHO * 0.6 * 0.2
    half = 0.5 * RHO * HEIGHT
    assert bar.end_mass == pytest.approx(
        (half * 0.2 + upstand * LX, half * 0.3 * LX + upstand * LX)
    )
    assert bar.standing_mass == pytest.approx(half * 0.2 * LY + 2.0 * upstand * LY)
    assert bar.slab_mass + bar.standing_mass + sum(bar.end_mass) == pytest.approx(MASSES[1])
    assert bar.stiffness == pytest.approx(below.stiffness)


def test_without_beams_along_x_and_at_an_angle(parts):
    bare = floor_bar(parts(), 1, 1)
    assert bare.stiffness == pytest.approx(E * LX * SLAB / (1.0 - NU**2))
    along_x = floor_bar(parts(edge="x+"), 1, bar_axis(parts(edge="x+").mesh, 1))
    assert along_x.length == LX
    assert along_x.stiffness == pytest.approx(E * LY * SLAB / (1.0 - NU**2))
    # The post is in the edge x = 6 m, the gable in x = 0.
    assert along_x.end_mass == pytest.approx((RHO * HEIGHT * 0.2 * LY, RHO * HEIGHT * 0.2))
    ell = np.hypot(LX, LY)
    skew = floor_bar(parts(SKEW), 1, 1)
    share = E * 0.2 * 0.3 * (LY / ell) ** 4 * ell / LY
    assert skew.stiffness == pytest.approx(bare.stiffness + share)
    # The same mass in all: a beam's own is not added a second time.
    assert skew.slab_mass == pytest.approx(bare.slab_mass)


def test_added_mass_slows_the_wave(parts):
    loaded = parts()
    bare = replace(loaded, added_mass=np.zeros_like(loaded.added_mass))
    assert floor_bar(bare, 1, 1).speed == pytest.approx(np.sqrt(E / (RHO * (1.0 - NU**2))))
    assert floor_bar(loaded, 1, 1).speed < 0.8 * floor_bar(bare, 1, 1).speed


def test_a_floor_without_a_slab(parts):
    with pytest.raises(KeyError, match="floor 3 has no slab"):
        floor_bar(parts(), 3, 1)

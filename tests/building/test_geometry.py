"""The sections of what the generator builds."""

from impactfem.building.geometry import MeshSize
from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection, ShellSection


def test_every_part_has_its_section(small_geometry):
    sections = small_geometry.part_sections()
    assert sections[Part("floor", 2)] == ShellSection(0.25)
    assert sections[Part("floor", 2, "acroterion")] == ShellSection(0.2)
    assert Part("floor", 1, "acroterion") not in sections
    assert sections[Part("storey", 1, "inner")] == ShellSection(0.2)
    assert Part("storey", 2, "inner") not in sections
    assert sections[Part("beam", 2, "long")] == BeamSection.beam(0.3, 0.5, -0.375)
    assert sections[Part("column", 1, "middle")] == BeamSection.column(0.4, 0.6)


def test_the_generator_makes_these_parts_and_no_others(small_geometry, small_mesh):
    parts = {*small_mesh.shell_parts, *small_mesh.beam_parts}
    assert parts == set(small_geometry.part_sections())


def test_sections_in_the_mesh_s_order(small_geometry, small_mesh):
    sections = small_geometry.sections(small_mesh.shell_parts, small_mesh.beam_parts)
    known = small_geometry.part_sections()
    assert list(sections.shells) == [known[part] for part in small_mesh.shell_parts]
    assert list(sections.beams) == [known[part] for part in small_mesh.beam_parts]


def test_one_size_for_all():
    assert MeshSize.uniform(0.9) == MeshSize(floor=0.9, storey=0.9, beam=0.9, column=0.9)

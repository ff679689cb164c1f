from dataclasses import replace

import pytest

from impactfem.building import beam
from impactfem.building.section import BeamSection
from impactfem.verify.shells import beams


@pytest.mark.parametrize(
    ("name", "seen"),
    [
        ("A", ("width", "depth", "axis", "next to")),
        ("I1", ("depth", "next to")),
        ("I2", ("width",)),
        ("J", ("twist", "next to")),
        ("k1", ("width",)),
        ("k2", ("depth", "next to")),
    ],
)
def test_a_wrong_section_is_seen_where_it_counts(failed, wrong, name, seen):
    """In the models alone, not in the closed forms."""

    def made(right, points, beams):
        changes = {name: 1.001 * getattr(beams.section, name)}
        return right(points, replace(beams, section=replace(beams.section, **changes)))

    wrong(beams, "shell_model", made)
    rows = beams.beam_cantilevers()
    every = {row.quantity for row in rows if row.quantity.startswith("tip")}
    assert failed(rows) == {q for q in every if any(word in q.split(",")[0] for word in seen)}


def test_swapped_sides_are_seen(failed, wrong, own_cache):
    """The frame turned by a quarter: n1 for n2."""

    def turned(right, fields, mesh):
        t, n1, n2 = right(fields, mesh)
        return t, n2, -n1

    wrong(beam.BeamFields, "_frame", turned)
    quantities = failed(beams.beam_cantilevers())
    assert sum("width" in quantity for quantity in quantities) == 3
    assert sum("depth" in quantity for quantity in quantities) == 3


def test_full_integration_of_the_shear_is_seen(failed, monkeypatch, own_cache):
    """It is too stiff across, and changes nothing along the axis."""
    monkeypatch.setattr(beam, "REDUCED", 4)
    quantities = failed(beams.beam_cantilevers())
    assert sum("width" in q or "depth" in q for q in quantities) == 6
    assert not [q for q in quantities if ("axis, beam" in q and "next to" not in q) or "twist" in q]


def test_half_of_the_rotary_inertia_is_seen(failed, wrong, own_cache):
    def half(right, fields, space):
        return right(replace(fields, second_moments=0.5 * fields.second_moments), space)

    wrong(beam.BeamFields, "mass", half)
    assert {f"frequency {k}, 20 elements" for k in (1, 2, 3)} <= failed(beams.beam_frequencies())


def test_rotations_of_the_wrong_sign_are_seen(failed, wrong, own_cache):
    wrong(beam, "halves", lambda right, w: (right(w)[0], -right(w)[1]))
    rows = beams.beam_rigid_body()
    assert {row.quantity for row in rows if "largest energy" in row.quantity} <= failed(rows)


@pytest.mark.parametrize("factor", [0.01, 100.0])
def test_the_joint_hardly_depends_on_the_drilling_factor(factor):
    rows = beams.l_frame(drilling=factor)
    assert all(row.passed for row in rows)
    assert max(row.error for row in rows) < 3e-3


def test_plates_that_do_not_meet_are_seen(wrong):
    """The web ends below the flange's mid-plane and carries the force alone."""

    def apart(right, panels):
        (nodes, triangles), *flanges = panels
        return right([(nodes - [0.0, 0.0, 1e-3], triangles), *flanges])

    wrong(beams, "joined", apart)
    (row,) = beams.t_beam()
    assert row.computed > 2.0 * row.reference


@pytest.mark.parametrize("shift", [None, 0.01])
def test_a_beam_without_its_offset_or_a_centimetre_off_is_seen(monkeypatch, shift):
    class Wrong:
        @staticmethod
        def beam(width, depth, offset):
            return BeamSection.beam(width, depth, 0.0 if shift is None else offset + shift)

    monkeypatch.setattr(beams, "BeamSection", Wrong)
    (row,) = beams.eccentric_beam()
    assert not row.passed
    assert shift is not None or row.computed > 3.0 * row.reference

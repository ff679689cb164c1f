from impactfem.building.section import BeamSection
from impactfem.verify.shells import eccentric_beam


def test_a_beam_without_its_offset_is_seen(monkeypatch):
    class Centred:
        @staticmethod
        def beam(width, depth, offset):
            return BeamSection.beam(width, depth)

    monkeypatch.setattr(eccentric_beam, "BeamSection", Centred)
    (row,) = eccentric_beam.eccentric_beam()
    assert not row.passed and row.computed > 3.0 * row.reference


def test_an_offset_to_the_wrong_side_by_a_centimetre_is_seen(monkeypatch):
    class Higher:
        @staticmethod
        def beam(width, depth, offset):
            return BeamSection.beam(width, depth, offset + 0.01)

    monkeypatch.setattr(eccentric_beam, "BeamSection", Higher)
    (row,) = eccentric_beam.eccentric_beam()
    assert not row.passed

from impactfem.motion import design_spectrum
from impactfem.verify import motion


def test_a_wrong_table_would_be_seen(monkeypatch):
    table = {**design_spectrum.HORIZONTAL[2], "D": (1.6, (0.1, 0.3, 1.2))}
    monkeypatch.setitem(design_spectrum.HORIZONTAL, 2, table)
    failed = [row.quantity for row in motion.eurocode_ordinates() if not row.passed]
    assert len(failed) == 1
    assert "type 2, ground D" in failed[0]


def test_a_wrong_unit_would_be_seen(monkeypatch):
    monkeypatch.setattr(
        motion, "esm_text", lambda a, step: f"{_esm(a, step)}".replace("cm/s^2", "mm/s^2")
    )
    failed = [row.name for row in motion.record_formats() if not row.passed]
    assert failed == ["ESM round trip"]


_esm = motion.esm_text

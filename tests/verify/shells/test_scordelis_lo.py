from impactfem.verify.shells import scordelis_lo


def test_a_thicker_roof_is_seen(altered, failed):
    altered(scordelis_lo, thickness=1.02)
    rows = scordelis_lo.scordelis_lo()
    assert len([row for row in rows if not row.passed]) >= 3
    assert "fitted order of the work of the weight, at least 2" in failed(rows)


def test_wrong_symmetry_is_seen(monkeypatch):
    """The crown may not be held against all rotations."""
    monkeypatch.setattr(scordelis_lo, "RZ", scordelis_lo.RY)
    assert not scordelis_lo.scordelis_lo()[2].passed

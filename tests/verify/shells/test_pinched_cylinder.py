from impactfem.verify.shells import pinched_cylinder


def test_a_thicker_cylinder_is_seen(altered):
    altered(pinched_cylinder, thickness=1.03)
    assert not any(row.passed for row in pinched_cylinder.pinched_cylinder())


def test_a_missing_diaphragm_is_seen(monkeypatch):
    """With free ends the cylinder is much softer."""
    right = pinched_cylinder.ShellModel.rows

    def rows(self, here, *components):
        ends = bool((self.nodes[here, 0] == 0.0).all())
        return right(self, here & (not ends), *components)

    monkeypatch.setattr(pinched_cylinder.ShellModel, "rows", rows)
    monkeypatch.setattr(pinched_cylinder, "CELLS", (4, 8, 16))
    row = pinched_cylinder.pinched_cylinder()[0]
    assert row.computed > 1.5 * row.reference

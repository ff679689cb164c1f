from dataclasses import replace

import pytest

from impactfem.verify.shells import curved
from impactfem.verify.shells.curved import ROOF, WEIGHT, weighed


def test_the_roof_without_shear_strains():
    """The converged value of isogeometric Kirchhoff–Love shells, Kiendl et al. 2009."""
    rigid = replace(ROOF, shear=1e6)
    assert weighed(rigid, WEIGHT)[0] == pytest.approx(0.300592, rel=1e-4)
    assert weighed(ROOF, WEIGHT)[0] > 1.002 * 0.300592


def test_wrong_symmetry_is_seen(monkeypatch):
    """The crown may not be held against all rotations."""
    monkeypatch.setattr(curved, "RZ", curved.RY)
    assert not curved.scordelis_lo()[2].passed


def test_a_missing_diaphragm_is_seen(wrong, monkeypatch):
    """With free ends the cylinder is much softer."""

    def make(right):
        def rows(self, here, *components):
            ends = bool((self.nodes[here, 0] == 0.0).all())
            return right(self, here & (not ends), *components)

        return rows

    wrong(curved.ShellModel, "rows", make)
    monkeypatch.setattr(curved, "CELLS", (4, 8, 16))
    row = curved.pinched_cylinder()[0]
    assert row.computed > 1.5 * row.reference

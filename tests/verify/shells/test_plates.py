from dataclasses import replace

import pytest

from impactfem.building import shell
from impactfem.verify import shells
from impactfem.verify.shells import curved, plates
from impactfem.verify.shells.curved import ROOF, WEIGHT, weighed


def test_another_shear_factor_is_seen_in_a_thick_plate_only(monkeypatch):
    monkeypatch.setattr(shells, "SHEAR", 1.0)
    monkeypatch.setattr(plates, "RATIOS", (0.1, 0.001))
    rows = plates.mindlin_plate()
    thick = [row for row in rows if "t/L = 0.1" in row.name]
    assert len(thick) == 7 and not any(row.passed for row in thick)
    assert all(row.passed for row in rows if "t/L = 0.001" in row.name)


@pytest.mark.usefixtures("partly_reduced")
def test_locking_is_seen(monkeypatch):
    monkeypatch.setattr(plates, "RATIOS", (0.001,))
    rows = plates.mindlin_plate()
    frequencies = [row for row in rows if "Hz" in row.unit]
    assert not any(row.passed for row in frequencies)
    assert all(row.computed > row.reference for row in frequencies)


def test_other_forces_are_seen(wrong, monkeypatch):
    """The shear 5 % too large."""

    def larger(right, fields, w, plane):
        found = right(fields, w, plane)
        return type(found)(*[found[i] if i < 6 else 1.05 * found[i] for i in range(8)])

    wrong(shell.ShellFields, "section_forces", larger)
    monkeypatch.setattr(plates, "RATIOS", (0.1,))
    failed = [row.quantity for row in plates.plate_forces() if not row.passed]
    assert failed and all("shear" in quantity or "Q1" in quantity for quantity in failed)


@pytest.mark.usefixtures("partly_reduced")
def test_partly_reduced_shear_is_seen():
    failed = {row.name for row in plates.clamped_plate() if not row.passed}
    assert failed == {f"clamped plate, t/L = {t:g}" for t in (0.01, 1e-3, 1e-4)}
    assert not any(row.passed for row in curved.hyperbolic_paraboloid())


@pytest.mark.parametrize(
    ("state", "kind"), [("membrane_state", "membrane"), ("bending_state", "bending")]
)
def test_another_state_is_not_reproduced(wrong, state, kind):
    turned = [1.0, 1.0, 1.0, 1.01, 1.01, 1.01]
    wrong(plates, state, lambda right, place, strain: right(place, strain) * turned)
    rows = plates.shell_patch()
    assert {row.name for row in rows if not row.passed} == {f"{kind} patch test"}
    assert all(row.passed == (kind not in row.name) for row in rows)


@pytest.mark.usefixtures("wrong_drilling")
def test_a_wrong_sign_of_drilling_is_seen(failed):
    rows = plates.shell_patch()
    assert not any(row.passed for row in rows if row.name == "membrane patch test")
    rows = plates.shell_rigid_body()
    quantities = failed(rows)
    assert {row.quantity for row in rows if "largest energy" in row.quantity} <= quantities
    assert "energy of rotations against the turn of a plate" in quantities


def test_spurious_modes_are_seen(failed, monkeypatch, own_cache):
    """With one point of integration."""
    monkeypatch.setattr(shell, "REDUCED", 1)
    rows = plates.shell_rigid_body()
    found = [row for row in rows if row.quantity == "zero eigenvalues, thin skew plate"]
    assert found[0].computed > 6.0
    # Rigid motions cost nothing all the same.
    assert not {quantity for quantity in failed(rows) if "largest energy" in quantity}


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

    def rows(right, self, here, *components):
        ends = bool((self.nodes[here, 0] == 0.0).all())
        return right(self, here & (not ends), *components)

    wrong(curved.ShellModel, "rows", rows)
    monkeypatch.setattr(curved, "CELLS", (4, 8, 16))
    row = curved.pinched_cylinder()[0]
    assert row.computed > 1.5 * row.reference

import pytest

from impactfem.building import section_forces
from impactfem.verify import shells
from impactfem.verify.shells import curved, plates


def test_another_shear_factor_is_seen_in_a_thick_plate_only(monkeypatch):
    monkeypatch.setattr(shells, "SHEAR", 1.0)
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


def test_other_forces_are_seen(monkeypatch):
    """The shear 5 % too large."""
    right = section_forces.section_force_vector

    def wrong(w, plane, fields):
        found = right(w, plane, fields)
        return type(found)(*[found[i] if i < 6 else 1.05 * found[i] for i in range(8)])

    monkeypatch.setattr(section_forces, "section_force_vector", wrong)
    monkeypatch.setattr(plates, "RATIOS", (0.1,))
    failed = [row.quantity for row in plates.plate_forces() if not row.passed]
    assert failed and all("shear" in quantity or "Q1" in quantity for quantity in failed)


@pytest.mark.usefixtures("partly_reduced")
def test_partly_reduced_shear_is_seen():
    failed = {row.name for row in plates.clamped_plate() if not row.passed}
    assert failed == {f"clamped plate, t/L = {t:g}" for t in (0.01, 1e-3, 1e-4)}
    assert not any(row.passed for row in curved.hyperbolic_paraboloid())


def test_a_thicker_plate_is_seen(altered, failed):
    altered(plates, thickness=1.03)
    rows = plates.nafems_fv12()
    assert len(failed(rows[:6])) >= 3
    assert len(failed(rows[6:])) == 6


def test_a_stiffer_membrane_is_seen(altered, failed):
    altered(plates, E=1.01)
    assert len(failed(plates.nafems_fv32())) == 6

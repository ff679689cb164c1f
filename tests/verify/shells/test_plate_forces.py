import numpy as np
import pytest

from impactfem.building import section_forces
from impactfem.verify.shells import plate_forces


def test_navier_by_differences():
    """∂j Mij = Qi and ∂i Qi = −1 inside the plate; at its edges moments across are zero."""
    step, place = 1e-3, np.array([0.35, 0.6, 0.0])

    def slope(axis):
        ends = place + np.outer([-step, step], np.eye(3)[axis])
        return np.diff(plate_forces.series(ends), axis=0)[0] / (2.0 * step)

    (along_x, along_y), here = (slope(0), slope(1)), plate_forces.series(place[None])[0]
    assert along_x[0] + along_y[2] == pytest.approx(here[3], rel=1e-3)
    assert along_x[2] + along_y[1] == pytest.approx(here[4], rel=1e-3)
    assert along_x[3] + along_y[4] == pytest.approx(-1.0, abs=0.02)
    centre = plate_forces.series(np.array([[0.5, 0.5]]))[0]
    assert centre[:2] == pytest.approx(0.0479, rel=1e-3)  # Timoshenko and Woinowsky-Krieger


def test_the_benchmarks_pass():
    assert all(row.passed for row in plate_forces.supported_plate())
    assert all(row.passed for row in plate_forces.bent_in_plane())


def test_other_forces_are_seen(monkeypatch):
    """The shear 5 % too large."""
    right = section_forces.section_force_vector

    def wrong(w, plane, fields):
        found = right(w, plane, fields)
        return type(found)(*[found[i] if i < 6 else 1.05 * found[i] for i in range(8)])

    monkeypatch.setattr(section_forces, "section_force_vector", wrong)
    monkeypatch.setattr(plate_forces, "RATIOS", (0.1,))
    failed = [row.quantity for row in plate_forces.supported_plate() if not row.passed]
    assert failed and all("shear" in quantity or "Q1" in quantity for quantity in failed)

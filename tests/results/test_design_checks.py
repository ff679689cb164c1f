"""Checks of the stage `design`, each with a twin that is not met."""

import pytest
import xarray as xr

from impactfem.results.design_checks import design_checks
from impactfem.results.design_coverage import coverage_table
from impactfem.results.design_view import DesignView

from .design_store import WantedDesign, design_store, ensemble_store

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")


def texts(folder, good):
    return [text for met, text in design_checks(folder) if met is good]


def test_all_met(tmp_path):
    design_store(tmp_path / "design.nc")
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        ensemble_store(tmp_path / "ensemble.nc", store["member_impact_force"].values)
    assert not texts(tmp_path, False)
    met = texts(tmp_path, True)
    assert [text[:15] for text in met[:3]] == [f"design: along {c}" for c in "xyz"]
    assert "design: 5 motions through the 3D model, 0 failed" in met
    assert any("as in the stage ensemble within 0.0e+00" in text for text in met)


def test_points_that_miss_the_floor(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=1.5))
    missed = texts(tmp_path, False)
    assert len(missed) == 3
    assert "reach 67 % of the peak over all vertices" in missed[1]
    assert "below 80 % on floor 1, floor 2: further probes would tell" in missed[1]


def test_without_fields(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=None))
    assert design_checks(tmp_path) == []
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        assert coverage_table(DesignView(store)) is None


def test_members_that_failed(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(failed=2))
    assert "design: 5 motions through the 3D model, 2 failed" in texts(tmp_path, False)


@pytest.mark.parametrize("building", ["B1", "B2"])
def test_other_impact_forces_than_in_the_ensemble(tmp_path, building):
    """They are told, unless the ensemble is of another building."""
    design_store(tmp_path / "design.nc")
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        force = store["member_impact_force"].values
    force[3, 1] *= 1.01
    ensemble_store(tmp_path / "ensemble.nc", force, building)
    told = [text for text in texts(tmp_path, False) if "impact forces" in text]
    assert len(told) == (building == "B1") and all("9.9e-03" in text for text in told)


def test_coverage(tmp_path):
    own = design_store(tmp_path / "design.nc")
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        table = coverage_table(DesignView(store))
    assert table is not None and len(table.rows) == 2 * 3
    row = table.rows[1]
    assert row[:6] == ("B1", "1", "y", 0.02, 2, 50)
    assert row[6] == pytest.approx(own.floor_psa[0, 0, 1].max(), rel=1e-5)
    assert row[7] == pytest.approx(1.1 * row[6], rel=1e-5)
    assert row[10] / row[9] == pytest.approx(1.1, rel=1e-5)

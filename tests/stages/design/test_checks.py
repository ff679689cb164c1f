"""Checks of the stage `design`, each with a twin that is not met."""

import pytest
import xarray as xr

from impactfem.stages.design.checks import design_checks
from impactfem.system.files import write_netcdf

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
    assert "design: 5 motions on the 3D model, 0 failed" in met
    assert any("from those of stage ensemble 0 (" in text for text in met)


def test_points_that_miss_the_floor(tmp_path):
    """The vertices that govern, too few of them, have two thirds of the envelope."""
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=1.5))
    missed = texts(tmp_path, False)
    assert len(missed) == 3
    assert "all vertices the points have 66.7 % (at least 95 %) on floor" in missed[1]
    assert "; too little on floor 1, floor 2" in missed[1]


def test_a_peak_acceleration_that_the_points_miss(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(motions=0))
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        changed = store.load()
    changed["whole_zpa"][1, 2] *= 1.5
    write_netcdf(tmp_path / "design.nc", changed)
    (missed,) = texts(tmp_path, False)
    assert "along z" in missed and "on floor 2, of the peak acceleration" in missed


def test_without_fields(tmp_path):
    """The probes stand alone for the floors: there is nothing to compare with, and that is told."""
    design_store(tmp_path / "design.nc", WantedDesign(motions=0, whole=None))
    (missed,) = design_checks(tmp_path)
    assert missed[0] is False and "envelope of the PROBES ALONE" in missed[1]


def test_members_that_failed(tmp_path):
    design_store(tmp_path / "design.nc", WantedDesign(failed=2))
    assert "design: 5 motions on the 3D model, 2 failed" in texts(tmp_path, False)


@pytest.mark.parametrize("building", ["B1", "B2"])
def test_other_impact_forces_than_in_the_ensemble(tmp_path, building):
    """They are told, unless the ensemble is of another building."""
    design_store(tmp_path / "design.nc")
    with xr.open_dataset(tmp_path / "design.nc", engine="h5netcdf") as store:
        force = store["member_impact_force"].values
    force[3, 1] *= 1.01
    ensemble_store(tmp_path / "ensemble.nc", force, building)
    told = [text for text in texts(tmp_path, False) if "impact forces" in text]
    assert len(told) == (building == "B1") and all("0.0099 (" in text for text in told)

"""The ZPA of the floors of a 3D model against the limit of the case."""

from types import SimpleNamespace

import pytest
import xarray as xr

from impactfem.case.capacities import Limits
from impactfem.stages.transient.limits import transient_verdicts


def verdicts(folder, floors, limit=None):
    zpa = xr.DataArray([[1.0, 2.0, 0.5], [3.0, 7.0, 1.0]], dims=("probe", "component"))
    content = {"zpa": zpa, "zpa_free": 0.5 * zpa}
    labels = {"probe": ["slab", "roof"], "component": [*"xyz"], "probe_floor": ("probe", floors)}
    about = {"building": "B1", "resolved_frequency": 64.0}
    xr.Dataset(content, labels, about).to_netcdf(folder / "transient.nc", engine="netcdf4")
    case = SimpleNamespace(limits=Limits(floor_acceleration=limit))
    return transient_verdicts(SimpleNamespace(case=case), folder)


@pytest.mark.parametrize(("limit", "passed"), [(7.1, True), (6.9, False), (None, None)])
def test_largest_zpa_of_a_floor(tmp_path, limit, passed):
    (one,) = verdicts(tmp_path, [1, 2], limit)
    assert (one.demand, one.demand_without_impact, one.passed) == (7.0, 3.5, passed)
    assert one.band == (0.0, 64.0) and one.place.split(", ")[1:3] == ["floor 2", "probe roof"]


def test_probes_on_no_floor_do_not_count(tmp_path):
    (one,) = verdicts(tmp_path, [1, 0])
    assert (one.demand, one.demand_without_impact) == (2.0, 1.0)
    assert verdicts(tmp_path, [0, 0]) == []

"""Tables of power spectral densities."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.transient.physics import impact_samples
from impactfem.stages.transient.selection import floors_of, shown
from impactfem.stages.transient.tables import density_tables


@pytest.fixture
def response(transient_folder):
    def of(**wanted):
        path = transient_folder(**wanted) / "transient.nc"
        with xr.open_dataset(path, engine="h5netcdf") as store:
            return shown(store).load()

    return of


def test_the_power_of_the_main_impacts(response):
    """Parseval: the densities add up to the mean square over the same time."""
    given = response()
    loads = given["edge_force"].transpose("edge", "time").values
    edges, forces = density_tables(given)
    floors = given["edge_floor"].values
    assert [name for name, _ in forces.columns] == ["frequency", *(f"floor {f}" for f in floors)]
    f, *densities = np.array(forces.rows).T
    ends = [impact_samples(load) for load in loads]
    longest = max(last - first for first, last in ends)
    for density, load, (first, last) in zip(densities, loads, ends, strict=True):
        power = np.sum(load[first:last] ** 2) / longest
        assert power > 0.0
        assert np.sum(density) * f[1] == pytest.approx(power, rel=1e-9)
    hit = floors_of(given, "edge")
    assert [name for name, _ in edges.columns] == ["frequency", *(f"floor {f}" for f in hit)]
    step = float(given["time"][1] - given["time"][0])
    assert f[-1] == edges.rows[-1][0] == pytest.approx(0.5 / step)


def test_nothing_is_hit(response):
    tables = density_tables(response(loads=()))
    assert [table.name for table in tables] == ["transient_edge_density"]

"""Tables of power spectral densities."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.transient.power import main_impact
from impactfem.stages.transient.tables import density_tables
from impactfem.stages.transient.view import TransientView


@pytest.fixture
def view(transient_folder):
    def of(**wanted):
        with xr.open_dataset(transient_folder(**wanted) / "transient.nc", engine="h5netcdf") as one:
            return TransientView(one.load())

    return of


def test_the_power_of_the_main_impacts(view):
    """Parseval: the densities add up to the mean square over the same time."""
    shown = view()
    edges, forces = density_tables(shown)
    assert [name for name, _ in forces.columns] == [
        "frequency",
        *(f"floor {f}" for f in shown.loads),
    ]
    f, *densities = np.array(forces.rows).T
    ends = [main_impact(shown.force[:, k]) for k in shown.loads.values()]
    longest = max(last - first for first, last in ends)
    for density, load, (first, last) in zip(densities, shown.loads.values(), ends, strict=True):
        power = np.sum(shown.force[first:last, load] ** 2) / longest
        assert power > 0.0
        assert np.sum(density) * f[1] == pytest.approx(power, rel=1e-9)
    assert [name for name, _ in edges.columns] == [
        "frequency",
        *(f"floor {f}" for f in shown.edges),
    ]
    assert f[-1] == edges.rows[-1][0] == pytest.approx(0.5 / shown.time_step)


def test_nothing_is_hit(view):
    assert [table.name for table in density_tables(view(loads=()))] == ["transient_edge_density"]

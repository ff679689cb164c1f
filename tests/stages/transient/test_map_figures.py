"""Fields over the top floor: values at a frequency, triangles, rigid motion, round factors."""

import numpy as np
import pytest
import xarray as xr

from impactfem.plot.floor_field import TopFloor, round_factor
from impactfem.stages.transient.floor_figures import psa_at


@pytest.fixture
def maps(transient_folder):
    with xr.open_dataset(transient_folder() / "transient_maps.nc", engine="h5netcdf") as store:
        yield store.load()


def test_spectrum_at_a_frequency(maps):
    # The store's spectra are PFA times the frequency: straight in logarithms.
    pfa = maps["pfa"].values
    for frequency in (0.5, 3.3, 85.0, 500.0):
        assert psa_at(maps, frequency).values == pytest.approx(frequency * pfa, rel=1e-5)
    assert psa_at(maps, 85.0).sel(component="x").values == pytest.approx(0.0)
    one = maps.isel(frequency=[3])
    f = float(one["frequency"][0])
    assert psa_at(one, f).values == pytest.approx(f * pfa, rel=1e-5)


def test_triangles_cover_the_floor(maps):
    floor = TopFloor(maps)

    def area(triangles):
        x, y = triangles.x[triangles.triangles], triangles.y[triangles.triangles]
        twice = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0])
        twice -= (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
        assert (twice > 0.0).all()
        return 0.5 * twice.sum()

    assert area(floor.split()) == pytest.approx(72.0)
    assert area(floor.elements()) == pytest.approx(72.0)
    assert floor.wide and floor.size == pytest.approx([12.0, 6.0])
    mesh = floor.elements()
    where = dict(zip(floor.node_number, floor.position, strict=True))
    assert np.column_stack([mesh.x, mesh.y]) == pytest.approx(
        np.array([where[n][:2] for n in floor.vertex_number])
    )


def test_values_along_a_line(maps):
    floor = TopFloor(maps)
    points = np.array([[1.3, 2.2], [6.0, 5.9], [20.0, 1.0]])
    values = 2.0 * floor.position[:, 0] - floor.position[:, 1]
    found = floor.along(values, points)
    assert found[:2] == pytest.approx([0.4, 6.1]) and np.isnan(found[2])


def test_deformation_is_what_is_not_rigid(maps):
    floor = TopFloor(maps)
    x, y = floor.position[:, 0], floor.position[:, 1]
    rigid = np.column_stack([0.01 - 1e-4 * y, -0.02 + 1e-4 * x, 0.3 * np.ones_like(x)])
    assert floor.deformation(rigid) == pytest.approx(0.0, abs=1e-12)
    stretched = rigid.copy()
    stretched[:, 1] += 1e-3 * (y - y.mean())
    assert floor.deformation(stretched)[:, 1] == pytest.approx(1e-3 * (y - y.mean()), abs=1e-9)


def test_round_factors():
    assert round_factor(1e-3, 0.36) == 200.0
    assert round_factor(1.0, 24.9) == 20.0
    assert round_factor(2.0, 1.0) == 0.5
    assert round_factor(0.0, 1.0) == 1.0

"""The stores of the stage, as they lie on the disk, and its scalars."""

import numpy as np
import pytest
import xarray as xr

from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.loads import Loads
from impactfem.spectra import response_spectra
from impactfem.stages.transient.compute import main_impact


@pytest.fixture(scope="module")
def folder(reduced):
    return reduced[1].folder


@pytest.fixture(scope="module")
def store(folder):
    return xr.load_dataset(folder / "transient.nc", engine="netcdf4")


@pytest.fixture(scope="module")
def maps(folder):
    return xr.load_dataset(folder / "transient_maps.nc", engine="netcdf4")


def test_every_number_has_a_unit(store, maps):
    for dataset in (store, maps):
        lacking = [
            name
            for name, variable in dataset.variables.items()
            if variable.dtype.kind == "f" and "units" not in variable.attrs
        ]
        assert lacking == []


def test_dimensions(store, maps):
    probes = ["centre_1", "centre_2", "edge_1", "edge_2", *(f"line_{k}" for k in range(1, 10))]
    assert store.probe.values.tolist() == probes
    kinds = [*["centre"] * 2, *["edge"] * 2, *["line"] * 9]
    assert store.probe_kind.values.tolist() == kinds
    assert store.probe_floor.values.tolist() == [1, 2, 1, 2, *[store.attrs["wave_floor"]] * 9]
    assert store.edge.values.tolist() == [f"floor {k}" for k in store.edge_floor.values]
    assert store.transfer_load_floor.values.tolist() == store.edge_floor.values.tolist()
    assert store.component.values.tolist() == ["x", "y", "z"]
    assert store.psa.dims == store.psa_band.dims == ("damping", "probe", "component", "frequency")
    assert store.acceleration.dims == ("time", "probe", "component")
    assert store.time.values == pytest.approx(1e-3 * np.arange(1001))
    assert store.transfer_re.dims == ("transfer_frequency", "transfer_load", "probe", "component")
    assert maps.psa.dims == ("node", "component", "frequency")
    assert maps.wave_triangle_node.shape == (maps.sizes["wave_triangle"], 6)


def test_accelerations_are_absolute_and_displacements_relative(store):
    """The first difference twice in time, plus the ground's, is the acceleration."""
    y = store.sel(component="y", probe="centre_2")
    twice = np.diff(y.displacement, n=2) / 1e-3**2
    ground = store.ground_acceleration.sel(component="y").values[1:-1]
    smooth = slice(0, 380)  # before the first impact
    apart = twice + ground - y.acceleration.values[1:-1]
    assert np.abs(apart[smooth]).max() < 0.03 * np.abs(y.acceleration[:380]).max()
    assert np.abs((apart - ground)[smooth]).max() > 0.2 * np.abs(y.acceleration[:380]).max()


def test_spectra_belong_to_the_histories(store):
    one = store.sel(probe="edge_2", component="y")
    again = response_spectra(one.acceleration.values, 1e-3, store.frequency.values, [0.05])
    assert one.psa.values[0] == pytest.approx(again.psa[0, 0], rel=1e-12)
    assert one.sd.values[0] == pytest.approx(again.sd[0, 0], rel=1e-12)
    assert float(one.pfa) == np.abs(one.acceleration.values).max()


def test_probes_lie_where_they_say(store, frame):
    nodes = frame.parts.mesh.nodes[store.probe_node.values]
    np.testing.assert_array_equal(store.probe_position.values, nodes)
    assert nodes[1].tolist() == [3, 2, 6]


def test_waves_can_be_drawn(maps, frame):
    """Corners of the triangles as indices of the waves' nodes; the slab is whole."""
    corners = maps.wave_node_position.values[maps.wave_triangle_node.values[:, :3]]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    assert 0.5 * np.abs(np.cross(a, b)[:, 2]).sum() == pytest.approx(24.0)
    middle = maps.wave_node_position.values[maps.wave_triangle_node.values[:, 3]]
    assert middle == pytest.approx(0.5 * (corners[:, 0] + corners[:, 1]))
    numbers = maps.wave_node_number.values
    assert np.array_equal(frame.parts.mesh.nodes[numbers], maps.wave_node_position.values)
    assert np.array_equal(
        frame.parts.mesh.nodes[maps.node_number.values], maps.node_position.values
    )


@pytest.fixture(scope="module")
def values(reduced):
    return {s.name: s.value for s in reduced[1].scalars}


def test_of_floors_and_edges(values, store):
    along = store.isel(damping=0).sel(component="y")
    valid = along.sel(frequency=slice(None, 50.0))
    for k in (1, 2):
        one = valid.sel(probe=f"centre_{k}")
        assert values[f"transient.frs.floor_{k}.peak"] == float(one.psa.max())
        assert values[f"transient.frs.floor_{k}.peak_frequency"] == float(one.psa.idxmax())
        assert values[f"transient.pfa.floor_{k}"] == float(np.abs(one.acceleration).max())
        assert float(one.largest_displacement) == float(np.abs(one.displacement).max())
    # Floor 1 is not struck.
    assert values["transient.pfa.edge_2"] == float(along.sel(probe="edge_2").pfa)
    assert "transient.pfa.edge_1" not in values


def test_along_the_edges(store, maps):
    """Over all vertices at the level and in the plane of the edge; more than its middle has."""
    position, pfa = maps.node_position.values, maps.pfa.sel(component="y").values
    for k in (1, 2):
        middle = store.probe_position.sel(probe=f"edge_{k}").values
        edge = np.isclose(position[:, 1:], middle[1:]).all(axis=1)
        assert np.ptp(position[edge, 0]) > 1.0 and not edge.all()
        found = store.sel(impact_edge=k, component="y")
        assert float(found.impact_edge_pfa_mean) == pytest.approx(pfa[edge].mean())
        assert float(found.impact_edge_pfa_max) == pfa[edge].max()
        assert pfa[edge].max() >= float(store.pfa.sel(probe=f"edge_{k}", component="y"))


def test_of_the_error_band(store):
    share = (store.psa_band / store.psa).where(store.psa > 1e-3 * store.psa.max())
    known = share.sel(frequency=slice(None, 50.0))
    assert float(store.band_max) == pytest.approx(float(known.max()), rel=1e-12)
    assert 0.0 < float(store.basis_difference) <= 0.005
    peak = store.psa_band.sel(frequency=store.psa_peak_frequency)
    np.testing.assert_array_equal(peak.values, store.psa_peak_band.values)


def test_waves_of_the_material(store):
    """33 GPa, 0.2 and 2500 kg/m3: a rod's wave is slower than the plate's, faster than shear."""
    rod = np.sqrt(33e9 / 2500.0)
    assert float(store.wave_speed) == pytest.approx(rod / np.sqrt(2.4))
    assert float(store.plate_wave_speed) == pytest.approx(rod / np.sqrt(0.96))
    # What the slab carries, and that beams do not fill it: slower than the bare plate.
    loaded = float(store.loaded_wave_speed)
    assert 0.2 * rod < loaded < rod
    assert float(store.loaded_wave_crossing) * loaded == pytest.approx(4.0)


def loads(*histories):
    force = np.array(histories, dtype=float).reshape(len(histories), 8).T
    edges = tuple(EdgeForce(f"floor {k}", k, (0.0, -1.0, 0.0)) for k in range(len(histories)))
    return Loads(0.5, np.zeros((len(force), 3)), (1,), edges, force, 0.0)


@pytest.mark.parametrize(
    ("force", "impact"),
    [
        ([0, 0, 1, 5, 2, 0, 0, 0], (1.0, 2.0)),
        ([0, 4, 4, 0, 0, 1, 9, 0], (2.5, 3.0)),  # not the impact before
        ([7, 1, 0, 0, 0, 0, 0, 0], (0.0, 0.5)),
        ([0, 0, 0, 0, 0, 0, 1, 3], (3.0, 3.5)),
        ([0, 0.04, 1, 5, 2, 0.03, 0, 0], (1.0, 2.0)),  # below a hundredth of the peak
        ([0, -1, 1, 5, 2, -1, 0.5, 0], (1.0, 2.0)),  # ripples of the projection
        ([0, 0, -1, -5, -2, 0, 0, 0], (1.0, 2.0)),
    ],
)
def test_main_impact(force, impact):
    assert main_impact(loads(force)) == impact
    # Of the edge that is hit hardest.
    assert main_impact(loads([0.5, 0, 0, 0, 0, 0, 0, 0], force)) == impact


def test_no_impact():
    assert main_impact(loads()) is None

"""Reading `transient.nc`."""

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.design.case_spectra import read_case_spectra
from impactfem.stages.design.records import Records, RecordSpectra
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

NAMES = ("centre_1", "edge_1", "roof")


@pytest.fixture
def store():
    rng = np.random.default_rng(0)
    dims = ("damping", "probe", "component", "frequency")
    return xr.Dataset(
        {
            "psa": (dims, rng.random((2, 3, 3, 5))),
            "pfa": (("probe", "component"), rng.random((3, 3))),
            "probe_node": ("probe", np.array([5, 2, 9])),
            "probe_position": (("probe", "xyz"), np.array([[0, 0, 3], [0, 2, 3], [0, 0, 4.0]])),
        },
        coords={
            "probe": ("probe", np.array(NAMES, dtype=object)),
            "probe_kind": ("probe", np.array(["centre", "edge", "point"], dtype=object)),
            "probe_floor": ("probe", np.array([1, 1, 0])),
            "damping": [0.02, 0.05],
            "frequency": np.geomspace(1.0, 10.0, 5),
        },
        attrs={"building": "B", "maximum_frequency": 100.0},
    )


def test_read(store, tmp_path):
    write_netcdf(tmp_path / "transient.nc", store)
    found = read_case_spectra(tmp_path / "transient.nc")
    psa = store["psa"].values
    np.testing.assert_array_equal(found.floor_psa[:, 0], np.maximum(psa[:, 0], psa[:, 1]))
    np.testing.assert_array_equal(found.floor_pfa[0], store["pfa"].values[:2].max(axis=0))
    assert (found.building, found.elsewhere, found.nodes.tolist()) == ("B", ("roof",), [5, 2, 9])


def test_with_vertices(store, tmp_path):
    """The floor gets the envelope of its probes and of a vertex along its direction alone."""
    write_netcdf(tmp_path / "transient.nc", store)
    alone = read_case_spectra(tmp_path / "transient.nc")
    vertices = Records(np.array([0]), np.array([2]), np.array([77]))
    spectra = RecordSpectra(np.full((2, 1, 5), 0.9), np.array([2.0]))
    found = alone.with_vertices(vertices, spectra)
    np.testing.assert_array_equal(found.floor_psa[:, 0, :2], alone.floor_psa[:, 0, :2])
    np.testing.assert_array_equal(
        found.floor_psa[:, 0, 2], np.maximum(0.9, alone.psa[:, :2, 2].max(1))
    )
    np.testing.assert_array_equal(found.probes_psa, alone.floor_psa)
    assert found.floor_pfa[0, 2] == 2.0 > alone.floor_pfa[0, 2]


def test_another_store(store, tmp_path):
    write_netcdf(tmp_path / "transient.nc", store.drop_vars("psa"))
    with pytest.raises(ImpactfemError, match=r"holds no spectra of probes: .*psa"):
        read_case_spectra(tmp_path / "transient.nc")


def test_no_file(tmp_path):
    with pytest.raises(ImpactfemError, match="cannot read spectra of probes from"):
        read_case_spectra(tmp_path / "transient.nc")

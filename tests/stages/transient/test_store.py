"""The stores of the stage, as they lie on the disk."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import xarray as xr

from impactfem import study
from impactfem.spectra import response_spectra

if TYPE_CHECKING:
    from .conftest import Frame


@pytest.fixture(scope="module")
def folder(reduced: tuple[Path, study.Run]) -> Path:
    return reduced[1].folder


@pytest.fixture(scope="module")
def store(folder: Path) -> Iterator[xr.Dataset]:
    with xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as opened:
        yield opened.load()


@pytest.fixture(scope="module")
def maps(folder: Path) -> Iterator[xr.Dataset]:
    with xr.open_dataset(folder / "transient_maps.nc", engine="h5netcdf") as opened:
        yield opened.load()


def test_every_number_has_a_unit(store: xr.Dataset, maps: xr.Dataset) -> None:
    for dataset in (store, maps):
        lacking = [
            name
            for name, variable in dataset.variables.items()
            if variable.dtype.kind == "f" and "units" not in variable.attrs
        ]
        assert lacking == []


def test_dimensions(store: xr.Dataset, maps: xr.Dataset) -> None:
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
    assert store.transfer_re.dims == (
        "transfer_frequency",
        "transfer_load",
        "probe",
        "component",
    )
    assert maps.psa.dims == ("node", "component", "frequency")
    assert maps.wave_triangle_node.shape == (maps.sizes["wave_triangle"], 6)


def test_accelerations_are_absolute_and_displacements_relative(store: xr.Dataset) -> None:
    """The first difference twice in time, plus the ground's, is the acceleration."""
    y = store.sel(component="y", probe="centre_2")
    twice = np.diff(y.displacement, n=2) / 1e-3**2
    ground = store.ground_acceleration.sel(component="y").values[1:-1]
    smooth = slice(0, 380)  # before the first impact
    apart = twice + ground - y.acceleration.values[1:-1]
    assert np.abs(apart[smooth]).max() < 0.03 * np.abs(y.acceleration[:380]).max()
    assert np.abs((apart - ground)[smooth]).max() > 0.2 * np.abs(y.acceleration[:380]).max()


def test_spectra_belong_to_the_histories(store: xr.Dataset) -> None:
    one = store.sel(probe="edge_2", component="y")
    again = response_spectra(one.acceleration.values, 1e-3, store.frequency.values, [0.05])
    assert one.psa.values[0] == pytest.approx(again.psa[0, 0], rel=1e-12)
    assert one.sd.values[0] == pytest.approx(again.sd[0, 0], rel=1e-12)
    assert float(one.pfa) == np.abs(one.acceleration.values).max()


def test_probes_lie_where_they_say(store: xr.Dataset, frame: Frame) -> None:
    nodes = frame.parts.mesh.nodes[store.probe_node.values]
    np.testing.assert_array_equal(store.probe_position.values, nodes)
    assert nodes[1].tolist() == [3, 2, 6]


def test_waves_can_be_drawn(maps: xr.Dataset, frame: Frame) -> None:
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

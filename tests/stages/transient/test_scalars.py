"""Scalar results of the stage."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem import study
from impactfem.reduction.loads import EdgeForce, Loads
from impactfem.stages.transient.compute import main_impact


@pytest.fixture(scope="module")
def values(reduced: tuple[Path, study.Run]) -> dict[str, float]:
    return {s.name: s.value for s in reduced[1].scalars}


@pytest.fixture(scope="module")
def store(reduced: tuple[Path, study.Run]) -> Iterator[xr.Dataset]:
    with xr.open_dataset(reduced[1].folder / "transient.nc", engine="h5netcdf") as opened:
        yield opened.load()


def test_of_floors_and_edges(values: dict[str, float], store: xr.Dataset) -> None:
    along = store.sel(component="y")
    for k in (1, 2):
        one = along.sel(probe=f"centre_{k}")
        peak = one.psa[0].argmax("frequency")
        assert values[f"transient.frs.floor_{k}.peak"] == float(one.psa[0].max())
        assert values[f"transient.frs.floor_{k}.peak_frequency"] == float(one.frequency[peak])
        assert values[f"transient.pfa.floor_{k}"] == float(np.abs(one.acceleration).max())
        assert values[f"transient.displacement.floor_{k}"] == float(np.abs(one.displacement).max())
        edge = along.sel(probe=f"edge_{k}")
        assert values[f"transient.pfa.edge_{k}"] == float(edge.pfa)


def test_along_the_edges(
    reduced: tuple[Path, study.Run], values: dict[str, float], store: xr.Dataset
) -> None:
    """Over all vertices at the level and in the plane of the edge; more than its middle has."""
    with xr.open_dataset(reduced[1].folder / "transient_maps.nc", engine="h5netcdf") as maps:
        position, pfa = maps.node_position.values, maps.pfa.sel(component="y").values
    for k in (1, 2):
        middle = store.probe_position.sel(probe=f"edge_{k}").values
        edge = np.isclose(position[:, 1:], middle[1:]).all(axis=1)
        assert np.ptp(position[edge, 0]) > 1.0 and not edge.all()
        name = f"transient.pfa.edge_{k}"
        assert values[f"{name}.mean"] == pytest.approx(pfa[edge].mean())
        assert values[f"{name}.max"] == pfa[edge].max() >= values[name]
        assert values[f"{name}.max"] > values[f"{name}.mean"]


def test_of_the_error_band(values: dict[str, float], store: xr.Dataset) -> None:
    share = (store.psa_band / store.psa).where(store.psa > 1e-3 * store.psa.max())
    known = share.sel(frequency=slice(None, 50.0))
    assert values["transient.band_max"] == pytest.approx(float(known.max()), rel=1e-12)
    assert 0.0 < values["transient.basis_difference"] <= 0.005


def test_waves_of_the_material(values: dict[str, float]) -> None:
    """33 GPa, 0.2 and 2500 kg/m3: a rod's wave is slower than the plate's, faster than shear."""
    rod = np.sqrt(33e9 / 2500.0)
    assert values["transient.wave_speed"] == pytest.approx(rod / np.sqrt(2.4))
    assert values["transient.plate_wave_speed"] == pytest.approx(rod / np.sqrt(0.96))
    # What the slab carries, and that beams do not fill it: slower than the bare plate.
    loaded = values["transient.loaded_wave_speed"]
    assert 0.2 * rod < loaded < rod
    assert values["transient.loaded_wave_crossing"] * loaded == pytest.approx(4.0)


def loads(*histories: list[float]) -> Loads:
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
def test_main_impact(force: list[float], impact: tuple[float, float]) -> None:
    assert main_impact(loads(force)) == impact
    # Of the edge that is hit hardest.
    assert main_impact(loads([0.5, 0, 0, 0, 0, 0, 0, 0], force)) == impact


def test_no_impact() -> None:
    assert main_impact(loads()) is None

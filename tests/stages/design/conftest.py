"""A reduced model of two modes that stands for a building, loads on it, and design spectra."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from impactfem.case import Spectra
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced import ReducedModel
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.stages.design.carrier import Carrier
from impactfem.stages.design.floors import NO_POINTS
from impactfem.stages.design.products import design_products_of

from .design_store import design_store, stick_store

STEP = 1e-3
LOADS = {"ground y": (-3.0, 1.0), "floor 1": (2e-5, 1e-5), "floor 2": (3e-5, -2e-5)}
"""b of each load in both modes."""
EDGES = {k: EdgeForce(f"floor {k}", k, (0.0, -1.0, 0.0)) for k in (1, 2)}


@pytest.fixture
def whole():
    """The two modes at the nodes 4, 7 and 9."""
    shapes = np.random.default_rng(3).normal(size=(3, 3, 2))
    model = ReducedModel(
        eigenvalue=(2.0 * np.pi * np.array([3.0, 11.0])) ** 2,
        load=np.array(list(LOADS.values())).T,
        coordinates=np.eye(2),
        shift=1e4,
        tail=np.zeros((0, 2)),
    )
    return ReducedBasis(
        loads=tuple(LOADS),
        models=(model,),
        larger=(),
        nodes=np.array([4, 7, 9]),
        vectors=shapes,
        difference=1e-3,
        certified=np.zeros(0, dtype=np.int64),
        norm=np.zeros((0, 3)),
        gram=np.zeros((0, 0)),
        rotations=np.zeros((0, 3, 2)),
    )


def points(**columns):
    """Points of floors by columns."""
    return pd.DataFrame({name: np.array(values) for name, values in columns.items()})


@pytest.fixture
def some_loads():
    """A ground motion along y with pulses on floors."""

    def make(floors=(1, 2), scale=1.0, steps=1000):
        time = STEP * np.arange(steps + 1)
        ground = np.zeros((steps + 1, 3))
        ground[:, 1] = scale * np.sin(2.0 * np.pi * 4.0 * time)
        pulses = {k: 1e5 * k * np.exp(-(((time - 0.3 * k) / 0.01) ** 2)) for k in floors}
        force = np.array(list(pulses.values())).T.reshape(steps + 1, len(floors))
        return Loads(
            time_step=STEP,
            ground=ground,
            directions=(1,),
            edges=tuple(EDGES[k] for k in floors),
            force=scale * force,
            impulse_error=0.0,
        )

    return make


@pytest.fixture
def carrier(whole):
    """Two floors with one probe each, node 9 and node 4."""
    frequencies = tuple(float(f) for f in np.geomspace(1.0, 30.0, 12))
    probes = points(floor=[0] * 3 + [1] * 3, component=[0, 1, 2] * 2, node=[9] * 3 + [4] * 3)
    return Carrier(
        basis=whole,
        points=probes,
        centres=np.ones(6, dtype=bool),
        candidates=NO_POINTS,
        frequency=np.geomspace(1.0, 30.0, 8),
        search_damping=0.02,
        damping=Rayleigh(0.5, 1e-4),
        spectra=Spectra(damping=(0.02, 0.05), frequencies=frequencies),
        highest=50.0,
        analyst=None,
        choice=None,
    )


@pytest.fixture
def searching(carrier):
    """The same, with nodes 7 and 9 of the lower floor to be looked at, along y and z."""
    every = points(floor=[0] * 4, component=[1, 1, 2, 2], node=[7, 9, 7, 9])
    return replace(carrier, candidates=every)


@pytest.fixture
def made(tmp_path):
    """Write a store of the stage, and the sticks beside it; gives the design spectra of both."""

    def make(asked=None, broadening=0.15):
        own = design_store(tmp_path / "design.nc", asked)
        stick_store(tmp_path / "pounding.nc")
        store = xr.load_dataset(tmp_path / "design.nc", engine="netcdf4")
        return design_products_of(store, tmp_path / "pounding.nc", broadening, False), own

    return make

"""What the views of all stores share: the time axis, the scalars, and the damping cases."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.system.scalar import Scalar, from_json

Array = NDArray[np.float64]


class StoreView:
    """A store of a stage of the 3D building.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.building = str(store.attrs["building"])

    @cached_property
    def time(self) -> Array:
        """Shape (n_t,) [s]."""
        return self._values("time")

    @property
    def time_step(self) -> float:
        """Δt [s]."""
        return float(self.time[1] - self.time[0])

    @cached_property
    def frequency(self) -> Array:
        """Frequencies of the spectra, shape (n_f,) [Hz]."""
        return self._values("frequency")

    @cached_property
    def scalars(self) -> list[Scalar]:
        """The scalars of the stage."""
        return from_json(self.store.attrs["scalars"])

    @property
    def values(self) -> dict[str, float]:
        """Those of them that have a value, by name."""
        return {s.name: s.value for s in self.scalars if s.value is not None}

    def _values(self, name: str) -> Array:
        return np.asarray(self.store[name].values, dtype=np.float64)


class CasesView(StoreView):
    """A store with results for one damping of the building after the other.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.cases = [str(name) for name in store["case"].values]

    def damping(self, case: int) -> Rayleigh:
        """The damping of a damping case, by its number from 0."""
        return Rayleigh(
            float(self.store["mass_coefficient"].values[case]),
            float(self.store["stiffness_coefficient"].values[case]),
        )

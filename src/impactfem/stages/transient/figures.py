"""The data of the figures of the stage `transient`."""

from collections.abc import Sequence
from functools import cached_property

import xarray as xr

from impactfem.case import Building3D
from impactfem.case.transient import Transient
from impactfem.device.from_case import device_of
from impactfem.device.modes import device_modes
from impactfem.stages.drawing import FigureData
from impactfem.stages.transient.film import Film, film_of
from impactfem.stages.transient.selection import shown

WITHOUT_DEVICES = (10.0, 33.0, 100.0)
"""Frequencies of maps of a building without devices [Hz]."""


class TransientData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def response(self) -> xr.Dataset:
        """`transient.nc` along the shown direction at the first damping."""
        return shown(self.opened("transient.nc"))

    @cached_property
    def sticks(self) -> xr.Dataset:
        """`pounding.nc`."""
        return self.opened("pounding.nc")

    @cached_property
    def building(self) -> xr.Dataset:
        """`building.nc`."""
        return self.opened("building.nc")

    @cached_property
    def maps(self) -> xr.Dataset | None:
        """`transient_maps.nc`; None without maps."""
        return self.optional("transient_maps.nc")

    @cached_property
    def film(self) -> Film | None:
        """The main impact of the building and its 3D neighbours; None if there is no film."""
        return film_of(self.folder)

    @property
    def fields(self) -> Sequence[str]:
        """Requested maps, "pfa" or "psa"."""
        return self._transient.fields

    @cached_property
    def frequency(self) -> list[str]:
        """Frequencies of the requested maps with spectra, as in names of files: "2p5hz"."""
        if self.maps is None or "psa" not in self.fields:
            return []
        low, high = self.maps["frequency"].values[[0, -1]] * (1.0 - 1e-9, 1.0 + 1e-9)
        wanted = self._transient.field_frequencies
        if wanted is None:
            devices = self.subject.devices if isinstance(self.subject, Building3D) else ()
            modes = [round(f, 1) for one in devices for f in device_modes(device_of(one)).frequency]
            wanted = tuple(sorted(set(modes))) or WITHOUT_DEVICES
        return [f"{f:g}hz".replace(".", "p") for f in wanted if low <= f <= high]

    @property
    def _transient(self) -> Transient:
        if self.subject.transient is None:
            raise ValueError("the case has no section transient")
        return self.subject.transient

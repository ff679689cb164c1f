"""Selections from `transient.nc` and `pounding.nc` for figures, tables and checks."""

import math

import numpy as np
import xarray as xr

from impactfem.stages.check import QUIET
from impactfem.stages.stores import time_step
from impactfem.system.arrays import Array


def shown(store: xr.Dataset) -> xr.Dataset:
    """Select the shown direction and the first damping of the spectra.

    Loads are in the order of their floors. The probes of the line have their `distance` d from the
    impact edge [m], the others nan; `ends` belongs to this direction.
    """
    response = store.sel(component=str(store.attrs["shown_direction"])).isel(damping=0)
    for loads in ("edge_floor", "transfer_load_floor"):
        if loads in response.coords:
            response = response.sortby(loads)
    position = store["probe_position"].transpose("probe", "xyz").values
    on_line = (store["probe_kind"] == "line").values
    distance = np.full(len(position), np.nan)
    if on_line.any():
        distance[on_line] = np.linalg.norm(position[on_line] - position[on_line][0], axis=1)
    response = response.assign_coords(distance=("probe", distance, {"units": "m"}))
    return response.assign(ends=ends(store).sel(component=response["component"]))


def of_kind(store: xr.Dataset, kind: str) -> xr.Dataset:
    """Select the probes of a kind: "centre" and "edge" by floor, "line" from the edge, "point"."""
    return store.isel(probe=(store["probe_kind"] == kind).values)


def at_floor(store: xr.Dataset, kind: str, floor: int) -> xr.Dataset:
    """Select the mass centre of a floor ("centre"), or the middle of its impact edge ("edge").

    IndexError: the store has no such probe.
    """
    probes = of_kind(store, kind)
    return probes.isel(probe=(probes["probe_floor"] == floor).values).isel(probe=0)


def floors_of(store: xr.Dataset, kind: str) -> list[int]:
    """Return the numbers of the floors with a probe of a kind, from the lowest."""
    return [int(floor) for floor in of_kind(store, kind)["probe_floor"].values]


def struck(response: xr.Dataset) -> xr.Dataset:
    """Select the sides with contact forces."""
    hit = (response["impact_force"] != 0.0).any("time")
    return response.isel(edge=hit.values)


def main_side(response: xr.Dataset) -> xr.Dataset:
    """Select the struck floors on the side with the largest force, from the lowest."""
    response = struck(response)
    if not response.sizes["edge"]:
        return response
    largest = abs(response["impact_force"]).max("time").argmax("edge")
    side = response["edge_side"].isel(edge=largest)
    return response.isel(edge=(response["edge_side"] == side).values)


def wave_floor(store: xr.Dataset) -> int:
    """Return the number of the floor with the line: the highest that may be struck."""
    return int(store.attrs["wave_floor"])


def known(store: xr.Dataset) -> xr.Dataset:
    """Select the frequencies of spectra for which the 3D model is valid."""
    highest = float(store.attrs["maximum_frequency"])
    return store.sel(frequency=slice(None, highest * (1.0 + 1e-9)))


def resolved(store: xr.Dataset) -> xr.Dataset:
    """Select the frequencies of spectra that the time step and the model resolve."""
    return store.sel(frequency=slice(None, resolved_end(store) * (1.0 + 1e-9)))


def resolved_end(store: xr.Dataset) -> float:
    """Return the highest frequency of the resolved band of a results file [Hz]."""
    return float(store.attrs["resolved_frequency"])


def at_frequencies(psa: xr.DataArray, frequency: Array) -> Array:
    """Interpolate spectra to other frequencies, linear in the logarithms; the last dimension.

    Args:
        psa: Spectra over `frequency` and one other dimension [m/s2].
        frequency: The frequencies, within the range of the spectra [Hz].
    """
    values = psa.transpose(..., "frequency").values.astype(np.float64)
    f = psa["frequency"].values
    place = np.interp(np.log(frequency), np.log(f), np.arange(len(f)))
    low = np.minimum(place.astype(np.int64), len(f) - 2)
    share = place - low
    tiny = np.finfo(np.float64).tiny
    below, above = (np.log(np.maximum(values[..., low + k], tiny)) for k in (0, 1))
    return np.asarray(np.exp((1.0 - share) * below + share * above))


def main_impact(store: xr.Dataset) -> tuple[float, float] | None:
    """Return start and end of the impact with the largest force [s]; None without an impact."""
    both = np.atleast_1d(store.attrs["main_impact"])
    return (float(both[0]), float(both[1])) if both.size == 2 else None


def inward(response: xr.Dataset) -> float:
    """Return the sense of the shown direction from the impact edge, 1 or −1; 0 if it is across."""
    position = of_kind(response, "line")["probe_position"].isel(probe=slice(None, None, -1))
    if position.sizes["probe"] < 2:
        return 0.0
    along = position[0] - position[-1]
    part = float(along.sel(xyz=response["component"].item()) / np.linalg.norm(along))
    return math.copysign(1.0, part) if abs(part) > 0.5 else 0.0


def line_ends(response: xr.Dataset) -> Array:
    """Return both ends of the line in plan, from the impact edge, shape (2, 2) [m]."""
    ends = of_kind(response, "line")["probe_position"].isel(probe=[0, -1])
    return ends.sel(xyz=["x", "y"]).transpose("probe", "xyz").values


def shown_line(response: xr.Dataset) -> xr.Dataset:
    """Select at most five probes of the line, its ends included: curves stay distinguishable."""
    line = of_kind(response, "line")
    last = line.sizes["probe"] - 1
    return line.isel(probe=np.unique(np.rint(np.linspace(0.0, last, min(5, last + 1))).astype(int)))


def between(store: xr.Dataset) -> xr.DataArray:
    """Peak acceleration between the samples (interpolated histories) over that at the samples [-].

    By probe and component; nan for points and directions at rest.
    """
    return _moving(store, store["pfa_interpolated"], store["pfa"])


def ends(store: xr.Dataset) -> xr.DataArray:
    """Ordinate at the highest valid frequency over the peak acceleration, its limit [-].

    By probe and component; nan as in `between`.
    """
    last = known(store)["psa"].isel(damping=0, frequency=-1)
    return _moving(store, last, store["pfa_interpolated"])


def _moving(store: xr.Dataset, values: xr.DataArray, over: xr.DataArray) -> xr.DataArray:
    largest = store["pfa"].max("probe")
    moves = (store["pfa"] > QUIET * largest) & (largest > QUIET * largest.max())
    return (values / over.where(moves)).transpose("probe", "component")


def transfer(response: xr.Dataset, floor: int) -> tuple[xr.DataArray, xr.DataArray]:
    """Return |acceleration / force| for the load on a floor, and the bound on its error [1/kg].

    By frequency and probe.
    """
    here = (response["transfer_load_floor"] == floor).values
    load = response.isel(transfer_load=here).isel(transfer_load=0)
    size: xr.DataArray = xr.apply_ufunc(np.hypot, load["transfer_re"], load["transfer_im"])
    return size, load["transfer_bound"]


def pounded(sticks: xr.Dataset, response: xr.Dataset) -> str:
    """Name the model that pounds: "sticks", or the 3D model with its time step."""
    if sticks["building_model"].sel(building=response.attrs["building"]).item() == "stick":
        return "sticks"
    return f"pounding, steps of {1e3 * time_step(sticks):.3g} ms"


def of_pounding(sticks: xr.Dataset, name: str, response: xr.Dataset) -> xr.DataArray | None:
    """Select a history, or a spectrum at its first damping, of the pounding model.

    At the floor with the line, along the shown direction; displacements are relative to the ground
    under the building. None if the pounding model lacks the floor or the direction.
    """
    axis = "direction" if "direction" in sticks[name].dims else "component"
    direction = response["component"].item()
    here = sticks["station_building"] == response.attrs["building"]
    here &= sticks["station_floor"] == wave_floor(response)
    if direction not in sticks[axis].values or not here.any():
        return None
    chosen = sticks[name].sel({axis: direction}).isel(station=here.values).isel(station=0)
    if name == "displacement" and "ground_apart" in sticks:
        ground = sticks["ground_apart"].sel(building=response.attrs["building"], axis=direction)
        chosen = chosen - ground.reset_coords(drop=True)
    return chosen.isel(damping=0, missing_dims="ignore")

"""Tables of the stage `transient`: probes, rotations, sides, and findings of the paper."""

from collections.abc import Mapping
from pathlib import Path

import xarray as xr
from scipy.integrate import trapezoid

from impactfem.plot.table import Table, beside_published, columns_of, write_tables
from impactfem.stages.stores import open_store, time_step
from impactfem.stages.transient.findings import finding_scalars
from impactfem.stages.transient.selection import known, shown
from impactfem.system.scalar import scalars_of

PEAKS = (
    "psa_peak",
    "psa_peak_band",
    "psa_peak_frequency",
    "pfa",
    "pfa_band",
    "largest_displacement",
)
"""Columns of the tables of probes and rotations."""


def transient_tables(folder: Path, published: Mapping[str, float]) -> list[Path]:
    """Write the tables of the stage, also into the log; returns the files.

    Published values are in SI, by the name of the result.
    """
    with open_store(folder / "transient.nc") as store:
        tables = [_probes(store), _physics(store, published)]
        tables += [_rotations(store)] if "rotation" in store.dims else []
        return write_tables(folder, tables + ([_sides(store)] if store.sizes["edge"] else []))


def _probes(store: xr.Dataset) -> Table:
    """Peaks at each probe, with the half widths of their error bands."""
    response = shown(store)
    position = {d: response["probe_position"].sel(xyz=d, drop=True) for d in ("x", "y", "z")}
    places = [("probe", "probe", ""), *((d, d, "m") for d in ("x", "y", "z"))]
    title = f"Response of the 3D building {store.attrs['building']} along "
    title += response["component"].item()
    return _peaks(response.assign(position), "transient_probes", title, places)


def _rotations(store: xr.Dataset) -> Table:
    """Peaks of the rotations of each probe with recorded rotations, with their error bands."""
    response = store.isel(damping=0).stack(place=("turning", "rotation"), create_index=False)
    places = [("turning", "probe", ""), ("rotation", "about", "")]
    title = f"Rotations of nodes of the 3D building {store.attrs['building']}"
    return _peaks(response, "transient_rotations", title, places, "rotational_")


def _peaks(
    response: xr.Dataset,
    name: str,
    title: str,
    places: list[tuple[str, str, str]],
    prefix: str = "",
) -> Table:
    """Peaks of spectra and histories, from the variables with a prefix; places come first."""
    highest = known(response)["frequency"].values[-1]
    return columns_of(
        response,
        name,
        f"{title}: peak of the floor response spectrum ({100 * response['damping'].item():g} % "
        f"damping, up to {highest:.4g} Hz) and peak acceleration, with half widths of their error "
        "bands",
        [*places, *(f"{prefix}{peak}" for peak in PEAKS)],
    )


def _sides(store: xr.Dataset) -> Table:
    """What each side that is struck or loaded takes, at its largest force."""
    force, step = store["edge_force"], time_step(store)
    largest = store.isel(time=abs(force).argmax("time"))
    return columns_of(
        xr.Dataset(
            {
                "length": store["edge_length"],
                "force": largest["edge_force"],
                "at": largest["time"].variable,
                "impulse": ("edge", trapezoid(force.transpose("edge", "time"), dx=step)),
                "moment": abs(store["edge_moment"]).max("time"),
                "from_middle": largest["edge_moment"] / largest["edge_force"],
            }
        ),
        "transient_sides",
        f"Forces on the sides of the 3D building {store.attrs['building']}, spread "
        f"'{store.attrs['spread']}': the largest, its distance from the middle of the side, and "
        "the largest moment F e, e along the side from its middle",
        [
            ("edge", "side", ""),
            ("length", "length", "m"),
            ("force", "largest force", "MN"),
            ("at", "at", "s"),
            ("from_middle", "from the middle", "m"),
            ("impulse", "whole impulse", "kN s"),
            ("moment", "largest moment", "MN m"),
        ],
    )


def _physics(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Table of findings compared with the paper's, after the other published values."""
    findings = finding_scalars(store)
    names = {scalar.name for scalar in findings}
    others = [s for s in scalars_of(store) if s.name in published and s.name not in names]
    title = f"Waves and amplification in the 3D building {store.attrs['building']}"
    return beside_published("transient_physics", title, others + findings, published)

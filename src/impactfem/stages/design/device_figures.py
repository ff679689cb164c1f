"""The members of an ensemble that went through the 3D building: table, and forces on anchors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, ORANGE, figure, letter
from impactfem.plot.table import Cell, Table
from impactfem.spectra.statistics import STATISTICS, over_members

Array = NDArray[np.float64]
PANELS = 3
"""Panels in a row."""


def design_device(folder: Path, store: xr.Dataset) -> list[Path]:
    """Write the table of the members and the figure of the forces on the anchors.

    Args:
        folder: The run's folder.
        store: The open `design.nc`.

    Returns:
        The files; none without an ensemble, no figure without devices.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    if "motion" not in store.dims:
        return []
    for part in ("tables", "figures"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    files = [member_table(store).write_csv(folder / "tables")]
    if "device" in store.dims:
        files.append(folder / "figures" / "design_device_force.png")
        _force_figure(files[-1], store)
    return files


def member_table(store: xr.Dataset) -> Table:
    """Each member: largest impact force, peaks of the floors' spectra, forces on the anchors."""
    axis = str(store.attrs["shown_direction"])
    impact = _impact(store)
    psa = store["member_psa"].isel(damping=0).sel(direction=axis).max("frequency").values
    columns: list[tuple[str, str, Array]] = [("largest impact force", "N", impact)]
    columns += [
        (f"peak of the spectrum of floor {floor}", "m/s2", psa[:, s])
        for s, floor in enumerate(store["station_floor"].values)
    ]
    if "device" in store.dims:
        for d, name in enumerate(store["device"].values):
            detailed, rsa = _forces(store, d)
            columns += [
                (f"F{axis} of {name}, 3D model", "N", detailed),
                (f"F{axis} of {name}, {store.attrs['analysis']}", "N", rsa),
            ]
    rows: list[tuple[Cell, ...]] = [
        (str(motion), *(_cell(values[m]) for *_, values in columns))
        for m, motion in enumerate(store["motion"].values)
    ]
    rows += [
        (words, *(_cell(_statistic(values, name)) for *_, values in columns))
        for name, words in STATISTICS.items()
    ]
    return Table(
        "design_members",
        f"Members of the ensemble through the 3D building, along {axis}",
        (("motion", ""), *((name, unit) for name, unit, _ in columns)),
        tuple(rows),
    )


def _force_figure(path: Path, store: xr.Dataset) -> None:
    axis, names = str(store.attrs["shown_direction"]), [str(n) for n in store["device"].values]
    impact = 1e-6 * _impact(store)
    columns = min(PANELS, len(names))
    rows = -(-len(names) // columns)
    caption = (
        f"Largest force on the anchor along $e_{axis}$ in the 3D model and by response spectrum "
        f"analysis ({store.attrs['analysis']}), against the largest impact force of the sticks, "
        f"for each of {len(impact)} motions. Lines: mean (solid) and 84 % fractile (dashed) of "
        "either."
    )
    size = (max(5.0, 3.4 * columns), 3.2 * rows)
    with figure(path, (rows, columns), size, caption) as (_, axes):
        for spare in axes[len(names) :]:
            spare.set_visible(False)
        for d, (panel, name) in enumerate(zip(axes, names, strict=False)):
            for force, colour, marker, label in zip(
                _forces(store, d),
                (BLUE, ORANGE),
                ("o", "^"),
                ("3D model", "response spectra"),
                strict=True,
            ):
                panel.plot(
                    impact, 1e-3 * force, marker, color=colour, ms=4.5, label=label, alpha=0.85
                )
                for statistic, style in (("mean", "-"), ("p84", "--")):
                    level = 1e-3 * float(over_members(force, statistic))
                    panel.axhline(level, color=colour, lw=0.9, ls=style)
            panel.set_xlabel("largest impact force [MN]")
            panel.set_ylabel(f"force of {name} [kN]")
            panel.set_ylim(bottom=0.0)
        axes[0].legend(loc="best")
        if len(names) > 1:
            letter(axes[: len(names)])


def _impact(store: xr.Dataset) -> Array:
    """Largest impact force of each member, shape (n_m,) [N]; 0 without contact pairs."""
    force = store["member_impact_force"].values
    return np.asarray(force.max(axis=1, initial=0.0), dtype=np.float64)


def _forces(store: xr.Dataset, device: int) -> tuple[Array, Array]:
    """Force of each member along the shown direction, in 3D and by response spectra [N]."""
    component = "xyz".index(str(store.attrs["shown_direction"]))
    return (
        np.asarray(store["member_device_force"].values[:, device, component], dtype=np.float64),
        np.asarray(store["member_device_spectrum"].values[:, device, component], dtype=np.float64),
    )


def _statistic(values: Array, name: str) -> float:
    """A statistic; nan for a lognormal one of values that are not all above zero."""
    if name == "p84_lognormal" and not np.all(values > 0.0):
        return float("nan")
    return float(over_members(values, name))


def _cell(value: float) -> Cell:
    return float(f"{value:.6g}") if np.isfinite(value) else None

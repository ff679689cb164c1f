"""The figures of the stage `device`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import xarray as xr

from impactfem.plot.curves import CurveFigure
from impactfem.stages.device import history_figures as device_histories
from impactfem.stages.device import input_figures as device_inputs
from impactfem.stages.device import model_figures as device_models
from impactfem.stages.device import position as device_position
from impactfem.stages.device import spectrum_figures as device_spectra
from impactfem.stages.device.pictures import device_pictures
from impactfem.stages.device.selection import drawing_of, file_stem, loaded
from impactfem.stages.stores import names_of, open_stores

Makers = dict[str, Callable[[Path], None]]


def device_figures(folder: Path) -> list[Path]:
    """Draw figures 23 to 30 and the demand by damping into `figures/`.

    Figures 23 to 27, 29 and 30 of further devices than the first have their names in the files.

    Args:
        folder: The run's folder, with `device.nc` and, for the position, `building.nc`.

    Returns:
        The files; what the stores have no data for is left out.

    Raises:
        ImpactfemError: A file cannot be written, or OpenGL is missing.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with open_stores(folder) as opened:
        store = loaded(opened("device.nc"))
        building = opened("building.nc") if (folder / "building.nc").is_file() else None
        makers: Makers = {
            "figure_28_damping": partial(device_spectra.damping_figure, store=store),
        }
        for device in names_of(store, "device"):
            own = _of_device(store, device, building)
            makers |= {file_stem(store, stem, device): draw for stem, draw in own.items()}
        drawn = [one.write_png(target) for one in _curves(store)]
        for name, draw in sorted(makers.items()):
            path = target / f"{name}.png"
            draw(path)
            drawn.append(path)
    return sorted([*drawn, *device_pictures(folder)])


def device_curves(folder: Path) -> list[CurveFigure]:
    """Figures 27 and 29 of all devices, for the report; argument as above."""
    with open_stores(folder) as opened:
        return _curves(loaded(opened("device.nc")))


def _curves(store: xr.Dataset) -> list[CurveFigure]:
    makers = (device_spectra.spectra_figure, device_histories.force_figure)
    return [make(store, device) for make in makers for device in names_of(store, "device")]


def _of_device(store: xr.Dataset, device: str, building: xr.Dataset | None) -> Makers:
    makers: Makers = {
        "device_demand": partial(device_spectra.demand_figure, store=store, device=device),
    }
    if len(device_inputs.input_choices(store, device)) > 1:
        makers["device_inputs"] = partial(device_inputs.inputs_figure, store=store, device=device)
    if store.sizes["case"] > 1:
        makers["figure_30_shear_force_damping"] = partial(
            device_histories.damping_forces_figure, store=store, device=device
        )
    if building is not None:
        makers["figure_23_position"] = partial(
            device_position.position_figure, store=store, device=device, building=building
        )
    if drawing_of(store, device) is not None:
        makers["figure_25_modes"] = partial(device_models.modes_figure, store=store, device=device)
        makers["figure_24_elements"] = partial(
            device_models.elements_figure, store=store, device=device
        )
        makers["figure_26_model"] = partial(device_models.model_figure, store=store, device=device)
    return makers

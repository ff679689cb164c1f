"""The figures of the stage `transient`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import xarray as xr

from impactfem.case.transient import Transient
from impactfem.stages.stores import open_stores
from impactfem.stages.transient.animation import wave_animation
from impactfem.stages.transient.frequency_figures import edge_figure, force_figure, transfer_figure
from impactfem.stages.transient.history_figures import across_figure, centre_figure, forces_figure
from impactfem.stages.transient.map_figures import map_file, peak_map, spectrum_map, spectrum_maps
from impactfem.stages.transient.pictures import transient_pictures
from impactfem.stages.transient.selection import main_impact, of_kind, shown
from impactfem.stages.transient.spectrum_figures import spectra_figures
from impactfem.stages.transient.wave_figures import membrane_figure, snapshots_figure, wave_map

FIELDS: tuple[str, ...] = Transient.model_fields["fields"].default
FIELD_FREQUENCIES: tuple[float, ...] = Transient.model_fields["field_frequencies"].default

Makers = dict[str, Callable[[Path], None]]


def transient_figures(
    folder: Path,
    *,
    fields: Sequence[str] = FIELDS,
    field_frequencies: Sequence[float] = FIELD_FREQUENCIES,
) -> list[Path]:
    """Draw figures 11 to 22, maps of the floors and a film of the wave into `figures/`.

    Args:
        folder: The run's folder, with `building.nc`, `pounding.nc`, `transient.nc` and, where
            fields were computed, `transient_maps.nc`.
        fields: Maps of the floors, as in the case: "pfa", "psa" or both.
        field_frequencies: Frequencies of the maps of pseudo-acceleration [Hz]; those without
            spectra are left out.

    Returns:
        The files; what the stores have no data for is left out.

    Raises:
        ImpactfemError: A file cannot be written, or OpenGL is missing.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with open_stores(folder) as opened:
        response = shown(opened("transient.nc"))
        makers = _of_probes(response, opened("pounding.nc"))
        if (folder / "transient_maps.nc").is_file():
            maps = opened("transient_maps.nc")
            makers |= _of_waves(response, maps)
            makers |= _of_floors(response, maps, fields, field_frequencies)
        drawn = [one.write_png(target) for one in spectra_figures(response, opened("pounding.nc"))]
        for name, draw in makers.items():
            draw(target / name)
            drawn.append(target / name)
    return sorted([*drawn, *transient_pictures(folder), *wave_animation(folder)])


def _of_probes(response: xr.Dataset, sticks: xr.Dataset) -> Makers:
    """Figures of histories, spectra and transfer functions at the probes."""
    hit = main_impact(response) is not None
    line, edges = (of_kind(response, kind).sizes["probe"] for kind in ("line", "edge"))
    of_run: dict[str, tuple[Callable[..., None], bool]] = {
        "figure_11_impact_forces.png": (forces_figure, hit and response.sizes["edge"] > 0),
        "figure_16_across.png": (across_figure, line > 0),
        "figure_17_map.png": (wave_map, hit and line > 1),
        "figure_20_edge.png": (edge_figure, edges > 0),
        "figure_21_force_spectra.png": (force_figure, hit and response.sizes["edge"] > 0),
        "figure_22_transfer.png": (
            transfer_figure,
            response.sizes.get("transfer_load", 0) > 0 and line + edges > 0,
        ),
    }
    return {
        "figure_12_centre.png": partial(centre_figure, response=response, sticks=sticks),
        **{name: partial(f, response=response) for name, (f, can) in of_run.items() if can},
    }


def _of_waves(response: xr.Dataset, maps: xr.Dataset) -> Makers:
    """Figures of the top floor at the snapshots."""
    if not maps.sizes["snapshot"] or of_kind(response, "line").sizes["probe"] < 2:
        return {}
    return {
        "figure_17_snapshots.png": partial(snapshots_figure, response=response, maps=maps),
        "figure_18_membrane.png": partial(membrane_figure, response=response, maps=maps),
    }


def _of_floors(
    response: xr.Dataset, maps: xr.Dataset, fields: Sequence[str], frequencies: Sequence[float]
) -> Makers:
    """Maps of the top floor."""
    makers: Makers = {}
    if "pfa" in fields:
        makers["building_map_pfa.png"] = partial(peak_map, response=response, maps=maps)
    if "psa" in fields:
        for f in spectrum_maps(frequencies, maps):
            makers[map_file(f)] = partial(spectrum_map, response=response, maps=maps, frequency=f)
    return makers

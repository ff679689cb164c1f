"""The figures of the stage `transient`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import xarray as xr

from impactfem.case.transient import Transient
from impactfem.stages.stores import open_stores
from impactfem.stages.transient import frequency_figures as transient_frequencies
from impactfem.stages.transient import history_figures as transient_histories
from impactfem.stages.transient import map_figures as transient_maps
from impactfem.stages.transient import spectrum_figures as transient_spectra
from impactfem.stages.transient import wave_figures as transient_waves
from impactfem.stages.transient.animation import wave_animation
from impactfem.stages.transient.pictures import transient_pictures
from impactfem.stages.transient.view import TransientView

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
        view = TransientView(opened("transient.nc"))
        makers = _of_probes(view, opened("pounding.nc"))
        if (folder / "transient_maps.nc").is_file():
            maps = opened("transient_maps.nc")
            makers |= _of_waves(view, maps)
            makers |= _of_floors(view, maps, fields, field_frequencies)
        drawn = []
        for name, draw in makers.items():
            draw(target / name)
            drawn.append(target / name)
    return sorted([*drawn, *transient_pictures(folder), *wave_animation(folder)])


def _of_probes(view: TransientView, sticks: xr.Dataset) -> Makers:
    """Figures of histories, spectra and transfer functions at the probes."""
    makers: Makers = {
        "figure_12_centre.png": lambda path: transient_histories.centre_figure(path, view, sticks),
        "figure_13_centre_spectrum.png": lambda path: transient_spectra.centre_spectrum(
            path, view, sticks
        ),
    }
    if view.loads and view.main_impact is not None:
        makers["figure_11_impact_forces.png"] = lambda path: transient_histories.forces_figure(
            path, view
        )
        makers["figure_21_force_spectra.png"] = lambda path: transient_frequencies.force_figure(
            path, view
        )
    if view.line:
        makers["figure_15_across_spectra.png"] = lambda path: transient_spectra.across_spectra(
            path, view
        )
        makers["figure_16_across.png"] = lambda path: transient_histories.across_figure(path, view)
    if len(view.line) > 1 and view.main_impact is not None:
        makers["figure_17_map.png"] = lambda path: transient_waves.wave_map(path, view)
    if view.edges:
        makers["figure_19_edge_spectra.png"] = lambda path: transient_spectra.edge_spectra(
            path, view
        )
        makers["figure_20_edge.png"] = lambda path: transient_frequencies.edge_figure(path, view)
    if view.transfer_loads and (view.edges or view.line):
        makers["figure_22_transfer.png"] = lambda path: transient_frequencies.transfer_figure(
            path, view
        )
    return makers


def _of_waves(view: TransientView, maps: xr.Dataset) -> Makers:
    """Figures of the top floor at the snapshots."""
    if not maps.sizes["snapshot"] or len(view.line) < 2:
        return {}
    return {
        "figure_17_snapshots.png": lambda path: transient_waves.snapshots_figure(path, view, maps),
        "figure_18_membrane.png": lambda path: transient_waves.membrane_figure(path, view, maps),
    }


def _of_floors(
    view: TransientView, maps: xr.Dataset, fields: Sequence[str], frequencies: Sequence[float]
) -> Makers:
    """Maps of the top floor."""
    makers: Makers = {}
    if "pfa" in fields:
        makers["building_map_pfa.png"] = lambda path: transient_maps.peak_map(path, view, maps)
    if "psa" in fields:
        for f in transient_maps.spectrum_maps(frequencies, maps):
            makers[transient_maps.map_file(f)] = _spectrum_maker(view, maps, f)
    return makers


def _spectrum_maker(
    view: TransientView, maps: xr.Dataset, frequency: float
) -> Callable[[Path], None]:
    return lambda path: transient_maps.spectrum_map(path, view, maps, frequency)

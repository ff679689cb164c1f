"""The figures of the stage `transient`, from its stores, in the paper's layout and numbering."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from impactfem.case.transient import Transient
from impactfem.plot.curves import NONE
from impactfem.stages.stores import open_stores
from impactfem.stages.transient.curve_figures import probe_figures
from impactfem.stages.transient.floor_figures import (
    floor_map,
    membrane_figure,
    snapshots_figure,
    wave_map,
)
from impactfem.stages.transient.pictures import draw_pictures
from impactfem.stages.transient.selection import main_impact, of_kind, shown
from impactfem.system.executor import in_own_process
from impactfem.system.parallel import meanwhile

FIELDS: tuple[str, ...] = Transient.model_fields["fields"].default
FIELD_FREQUENCIES: tuple[float, ...] = Transient.model_fields["field_frequencies"].default


def transient_figures(
    folder: Path,
    published: Mapping[str, float] = NONE,
    *,
    fields: Sequence[str] = FIELDS,
    field_frequencies: Sequence[float] = FIELD_FREQUENCIES,
) -> list[Path]:
    """Draw figures 11 to 22, maps of the floors and the film of the main impact; the files.

    What the stores have no data for is left out; so are the maps of frequencies [Hz] without
    spectra. Maps are "pfa", "psa" or both; published values, in SI by the name of the result, are
    drawn with ours.
    """
    target, pictures = folder / "figures", partial(in_own_process, draw_pictures, folder)
    with meanwhile(pictures) as drawn_meanwhile, open_stores(folder) as opened:
        response = shown(opened("transient.nc"))
        curves = probe_figures(response, opened("pounding.nc"), published)
        drawn = [one.write(target) for one in curves]
        makers: dict[str, Callable[[Path], None]] = {}
        on_line = of_kind(response, "line").sizes["probe"] > 1
        if main_impact(response) is not None and on_line:
            makers["figure_17_map.png"] = partial(wave_map, response=response)
        if (folder / "transient_maps.nc").is_file():
            maps = opened("transient_maps.nc")
            both: dict[str, Any] = {"response": response, "maps": maps}
            if maps.sizes["snapshot"] and on_line:
                makers["figure_17_snapshots.png"] = partial(snapshots_figure, **both)
                makers["figure_18_membrane.png"] = partial(membrane_figure, **both)
            if "pfa" in fields:
                makers["building_map_pfa.png"] = partial(floor_map, **both)
            low, high = maps["frequency"].values[[0, -1]] * (1.0 - 1e-9, 1.0 + 1e-9)
            for f in field_frequencies if "psa" in fields else ():
                if low <= f <= high:
                    name = f"building_map_psa_{f:g}hz".replace(".", "p")
                    makers[f"{name}.png"] = partial(floor_map, **both, frequency=f)
        for name, draw in makers.items():
            draw(target / name)
            drawn.append(target / name)
    return sorted([*drawn, *drawn_meanwhile()])

"""A picture of the forces along the edges of floors that touch in 3D."""

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.floor_field import line_load_maps
from impactfem.system.arrays import Array

CUT = 0.01
"""Part of the largest line loads that is drawn in the last colour: single points have these."""
MOST = 4
"""Lines that are drawn, those with the largest forces."""
MARGIN = 0.15
"""Part of the length of the main impact that is shown before and after it."""


def edge_force_figure(path: Path, sticks: xr.Dataset, forces: xr.Dataset) -> list[Path]:
    """Maps of the line load over edge and time, while the main impact lasts; none without force."""
    main = sticks.isel(impact=sticks["impact_peak_force"].argmax("impact"))
    start, end = float(main["impact_first_contact"]), float(main["impact_end"])
    margin = MARGIN * (end - start)
    time = forces["time"].values
    shown = forces.isel(time=(time >= start - margin) & (time <= end + margin))
    loads: dict[str, tuple[Array, Array]] = {}
    for name in dict.fromkeys(forces["line"].values.astype(str).tolist()):
        line = shown.isel(pair=(shown["line"] == name).values)
        if not name or not line["force"].any():
            continue
        # Of a stick, and inside a storey, a hat has no width: that of the other side counts.
        widths = [0.5 * np.ptp(line[f"hat_{side}"].fillna(0.0).values, axis=1) for side in "ab"]
        width = np.maximum(*widths)
        along = line["offset_a"] - line["offset_a"].isel(pair=0)
        place = np.linalg.norm(along.transpose("pair", "axis").values, axis=1)
        load = 1e-6 * line["force"].transpose("pair", "time").values
        if (width > 0.0).all():
            loads[name] = place, load / width[:, None]
    if not loads:
        return []
    largest = sorted(loads, key=lambda name: -float(loads[name][1].max()))[:MOST]
    pushing = np.concatenate([loads[name][1][loads[name][1] > 0.0] for name in largest])
    most = float(pushing.max())
    t = 1e3 * (shown["time"].values - start)
    caption = (
        "Line load between the edges that touch in 3D, over the distance along them and the time "
        f"from the first contact of the main impact at {start:.4g} s, straight between the points "
        f"of contact. Largest value: {most:.3g} MN/m, between {largest[0]}."
    )
    seen = (
        f"Line load by colour over time and edge, of {len(largest)} lines; at most {most:.3g} MN/m."
    )
    limit = float(np.quantile(pushing, 1.0 - CUT))
    line_load_maps(path, caption, seen, {name: (t, *loads[name]) for name in largest}, limit)
    return [path]

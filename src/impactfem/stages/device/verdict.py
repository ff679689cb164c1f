"""Difference of the detailed analysis from response spectrum analysis (RSA), and its causes."""

import numpy as np
import xarray as xr

from impactfem.plot.table import Cell, Table, heads
from impactfem.stages.device.selection import (
    LOADS,
    RIGID,
    ROTATIONS,
    Load,
    direction,
    loads_of,
    modes_of,
    rigid_variants,
    shown_modes,
    variant,
)

SAME = 0.005
"""Smallest difference that has causes, over the detailed force."""
STIFF = 0.1
"""A mode follows the floor if its pseudo-acceleration is within this part of the ZPA."""
CAUSES = (*(f"rigid part, {method}" for method in RIGID.values()), "rotations", "modes in phase")


def verdict(store: xr.Dataset) -> Table:
    """Return the table of differences, with a row for each device, damping and load."""
    rows: list[tuple[Cell, ...]] = []
    for load in loads_of(store):
        difference, parts = load.difference(), causes(load)
        cells: list[float | None] = [None] * (len(CAUSES) + 2)
        if difference is not None:
            largest = min(max(parts.values(), default=0.0), 1.0)
            left = difference * (1.0 - largest) if difference > SAME else 0.0
            cells = [difference, *(parts.get(cause) for cause in CAUSES), left]
        percent = (None if cell is None else 100.0 * cell for cell in cells)
        names = load.device, load.case, LOADS[load.impact]
        rows.append((*names, load.detailed, load.by_spectrum(), *percent))
    causes_of = "; ".join(f"due to {cause} [%]" for cause in CAUSES)
    return Table(
        "device_verdict",
        "Difference = (detailed - RSA) / detailed; causes as parts of the difference; unexplained "
        "part over the detailed force",
        heads(
            "device; damping; load; detailed [N]; RSA [N]; difference [%]; "
            f"{causes_of}; unexplained [%]"
        ),
        tuple(rows),
    )


def causes(load: Load) -> dict[str, float]:
    """Return the part of the deficit of RSA that each cause alone removes; empty without deficit.

    A part above 1 removes more than the deficit; a negative part increases it.
    """
    detailed, own = load.detailed, load.by_spectrum()
    lacking = detailed - own
    if not lacking > SAME * detailed:
        return {}
    names = {
        f"rigid part, {RIGID[method]}": name
        for method, name in rigid_variants(load.store).items()
        if method in RIGID and load.was_done(name)
    }
    if (rotations := variant(load.store, ROTATIONS)) is not None:
        names["rotations"] = rotations
    parts = {cause: (load.by_spectrum(name) - own) / lacking for cause, name in names.items()}
    if (summed := in_phase(load)) is not None:
        parts["modes in phase"] = 1.0 - abs(detailed - summed) / lacking
    return parts


def in_phase(load: Load) -> float | None:
    """Return the sum of the modal forces with signs [N]; None if a mode does not follow the floor.

    Modes follow the floor if all are above the peak of its spectrum and at its ZPA. The force of a
    mode along the shown direction is then M_i S_i, without the missing mass.
    """
    axis = direction(load.store)
    zpa = float(abs(load.of("anchor_acceleration", component=axis)).max())
    modes = shown_modes(load.store, load.device)
    if modes.sizes["mode"] < 2 or not zpa > 0.0:
        return None
    ratio = load.ordinates.sel(component=axis, mode=modes["mode"]).values / zpa
    above = modes["mode_frequency"].values > float(load.psa.idxmax("frequency"))
    if not (above & (np.abs(ratio - 1.0) <= STIFF)).all():
        return None
    forces = load.ordinates * modes_of(load.store, load.device)["effective_mass"]
    return float(forces.sel(component=axis).sum())

"""The checks of the stage `calibrate` in words: contact, energy, steps, penetration, floors."""

from pathlib import Path

import xarray as xr

from impactfem.stages.calibrate.selection import MODEL, STICK, impacts_of
from impactfem.stages.check import Check, limited
from impactfem.stages.stores import open_store, time_step
from impactfem.system.scalar import values_of

COMPLEMENTARITY = 1e-9
ENERGY = 1e-9
BASIS = 0.005
"""Largest error of the reduced basis under even loads on the edges."""
STEPS = 16.0
"""Least number of steps in an impact (paper, equation 7)."""
EVEN = 1e-6
"""Largest departure of a floor that is held as a whole from its displacement, over it."""
RIGID, PENALTY = 0.05, 0.5
"""Largest penetration in parts of the gap: of a rigid wall, and of the stick's penalty law."""


def wall_checks(folder: Path) -> list[Check]:
    """The checks of the stage, from `calibrate.nc` in the folder of the run."""
    with open_store(folder / "calibrate.nc") as store:
        value = {name.removeprefix("calibration."): v for name, v in values_of(store).items()}
        lines = [
            *_course(store, value),
            limited("complementarity", value["complementarity"], COMPLEMENTARITY),
            limited("energy identity", value["energy_residual"], ENERGY),
            limited("energy that contact adds in a step", value["energy_gained"], ENERGY),
        ]
        if (error := value.get("basis_error")) is not None:
            lines.append(limited("error of the reduced basis", error, BASIS, "%"))
        steps_of = store["impact_duration"] / time_step(store)
        fewest = steps_of.isel(case=steps_of.argmin("case"))
        which = f", damping {fewest['case'].item()}" if store.sizes["case"] > 1 else ""
        stick = impacts_of(store, STICK)
        top, of_stick = stick[-1].floor, stick[-1].first_complete().duration / time_step(store)
        for steps, who in ((float(fewest), f"3D model{which}"), (of_stick, "stick")):
            text = f"first impact of floor {top} of the {who}: time steps"
            lines.append(limited(text, steps, STEPS, least=True))
        gap = float(store.attrs["gap"])
        if gap > 0.0:
            into = max(0.0, *(-found.closest for found in stick))
            model = value["penetration"]
            for who, depth, limit in (("3D model", model, RIGID), ("stick", into, PENALTY)):
                text = f"penetration of the {who}"
                lines.append(limited(text, depth / gap, limit, "% of the gap"))
    return [(met, f"calibrate: {text}") for met, text in lines]


def _course(store: xr.Dataset, value: dict[str, float]) -> list[Check]:
    """What happened: start, first impact, stick, floors that do not hit or are not free again."""
    floors = {"3D model": impacts_of(store, MODEL), "stick": impacts_of(store, STICK)}
    pull, uneven, later = store.attrs["pull"], value["start_unevenness"], value["stick_delay"]
    start = (
        f"floor {store.attrs['displaced_floor']} starts at "
        f"{1e3 * store.attrs['displacement_at_start']:.4g} mm"
    )
    text = f"{start} at its mass centre, its slab within {uneven:.2g} of it (pull = {pull})"
    at_start: Check = (None, text)
    if pull == "whole_floor":
        at_start = limited(f"{start}; largest departure of its slab", uneven, EVEN)
    top = floors["3D model"][-1]
    first = top.first_complete()
    lines: list[Check] = [
        at_start,
        (
            None,
            f"ε = {value['epsilon']:.3g}, ξ_c = {value['xi_c']:.3g}, "
            f"K_Ceq = {value['K_Ceq']:.3g} N/m from the impact of floor {top.floor} "
            f"at {first.start:.4g} s: {1e3 * first.duration:.3g} ms, "
            f"{1e-3 * first.largest_impulse:.4g} kN s, {first.approach:.3g} m/s before it",
        ),
        (
            None,
            f"stick: {1e3 * abs(later):.3g} ms {'later' if later >= 0.0 else 'earlier'}, impulse "
            f"{100.0 * (value['stick_impulse_ratio'] - 1.0):+.3g} %, duration "
            f"{100.0 * (value['stick_duration_ratio'] - 1.0):+.3g} %, relative to the 3D model",
        ),
    ]
    for kind, of_kind in floors.items():
        for found in of_kind:
            who, near = f"floor {found.floor} of the {kind}", 1e3 * found.closest
            if not found.impacts:
                lines.append((None, f"{who} does not hit the wall, it stays {near:.3g} mm away"))
            elif not found.impacts[-1].complete:
                begun = found.impacts[-1].start
                text = f"{who} is still at the wall when the window ends, since {begun:.4g} s"
                lines.append((False, text))
    return lines

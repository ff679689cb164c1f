"""The checks of the stage `calibrate` in words: contact, energy, steps, penetration, floors."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.stages.calibrate.selection import MODEL, STICK, impacts_of
from impactfem.stages.check import Check
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
    """The checks of the stage.

    Args:
        folder: The run's folder, with `calibrate.nc`.
    """
    with open_store(folder / "calibrate.nc") as store:
        return [
            *_start(store),
            *_found(store),
            *_floors(store),
            *_contact(store),
            *_steps(store),
            *_penetration(store),
        ]


def _start(store: xr.Dataset) -> list[Check]:
    """Whether the building starts from the state that was requested."""
    pull, uneven = store.attrs["pull"], values_of(store)["calibration.start_unevenness"]
    floor, d = store.attrs["displaced_floor"], 1e3 * store.attrs["displacement_at_start"]
    text = f"calibrate: floor {floor} starts at {d:.4g} mm"
    if pull == "whole_floor":
        return [(uneven <= EVEN, f"{text}, all of its slab within {uneven:.1e} (limit {EVEN:g})")]
    return [
        (None, f"{text} at its mass centre, its slab within {uneven:.2g} of it (pull = {pull})")
    ]


def _found(store: xr.Dataset) -> list[Check]:
    values, top = values_of(store), impacts_of(store, MODEL)[-1]
    first = top.first_complete()
    later = 1e3 * values["calibration.stick_delay"]
    return [
        (
            None,
            f"calibrate: ε = {values['calibration.epsilon']:.3g}, "
            f"ξ_c = {values['calibration.xi_c']:.3g}, "
            f"K_Ceq = {values['calibration.K_Ceq']:.3g} N/m from the impact of floor {top.floor} "
            f"at {first.start:.4g} s: {1e3 * first.duration:.3g} ms, "
            f"{1e-3 * first.largest_impulse:.4g} kN s, {first.approach:.3g} m/s before it",
        ),
        (
            None,
            f"calibrate: the stick hits {abs(later):.3g} ms {'later' if later >= 0.0 else 'before'}"
            f", with {values['calibration.stick_impulse_ratio']:.3g} of the impulse and "
            f"{values['calibration.stick_duration_ratio']:.3g} of the duration",
        ),
    ]


def _floors(store: xr.Dataset) -> list[Check]:
    lines: list[Check] = []
    for kind, which in (("3D model", MODEL), ("stick", STICK)):
        for found in impacts_of(store, which):
            who = f"calibrate: floor {found.floor} of the {kind}"
            if not found.impacts:
                near = 1e3 * found.closest
                lines.append((None, f"{who} does not hit the wall, it stays {near:.3g} mm away"))
            elif not found.impacts[-1].complete:
                begun = found.impacts[-1].start
                text = f"{who} is still at the wall when the window ends, since {begun:.4g} s"
                lines.append((False, text))
    return lines


def _contact(store: xr.Dataset) -> list[Check]:
    values = values_of(store)
    residual = values["calibration.complementarity"]
    identity, gained = values["calibration.energy_residual"], values["calibration.energy_gained"]
    lines: list[Check] = [
        (
            residual < COMPLEMENTARITY,
            f"calibrate: complementarity within {residual:.1e}, {COMPLEMENTARITY:g} asked",
        ),
        (
            identity < ENERGY,
            f"calibrate: energy identity to {identity:.1e}, {ENERGY:g} asked",
        ),
        (
            gained < ENERGY,
            f"calibrate: contact puts in at most {gained:.1e} of the energy in a step, {ENERGY:g} "
            "asked",
        ),
    ]
    error = values.get("calibration.basis_error")
    if error is not None:
        text = (
            f"calibrate: transfer functions of the reduced basis within {100 * error:.2g} %, "
            f"{100 * BASIS:g} % asked"
        )
        lines.append((error <= BASIS, text))
    return lines


def _steps(store: xr.Dataset) -> list[Check]:
    steps_of = store["impact_duration"] / time_step(store)
    fewest = steps_of.isel(case=steps_of.argmin("case"))
    which = f" with the damping {fewest['case'].item()}" if store.sizes["case"] > 1 else ""
    stick = impacts_of(store, STICK)[-1]
    lines: list[Check] = []
    for steps, who in (
        (float(fewest), f"floor {stick.floor} of the 3D model{which}"),
        (
            stick.first_complete().duration / time_step(store),
            f"floor {stick.floor} of the stick",
        ),
    ):
        text = f"calibrate: {steps:.3g} steps in the first impact of {who}, {STEPS:g} asked"
        lines.append((steps >= STEPS, text))
    return lines


def _penetration(store: xr.Dataset) -> list[Check]:
    gap = float(store.attrs["gap"])
    if not gap > 0.0:
        return []
    into = values_of(store)["calibration.penetration"] / gap
    stick = max(0.0, *(-found.closest for found in impacts_of(store, STICK))) / gap
    return [
        (
            into <= RIGID,
            f"calibrate: the 3D model penetrates {100 * into:.2g} % of the gap, "
            f"{100 * RIGID:g} % asked",
        ),
        (
            stick <= PENALTY,
            f"calibrate: the stick penetrates {100 * stick:.2g} % of the gap, "
            f"{100 * PENALTY:g} % asked",
        ),
    ]

"""The checks of the stage `calibrate` in words: contact, energy, steps, penetration, floors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from impactfem.stages.calibrate.view import WallView
from impactfem.stages.check import Check
from impactfem.stages.stores import open_store

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
        view = WallView(store)
        return [
            *_start(view),
            *_found(view),
            *_floors(view),
            *_contact(view),
            *_steps(view),
            *_penetration(view),
        ]


def _start(view: WallView) -> list[Check]:
    """Whether the building starts from the state that was requested."""
    pull, uneven = view.store.attrs["pull"], view.values["calibration.start_unevenness"]
    floor, d = view.store.attrs["displaced_floor"], 1e3 * view.store.attrs["displacement_at_start"]
    text = f"calibrate: floor {floor} starts at {d:.4g} mm"
    if pull == "whole_floor":
        return [(uneven <= EVEN, f"{text}, all of its slab within {uneven:.1e} (limit {EVEN:g})")]
    return [
        (None, f"{text} at its mass centre, its slab within {uneven:.2g} of it (pull = {pull})")
    ]


def _found(view: WallView) -> list[Check]:
    values, first = view.values, view.first_impact
    later = 1e3 * values["calibration.stick_delay"]
    return [
        (
            None,
            f"calibrate: ε = {values['calibration.epsilon']:.3g}, "
            f"ξ_c = {values['calibration.xi_c']:.3g}, "
            f"K_Ceq = {values['calibration.K_Ceq']:.3g} N/m from the impact of floor {view.top} at "
            f"{first.start:.4g} s: {1e3 * first.duration:.3g} ms, "
            f"{1e-3 * first.largest_impulse:.4g} kN s, {first.approach:.3g} m/s before it",
        ),
        (
            None,
            f"calibrate: the stick hits {abs(later):.3g} ms {'later' if later >= 0.0 else 'before'}"
            f", with {values['calibration.stick_impulse_ratio']:.3g} of the impulse and "
            f"{values['calibration.stick_duration_ratio']:.3g} of the duration",
        ),
    ]


def _floors(view: WallView) -> list[Check]:
    lines: list[Check] = []
    for kind, impacts in (("3D model", view.model_impacts), ("stick", view.stick_impacts)):
        for found in impacts:
            who = f"calibrate: floor {found.floor} of the {kind}"
            if not found.impacts:
                near = 1e3 * found.closest
                lines.append((None, f"{who} does not hit the wall, it stays {near:.3g} mm away"))
            elif not found.impacts[-1].complete:
                begun = found.impacts[-1].start
                text = f"{who} is still at the wall when the window ends, since {begun:.4g} s"
                lines.append((False, text))
    return lines


def _contact(view: WallView) -> list[Check]:
    values = view.values
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


def _steps(view: WallView) -> list[Check]:
    duration = view.store["impact_duration"].values / view.time_step
    k = int(np.argmin(duration))
    which = f" with the damping {view.cases[k]}" if len(view.cases) > 1 else ""
    lines: list[Check] = []
    for steps, who in (
        (float(duration[k]), f"floor {view.top} of the 3D model{which}"),
        (
            view.stick_impacts[-1].first_complete().duration / view.time_step,
            f"floor {view.top} of the stick",
        ),
    ):
        text = f"calibrate: {steps:.3g} steps in the first impact of {who}, {STEPS:g} asked"
        lines.append((steps >= STEPS, text))
    return lines


def _penetration(view: WallView) -> list[Check]:
    if not view.gap > 0.0:
        return []
    into = view.values["calibration.penetration"] / view.gap
    stick = max(0.0, *(-found.closest for found in view.stick_impacts)) / view.gap
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

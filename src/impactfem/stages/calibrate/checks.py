"""Checks of the stage `calibrate`: contact, energy, steps, penetration, floors at the wall."""

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from impactfem.stages.calibrate.selection import MODEL, STICK, impacts_of
from impactfem.stages.check import PROGRAM_FAULT, Check, Criterion
from impactfem.stages.stores import open_store, time_step

RIGID, PENALTY = 0.05, 0.5
"""Largest penetration in parts of the gap: of a rigid wall, and of the stick's penalty law."""

START = Criterion("calibrate.start", "displacement of the mass centre at the start", "mm")
UNEVENNESS = Criterion(
    "calibrate.start_unevenness",
    "largest departure of the slab from its displacement at the start",
    upper=1e-6,
    severity="invalid",
    consequence="The floor is not displaced as a whole",
    remedy=PROGRAM_FAULT,
)
RESTITUTION = Criterion("calibrate.restitution", "restitution ε of the impact on the rigid wall")
STICK_DELAY = Criterion("calibrate.stick_delay", "delay of the impact of the stick", "ms")
NO_IMPACT = Criterion("calibrate.least_distance", "least distance from the wall, no impact", "mm")
AT_THE_WALL = Criterion(
    "calibrate.contact_at_end",
    "floors in contact at the end of the time window",
    upper=0,
    consequence="The impact of these floors is not complete: its impulse and restitution are not "
    "known",
    remedy="Raise wall_impact.duration",
)
COMPLEMENTARITY = Criterion(
    "calibrate.complementarity",
    "residual of complementarity",
    upper=1e-9,
    severity="invalid",
    consequence="The unilateral contact is not solved",
    remedy=PROGRAM_FAULT,
)
ENERGY = Criterion(
    "calibrate.energy_residual",
    "residual of the energy identity",
    upper=1e-9,
    severity="invalid",
    consequence="The time stepping does not conserve energy",
    remedy=PROGRAM_FAULT,
)
GAINED = Criterion(
    "calibrate.energy_gained",
    "largest energy that contact adds in a step",
    upper=1e-9,
    severity="invalid",
    consequence="Contact adds energy",
    remedy=PROGRAM_FAULT,
)
BASIS = Criterion(
    "calibrate.basis_error",
    "error of the reduced basis under even loads on the edges",
    "%",
    upper=0.005,
    consequence="Restitution and contact stiffness may be wrong by this error",
    remedy="Raise transient.largest_basis, or lower transient.tolerance",
)
STEPS = Criterion(
    "calibrate.steps_per_impact",
    "time steps in the first impact",
    lower=16.0,  # paper, equation 7
    consequence="The velocity after the impact and the restitution are inaccurate",
    remedy="Reduce wall_impact.time_step",
)
PENETRATION = Criterion(
    "calibrate.penetration",
    "largest penetration",
    "% of the gap",
    upper=RIGID,
    consequence="The contact is too soft for a rigid wall",
    remedy="Raise the stiffness of the contact law, or reduce wall_impact.time_step",
)


def wall_checks(folder: Path) -> list[Check]:
    """Return the checks of the stage, from `calibrate.nc` in the folder of the run."""
    with open_store(folder / "calibrate.nc") as store:
        checks = [
            *_course(store),
            COMPLEMENTARITY.check(float(store["complementarity"].max())),
            ENERGY.check(float(store["energy_residual"])),
            GAINED.check(float(store["energy_gained"]), upper=_most_gained(store)),
            BASIS.check(float(store["basis_error"])),
        ]
        steps_of = store["impact_duration"] / time_step(store)
        fewest = steps_of.isel(case=steps_of.argmin("case"))
        which = f", damping {fewest['case'].item()}" if store.sizes["case"] > 1 else ""
        stick = impacts_of(store, STICK)
        top, of_stick = stick[-1].floor, stick[-1].first_complete().duration / time_step(store)
        checks.append(STEPS.check(float(fewest), f"floor {top} of the 3D model{which}"))
        checks.append(STEPS.check(of_stick, f"floor {top} of the stick"))
        gap = float(store.attrs["gap"])
        if gap > 0.0:
            into = max(0.0, *(-floor.closest for floor in stick))
            checks.append(PENETRATION.check(float(store["penetration"]) / gap, "3D model"))
            checks.append(PENETRATION.check(into / gap, "stick", upper=PENALTY))
    return checks


def _most_gained(store: xr.Dataset) -> float:
    """Limit of the energy that contact adds in a step: zero but for rounding in Moreau's scheme.

    The other one has an error of second order in the steps in which points close and open.
    """
    return 2e-3 if store.attrs["unilateral_scheme"] == "massless" else 1e-9


def _course(store: xr.Dataset) -> Iterator[Check]:
    """Check start, first impact, stick, and floors without an impact or still at the wall."""
    floors = {"3D model": impacts_of(store, MODEL), "stick": impacts_of(store, STICK)}
    pull, uneven = store.attrs["pull"], float(store["start_unevenness"])
    own = store.isel(case=0)
    displaced = f"floor {store.attrs['displaced_floor']}"
    start = 1e3 * store.attrs["displacement_at_start"]
    yield START.check(
        start, displaced, f"largest relative departure of its slab {uneven:.2g}; pull = {pull}"
    )
    if pull == "whole_floor":
        yield UNEVENNESS.check(uneven, displaced)
    top = floors["3D model"][-1]
    first = top.first_complete()
    yield RESTITUTION.check(
        float(own["epsilon"]),
        f"floor {top.floor} at {first.start:.4g} s",
        f"ξ_c = {float(own['xi_c']):.3g}, K_Ceq = {float(own['K_Ceq']):.3g} N/m, duration "
        f"{1e3 * first.duration:.3g} ms, impulse {1e-3 * first.largest_impulse:.4g} kN s, approach "
        f"velocity {first.approach:.3g} m/s",
    )
    yield STICK_DELAY.check(
        1e3 * float(store["stick_delay"]),
        "relative to the 3D model",
        f"impulse {100.0 * (float(store['stick_impulse_ratio']) - 1.0):+.3g} %, duration "
        f"{100.0 * (float(store['stick_duration_ratio']) - 1.0):+.3g} %",
    )
    for kind, of_kind in floors.items():
        for floor in of_kind:
            if not floor.impacts:
                yield NO_IMPACT.check(1e3 * floor.closest, f"floor {floor.floor} of the {kind}")
    still = [
        f"floor {floor.floor} of the {kind} since {floor.impacts[-1].start:.4g} s"
        for kind, of_kind in floors.items()
        for floor in of_kind
        if floor.impacts and not floor.impacts[-1].complete
    ]
    yield AT_THE_WALL.check(len(still), detail=", ".join(still))

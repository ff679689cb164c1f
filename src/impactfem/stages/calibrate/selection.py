"""What is read off `calibrate.nc`: contact laws with its values (paper, section 3.2.2), histories.

Stages take the laws; figures, tables and checks take histories, impacts and damping cases.
"""

from pathlib import Path

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid

from impactfem.case import BuildingInTime, Case, KelvinVoigtLaw
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.coupling.restitution import kelvin_voigt_phase, kelvin_voigt_xi
from impactfem.stages.calibrate.experiment import WallHistory
from impactfem.stages.calibrate.impact import FloorImpacts, floor_impacts
from impactfem.stages.stores import damping_of, names_of, number_of, open_store, time_step
from impactfem.system.arrays import Array

MODEL, STICK = "", "stick_"
"""What the names of the histories of the 3D model and of the stick begin with."""


def asks_calibration(case: Case) -> bool:
    """Whether a contact of the case has a law that leaves values to the calibration."""
    laws = [case.contact_laws[contact.law] for contact in case.contacts]
    return any(isinstance(law, KelvinVoigtLaw) and law.calibrated for law in laws)


def calibrated_laws(case: Case) -> frozenset[str]:
    """Names of the contact laws of a case that leave their restitution to the calibration."""
    return frozenset(
        name
        for name, law in case.contact_laws.items()
        if isinstance(law, KelvinVoigtLaw) and law.restitution == CALIBRATED
    )


def with_calibrated_contact(case: Case, epsilon: float, K_Ceq: float) -> Case:
    """The case with the ε [-] and K_Ceq [N/m] of equations 5 and 6 where its laws say "calibrated".

    A law that may not pull keeps the duration of the impact, which is φ √(M / K) with the law's
    phase φ: its stiffness is K_Ceq (φ / φ_tension)², both phases for ε.
    """

    def phase(tension: bool) -> float:
        return kelvin_voigt_phase(kelvin_voigt_xi(epsilon, tension=tension), tension=tension)

    laws = dict(case.contact_laws)
    for name, law in laws.items():
        if not isinstance(law, KelvinVoigtLaw) or not law.calibrated:
            continue
        found = {"stiffness": K_Ceq * (phase(law.tension) / phase(True)) ** 2}
        found["restitution"] = epsilon
        values = {key: value for key, value in found.items() if getattr(law, key) == CALIBRATED}
        laws[name] = law.model_copy(update=values)
    return case if laws == case.contact_laws else case.model_copy(update={"contact_laws": laws})


def with_contact_of_run(case: Case, run: Path) -> Case:
    """The case with what `calibrate.nc` of this run gives for its contact laws.

    ImpactfemError where the store has no restitution or stiffness of the building's own damping.
    """
    if not asks_calibration(case):
        return case
    with open_store(_store(case, run)) as store:
        epsilon, K_Ceq = (number_of(store, name, case=OWN) for name in ("epsilon", "K_Ceq"))
    return with_calibrated_contact(case, epsilon, K_Ceq)


def calibrated_restitutions(case: Case, run: Path) -> dict[str, float]:
    """Restitution of each damping case that leaves it to the impact on the wall, if there is one.

    An ImpactfemError where the store lacks one.
    """
    asked = [one.name for one in case.damping_cases if one.restitution == CALIBRATED]
    if case.wall_impact is None or not asked:
        return {}
    with open_store(_store(case, run)) as store:
        return {name: number_of(store, "epsilon", case=name) for name in asked}


def impulses_of_run(building: BuildingInTime, run: Path) -> dict[int, Array] | None:
    """Impulse of each point of contact in the first impact, by floor, for spread `calibrated`.

    Not collective; None for another spread. An ImpactfemError where there is no store.
    """
    if building.transient.spread != "calibrated":
        return None
    with open_store(_store(building.case, run)) as store:
        force, floors = store["constraint_force"].sum("step"), store["constraint_floor"].values
        return {int(k): force.values[floors == k] for k in np.unique(floors)}


def _store(case: Case, run: Path) -> Path:
    """The store of the impact on the wall, in the folder of its building."""
    [building] = case.at_wall
    return building.folder(run) / "calibrate.nc"


def history_of(store: xr.Dataset, which: str) -> WallHistory:
    """Histories of the 3D model, or of the stick."""
    names = ("displacement", "velocity", "force", "opening")
    histories = {name: store[f"{which}{name}"].transpose("time", "floor").values for name in names}
    return WallHistory(
        floors=tuple(store["floor"].values.tolist()),
        mass=store["floor_mass"].values,
        gap=float(store.attrs["gap"]),
        time_step=time_step(store),
        **histories,
    )


def impacts_of(store: xr.Dataset, which: str) -> list[FloorImpacts]:
    """Impacts of the 3D model or of the stick by floor, bottom to top.

    The top one of the floors that may hit, which gives the parameters, has one that ends in the
    window: the stage writes no other store.
    """
    history, separation = history_of(store, which), float(store.attrs["separation"])
    return [floor_impacts(history, floor, separation=separation) for floor in history.floors]


def focus(store: xr.Dataset) -> tuple[float, float]:
    """Start and end of what is shown of the first impact of all floors that hit [s]."""
    found, time = impacts_of(store, MODEL), store["time"].values
    latest = found[-1].first_complete().end + float(store.attrs["separation"])
    firsts = [floor.impacts[0] for floor in found if floor.impacts]
    near = [impact for impact in firsts if impact.start < latest]
    start, end = min(i.start for i in near), max(i.end for i in near)
    margin = 0.4 * (end - start)
    return max(time[0], start - margin), min(time[-1], end + margin)


def half_wave(store: xr.Dataset) -> float:
    """Frequency whose half wave lasts as long as the first impact, 1 / (2 Δt_c) [Hz]."""
    return 0.5 / float(store["impact_duration"][0])


def damping_ratios(store: xr.Dataset, frequency: float) -> xr.DataArray:
    """The building's damping ratio at a frequency [Hz] in each damping case [-]."""
    ratios = [damping_of(store.sel(case=case)).ratio(frequency) for case in names_of(store, "case")]
    return xr.DataArray(ratios, coords={"case": store["case"]}, dims="case")


def running_impulse(history: WallHistory, floor: int) -> Array:
    """∫ F dt of a floor from the start on, shape (n_t,) [N s]."""
    F = history.force[:, history.column(floor)]
    return np.asarray(cumulative_trapezoid(F, dx=history.time_step, initial=0.0))

"""Contact laws with the values that the impact on a rigid wall gives (paper, section 3.2.2)."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case, KelvinVoigtLaw
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.coupling.restitution import kelvin_voigt_phase, kelvin_voigt_xi
from impactfem.stages.stores import number_of, open_store


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
    """The case with numbers where its contact laws say "calibrated"; itself when none does.

    A law that may not pull keeps the duration of the impact, which is φ √(M / K) with the law's
    phase φ: its stiffness is K_Ceq (φ / φ_tension)², both phases for ε.

    Args:
        case: The case.
        epsilon: Restitution ε of equation 5 [-].
        K_Ceq: Stiffness of equation 6, of a law that may pull at its end [N/m].
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


def with_contact_of_run(case: Case, folder: Path) -> Case:
    """The case with what the stage `calibrate` of this run found.

    Args:
        case: The case.
        folder: Its folder, in a run with `calibrate.nc` where the case asks for it.

    Raises:
        ImpactfemError: The store has no restitution or stiffness of the building's own damping.
    """
    if not asks_calibration(case):
        return case
    with open_store(_store(case, folder)) as store:
        epsilon, K_Ceq = (number_of(store, name, case=OWN) for name in ("epsilon", "K_Ceq"))
    return with_calibrated_contact(case, epsilon, K_Ceq)


def calibrated_restitutions(case: Case, folder: Path) -> dict[str, float]:
    """Restitution of each damping case that leaves it to the impact on the wall, if there is one.

    Args: as of `with_contact_of_run`.

    Raises:
        ImpactfemError: The store lacks one.
    """
    asked = [one.name for one in case.damping_cases if one.restitution == CALIBRATED]
    if case.whole.wall_impact is None or not asked:
        return {}
    with open_store(_store(case, folder)) as store:
        return {name: number_of(store, "epsilon", case=name) for name in asked}


def _store(case: Case, folder: Path) -> Path:
    """The store of the impact on the wall, in the folder of its building."""
    building = next((one for one in case.whole.views if one.wall_impact is not None), case.whole)
    return building.folder(case.run_folder(folder)) / "calibrate.nc"

"""What analyses the devices under the members of an ensemble."""

from __future__ import annotations

from dataclasses import replace

from impactfem.case import Case
from impactfem.equipment.analysis import Analyst
from impactfem.equipment.prepared import Prepared as DevicePrepared
from impactfem.equipment.scalars import PREFERRED
from impactfem.equipment.spectrum_choice import SpectrumChoice
from impactfem.equipment.stage import analyst_of
from impactfem.equipment.study_model import StudyModel


def choice_of(equipment: DevicePrepared) -> SpectrumChoice:
    """The response spectrum analysis that counts: translations, spectra as computed.

    Args:
        equipment: Of the stage `device`.
    """
    asked = list(equipment.plans[0].rules)
    combination = next((one for one in PREFERRED if one in asked), asked[0])
    return SpectrumChoice(combination, rotations=False, broadened=False)


def analyst_alone(case: Case, equipment: DevicePrepared, model: StudyModel) -> Analyst:
    """What does the analysis that counts alone of each device, beside the detailed one.

    Args:
        case: The case.
        equipment: Of the stage `device`.
        model: Its reduced model.
    """
    chosen = choice_of(equipment).combination
    # The contacts of the wall experiment are most of the model, and of no use here.
    every = analyst_of(case, equipment, replace(model, wall=None))
    plans = [
        replace(
            plan,
            rules={one: rules for one, rules in plan.rules.items() if one == chosen},
            rotations=False,
            broadening=0.0,
            given=(),
        )
        for plan in every.plans
    ]
    return replace(every, plans=plans, covered=[()] * len(every.covered))

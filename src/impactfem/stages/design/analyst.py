"""What analyses the devices under the members of an ensemble."""

from __future__ import annotations

from dataclasses import replace

from impactfem.case import Case
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.device.prepared import Prepared as DevicePrepared
from impactfem.stages.device.spectrum_choice import SpectrumChoice, headline_of
from impactfem.stages.device.study_model import StudyModel


def choice_of(equipment: DevicePrepared) -> SpectrumChoice:
    """The response spectrum analysis that counts: translations, spectra as computed.

    Args:
        equipment: Of the stage `device`.
    """
    return headline_of(equipment.plans[0].rules)


def analyst_alone(case: Case, equipment: DevicePrepared, model: StudyModel) -> Analyst:
    """What does the analysis that counts alone of each device, beside the detailed one.

    Args:
        case: The case.
        equipment: Of the stage `device`.
        model: Its reduced model.
    """
    chosen = choice_of(equipment)
    # The contacts of the wall experiment are most of the model, and of no use here.
    every = analyst_of(case, equipment, replace(model, wall=None))
    plans = [
        replace(
            plan,
            rules={
                (chosen.combination, chosen.rigid): plan.rules[chosen.combination, chosen.rigid]
            },
            rotations=False,
            broadening=0.0,
            given=(),
        )
        for plan in every.plans
    ]
    return replace(every, plans=plans, covered=[()] * len(every.covered))

"""Demand on the items of an equipment list against their capacities."""

from __future__ import annotations

import math

import numpy as np

from impactfem.case import Case
from impactfem.case.equipment import Equipment
from impactfem.device.equipment import absolute_acceleration, force_on_floor, item_bolt_demand
from impactfem.stages.device.capacity import bolt_group
from impactfem.stages.equipment.motion import FloorMotions, ItemMotion
from impactfem.stages.qualification import compared
from impactfem.system.errors import SolutionError
from impactfem.system.quantity import quantity, results, si


@results
class ItemDemand:
    """The demand on an item, with or without impacts; nan where it has no such capacity."""

    zpa: float = si("m/s2", "zero-period acceleration at the item, along the governing axis")
    shear_force: float = si("N", "shear force, horizontal force on the floor", shown="kN")
    moment: float = si("N m", "overturning moment, at the anchors", shown="kN m")
    uplift: float = si("N", "net uplift, vertical force on the floor less the weight", shown="kN")
    bolt_tension: float = si("N", "largest tension of a bolt, in any direction", shown="kN")
    bolt_shear: float = si("N", "largest shear of a bolt, in any direction", shown="kN")
    interaction: float = si("-", "interaction, (T/T_R)^k + (V/V_R)^k in the critical direction")
    #: Of the ordinate with the largest ratio to the required spectrum.
    spectrum: float = si("m/s2", "floor spectrum, where its ratio to the required one is largest")
    spectrum_capacity: float = si("m/s2", "required spectrum, there")
    spectrum_frequency: float = si("Hz", "frequency of this ordinate")
    zpa_limit: float = si("m/s2", "limit of the zero-period acceleration")

    @property
    @quantity("-", "spectrum ratio, floor spectrum over required spectrum")
    def spectrum_ratio(self) -> float:
        """Largest ratio of the floor spectrum to the required one."""
        return self.spectrum / self.spectrum_capacity

    @property
    @quantity("-", "ZPA ratio, zero-period acceleration over its limit")
    def zpa_ratio(self) -> float:
        """ZPA over its limit."""
        return self.zpa / self.zpa_limit

    @property
    @quantity("-", "governing ratio, the largest of interaction, spectrum and ZPA ratio")
    def ratio(self) -> float:
        """Largest ratio of demand to capacity; nan without a capacity."""
        ratios = [self.interaction, self.spectrum_ratio, self.zpa_ratio]
        known = [one for one in ratios if not math.isnan(one)]
        return max(known, default=math.nan)


def item_demand(item: Equipment, motion: ItemMotion, case: Case, end: float) -> ItemDemand:
    """Return the demand on an item under the motion of its floor.

    Args:
        item: The item.
        motion: The motion at the item, in the resolved band.
        case: The case, for the rules of spectra.
        end: End of the resolved band [Hz].
    """
    floor, step = motion.acceleration, motion.time_step
    own = absolute_acceleration(floor, step, item.frequencies, item.damping or 0.0)
    force = force_on_floor(own, item.mass, item.mass_height)
    horizontal = float(np.hypot(force[0], force[1]).max())
    tension = shear = interaction = math.nan
    if (anchors := item.bolts) is not None:
        group = bolt_group(anchors, 0.5 * (item.circle or 0.0))
        try:
            demand = item_bolt_demand(group, force, motion.time)
            tension, shear, interaction = demand.tension, demand.shear, demand.interaction
        except SolutionError:
            interaction = math.inf
    ordinate = None
    if item.spectrum is not None:
        rules = case.spectra
        ordinate = compared(floor, step, item.spectrum, rules, rules.broadening, end)
    return ItemDemand(
        zpa=float(np.abs(floor).max()),
        shear_force=horizontal,
        moment=item.mass_height * horizontal,
        uplift=float(force[2].max()),
        bolt_tension=tension,
        bolt_shear=shear,
        interaction=interaction,
        spectrum=math.nan if ordinate is None else ordinate.demand,
        spectrum_capacity=math.nan if ordinate is None else ordinate.capacity,
        spectrum_frequency=math.nan if ordinate is None else ordinate.frequency,
        zpa_limit=math.nan if item.zpa_limit is None else item.zpa_limit,
    )


def both_demands(
    item: Equipment, floors: FloorMotions, case: Case
) -> tuple[ItemDemand, ItemDemand]:
    """Return the demand on an item without and with impacts."""
    without, hit = (
        item_demand(item, floors.at(item, impacts=impacts), case, floors.end)
        for impacts in (False, True)
    )
    return without, hit

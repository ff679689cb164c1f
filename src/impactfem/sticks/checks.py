"""Checks of a pounding run: separation, steps per impact, and whether linear analysis is meant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.sticks.impacts import Impact
from impactfem.sticks.pounding import Pair, Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Separation:
    """How far two points come together when nothing holds them, against their gap.

    Args:
        pair: The pair.
        required: Gap that would have prevented contact, the largest approach without contact [m].
        touched: Whether the points touch with contact.
    """

    pair: Pair
    required: float
    touched: bool

    @property
    def margin(self) -> float:
        """Gap less the required separation [m]; negative where pounding is to be expected."""
        return self.pair.gap - self.required


def separations(free: Response, response: Response) -> list[Separation]:
    """Required separation of each pair from the run without contact.

    Args:
        free: The run without contact.
        response: The run with contact.
    """
    approach = -(free.u @ response.system.J.T)
    return [
        Separation(pair, float(max(approach[:, k].max(), 0.0)), bool(response.force[:, k].any()))
        for k, pair in enumerate(response.system.pairs)
    ]


@dataclass(frozen=True)
class ImpactCheck:
    """What an impact asks of the buildings, during its time.

    Args:
        impact: The impact.
        bearing_pressure: Peak force over the bearing area [Pa]; nan where the area is not known.
        bearing_ratio: That over the lower compressive strength of the two buildings [-]; nan where
            none is known.
        storey_shear: Largest elastic storey shear along the normal in the two buildings [N].
        shear_stress: That over the shear area of its storey [Pa].
        cracking_ratio: Shear stress over the mean tensile strength f_ctm = 0.30 f_ck^(2/3) MPa
            (EN 1992-1-1, table 3.1) [-]; above 1 the storey cracks in shear, and linear analysis
            overrates its stiffness; nan where no strength is known.
    """

    impact: Impact
    bearing_pressure: float
    bearing_ratio: float
    storey_shear: float
    shear_stress: float
    cracking_ratio: float


def impact_checks(
    response: Response, impacts: Sequence[Impact], strength: Mapping[str, float | None]
) -> list[ImpactCheck]:
    """Mean bearing pressure and storey shears of each impact.

    Args:
        response: The run with contact.
        impacts: Its impacts.
        strength: Compressive strength of each building's storeys [Pa]; None where not given.
    """
    system = response.system
    checks = []
    for impact in impacts:
        pair = impact.pair
        window = slice(max(impact.first - 1, 0), impact.last + 2)
        worst = (0.0, 0.0, np.nan)
        known = []
        for end in (pair.a, pair.b):
            if end is None:
                continue
            stick = system.stick(end.building)
            f_c = strength.get(stick.name)
            start = system.offsets[stick.name]
            forces = stick.storey_forces(response.u[window, start : start + stick.n])
            shear = np.abs(forces[..., :3] @ pair.normal).max(axis=0)
            n_x, n_y, n_z = np.abs(pair.normal)
            areas = [
                n_x * f.section.Avx + n_y * f.section.Avy + n_z * f.section.A for f in stick.floors
            ]
            stress = shear / np.array(areas)
            k = int(np.argmax(stress))
            if f_c is not None:
                known.append(f_c)
            ratio = np.nan if f_c is None else stress[k] / _mean_tensile_strength(f_c)
            if stress[k] > worst[1]:
                worst = (float(shear[k]), float(stress[k]), float(ratio))
        pressure = np.nan if pair.area is None else impact.peak_force / pair.area
        checks.append(
            ImpactCheck(
                impact=impact,
                bearing_pressure=float(pressure),
                bearing_ratio=float(pressure / min(known)) if known else np.nan,
                storey_shear=worst[0],
                shear_stress=worst[1],
                cracking_ratio=worst[2],
            )
        )
    return checks


def _mean_tensile_strength(f_ck: float) -> float:
    return float(0.30e6 * (f_ck / 1e6) ** (2.0 / 3.0))

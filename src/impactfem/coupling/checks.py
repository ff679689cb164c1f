"""Checks of a pounding run: separation, steps per impact, and whether linear analysis is meant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.impacts import Impact
from impactfem.coupling.pounding import Pair, Response

Array = NDArray[np.float64]
VERTICAL = 1e-6  # a normal with a smaller horizontal part is vertical


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
    # Zero is added, as a point that never approaches has -0, which would be written as such.
    required = np.maximum((-(free.u @ response.system.J.T)).max(axis=0), 0.0) + 0.0
    return [
        Separation(pair, float(required[k]), bool(response.force[:, k].any()))
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
        storey_shear: Largest elastic storey shear along the normal's horizontal part in the two
            buildings [N]; nan for a vertical normal.
        shear_stress: Largest shear over the shear area of its storey, n_x² A_vx + n_y² A_vy [Pa].
        cracking_ratio: Largest shear stress over the mean tensile strength
            f_ctm = 0.30 f_ck^(2/3) MPa (EN 1992-1-1, table 3.1) [-]; above 1 the storey cracks in
            shear, and linear analysis overrates its stiffness; nan where no strength is known.
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
        horizontal = float(np.hypot(pair.normal[0], pair.normal[1]))
        found = []
        known = []
        for end in (pair.a, pair.b):
            if end is None:
                continue
            stick = system.stick(end.building)
            f_c = strength.get(stick.name)
            if f_c is not None:
                known.append(f_c)
            if horizontal < VERTICAL:
                continue
            n_x, n_y = pair.normal[:2] / horizontal
            start = system.offsets[stick.name]
            forces = stick.element_forces(response.u[window, start : start + stick.n])
            shear = np.abs(forces[..., 0] * n_x + forces[..., 1] * n_y).max(axis=0)
            for element, V in zip(stick.elements, shear, strict=True):
                section = stick.floors[element.storey].section
                stress = float(V / (n_x**2 * section.Avx + n_y**2 * section.Avy))
                ratio = np.nan if f_c is None else stress / _mean_tensile_strength(f_c)
                found.append((float(V), stress, ratio))
        shears, stresses, ratios = zip(*found, strict=True) if found else ((), (), ())
        pressure = np.nan if pair.area is None else impact.peak_force / pair.area
        checks.append(
            ImpactCheck(
                impact=impact,
                bearing_pressure=float(pressure),
                bearing_ratio=float(pressure / min(known)) if known else np.nan,
                storey_shear=max(shears, default=np.nan),
                shear_stress=max(stresses, default=np.nan),
                cracking_ratio=max((r for r in ratios if np.isfinite(r)), default=np.nan),
            )
        )
    return checks


def _mean_tensile_strength(f_ck: float) -> float:
    return float(0.30e6 * (f_ck / 1e6) ** (2.0 / 3.0))

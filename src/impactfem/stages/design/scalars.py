"""The scalar results of the stage `design`, by the names of `summary.json`.

Spectra are those at the first damping along the shown direction, enveloped over the points of each
floor: its probes, and the vertices that govern. `ensemble3d.STATISTIC.X` is a statistic over the
members of their X; X has the name that it has for the case's own motion, `design.X` for `frs.*`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.design.carried import CarriedEnsemble
from impactfem.stages.design.case_spectra import CaseSpectra
from impactfem.system.scalar import Scalar

Array = NDArray[np.float64]


def design_scalars(
    own: CaseSpectra, direction: str, carried: CarriedEnsemble | None
) -> list[Scalar]:
    """All scalars of the stage.

    Args:
        own: The spectra under the case's own motion.
        direction: The shown direction.
        carried: The ensemble; None without one.
    """
    c = "xyz".index(direction)
    scalars = []
    for k, floor in enumerate(own.floors):
        psa, at = own.floor_psa[0, k, c], _points(len(floor.names), len(own.vertices.at(k, c)))
        peak = int(np.argmax(psa))
        name = f"design.frs.floor_{floor.floor}"
        scalars += [
            Scalar(f"{name}.peak", float(psa[peak]), "m/s2", at),
            Scalar(f"{name}.peak_frequency", float(own.frequency[peak]), "Hz", at),
            Scalar(f"{name}.zpa", float(own.floor_pfa[k, c]), "m/s2", at),
        ]
    return scalars if carried is None else [*scalars, *_ensemble(own, c, carried)]


def _ensemble(own: CaseSpectra, c: int, carried: CarriedEnsemble) -> list[Scalar]:
    scalars = [
        Scalar("ensemble3d.members", float(len(carried.members)), "-"),
        Scalar("ensemble3d.failed", float(len(carried.failed)), "-", "; ".join(carried.failed)),
        Scalar(
            "ensemble3d.basis_error",
            float(carried.basis_error.max()),
            "-",
            "transfer functions at the points",
        ),
    ]
    peaks = carried.floor_psa[:, 0, :, c].max(axis=-1)
    zpa = carried.floor_pfa[:, :, c]
    for k, floor in enumerate(own.floors):
        centre = floor.centre
        at_centre = carried.psa[:, 0, centre, c].max(axis=-1)
        envelope = _points(len(floor.names), round(carried.vertices[:, k, c].mean()))
        name = f"floor_{floor.floor}"
        scalars += _statistics(f"frs.{name}.peak", peaks[:, k], "m/s2", envelope)
        scalars += _statistics(f"frs.{name}.zpa", zpa[:, k], "m/s2", envelope)
        scalars += _statistics(f"transient.frs.{name}.peak", at_centre, "m/s2", "mass centre")
    force = carried.largest_impact
    scalars += _statistics("impact_force", force, "N", "largest one, sticks")
    axis = "xyz"[c]
    for d, device in enumerate(carried.devices):
        name = "device" if d == 0 else f"device.{device}"
        detailed, rsa = carried.device_force[:, d, c], carried.device_spectrum[:, d, c]
        analysis = f"{device}, {carried.analysis}"
        scalars += _statistics(f"{name}.f{axis}.detailed.impact", detailed, "N", device)
        scalars += _statistics(f"{name}.f{axis}.rsa.impact", rsa, "N", analysis)
        if np.all(detailed > 0.0):
            difference = 1.0 - rsa / detailed
            scalars += _statistics(f"{name}.relative_difference.impact", difference, "-", analysis)
    return scalars


def _points(probes: int, vertices: int) -> str:
    """What is enveloped, in words."""
    return f"envelope of {probes} probes" + (f" and {vertices} vertices" if vertices else " alone")


def _statistics(name: str, values: Array, unit: str, note: str) -> list[Scalar]:
    # Differences and forces that are zero have no logarithm.
    known = [key for key in STATISTICS if key != "p84_lognormal" or np.all(values > 0.0)]
    return [
        Scalar(
            f"ensemble3d.{key}.{name}",
            float(over_members(values, key)),
            unit,
            f"{note}; over {len(values)} members",
        )
        for key in known
    ]

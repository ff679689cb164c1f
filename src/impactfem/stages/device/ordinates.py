"""Pseudo-accelerations that the modes of the devices got in response spectrum analysis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.device.springs import COMPONENTS
from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.damping_study import DampedStudy
from impactfem.stages.device.spectrum_choice import SpectrumChoice

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]


def ordinate_variables(
    cases: Sequence[DampedStudy], choice: SpectrumChoice, modes: int
) -> Variables:
    """The variable `mode_psa` of `device.nc`.

    Args:
        cases: The devices by damping.
        choice: Which analysis; one with rotations has inputs about the axes, too.
        modes: Length of the dimension `mode`; values beyond a device's modes are nan.

    Returns:
        By name: dimensions, values and attributes. Nan where a component of the anchor does not
        move or is no input; 0 where it moves, but not the mode. Of each of several anchors, its
        own.
    """
    values = [
        [[_of(result, choice, modes) for result in load] for load in (one.no_impact, one.impact)]
        for one in cases
    ]
    note = "rad/s2 for rx, ry, rz; of the anchor without the device, at the dampings of the modes"
    return {
        "mode_psa": (
            ("case", "impact", "device", "component", "mode"),
            np.array(values, dtype=np.float64),
            {"units": "m/s2", "note": note},
        )
    }


def _of(result: DeviceResult, choice: SpectrumChoice, modes: int) -> Array:
    found = np.full((len(COMPONENTS), modes), np.nan)
    response = result.by_spectrum[choice]
    first = result.support.rows.start
    for one, column in zip(response.inputs, response.columns, strict=True):
        if first <= column < first + len(COMPONENTS):
            found[column - first, : one.ordinate.size] = one.ordinate
    return found

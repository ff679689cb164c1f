"""What is done to a record before it is used: each step explicit, in a fixed order, and logged."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import signal

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.baseline import BaselineCorrection
from impactfem.motion.resampling import resampled
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER

FloatArray = npt.NDArray[np.float64]
Baseline = Literal["none", "mean", "linear", "rest"]

FILTER_ORDER = 4


@dataclass(frozen=True)
class Treatment:
    """The steps done to a record, in this order; each is left out by its default.

    1. `baseline` "mean" or "linear": the mean, or the straight line of least squares, of the whole
       record is taken out. First, so that nothing steps at the ends of what follows.
    2. `taper`: half a cosine takes the record to zero over this time at both ends.
    3. `band`: Butterworth band-pass of order 4, once forward and once backward over the record
       continued by zeros for 1.5 x 4 / f_low at both ends (the length that Boore and Bommer 2005,
       Soil Dyn. Earthq. Eng. 25, 93-115, advise): no phase is shifted, the corners are damped by
       a half, and the fall beyond them is that of order 8. The continuation is cut off again, and
       with it what the filter left there: `baseline` "rest" mends the end.
    4. `resample`: another step (:func:`impactfem.motion.resampling.resampled`).
    5. `baseline` "rest": end velocity and displacement are brought to zero by two smooth bells
       (:class:`impactfem.motion.baseline.BaselineCorrection`). Last, as all others would spoil it.

    Args:
        baseline: See 1 and 5.
        taper: Length of either taper [s].
        band: Low and high corner frequency [Hz].
        resample: New time step [s].

    Raises:
        ImpactfemError: A value is out of range.
    """

    baseline: Baseline = "none"
    taper: float | None = None
    band: tuple[float, float] | None = None
    resample: float | None = None

    def __post_init__(self) -> None:
        if self.taper is not None and not (math.isfinite(self.taper) and self.taper > 0.0):
            raise ImpactfemError(f"the taper must be positive, got {self.taper!r} s")
        if self.band is not None and not 0.0 < self.band[0] < self.band[1] < math.inf:
            raise ImpactfemError(
                f"the corner frequencies must be 0 < low < high, got {self.band!r} Hz"
            )

    def __call__(self, accelerogram: Accelerogram) -> Accelerogram:
        """Treat a record.

        Args:
            accelerogram: The record.

        Returns:
            The record with each step done in its origin, which is logged as well.

        Raises:
            ImpactfemError: A step cannot be done on this record.
        """
        result = accelerogram
        if self.baseline in {"mean", "linear"}:
            result = _detrended(result, self.baseline)
        if self.taper is not None:
            result = _tapered(result, self.taper)
        if self.band is not None:
            result = _filtered(result, self.band)
        if self.resample is not None:
            result = resampled(result, self.resample)
        if self.baseline == "rest":
            result = _at_rest(result)
        done = result.origin.removeprefix(accelerogram.origin).removeprefix("; ")
        if done:
            LOGGER.info("%s: %s", accelerogram.name or "record", done)
        return result


def _noted(accelerogram: Accelerogram, acceleration: FloatArray, note: str) -> Accelerogram:
    origin = f"{accelerogram.origin}; {note}".removeprefix("; ")
    return replace(accelerogram, acceleration=acceleration, origin=origin)


def _detrended(accelerogram: Accelerogram, kind: str) -> Accelerogram:
    a = accelerogram.acceleration
    if kind == "mean":
        mean = float(a.mean())
        return _noted(accelerogram, a - mean, f"mean of {mean:.6g} m/s2 taken out")
    t = accelerogram.time
    middle = t - t.mean()
    slope = float(a @ middle / (middle @ middle))
    level = float(a.mean()) - slope * float(t.mean())
    note = f"line {level:.6g} m/s2 + {slope:.6g} m/s3 t taken out"
    return _noted(accelerogram, a - (level + slope * t), note)


def _tapered(accelerogram: Accelerogram, length: float) -> Accelerogram:
    if length > 0.5 * accelerogram.duration:
        raise ImpactfemError(
            f"the taper of {length:.6g} s is longer than half the record,"
            f" {0.5 * accelerogram.duration:.6g} s"
        )
    t = accelerogram.time
    nearest = np.minimum(t, accelerogram.duration - t)
    window = 0.5 * (1.0 - np.cos(np.pi * np.clip(nearest / length, 0.0, 1.0)))
    note = f"tapered over {length:.6g} s at both ends"
    return _noted(accelerogram, accelerogram.acceleration * window, note)


def _filtered(accelerogram: Accelerogram, band: tuple[float, float]) -> Accelerogram:
    h, a = accelerogram.time_step, accelerogram.acceleration
    nyquist = 0.5 / h
    if band[1] >= nyquist:
        raise ImpactfemError(
            f"the high corner of {band[1]:.6g} Hz must be below the Nyquist frequency of the"
            f" record, {nyquist:.6g} Hz"
        )
    if band[0] < 0.1 / accelerogram.duration:
        raise ImpactfemError(
            f"the low corner of {band[0]:.6g} Hz must be at least a tenth of a cycle in the"
            f" duration, {0.1 / accelerogram.duration:.6g} Hz"
        )
    pad = math.ceil(1.5 * FILTER_ORDER / band[0] / h)
    sections = signal.butter(FILTER_ORDER, band, btype="bandpass", fs=1.0 / h, output="sos")
    forward = signal.sosfilt(sections, np.pad(a, pad))
    both = signal.sosfilt(sections, forward[::-1])[::-1]
    note = (
        f"Butterworth band-pass {band[0]:.6g} Hz to {band[1]:.6g} Hz of order {FILTER_ORDER},"
        " forward and backward"
    )
    return _noted(accelerogram, both[pad : pad + a.size], note)


def _at_rest(accelerogram: Accelerogram) -> Accelerogram:
    a = accelerogram.acceleration
    correction = BaselineCorrection(a.size, accelerogram.time_step)(a) - a
    note = (
        "brought to rest at its end by a correction of at most"
        f" {float(np.abs(correction).max()):.4g} m/s2"
    )
    return _noted(accelerogram, a + correction, note)

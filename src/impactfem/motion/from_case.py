"""From the case file's motions to accelerograms with their measures and spectra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.case import Motion, RecordMotion, SyntheticMotion
from impactfem.errors import Fault, InputError
from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.measures import Measures, measures
from impactfem.motion.misfit import Misfit
from impactfem.motion.record import read_record
from impactfem.motion.synthesis import synthesise
from impactfem.spectra import ResponseSpectra, logarithmic_frequencies, response_spectra

RECORD_DAMPING = 0.05  # of the spectrum that describes a record, by custom
SPECTRUM_RANGE = (0.2, 100.0, 200)  # lowest and highest frequency [Hz], points a decade


@dataclass(frozen=True, eq=False)
class GroundMotion:
    """One component of the ground motion.

    Args:
        direction: "x", "y" or "z".
        accelerogram: The motion.
        measures: Its measures.
        spectrum: Its response spectrum, one record at one damping.
        target: Pseudo-acceleration of the design spectrum at the same frequencies, shape (n_f,)
            [m/s2]; None for a record.
        misfit: How well it meets the design spectrum; None for a record.
    """

    direction: str
    accelerogram: Accelerogram
    measures: Measures
    spectrum: ResponseSpectra
    target: npt.NDArray[np.float64] | None
    misfit: Misfit | None


def ground_motions(motions: Sequence[Motion]) -> tuple[GroundMotion, ...]:
    """Read or synthesise the motions of a case, in its order.

    Raises:
        InputError: A record is not usable.
        SolutionError: A synthesis found no motion.
    """
    return tuple(_ground_motion(motion) for motion in motions)


def check_records(motions: Sequence[Motion]) -> None:
    """Read the records of a case and see that they are usable.

    Raises:
        InputError: With the faults of all of them.
    """
    faults: list[Fault] = []
    for motion in motions:
        if isinstance(motion, RecordMotion):
            try:
                read_record(motion.file, motion.format)
            except InputError as error:
                faults += error.faults
    if faults:
        raise InputError(faults)


def _ground_motion(motion: Motion) -> GroundMotion:
    target, misfit = None, None
    frequency = logarithmic_frequencies(*SPECTRUM_RANGE)
    if isinstance(motion, SyntheticMotion):
        design = DesignSpectrum(
            ground_acceleration=motion.spectrum.ground_acceleration,
            corner_periods=motion.spectrum.corner_periods,
            amplification=motion.spectrum.amplification,
            damping=motion.damping,
        )
        made = synthesise(
            design,
            duration=motion.duration,
            time_step=motion.time_step,
            strong_phase=motion.strong_phase,
            seed=motion.seed,
            pga=motion.pga,
            iterations=motion.iterations,
        )
        accelerogram, misfit, damping = made.accelerogram, made.misfit, motion.damping
        target = design.pseudo_acceleration(frequency)
    else:
        damping = RECORD_DAMPING
        accelerogram = read_record(motion.file, motion.format)
        if motion.pga is not None:
            accelerogram = accelerogram.scaled(motion.pga / measures(accelerogram).pga)
        elif motion.scale != 1.0:
            accelerogram = accelerogram.scaled(motion.scale)
    spectrum = response_spectra(
        accelerogram.acceleration, accelerogram.time_step, frequency, [damping]
    )
    return GroundMotion(
        motion.direction, accelerogram, measures(accelerogram), spectrum, target, misfit
    )

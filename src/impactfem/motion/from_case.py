"""From the case file's motions to accelerograms with their measures and spectra."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from impactfem.case import Case, Motion, RecordMotion, SyntheticMotion
from impactfem.case.design_spectrum import TableSpectrum as SpectrumTable
from impactfem.case.model import CaseFile
from impactfem.case.plausibility import LASTING, PGA, STEP
from impactfem.case.source import read_source
from impactfem.motion.acceptance import Acceptance, Misfit, acceptance
from impactfem.motion.components import aligned, conflicts, same_directions
from impactfem.motion.design_spectrum import DesignSpectrum, TableSpectrum, design_spectrum
from impactfem.motion.synthesis import default_range, synthesise
from impactfem.motion.treatment import (
    HIGHEST,
    Treatment,
    TreatmentError,
    refined_step,
    straight_line_loss,
)
from impactfem.records import read_record
from impactfem.records.accelerogram import Accelerogram, Measures, measures
from impactfem.spectra import Method, ResponseSpectra, logarithmic_frequencies, response_spectra
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.log import LOGGER, quiet
from impactfem.system.quantity import quantity, results

RECORD_DAMPING = 0.05  # of the spectrum that describes a record, by custom
RIGID = 33.0  # Hz: a spectrum that ends here or above ends at the peak ground acceleration
COARSE = 0.1
"""Part of the amplitude at 33 Hz that the straight lines of a synthetic motion may lose: that of a
step of 5 ms is 9 %."""
PEAK = (0.99, 1.3)
"""Usual peak of a synthetic motion over that of its target: EN 1998-1, 3.2.3.1.2(4)b, asks for no
less, but values are rounded; US NRC SRP 3.7.1 has no ordinate above 1.3."""
AT_REST = 0.5
"""Velocity at the end of a record over the largest that is told: that of noise is well below."""
LEFT_OUT = 0.1
"""Part of the Arias intensity after the time that is computed; the significant duration leaves out
5 % after its end."""
SPECTRUM_RANGE = (0.2, 100.0, 200)  # lowest and highest frequency [Hz], points a decade


@results
class GroundMotion:
    """One component of the ground motion, with its response spectrum at one damping.

    A record has no target and no misfit; only synthetic motions are checked for acceptance, on
    request.
    """

    direction: str
    accelerogram: Accelerogram
    measures: Measures
    spectrum: ResponseSpectra
    target: Array | None  #: at the frequencies of the spectrum, (n_f,) [m/s2]
    misfit: Misfit | None
    acceptance: Acceptance | None = None
    target_pga: float | None = None  #: ordinate of the target at zero period, if known [m/s2]

    @property
    @quantity("m/s2", "largest spectral acceleration")
    def sa_max(self) -> float:
        """Largest ordinate of the response spectrum [m/s2]."""
        return float(self.spectrum.psa[0, 0].max())

    @property
    @quantity("Hz", "frequency of the largest spectral acceleration")
    def sa_max_frequency(self) -> float:
        """Frequency of the largest ordinate [Hz]."""
        return float(self.spectrum.frequency[self.spectrum.psa[0, 0].argmax()])

    @property
    @quantity("-", "misfit to the target, root mean square of ratio - 1")
    def misfit_rms(self) -> float | None:
        """Root mean square of the ratio to the target less 1; None without a target."""
        return None if self.misfit is None else self.misfit.rms

    @property
    @quantity("-", "largest ratio to the target, at the matched frequencies")
    def misfit_largest(self) -> float | None:
        """Largest ratio to the target; None without a target."""
        return None if self.misfit is None else self.misfit.largest_ratio

    @property
    @quantity("-", "smallest ratio to the target, at the matched frequencies")
    def misfit_smallest(self) -> float | None:
        """Smallest ratio to the target; None without a target."""
        return None if self.misfit is None else self.misfit.smallest_ratio

    @property
    @quantity("-", "peak ground acceleration / that of the target")
    def pga_over_target(self) -> float | None:
        """Peak ground acceleration over that of the target; None without a target."""
        known = self.misfit is not None and self.target_pga is not None
        return self.measures.pga / self.target_pga if known and self.target_pga else None

    @property
    def history(self) -> tuple[int, float, Array]:
        """Component (0, 1, 2), time step [s] and acceleration [m/s2]."""
        motion = self.accelerogram
        return "xyz".index(self.direction), motion.time_step, motion.acceleration


def ground_motions(motions: Sequence[Motion], *, accept: bool = False) -> tuple[GroundMotion, ...]:
    """Read or synthesise the motions of a case, in its order.

    On request (`accept`) synthetic motions are compared with a reviewer's criteria.

    Raises:
        InputError: A record or the table of a spectrum is not usable, or records are of another
            event, station or sensor than each other.
        SolutionError: A synthesis found no motion.
    """
    made, frequency = [], logarithmic_frequencies(*SPECTRUM_RANGE)
    records = {
        index: treated_record(motion)
        for index, motion in enumerate(motions)
        if isinstance(motion, RecordMotion)
    }
    if faults := conflicts(motions, records):
        raise InputError(faults)
    records = aligned(motions, records)
    for index, motion in enumerate(motions):
        target, misfit, accepted, level, damping = None, None, None, None, RECORD_DAMPING
        method: Method = "upsampled"
        if isinstance(motion, SyntheticMotion):
            damping = motion.damping
            design = design_spectrum(motion.spectrum, damping)
            synthetic = synthesise(
                design,
                duration=motion.duration,
                time_step=motion.time_step,
                strong_phase=motion.strong_phase,
                seed=motion.seed,
                pga=motion.pga,
                iterations=motion.iterations,
                matched=_matched(design, motion),
            )
            accelerogram, misfit = synthetic.accelerogram, synthetic.misfit
            target, level = design.pseudo_acceleration(frequency), _at_zero_period(design)
            if accept:
                highest = min(50.0, 0.5 / accelerogram.time_step)
                accepted = acceptance(accelerogram, design, maximum=highest)
        elif isinstance(motion, RecordMotion):
            accelerogram = records[index]
            # A step of the user's choice: the spectrum is that of the straight lines, too.
            if refined_step(accelerogram.time_step) is not None:
                method = "in-step"
        else:
            n_t = max(2, round(motion.duration / motion.time_step) + 1)
            accelerogram = Accelerogram(motion.time_step, np.zeros(n_t), "rest", "ground at rest")
        h, a = accelerogram.time_step, accelerogram.acceleration
        spectrum = response_spectra(a, h, frequency, [damping], method=method)
        fields = motion.direction, accelerogram, measures(accelerogram), spectrum
        made.append(GroundMotion(*fields, target, misfit, accepted, level))
    return tuple(made)


def plausibility_warnings(case: Case) -> list[Fault]:
    """Return plausibility warnings for the motions of a case and of its ensemble.

    Warned of are a synthetic motion whose peak differs from that of its target; the peak, time
    step, duration and final velocity of a record as the case uses it; and two motions that are the
    same. Motions that cannot be read are left out.
    """
    found = _same_motions(case)
    records = () if case.ensemble is None else case.ensemble.of_records(case.motions)
    together = dict[int, Accelerogram]()
    for index, motion in enumerate(case.motions):
        # Warnings and faults of the files were given when these were checked.
        with suppress(InputError), quiet(warnings=False):
            if isinstance(motion, RecordMotion):
                together[index] = treated_record(motion)
    together = aligned(case.motions, together)
    for index, motion in (*enumerate(case.motions), *enumerate(records, len(case.motions))):
        with suppress(InputError):
            if isinstance(motion, SyntheticMotion):
                found += _of_synthetic(case, index, motion)
            elif isinstance(motion, RecordMotion):
                if index < len(case.motions) and index not in together:
                    continue
                with quiet(warnings=False):
                    record = together.get(index) or treated_record(motion)
                found += _of_record(case, motion, record)
    return [*found, *same_directions(case.motions, together)]


def _same_motions(case: Case) -> list[Fault]:
    source, found = read_source(case.path, CaseFile), list[Fault]()
    for (i, a), (j, b) in combinations(enumerate(case.motions), 2):
        what, key = "", "seed"
        if isinstance(a, SyntheticMotion) and isinstance(b, SyntheticMotion) and a.seed == b.seed:
            what = "the seed"
        elif isinstance(a, RecordMotion) and isinstance(b, RecordMotion):
            key, same = "file", (a.file, a.component) == (b.file, b.component)
            what = "the record and component" if same else ""
        if what:
            text = f"{what} of motions[{i}] along {a.direction}, too: both go up and down together"
            found.append(source.remark(("motions", j, key), text))
    return found


def _of_synthetic(case: Case, index: int, motion: SyntheticMotion) -> Iterator[Fault]:
    """Warnings of the time step, the strong phase and the peak of a synthetic motion."""
    source, (low, high) = read_source(case.path, CaseFile), PEAK
    loss = straight_line_loss(motion.time_step, RIGID)
    if loss > COARSE:
        text = (
            f"the structure takes straight lines between the samples, which lose "
            f"{100 * loss:.2g} % of the amplitude at {RIGID:g} Hz: floor spectra are "
            "too low there; give time_step = '5 ms' or less"
        )
        yield source.remark(("motions", index, "time_step"), text)
    end = motion.strong_phase[1]
    if (case.pounding.duration or math.inf) < end:
        text = f"the strong phase of motions[{index}] lasts until {end:g} s"
        yield source.remark(("pounding", "duration"), text)
    level = _at_zero_period(design_spectrum(motion.spectrum, motion.damping))
    if level is not None and not low <= motion.pga / level <= high:
        text = (
            f"{motion.pga / level:.3g} times that of its spectrum at zero period, "
            f"{level:.4g} m/s2 with the soil; usual is the same"
        )
        yield source.remark(("motions", index, "pga"), text)


def _of_record(case: Case, motion: RecordMotion, record: Accelerogram) -> Iterator[Fault]:
    """Warnings of the direction, duration, peak, time step and end of a record."""
    computed = case.pounding.duration or math.inf
    along_z, of = motion.direction == "z", record.recording.orientation
    if of is not None and of.vertical != along_z:
        text = (
            f"{record.recording.component} is the name of a "
            f"{'vertical' if of.vertical else 'horizontal'} component: the spectra "
            f"along {motion.direction} would be those of another direction; give "
            f"{'the vertical one' if along_z else 'a horizontal one'} as file or "
            "component, or the direction that it has"
        )
        yield Fault(motion.file, "direction", motion.direction, text)
    # What the case itself says of either is warned of as its own.
    size = np.abs(record.acceleration)
    peak = float(size.max())
    late, whole = (np.sum(one**2) for one in (size[record.time > computed], size))
    if late > LEFT_OUT * whole:
        text = f"{100 * late / whole:.3g} % of its Arias intensity come later"
        yield Fault(motion.file, "pounding.duration", f"{computed:g} s", text)
    for what, value, unit, usual, given in (
        ("peak ground acceleration", peak, "m/s2", PGA, motion.pga),
        ("time step", record.sampling_step, "s", STEP, motion.resample),
        ("duration", record.duration, "s", LASTING, None),
    ):
        if given is None and not usual.low <= value <= usual.high:
            text = f"as the case uses it; usual is {usual.words}"
            yield Fault(motion.file, what, f"{value:.4g} {unit}", text)
    velocity = record.velocity
    last, most = abs(float(velocity[-1])), float(np.abs(velocity).max())
    if last > AT_REST * most:
        text = (
            f"{100 * last / most:.3g} % of the largest, as an offset or a cut leaves "
            "it; usual is a motion that ends at rest: see baseline of [[motions]]"
        )
        yield Fault(motion.file, "velocity at the end", f"{last:.3g} m/s", text)


def checked_durations(motions: Sequence[Motion], path: Path | None = None) -> list[float]:
    """Durations of a case's motions [s], whose records are read, treated and checked without a log.

    With the path of a case its records are compared with each other, and have one clock; without
    one they are those of an ensemble, each on its own.

    Raises:
        InputError: With the faults of all records, and of tables that no motion can be matched to;
            those of keys of a motion, such as its filter, are told of the case file of the path,
            of the record where none is given.
    """
    faults: list[Fault] = []
    durations, records = [], dict[int, Accelerogram]()
    for index, motion in enumerate(motions):
        try:
            if isinstance(motion, RecordMotion):
                with quiet():
                    record = treated_record(motion)
                if path is not None and motion.resample is None:
                    _report_refinement(motion.file, record)
                durations.append(record.duration)
                records[index] = record
                if not record.acceleration.any():
                    expected = "expected a record that is not zero throughout"
                    faults.append(Fault(motion.file, "", None, expected))
                continue
            durations.append(motion.duration)
            if isinstance(motion, SyntheticMotion):
                _matched(design_spectrum(motion.spectrum, motion.damping), motion)
        except InputError as error:
            faults += [
                replace(fault, file=path, key=f"motions[{index}].{fault.key}")
                if path is not None and fault.key in type(motion).model_fields
                else fault
                for fault in error.faults
            ]
    if path is not None:
        faults += conflicts(motions, records)
    if faults:
        raise InputError(faults)
    if path is not None:
        for index, record in aligned(motions, records, report=True).items():
            durations[index] = record.duration
    return durations


def _report_refinement(file: Path, record: Accelerogram) -> None:
    """Log the step to which a record was refined, and what straight lines would have lost."""
    step = record.sampling_step
    if record.time_step < step:
        highest = min(HIGHEST, 0.5 / step)
        LOGGER.info(
            "%s: time step refined from %.4g ms to %.4g ms, band-limited; straight lines between "
            "its samples would lose up to %.2g %% of the amplitude at %.3g Hz",
            file,
            1e3 * step,
            1e3 * record.time_step,
            100.0 * straight_line_loss(step, highest),
            highest,
        )


def treated_record(motion: RecordMotion) -> Accelerogram:
    """Read a record and do to it what the case says.

    The order: "mean" or "linear" baseline, taper, filter, resampling, baseline at rest
    (:class:`impactfem.motion.treatment.Treatment`), then the scale or the peak acceleration, which
    so holds for the motion that is used. Without `resample` a coarse step is refined
    (:func:`impactfem.motion.treatment.refined_step`). InputError where the file is at fault, or a
    step cannot be done on what it holds.
    """
    record = read_record(motion.file, motion.format, motion.component)
    step = motion.resample or refined_step(record.time_step)
    try:
        record = Treatment(motion.baseline, motion.taper, motion.filter, step)(record)
        if motion.scale != 1.0:
            record = record.scaled(motion.scale)
        return record if motion.pga is None else record.scaled_to_pga(motion.pga)
    except ImpactfemError as error:
        key = error.key if isinstance(error, TreatmentError) else ""
        raise InputError([Fault(motion.file, key, None, str(error))]) from error


def _at_zero_period(design: DesignSpectrum | TableSpectrum) -> float | None:
    """Its ordinate there, with the soil factor [m/s2]; None of a table that ends below 33 Hz."""
    if isinstance(design, TableSpectrum) and design.range[1] < RIGID:
        return None
    return float(design.pseudo_acceleration(np.inf))


def _matched(
    design: DesignSpectrum | TableSpectrum, motion: SyntheticMotion
) -> tuple[float, float] | None:
    """Frequencies at which a table can be met: its own, as far as the motion has them."""
    if not (isinstance(design, TableSpectrum) and isinstance(motion.spectrum, SpectrumTable)):
        return None
    low, high = default_range(motion.duration, motion.time_step)
    matched = (max(low, design.range[0]), min(high, design.range[1]))
    if not matched[0] < matched[1]:
        given = f"{design.range[0]:.4g} to {design.range[1]:.4g} Hz"
        expected = f"expected a range in common with the motion, {low:.4g} to {high:.4g} Hz"
        raise InputError([Fault(motion.spectrum.file, "frequency", given, expected)])
    return matched

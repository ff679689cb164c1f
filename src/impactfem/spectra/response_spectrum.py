"""Response spectra of many records at once, with a bound of the sampling error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.spectra.oscillator import FloatArray, StepCoefficients, step_coefficients
from impactfem.spectra.peaks import displacement_peaks, in_step_peak_responses, peak_responses
from impactfem.spectra.sampling import sampling_loss, upsample, upsampling_factor
from impactfem.system.errors import ImpactfemError

Method = Literal["upsampled", "in-step"]

_SAMPLES_AT_ONCE = 2**24  # of upsampled records, 128 MiB
_LONGEST_RECORD = 2**27  # samples of one upsampled record: 1 GiB, and more while it is made


@dataclass(frozen=True)
class ResponseSpectra:
    """Spectra of n_r records at n_d dampings and n_f frequencies, and how well they are sampled."""

    frequency: FloatArray  #: shape (n_f,) [Hz]
    damping: FloatArray  #: shape (n_d,) [-]
    sd: FloatArray  #: relative displacement max |x|, shape (n_d, n_r, n_f) [m]
    psv: FloatArray  #: pseudo-velocity ω Sd, shape (n_d, n_r, n_f) [m/s]
    psa: FloatArray  #: pseudo-acceleration ω² Sd, shape (n_d, n_r, n_f) [m/s2]
    sa: FloatArray  #: absolute acceleration max |x'' + a|, shape (n_d, n_r, n_f) [m/s2]
    #: zero-period acceleration, the largest |a| of the samples given, shape (n_r,) [m/s2]
    zpa: FloatArray
    #: the same of the series that the oscillators saw, shape (n_r,) [m/s2]: the limit of `sa` and
    #: `psa` at high frequency. Equal to `zpa` when nothing was upsampled
    zpa_interpolated: FloatArray
    method: Method  #: "upsampled" or "in-step"
    #: How many new steps an old one was cut into; 1 when none was needed [-].
    upsampling_factor: int
    points_per_cycle: float  #: samples in one cycle of the highest frequency, after upsampling [-]
    #: bound of the relative loss of `sd`, `psv` and `psa` by the samples,
    #: `sampling.sampling_loss` at `points_per_cycle`: straight lines
    #: between the samples and peaks at the samples, both. For what the records hold up to the
    #: highest frequency; what they hold above it loses more. 0 for "in-step", exact where the
    #: records are straight lines [-]
    peak_error_bound: float
    #: sinc²(1 / points_per_cycle): the amplitude that the straight lines between the samples leave
    #: of input at the highest frequency [-]
    interpolation_factor: float
    #: of the records as given [Hz]. Above it the records hold nothing; an oscillator above it is
    #: legitimate and its peak tends to the zero-period acceleration
    nyquist_frequency: float


def response_spectra(
    acceleration: npt.ArrayLike,
    time_step: float,
    frequencies: npt.ArrayLike,
    dampings: npt.ArrayLike,
    *,
    points_per_cycle: float = 20.0,
    method: Method = "upsampled",
    threads: int = 1,
    absolute: bool = True,
) -> ResponseSpectra:
    """Compute Sd, PSv, PSa, absolute Sa and ZPA for all records, dampings and frequencies.

    Oscillators start at rest; after the last sample the base stands still and the free vibration
    is followed to its exact maximum, so that a peak behind the end of a record is not lost.

    With "upsampled" every record is refined once by band-limited interpolation
    (:mod:`impactfem.spectra.sampling`), so that the highest frequency gets at least
    ``points_per_cycle`` samples a cycle; the peaks are then those at the samples. With "in-step"
    the records are taken as straight lines between their samples, and the maximum of the exact
    response inside each step is found; right where the input truly is piecewise linear.

    Args:
        acceleration: Records in rows, shape (n_r, n), or one record, shape (n,) [m/s2]; n >= 2.
        time_step: Step of the records [s].
        frequencies: Natural frequencies, shape (n_f,) [Hz], positive, in any order.
        dampings: Damping ratios, shape (n_d,) [-], 0 <= ratio < 1.
        points_per_cycle: Least number of samples in a cycle of the highest frequency, >= 2 [-]; not
            used by "in-step".
        method: See above.
        threads: Records are shared out to so many threads ("upsampled" only) [-].
        absolute: Whether ``sa`` is computed; nan without, in about half the time ("upsampled").

    Returns:
        The spectra, with the points per cycle reached and the bound of the loss by the samples.

    Raises:
        ImpactfemError: A record is too short or not finite, a parameter is out of range, or the
            upsampled record would be too long.
    """
    a = _records(acceleration)
    if not points_per_cycle >= 2.0:
        raise ImpactfemError(f"points per cycle must be at least 2, got {points_per_cycle!r}")
    if method not in get_args(Method):
        raise ImpactfemError(f"the method is one of {get_args(Method)}, got {method!r}")

    coarse = step_coefficients(time_step, frequencies, dampings)  # also validates the arguments
    f = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    d = np.atleast_1d(np.asarray(dampings, dtype=np.float64))
    h = coarse.time_step
    highest = float(f.max())
    zpa = np.abs(a).max(axis=1)
    if method == "in-step":
        factor, zpa_interpolated = 1, zpa
        sd, sa = in_step_peak_responses(a, coarse)
    else:
        factor, n = upsampling_factor(h, highest, points_per_cycle), a.shape[1]
        if n * factor > _LONGEST_RECORD:
            raise ImpactfemError(
                f"{points_per_cycle:g} points in a cycle of {highest:g} Hz make the {n} samples of"
                f" a record {factor} times finer, too many to hold; take a lower highest frequency,"
                " fewer points per cycle, or the method 'in-step'"
            )
        fine = step_coefficients(h / factor, f, d)
        sd, sa, zpa_interpolated = _upsampled_peaks(
            a, fine, factor, threads=threads, absolute=absolute
        )

    points = factor / (highest * h)
    shape = (a.shape[0], d.size, f.size)
    omega = 2.0 * np.pi * f
    displacement = np.ascontiguousarray(np.moveaxis(sd.reshape(shape), 1, 0))
    sampled = method == "upsampled"
    return ResponseSpectra(
        frequency=f,
        damping=d,
        sd=displacement,
        psv=displacement * omega,
        psa=displacement * omega**2,
        sa=np.ascontiguousarray(np.moveaxis(sa.reshape(shape), 1, 0)),
        zpa=zpa,
        zpa_interpolated=zpa_interpolated,
        method=method,
        upsampling_factor=factor,
        points_per_cycle=points,
        peak_error_bound=float(sampling_loss(points)) if sampled else 0.0,
        interpolation_factor=float(np.sinc(1.0 / points) ** 2),
        nyquist_frequency=0.5 / h,
    )


def _records(acceleration: npt.ArrayLike) -> FloatArray:
    """Records in rows, shape (n_r, n)."""
    a = np.ascontiguousarray(np.atleast_2d(np.asarray(acceleration, dtype=np.float64)))
    if a.ndim != 2 or a.shape[0] < 1 or a.shape[1] < 2:
        raise ImpactfemError(
            f"records must have shape (records, samples) with at least 2 samples, got {a.shape}"
        )
    if not np.all(np.isfinite(a)):
        first = int(np.argmin(np.isfinite(a).all(axis=1)))
        raise ImpactfemError(f"record {first} holds a value that is not a finite number")
    return a


def _upsampled_peaks(
    a: FloatArray, oscillators: StepCoefficients, factor: int, *, threads: int, absolute: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Peaks at the samples of records that are made finer, some records at a time.

    Returns:
        max |x| and max |x'' + a|, shape (n_r, n_o), and the largest sample, shape (n_r,).
    """
    sd, sa = np.empty((2, a.shape[0], oscillators.omega.size))
    largest = np.empty(a.shape[0])
    chunk = max(1, _SAMPLES_AT_ONCE // (a.shape[1] * factor))
    for first in range(0, a.shape[0], chunk):
        part = slice(first, first + chunk)
        fine = upsample(a[part], factor)
        if absolute:
            sd[part], sa[part] = peak_responses(fine, oscillators, threads=threads)
        else:
            sd[part] = displacement_peaks(fine, oscillators, threads=threads)
            sa[part] = np.nan
        largest[part] = np.abs(fine).max(axis=1)
    return sd, sa, largest

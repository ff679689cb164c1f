"""Response spectra of many records at once, with a bound of what their samples lose."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from scipy import fft

from impactfem.spectra.oscillator import StepCoefficients, step_coefficients
from impactfem.spectra.peaks import in_step_peak_responses, peak_responses
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError


def upsampling_factor(time_step: float, frequency: float, points_per_cycle: float) -> int:
    """Smallest whole factor that brings a record to the requested points in a cycle.

    max(1, ⌈points_per_cycle f h⌉), h the step of the record [s], f the highest frequency [Hz].
    """
    # The allowance keeps 20 points x 500 Hz x 1 ms at 10, whatever the rounding of the product.
    return max(1, math.ceil(points_per_cycle * frequency * time_step * (1.0 - 1e-12)))


def upsample(acceleration: Array, factor: int) -> Array:
    """Insert factor - 1 band-limited samples between the samples of each record.

    The discrete spectrum is continued by zeros, which interpolates by the periodic sinc function.
    Each record is first continued by zeros to at least twice its length: the interpolant of the
    last samples then fades out in the silence behind the record and does not come back at its
    beginning. The bin at the Nyquist frequency is halved, because its energy belongs to the
    positive and to the negative frequency alike; only so are the given samples kept.

    Args:
        acceleration: Records in rows, shape (n_r, n) [m/s2]. A record that begins or ends with a
            step rings there, as any band-limited signal with a step does.
        factor: Whole number of new steps in an old one, at least 1 [-].

    Gives records of the shape (n_r, (n - 1) factor + 1) [m/s2]; every factor-th sample is the given
    one to round-off. What the interpolant does after the last given sample is left out.
    """
    if factor < 1:
        raise ImpactfemError(f"the upsampling factor must be a whole number >= 1, got {factor}")
    if factor == 1:
        return acceleration
    n_records, n = acceleration.shape
    padded = 2 * fft.next_fast_len(n, real=True)
    fine = np.empty((n_records, (n - 1) * factor + 1))
    # Record by record: the padded spectra of a large ensemble at once would not fit in memory.
    for record, out in zip(acceleration, fine, strict=True):
        spectrum = fft.rfft(record, padded)
        spectrum[-1] *= 0.5
        out[:] = fft.irfft(spectrum, padded * factor)[: out.size]
    fine *= factor
    return fine


def sampling_loss(points_per_cycle: npt.ArrayLike) -> Array:
    """Bound of the relative loss of a peak that is read at n samples in a cycle.

    Let the base's motion hold nothing above a frequency f, of which n = 1 / (f Δt) samples make a
    cycle. Neither does the relative displacement x of any oscillator on it, and about its peak
    x_max at the time t it stays above a cosine (Duffin and Schaeffer 1938),

        x(t + τ) ≥ x_max cos(2πfτ),   |τ| ≤ 1 / 2f.

    The straight lines between the samples average x over ±Δt with the weights of a hat, which
    leaves sinc²(1/n) of that cosine at least; the sample that is nearest to the peak is within Δt/2
    of it, which leaves cos(π/n):

        loss ≤ 1 − sinc²(1/n) cos(π/n),   sinc(x) = sin(πx) / (πx),   n ≥ 3.

    An oscillator in resonance with a sine at f reaches it. Below three samples nothing is proved;
    at the Nyquist frequency, n = 2, nothing is left: the bound is 1, as for less. It has the shape
    of n [-].
    """
    n = np.maximum(np.asarray(points_per_cycle, dtype=np.float64), 2.0)
    return np.asarray(1.0 - np.sinc(1.0 / n) ** 2 * np.cos(np.pi / n), dtype=np.float64)


Method = Literal["upsampled", "in-step"]

_SAMPLES_AT_ONCE = 2**24  # of upsampled records, 128 MiB
_LONGEST_RECORD = 2**27  # samples of one upsampled record: 1 GiB, and more while it is made


@dataclass(frozen=True)
class ResponseSpectra:
    """Spectra of n_r records at n_d dampings and n_f frequencies, and how well they are sampled."""

    frequency: Array  #: shape (n_f,) [Hz]
    damping: Array  #: shape (n_d,) [-]
    sd: Array  #: relative displacement max |x|, shape (n_d, n_r, n_f) [m]
    psv: Array  #: pseudo-velocity ω Sd, shape (n_d, n_r, n_f) [m/s]
    psa: Array  #: pseudo-acceleration ω² Sd, shape (n_d, n_r, n_f) [m/s2]
    sa: Array  #: absolute acceleration max |x'' + a|, shape (n_d, n_r, n_f) [m/s2]
    #: zero-period acceleration, the largest |a| of the samples given, shape (n_r,) [m/s2]
    zpa: Array
    #: the same of the series that the oscillators saw, shape (n_r,) [m/s2]: the limit of `sa` and
    #: `psa` at high frequency. Equal to `zpa` when nothing was upsampled
    zpa_interpolated: Array
    method: Method  #: "upsampled" or "in-step"
    #: How many new steps an old one was cut into; 1 when none was needed [-].
    upsampling_factor: int
    points_per_cycle: float  #: samples in one cycle of the highest frequency, after upsampling [-]
    #: bound of the relative loss of `sd`, `psv` and `psa` by the samples, `sampling_loss` at
    #: `points_per_cycle`: straight lines between the samples and peaks at the samples, both. For
    #: what the records hold up to the highest frequency; what they hold above it loses more. 0 for
    #: "in-step", exact where the records are straight lines [-]
    peak_error_bound: float
    #: sinc²(1 / points_per_cycle): the amplitude that the straight lines between the samples leave
    #: of input at the highest frequency [-]
    interpolation_factor: float
    #: of the records as given [Hz]. Above it the records hold nothing; an oscillator above it is
    #: legitimate and its peak tends to the zero-period acceleration
    nyquist_frequency: float


def _check_sampling(points_per_cycle: float, method: str) -> None:
    """Refuse parameters that are out of range."""
    if not points_per_cycle >= 2.0:
        raise ImpactfemError(f"points per cycle must be at least 2, got {points_per_cycle!r}")
    if method not in get_args(Method):
        raise ImpactfemError(f"the method is one of {get_args(Method)}, got {method!r}")


def _upsampled(
    a: Array, fine: StepCoefficients, factor: int, threads: int, absolute: bool
) -> tuple[Array, Array, Array]:
    """Peaks of relative displacement and absolute acceleration, and ZPA, of refined records."""
    sd, sa = np.empty((2, a.shape[0], fine.omega.size))
    zpa = np.empty(a.shape[0])
    chunk = max(1, _SAMPLES_AT_ONCE // (a.shape[1] * factor))
    for first in range(0, a.shape[0], chunk):
        part = slice(first, first + chunk)
        finer = upsample(a[part], factor)
        sd[part], sa[part] = peak_responses(finer, fine, threads=threads, absolute=absolute)
        zpa[part] = np.abs(finer).max(axis=1)
    return sd, sa, zpa


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
    (:mod:`impactfem.spectra.response_spectrum`), so that the highest frequency gets at least
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
        absolute: Whether ``sa`` is computed; nan without, in a third of the time ("upsampled").

    Gives the spectra, with the points per cycle reached and the bound of the loss by the samples.
    ImpactfemError where a record is too short or not finite, a parameter is out of range, or the
    upsampled record would be too long.
    """
    a = _records(acceleration)
    _check_sampling(points_per_cycle, method)
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
        sd, sa, zpa_interpolated = _upsampled(a, fine, factor, threads, absolute)

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


def _records(acceleration: npt.ArrayLike) -> Array:
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

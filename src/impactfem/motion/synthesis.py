"""Synthetic ground motions whose response spectrum meets a design spectrum.

A sum of harmonics with random phases ϕ_k under an envelope e(t),

    a(t) = e(t) Σ_k A_k cos(2π f_k t + ϕ_k)                                              (1)

after Gasparini and Vanmarcke (1976), SIMQKE, MIT R76-4. The amplitudes start as those of a
stationary motion with the target as its spectrum, A_k ~ S_target(f_k) / √f_k, and are corrected
by the ratio of the target to the response spectrum that the motion has,

    A_k <- A_k S_target(f_k) / S(f_k)                                                    (2)

The phases and the envelope stay. Every time (1) is evaluated, two things are done before its
spectrum is taken, so that (2) sees and mends what they change:

* the peaks are brought to the requested peak ground acceleration. With k = 0.8 of it, a sample of
  size s = |a|/PGA > k becomes k + (1-k) u / (1 + (U-1) u/U), u = (s-k)/(1-k), U = u at the
  largest peak: smooth at k, ascending, and 1 at the largest. Smaller samples stay as they are;
  scaling the whole motion instead would move the whole spectrum;
* the end velocity and displacement are taken out
  (:class:`impactfem.motion.treatment.BaselineCorrection`).

Of all the motions visited the one with the least root mean square misfit is the result: (2) is
no descent method, and may leave a good motion again.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import fft

from impactfem.motion.acceptance import Misfit, spectral_misfit
from impactfem.motion.design_spectrum import Target
from impactfem.motion.treatment import BaselineCorrection
from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra import logarithmic_frequencies
from impactfem.spectra.oscillator import step_coefficients
from impactfem.spectra.peaks import peak_responses
from impactfem.spectra.response_spectrum import upsample, upsampling_factor
from impactfem.system.arrays import Array, Complex
from impactfem.system.errors import ImpactfemError, SolutionError

_KNEE = 0.8
_PER_DECADE = 40  # of the iteration; the misfit is reported on a denser list
_PEAK_PASSES = 100
_PEAK_TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False)
class SyntheticMotion:
    """A synthetic motion and how well it meets its target."""

    accelerogram: Accelerogram
    target: Target
    misfit: Misfit  #: of its response spectrum, over the matched frequencies
    iterations: int  #: corrections (2) that the motion went through; those after it did worse


def synthesise(
    target: Target,
    *,
    duration: float,
    time_step: float,
    strong_phase: tuple[float, float],
    seed: int,
    pga: float | None = None,
    iterations: int = 30,
    matched: tuple[float, float] | None = None,
) -> SyntheticMotion:
    """Make a motion whose response spectrum meets a design spectrum.

    The same arguments give the same motion, on any machine and number of cores, to round-off.

    Args:
        target: Design spectrum, with its damping.
        duration: Of the motion, a whole number of time steps [s].
        time_step: Of the motion [s].
        strong_phase: Begin and end of the strong phase, inside the duration [s].
        seed: Of the random phases (numpy's PCG64), >= 0.
        pga: Peak ground acceleration that the motion must have [m/s2]; None leaves it as it
            comes, near the zero-period acceleration of the target.
        iterations: Corrections of the amplitudes, >= 0.
        matched: Lowest and highest frequency at which the target is to be met [Hz]: at least one
            cycle in the duration, and not above the Nyquist frequency of the time step. Below
            half the lowest and above twice the highest the harmonics hold nothing. None means
            0.2 Hz to 50 Hz, or what the duration and 0.8 of the Nyquist frequency leave of it;
            the misfit of the result says which.

    Raises:
        ImpactfemError: An argument is out of range.
        SolutionError: The peak acceleration and the rest at the end cannot be had together.
    """
    matched = _check(seed, pga, iterations, matched, duration, time_step)
    n = round(duration / time_step) + 1
    f_k, carrier = _carrier(target, n, time_step, matched, seed)
    e = envelope(np.arange(n) * time_step, duration, strong_phase)
    at_rest = BaselineCorrection(n, time_step)
    frequency = logarithmic_frequencies(*matched, _PER_DECADE)
    required = target.pseudo_acceleration(frequency)
    factor = upsampling_factor(time_step, matched[1], 20.0)
    oscillators = step_coefficients(time_step / factor, frequency, [target.damping])

    def spectrum(acceleration: Array) -> Array:
        fine = upsample(acceleration[None, :], factor)
        return np.asarray(
            peak_responses(fine, oscillators, absolute=False)[0][0] * oscillators.omega**2
        )

    def harmonics() -> Array:
        return np.asarray(e * fft.irfft(carrier, 2 * (f_k.size - 1))[:n])

    # The level first: the iteration then corrects the shape.
    carrier *= np.exp(np.mean(np.log(required / spectrum(harmonics()))))
    best: Array = np.zeros(n)
    best_rms, best_iteration = math.inf, 0
    for iteration in range(iterations + 1):
        motion = at_rest(harmonics())
        if pga is not None:
            motion = _with_peak(motion, pga, at_rest)
        ratio = required / spectrum(motion)
        rms = float(np.sqrt(np.mean((1.0 / ratio - 1.0) ** 2)))
        if rms < best_rms:
            best, best_rms, best_iteration = motion, rms, iteration
        # Below the matched range, where no ratio is known, nothing may be added: a drift could be.
        carrier *= np.interp(f_k, frequency, ratio, left=min(1.0, float(ratio[0])))

    origin = f"synthetic, seed {seed}, {best_iteration} iterations"
    accelerogram = Accelerogram(time_step, best, "", origin)
    misfit = spectral_misfit(accelerogram, target, *matched)
    return SyntheticMotion(accelerogram, target, misfit, best_iteration)


def _with_peak(motion: Array, pga: float, at_rest: BaselineCorrection) -> Array:
    """Return the motion with a peak acceleration, at rest at its end.

    Each of the two corrections changes what the other one sets, less from pass to pass.
    """
    for _ in range(_PEAK_PASSES):
        motion = at_rest(_to_peak(motion, pga))
        if abs(np.abs(motion).max() / pga - 1.0) <= _PEAK_TOLERANCE:
            return motion
    raise SolutionError(
        f"no motion was found that has its peak at {pga!r} m/s2 and is at rest at its end"
    )


def envelope(time: npt.ArrayLike, duration: float, strong_phase: tuple[float, float]) -> Array:
    """Evaluate the envelope of a motion: quadratic rise, strong phase, exponential decay.

    The form is that of Jennings, Housner and Tsai (1968), "Simulated earthquake motions", Caltech
    EERL: with the strong phase from t_1 to t_2 and the duration T,

        e(t) = (t / t_1)²                    0   <= t <= t_1
        e(t) = 1                             t_1 <= t <= t_2
        e(t) = exp(-c (t - t_2))             t_2 <= t <= T,   c = ln(1 / e_T) / (T - t_2)

    so that e_T = 0.05 is left at the end. Over the last twentieth of the duration a straight line
    takes that rest to zero. Times [s] have shape (n,), as has the envelope [-].

    Raises:
        ImpactfemError: The strong phase does not lie inside the duration.
    """
    t, T = np.asarray(time, dtype=np.float64), duration
    t_1, t_2 = strong_phase
    if not 0.0 <= t_1 < t_2 <= T < math.inf:
        raise ImpactfemError(
            "the strong phase must lie inside the motion, 0 <= begin < end <= duration:"
            f" got {t_1!r} s to {t_2!r} s of {T!r} s"
        )
    level = np.ones_like(t)
    rising, falling = t < t_1, t > t_2
    level[rising] = (t[rising] / t_1) ** 2
    level[falling] = 0.05 ** ((t[falling] - t_2) / (T - t_2))
    return np.asarray(level * np.clip((T - t) / (0.05 * T), 0.0, 1.0))


def default_range(duration: float, time_step: float) -> tuple[float, float]:
    """0.2 Hz and 50 Hz, or what one cycle in the duration and 0.8 of the Nyquist one leave."""
    return max(0.2, 1.0 / duration), min(50.0, 0.4 / time_step)


def _carrier(
    target: Target, n: int, time_step: float, matched: tuple[float, float], seed: int
) -> tuple[Array, Complex]:
    """Frequencies f_k and starting values A_k exp(iϕ_k) of (1), up to a common factor."""
    period = fft.next_fast_len(n, real=True)
    period += period % 2
    f_k = np.arange(period // 2 + 1) / (period * time_step)
    low, high = matched
    edge = min(2.0 * high, float(f_k[-1]))
    band = np.clip(f_k / (0.5 * low) - 1.0, 0.0, 1.0) * np.clip(
        (edge - f_k) / max(edge - high, f_k[1]), 0.0, 1.0
    )
    amplitude = np.zeros(f_k.size)
    amplitude[1:] = target.pseudo_acceleration(f_k[1:]) / np.sqrt(f_k[1:]) * band[1:]
    phase = 2.0 * np.pi * np.random.Generator(np.random.PCG64(seed)).random(f_k.size)
    return f_k, amplitude * np.exp(1j * phase)


def _to_peak(acceleration: Array, pga: float) -> Array:
    """Bring the largest sample to the PGA, smoothly and without touching the small ones."""
    s = np.abs(acceleration) / pga
    top = float(s.max())
    knee = min(_KNEE, 0.5 * top)
    u, U = np.maximum(s - knee, 0.0) / (1.0 - knee), (top - knee) / (1.0 - knee)
    bent = u / (1.0 + (U - 1.0) * u / U)
    size = np.where(u > 0.0, knee + (1.0 - knee) * bent, s)
    return np.asarray(pga * np.copysign(size, acceleration))


def _check(
    seed: int,
    pga: float | None,
    iterations: int,
    matched: tuple[float, float] | None,
    duration: float,
    time_step: float,
) -> tuple[float, float]:
    """Refuse arguments out of range; gives the matched frequencies."""
    for name, value in (("time step", time_step), ("duration", duration)):
        if not 0.0 < value < math.inf:
            raise ImpactfemError(f"the {name} must be positive, got {value!r} s")
    steps = duration / time_step
    if abs(steps - round(steps)) > 1e-6 * max(steps, 1.0) or round(steps) < 16:
        raise ImpactfemError(
            "the duration must be a whole number of time steps, at least 16:"
            f" {duration!r} s are {steps:.6g} steps of {time_step!r} s"
        )
    if seed < 0 or iterations < 0:
        raise ImpactfemError(
            f"seed and iterations must not be negative, got {seed!r} and {iterations!r}"
        )
    if pga is not None and not 0.0 < pga < math.inf:
        raise ImpactfemError(f"the peak ground acceleration must be positive, got {pga!r} m/s2")
    low, high = default_range(duration, time_step) if matched is None else matched
    lowest, nyquist = 1.0 / duration, 0.5 / time_step
    if not lowest <= low < high <= nyquist:
        raise ImpactfemError(
            f"the matched frequencies must lie between {lowest:.4g} Hz (one cycle in the"
            f" duration) and {nyquist:.4g} Hz (Nyquist), got {low!r} and {high!r} Hz"
        )
    return low, high

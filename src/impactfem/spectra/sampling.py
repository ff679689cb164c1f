"""What the peak of an oscillator loses by the samples of its base's motion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def sampling_loss(points_per_cycle: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Bound of the relative loss of a peak that is read at samples.

    Let the base's motion hold nothing above a frequency f, of which n = 1 / (f Δt) samples make a
    cycle. Neither does the relative displacement x of any oscillator on it, and about its peak
    x_max at the time t it stays above a cosine (Duffin and Schaeffer 1938),

        x(t + τ) ≥ x_max cos(2πfτ),   |τ| ≤ 1 / 2f.

    The straight lines between the samples average x over ±Δt with the weights of a hat, which
    leaves sinc²(1/n) of that cosine at least; the sample that is nearest to the peak is within
    Δt/2 of it, which leaves cos(π/n):

        loss ≤ 1 − sinc²(1/n) cos(π/n),   sinc(x) = sin(πx) / (πx),   n ≥ 3.

    An oscillator in resonance with a sine at f reaches it. Below three samples nothing is proved;
    at the Nyquist frequency, n = 2, nothing is left: the bound is 1.

    Args:
        points_per_cycle: n, any shape [-]; at 2 or less the bound is 1.

    Returns:
        The bound, of the same shape [-].
    """
    n = np.maximum(np.asarray(points_per_cycle, dtype=np.float64), 2.0)
    return np.asarray(1.0 - np.sinc(1.0 / n) ** 2 * np.cos(np.pi / n), dtype=np.float64)

"""What the peak of an oscillator loses between the samples of its base's motion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def sampling_loss(points_per_cycle: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Bound of the relative loss of a resonant peak that is read at samples.

    An oscillator swings with its natural frequency f, of which n = 1 / (f Δt) samples make a
    cycle. The straight lines between the samples leave sinc²(1/n) of the motion that drives it,
    and the largest sample of its own motion is at least cos(π/n) of the peak:

        loss ≤ 1 − sinc²(1/n) cos(π/n),   sinc(x) = sin(πx) / (πx).

    At the Nyquist frequency, n = 2, nothing is sure: the bound is 1.

    Args:
        points_per_cycle: n, any shape [-]; at 2 or less the bound is 1.

    Returns:
        The bound, of the same shape [-].
    """
    n = np.maximum(np.asarray(points_per_cycle, dtype=np.float64), 2.0)
    return np.asarray(1.0 - np.sinc(1.0 / n) ** 2 * np.cos(np.pi / n), dtype=np.float64)

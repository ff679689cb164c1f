"""Peaks of the displacement of slow oscillators, in strides of many samples.

Over m samples the recurrence (4) of :mod:`impactfem.spectra.oscillator` is

    w_n+m = e^(mλh) w_n - h φ1² Σ_k e^((m-1-k)λh) a_n+k,    k = 0 ... m-1.                (1)

Where |λ| m h is at most 1, the weights of all oscillators are combinations of few columns, those of
their singular value decomposition up to rounding: the record is multiplied by these once, and what
is left for each oscillator is a product of short rows.

Inside a stride f = Im z departs from its chord by at most H²/8 times the largest |f''|, H = m h,
with f'' = Im(λ² z - λ a), so that

    |f| <= max(|f_n|, |f_n+m|) + H²/8 (ω² (|z_n| + H A) + ω_d A),    A = max |a|.         (2)

Only where this is above the largest |f| so far are the samples of a stride gone through, by (4):
the peaks are those of all samples.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from impactfem.spectra.oscillator import FUSED, StepCoefficients, larger, next_state
from impactfem.system.arrays import Array, Index

LENGTHS = 64, 32, 16
"""Samples of a stride: shorter ones gain nothing, longer ones little."""
LANES, LEAST = 8, 32
"""Oscillators in the widest register; the fewest that are worth the columns of their own."""
CACHE = 1 << 19
"""Size of the states at the ends of strides that are computed at once [byte]."""
ROUNDING = 1e-15
"""Singular values up to this part of the largest one are left out."""


class Table(NamedTuple):
    """Coefficients of the oscillators of `Strides`."""

    rows: Array
    far: Array
    bend: Array


@dataclass(frozen=True, eq=False)
class Strides:
    """Oscillators that go through a record in strides of one length."""

    length: int  #: samples m of a stride
    index: Index  #: the oscillators, shape (k,)
    #: Re and Im of their propagators, input gains and feedthroughs, shape (6, k).
    rows: Array
    columns: Array  #: which combinations of the samples count, shape (m, p)
    gains: Array  #: what they add to Re w, then to Im w of each, shape (p, 2 k) [s]
    far: Array  #: Re and Im of e^(mλh), shape (2, k)
    bend: Array  #: H² ω² / 8, and H² (ω² H + ω_d) / 8 [s], shape (2, k)

    def end(self, n: int) -> int:
        """Index of the sample at the end of the last stride in n samples."""
        return (n - 1) // self.length * self.length

    def follow(self, a: Array, state: Array, peak: Array) -> Array:
        """Raise the peaks of |Im z|, shape (k,) [m/s], up to the end of a record's last stride.

        From accelerations (n,) [m/s2] and Re and Im of the shifted state w at the first sample,
        shape (2, k) [m/s]; gives the state at the end of the last stride.
        """
        m, last = self.length, self.end(len(a))
        count, size, state = last // m, np.abs(a[: last + 1]), np.ascontiguousarray(state)
        largest = np.maximum(size[:-1].reshape(count, m).max(axis=1), size[m::m])
        at_once = max(1, CACHE // state.nbytes)
        w = np.empty((min(at_once, count) + 1, *state.shape))
        table = Table(self.rows, self.far, self.bend)
        for first in range(0, count, at_once):
            part = a[first * m : min(first + at_once, count) * m + 1]
            samples = part[:-1].reshape(-1, m)
            ends = w[: len(samples) + 1]
            added = ends[1:].reshape(len(samples), -1)
            np.matmul(samples @ self.columns, self.gains, out=added)
            _follow(part, m, table, largest[first:], ends, state, peak)
        return state


def strides_of(coefficients: StepCoefficients, rows: Array) -> tuple[list[Strides], Index]:
    """Strides of oscillators with their rows, shape (6, n_o), and those that are too fast."""
    c = coefficients
    y = c.rate * c.time_step
    speed, found = np.abs(y), list[Strides]()
    rest = np.argsort(speed)
    for m in LENGTHS:
        # As many as fill registers; the fastest that are left over take shorter strides.
        count = int(np.sum(m * speed[rest] <= 1.0)) // LANES * LANES
        if count >= LEAST:
            at, rest = np.sort(rest[:count]), rest[count:]
            weights = np.exp(np.outer(np.arange(m - 1, -1, -1), y[at])) * c.input_gain[at]
            U, s, V = np.linalg.svd(np.hstack([weights.real, weights.imag]), full_matrices=False)
            p = int(np.sum(s > ROUNDING * s[0]))
            far, H, omega = np.exp(m * y[at]), m * c.time_step, c.omega[at]
            bend = H**2 / 8.0 * np.array([omega**2, omega**2 * H + c.omega_d[at]])
            own, columns = np.ascontiguousarray(rows[:, at]), np.ascontiguousarray(U[:, :p])
            gains = s[:p, None] * V[:p]
            found.append(Strides(m, at, own, columns, gains, np.array([far.real, far.imag]), bend))
    return found, np.sort(rest)


@njit(nogil=True, cache=True, fastmath=FUSED)
def _follow(
    a: Array,
    m: int,
    table: Table,
    largest: Array,
    w: Array,
    state: Array,
    peak: Array,
) -> None:
    """Strides from a state on; w holds what the samples add, and then w at the ends of all."""
    rows, far, bend = table
    er, ei, br, bi, dr, di = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    fr, fi, by_state, by_input = far[0], far[1], bend[0], bend[1]
    r, s, k = state[0], state[1], len(peak)
    w[0] = state
    # (1), and the peaks at the ends of the strides.
    for i in range(1, len(w)):
        end, added_r, added_s = a[i * m], w[i, 0], w[i, 1]
        for j in range(k):
            r0, s0 = r[j], s[j]
            r[j] = added_r[j] + (fr[j] * r0 - fi[j] * s0)
            s[j] = added_s[j] + (fi[j] * r0 + fr[j] * s0)
            peak[j] = larger(s[j] + di[j] * end, peak[j])
        w[i] = state
    # (2) tells in which strides a peak may be inside.
    bound = np.empty(k)
    for i in range(len(w) - 1):
        begin, end, A, hits = a[i * m], a[(i + 1) * m], largest[i], 0
        r0, s0, s1 = w[i, 0], w[i, 1], w[i + 1, 1]
        for j in range(k):
            f, last = abs(s0[j] + di[j] * begin), abs(s1[j] + di[j] * end)
            z = f + abs(r0[j] + dr[j] * begin)
            f = f if f > last else last
            bound[j] = f + by_state[j] * z + by_input[j] * A
            hits += bound[j] > peak[j]
        if hits:
            for j in range(k):
                if bound[j] > peak[j]:
                    p, q, most = r0[j], s0[j], peak[j]
                    for n in range(i * m, (i + 1) * m):
                        most = larger(q + di[j] * a[n], most)
                        p, q = next_state(p, q, er[j], ei[j], br[j], bi[j], a[n])
                    peak[j] = most

"""Error of a reduced model: an estimate, and a bound.

The estimate: with the models nested in it, k, of some smaller sizes,

    |Δy| ≈ max over k of q_k |y − y_k|,   q_k = ‖w‖ / ‖w_k‖,   w = S Y z,

as maxima within thirds of an octave, times `NESTED_SAFETY`. Where the basis converges fast, the
difference is the error of the smaller model; w, what A x has outside the space, says how much
larger than that of the model it is. More than one nested model, as any may be near by chance. It
may be wrong.

Where the band is to be of use for any load, the space of the model is taken further to some larger
sizes N (Hain, Ohlberger, Radic and Urban, A hierarchical a posteriori error estimator for the
reduced basis method, Advances in Computational Mathematics 45 (2019) 2191). With their responses
y_N, nearer to the truth than y,

    |Δy| ≈ max over N of |y − y_N|,

as maxima within parts of an octave, times `LARGER_SAFETY`. This is the error itself but for that of
the larger models: it is too small where one of these is hardly better, or as wrong by chance, hence
several of them and the safety factor. Smaller models tell their own error, which is often far
larger than that of the model.

These hold for any law of damping. The bound, for an output y = lᵀ x, is known of Rayleigh damping
alone; there it holds always and needs no eigenvalue. The pencil is normal in the
inner product of K + σ0 M, where K + σ M has the eigenvalues (λ + σ) / (λ + σ0). None of them is
smaller than |Im σ| / |σ − σ0|, so that with ‖f‖² = fᴴ (K + σ0 M)⁻¹ f and the residual r

    |Δy| ≤ ‖l‖ ‖r‖ |σ − σ0| / (|1 + iωβ| |Im σ|).

It is some hundred times the error, more at low frequencies. (In the norm of M⁻¹, where |σ − σ0|
falls out, it would be five to a hundred times larger still.)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from impactfem.dynamics.damping import DampingLaw, Rayleigh
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import ReducedModel, reduced_model, shift_of
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

NESTED_SHARES = (0.95, 0.9, 0.85)
"""Sizes of the nested models over that of the basis."""
NESTED_SAFETY = 2.5
"""Measured on a building of 63,000 degrees of freedom with 80 to 300 vectors: the band is 1 to 10
times the error in 96 % of all thirds of an octave, probes and patterns where the error is above
0.1 % of the response, and smaller than the error in 2 %; on a membrane in 93 % and 5 %."""
LARGER_SHARES = (1.1, 1.15, 1.2)
"""Sizes of the larger models over that of the one that is used."""
LARGER_SAFETY = 1.75
"""Factor on their differences; how it was measured: `impactfem.reduction.response`."""
BANDS_AN_OCTAVE = 3
LEAST, MOST = 1.0, 10.0
"""Between which an effectivity, band over error, is good."""
NEGLIGIBLE = 1e-4
"""Error over the spectrum, as maxima within a third of an octave, that is not looked at."""


def nested_models(
    basis: KrylovBasis, shares: Sequence[float] = NESTED_SHARES
) -> list[ReducedModel]:
    """The model of a basis, and those of about shares of its size that the estimate compares it to.

    Raises:
        SolutionError: The basis has not taken a block step since the last loads came in.
    """
    sizes = [n for n in basis.sizes if n < basis.size and not np.any(basis.R[n:])]
    if not sizes:
        raise SolutionError("no smaller space of the reduced basis holds all loads: let it grow")
    nested = [min(sizes, key=lambda n: abs(n - share * basis.size)) for share in shares]
    return [reduced_model(basis), *(reduced_model(basis, n) for n in dict.fromkeys(nested))]


def larger_models(basis: KrylovBasis, size: int) -> list[ReducedModel]:
    """The models that one of some size is nested in; the basis grows where it has to. Collective.

    Of `LARGER_SHARES` of that size, or up to a block step more, one of each size. Where
    the space holds all that the loads can reach: the model that is used.
    """
    while basis.size < LARGER_SHARES[-1] * size and basis.grow(1) > 0:
        pass
    wanted = [
        min([n for n in basis.sizes if n >= share * size], default=basis.size)
        for share in LARGER_SHARES
    ]
    return [reduced_model(basis, n) for n in dict.fromkeys(wanted)]


def transfer_band(
    models: Sequence[ReducedModel], basis: Array, omega: Array, damping: DampingLaw
) -> Array:
    """Half width of the band on the size of transfer functions, as of `ReducedModel.transfer`.

    Of the model, and those nested in it; V at the probes, shape (n_probes, size); ω ascending,
    above zero, shape (n_freq,) [rad/s]. Shape (n_freq, n_probes, n_patterns) [m per unit of load].
    """
    responses = [m.transfer(basis, omega, damping) for m in models]
    outside = [m.outside(omega, damping) for m in models]
    size = [by_third_octave(omega, np.linalg.norm(w, axis=1)) for w in outside]
    found = np.zeros(responses[0].shape)
    for response, other in zip(responses[1:], size[1:], strict=True):
        apart = by_third_octave(omega, np.abs(responses[0] - response))
        # A smaller model that is no worse says nothing of how fast the basis converges.
        ratio = np.divide(size[0], other, out=np.ones_like(other), where=other > size[0])
        np.maximum(found, ratio[:, None, :] * apart, out=found)
    return NESTED_SAFETY * found


def transfer_bound(
    model: ReducedModel, probe_norm: Array, residual_norm: Array, omega: Array, damping: Rayleigh
) -> Array:
    """Bound on the error of transfer functions, in the modulus of the complex difference.

    By ‖l‖ of each probe (`KrylovBasis.dual_norm`), shape (n_probes,), and ‖r‖ (`residual_norms`),
    shape (n_freq, n_patterns). Shape (n_freq, n_probes, n_patterns) [m per unit of the load];
    infinite without damping, and at zero.
    """
    sigma = shift_of(omega, damping)
    with np.errstate(divide="ignore"):
        gain = np.abs(sigma - model.shift) / np.abs(sigma.imag)
    gain /= np.abs(1.0 + 1j * damping.beta * np.asarray(omega))
    return np.asarray(probe_norm[:, None] * (gain[:, None] * residual_norm)[:, None, :])


def by_third_octave(omega: Array, values: Array) -> Array:
    """The largest value within each third of an octave, at each frequency in it.

    The thirds of an octave are those around 1 kHz and its multiples by 2^(k/3). ω ascends above
    zero, shape (n_freq,) [rad/s]; the values, shape (n_freq, ...), are not negative.
    """
    number = np.round(BANDS_AN_OCTAVE * np.log2(np.asarray(omega) / (2.0e3 * np.pi)))
    _, first, band = np.unique(number, return_index=True, return_inverse=True)
    if not len(first):
        return np.array(values)
    return np.asarray(np.maximum.reduceat(values, first, axis=0)[band])


@dataclass(frozen=True, eq=False)
class Effectivity:
    """Band over error, of all spectra and thirds of an octave with an error to speak of."""

    ratio: Array  #: Band over error, shape (n,).
    spectrum: Index  #: Number of the spectrum of each, shape (n,).
    frequency: Array  #: Middle of the third of an octave of each, shape (n,) [Hz].

    @property
    def good(self) -> float:
        """Share of the ratios between 1 and 10; 1 where there is no error at all."""
        good = (self.ratio >= LEAST) & (self.ratio <= MOST)
        return float(np.mean(good)) if good.size else 1.0

    @property
    def misses(self) -> list[tuple[int, float, float]]:
        """Number of the spectrum, frequency [Hz] and ratio where the band is less, least first."""
        order = np.argsort(self.ratio)
        missed = order[self.ratio[order] < LEAST]
        return [
            (int(self.spectrum[k]), float(self.frequency[k]), float(self.ratio[k])) for k in missed
        ]


def effectivity(band: Array, computed: Array, truth: Array, frequency: Array) -> Effectivity:
    """Compare the half width of a band of computed spectra with their error.

    Of shape (n_spectra, n_frequencies) each; the frequencies ascend [Hz].
    """
    number = np.round(BANDS_AN_OCTAVE * np.log2(np.asarray(frequency) / 1e3))
    thirds, first = np.unique(number, return_index=True)
    widths, errors, size = (
        np.maximum.reduceat(values, first, axis=1).T
        for values in (band, np.abs(computed - truth), truth)
    )
    third, spectrum = np.nonzero(errors > NEGLIGIBLE * size)
    return Effectivity(
        ratio=widths[third, spectrum] / errors[third, spectrum],
        spectrum=np.asarray(spectrum, dtype=np.int64),
        frequency=1e3 * 2.0 ** (thirds[third] / BANDS_AN_OCTAVE),
    )


def together(parts: Sequence[Effectivity]) -> Effectivity:
    """Those of several cases as one."""
    return Effectivity(
        ratio=np.concatenate([one.ratio for one in parts]),
        spectrum=np.concatenate([one.spectrum for one in parts]),
        frequency=np.concatenate([one.frequency for one in parts]),
    )

"""How far a reduced model may be from the full one: an estimate, and a bound.

The estimate: with the models nested in it, k, of some smaller sizes,

    |Δy| ≈ max over k of q_k |y − y_k|,   q_k = ‖w‖ / ‖w_k‖,   w = S Y z,

as maxima within thirds of an octave, times `SAFETY`. Where the basis converges fast, the difference
is the error of the smaller model; w, what A x has outside the space, says how much larger than that
of the model it is. More than one nested model, as any may be near by chance. It may be wrong.

The bound, for an output y = lᵀ x, holds always and needs no eigenvalue. The pencil is normal in the
inner product of K + σ0 M, where K + σ M has the eigenvalues (λ + σ) / (λ + σ0). None of them is
smaller than |Im σ| / |σ − σ0|, so that with ‖f‖² = fᴴ (K + σ0 M)⁻¹ f and the residual r

    |Δy| ≤ ‖l‖ ‖r‖ |σ − σ0| / (|1 + iωβ| |Im σ|).

It is some hundred times the error, more at low frequencies. (In the norm of M⁻¹, where |σ − σ0|
falls out, it would be five to a hundred times larger still.)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import ReducedModel, nested_size, reduced_model, shift_of

Array = NDArray[np.float64]

SHARES = (0.95, 0.9, 0.85)
"""Sizes of the nested models over that of the basis."""
SAFETY = 2.5
"""Measured on a building of 63,000 degrees of freedom with 80 to 300 vectors: the band is 1 to 10
times the error in 96 % of all thirds of an octave, probes and patterns where the error is above
0.1 % of the response, and smaller than the error in 2 %; on a membrane in 93 % and 5 %."""
BANDS_AN_OCTAVE = 3


def nested_models(basis: KrylovBasis, shares: Sequence[float] = SHARES) -> list[ReducedModel]:
    """The model of a basis, and those nested in it that the estimate compares it with.

    Args:
        basis: The basis.
        shares: About the sizes of the nested models, over the size of the basis.

    Raises:
        SolutionError: The basis is too small.
    """
    sizes = dict.fromkeys(nested_size(basis, share) for share in shares)
    return [reduced_model(basis), *(reduced_model(basis, size) for size in sizes)]


def transfer_band(
    models: Sequence[ReducedModel], basis: Array, omega: Array, damping: Rayleigh
) -> Array:
    """Half width of the band on the size of transfer functions, as of `ReducedModel.transfer`.

    Args:
        models: The model, and those nested in it.
        basis: Rows of V at the probes, shape (n_probes, size).
        omega: ω, ascending, above zero, shape (n_freq,) [rad/s].
        damping: The damping.

    Returns:
        Shape (n_freq, n_probes, n_patterns) [m per unit of the load].
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
    return SAFETY * found


def transfer_bound(
    model: ReducedModel,
    probe_norm: Array,
    residual_norm: Array,
    omega: Array,
    damping: Rayleigh,
) -> Array:
    """Bound on the error of transfer functions, in the modulus of the complex difference.

    Args:
        model: The model.
        probe_norm: ‖l‖ of each probe, by `KrylovBasis.dual_norm`, shape (n_probes,).
        residual_norm: ‖r‖ by `Residual.norms`, shape (n_freq, n_patterns).
        omega: ω, shape (n_freq,) [rad/s]. Without damping, and at zero, the bound is infinite.
        damping: The damping.

    Returns:
        Shape (n_freq, n_probes, n_patterns) [m per unit of the load].
    """
    sigma = shift_of(omega, damping)
    with np.errstate(divide="ignore"):
        gain = np.abs(sigma - model.shift) / np.abs(sigma.imag)
    gain /= np.abs(1.0 + 1j * damping.beta * np.asarray(omega))
    return np.asarray(probe_norm[:, None] * (gain[:, None] * residual_norm)[:, None, :])


def by_third_octave(omega: Array, values: Array) -> Array:
    """The largest value within each third of an octave, at each frequency in it.

    Args:
        omega: ω, ascending, above zero, shape (n_freq,) [rad/s]. The thirds of an octave are those
            around 1 kHz and its multiples by 2^(k/3).
        values: Not negative, shape (n_freq, ...).
    """
    number = np.round(BANDS_AN_OCTAVE * np.log2(np.asarray(omega) / (2.0e3 * np.pi)))
    _, first, band = np.unique(number, return_index=True, return_inverse=True)
    if not len(first):
        return np.array(values)
    return np.asarray(np.maximum.reduceat(values, first, axis=0)[band])

"""How far a reduced model may be from the full one, told by larger models that it is nested in.

The space of the model, of n vectors, is taken further to some larger sizes N. With their responses
y_N, nearer to the truth than y,

    |Δy| ≈ max over N of |y − y_N|,

as maxima within parts of an octave, times `SAFETY`. This is the error itself but for that of the
larger models: it is too small where one of these is hardly better, or as wrong by chance, hence
several of them and the safety factor. Models smaller than the one that is used (see `error_band`)
tell their own error, which is often far larger than that of the model.

Hain, Ohlberger, Radic and Urban, A hierarchical a posteriori error estimator for the reduced basis
method, Advances in Computational Mathematics 45 (2019) 2191.
"""

from __future__ import annotations

from collections.abc import Sequence

from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import ReducedModel, reduced_model

SHARES = (1.1, 1.15, 1.2)
"""Sizes of the larger models over that of the one that is used."""
SAFETY = 1.75
"""Factor on the differences; how it was measured: `transient.band`."""


def larger_models(
    basis: KrylovBasis, size: int, shares: Sequence[float] = SHARES
) -> list[ReducedModel]:
    """The models that one of some size is nested in; the basis grows where it has to. Collective.

    Args:
        basis: The basis.
        size: Size of the model that is used.
        shares: Sizes of the larger models over that, each above 1, ascending.

    Returns:
        Models of the given sizes or up to a block step more, one of each size. Where the space
        holds all that the loads can reach: the model that is used.
    """
    while basis.size < shares[-1] * size and basis.grow(1) > 0:
        pass
    wanted = [
        min([n for n in basis.sizes if n >= share * size], default=basis.size) for share in shares
    ]
    return [reduced_model(basis, n) for n in dict.fromkeys(wanted)]

"""Forces of links with smooth laws at the new time of a step, for `march`.

The new forces F change the gaps without them, δ = δ_free + h W F and δ̇ = δ̇_free + W F; each is that
of its law,

    F_j = law_j(-δ_j, -δ̇_j).                                                               (1)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.law import Law
from impactfem.coupling.law_function import law_force
from impactfem.system.arrays import Array, Index

MAX_SWEEPS = 200
FREE_SWEEPS = 20
MAX_NEWTON = 200
_LOOP: Any = {"cache": True, "nogil": True, "forceinline": True, "_nrt": False}  # see `march`


class Laws(NamedTuple):
    """Laws of the links, and the states of their contacts."""

    force: Index  #: address of the compiled ``force`` of each link, shape (m,)
    advance: Index  #: address of its ``advance``; 0 for none
    jumps: NDArray[np.bool_]  #: the force begins with a jump at p = 0
    size: Index  #: number of parameters, and of state variables, shape (m, 2)
    parameters: Array  #: row by row, shape (m, largest number)
    state: Array  #: approach velocity, then the memory of the law, row by row

    @classmethod
    def of(cls, laws: list[Law]) -> Laws:
        """Gather the laws of all links."""
        m = len(laws)
        values = [law.parameters for law in laws]
        size = np.array([(len(x), 1 + law.n_state) for x, law in zip(values, laws, strict=True)])
        parameters = np.zeros((m, max(map(len, values), default=0)))
        for row, x in zip(parameters, values, strict=True):
            row[: len(x)] = x
        return cls(
            force=np.array([law.addresses[0] for law in laws], dtype=np.int64),
            advance=np.array([law.addresses[1] for law in laws], dtype=np.int64),
            jumps=np.array([law.jumps for law in laws], dtype=np.bool_),
            size=size.reshape(m, 2).astype(np.int64),
            parameters=parameters,
            state=np.zeros((m, int(size[:, 1].max()) if m else 1)),
        )


class LinkTrial(NamedTuple):
    """Gaps and forces of the links at the end of a step."""

    gap: Array  #: δ, shape (m,) [m]
    rate: Array  #: δ̇, between the steps that of the state, shape (m,) [m/s]
    F: Array  #: forces, shape (m,) [N]
    touches: NDArray[np.bool_]  #: the contact is closed, shape (m,)

    @classmethod
    def of(cls, m: int) -> LinkTrial:
        """Make room for m links."""
        return cls(np.empty(m), np.empty(m), np.zeros(m), np.zeros(m, dtype=np.bool_))


@numba.njit(**_LOOP)
def pair_force(
    laws: Laws, k: int, p_free: float, v_free: float, h: float, W: float
) -> tuple[float, float]:
    """Force of link k at the new time, given the motion that it would have without this force.

    Solves F = law(p, v) with p = p_free - h W F and v = v_free - W F by Newton's method (one
    iteration for a linear law), halving the bracket where a step leaves it. The pair is taken to
    touch: a law that jumps at p = 0 has no solution when its own force would open the gap within
    the step; then the force is that at p = 0.

    p_free and v_free are penetration and rate without this force, W is the velocity of the pair per
    force. Returns the force, nan if the iteration does not converge; and the size of the terms that
    add up to it, of which it can be a small difference.
    """
    tiny, law = 1e-300, laws.force[k]
    row, state = laws.parameters[k, : laws.size[k, 0]], laws.state[k, : laws.size[k, 1]]
    f, k_p, c = law_force(law, row, max(p_free, tiny), v_free, state)
    # The law falls with F, so the root of F - law lies between zero and the force at F = 0.
    low, high = min(0.0, f), max(0.0, f)
    F = 0.0
    outside = False
    size = abs(f) + k_p * abs(p_free) + c * abs(v_free)
    for _ in range(MAX_NEWTON):
        if f > F:
            low = F
        else:
            high = F
        # d(law)/dF = -W (h dF/dp + dF/dv).
        step = F + (f - F) / (1.0 + W * (h * k_p + c))
        if outside or not low <= step <= high:
            step = 0.5 * (low + high)
        change = abs(step - F)
        F = step
        if change <= 1e-13 * size:
            return F, size
        p = p_free - h * W * F
        f, k_p, c = law_force(law, row, max(p, tiny), v_free - W * F, state)
        outside = p < tiny and not laws.jumps[k]
        if p < tiny:
            k_p = 0.0
    return np.nan, 0.0


@numba.njit(**_LOOP)
def contact_forces(h: float, W: Array, laws: Laws, links: LinkTrial) -> bool:
    """Find the forces of all links at the new time, swept until they agree.

    Block Gauss-Seidel on δ = δ_free + h W F, δ̇ = δ̇_free + W F and the laws. A pair touches if it
    penetrates without its own force. Two pairs whose forces open each other's gap could alternate
    for ever where the law jumps at p = 0: after FREE_SWEEPS sweeps the closed pairs are kept.

    W, shape (m, m), is symmetric and positive semidefinite; gaps and rates are those without the
    new forces. Fills its F; returns whether the forces agree.
    """
    F, touches = links.F, links.touches
    m = F.size
    for sweep in range(MAX_SWEEPS):
        largest = 0.0
        change = 0.0
        for j in range(m):
            other = 0.0
            for k in range(m):
                if k != j:
                    other += W[j, k] * F[k]
            p_free = -links.gap[j] - h * other
            if sweep < FREE_SWEEPS:
                touches[j] = p_free > 0.0
            force, size = 0.0, 0.0
            if touches[j]:
                force, size = pair_force(laws, j, p_free, -links.rate[j] - other, h, W[j, j])
            if np.isnan(force):
                return False
            change = max(change, abs(force - F[j]))
            largest = max(largest, size)
            F[j] = force
        if change <= 1e-13 * largest:
            return True
    return change <= 1e-10 * largest

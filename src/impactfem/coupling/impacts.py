"""Impact events: when each pair touched, how hard, and what the law made of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.contact import Law, law_force
from impactfem.coupling.pounding import Pair, Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Impact:
    """One impact of one pair: a run of steps with a contact force.

    Args:
        pair: The pair.
        index: Its index in the system.
        first: Index of the first time with a force.
        last: Index of the last time with a force.
        start: Time when the gap closed, interpolated [s].
        end: Time when the force ended, interpolated [s].
        peak_time: Time of the largest force [s].
        peak_force: Largest force [N].
        impulse: Time integral of the force [N s].
        penetration: Largest penetration [m].
        approach: Speed of approach at the last time before the force, positive [m/s].
        separation: Speed of separation at the first time after it, positive when they part [m/s].
        dissipated: Energy that the contact law took over the impact, by the work of the force [J].
        defect: What the time stepping took besides the law: minus the work of the force on the
            buildings, less what the law takes along the same motion [J]; positive when energy was
            lost, negative when it was added.
    """

    pair: Pair
    index: int
    first: int
    last: int
    start: float
    end: float
    peak_time: float
    peak_force: float
    impulse: float
    penetration: float
    approach: float
    separation: float
    dissipated: float
    defect: float

    @property
    def duration(self) -> float:
        """Duration of the impact [s]."""
        return self.end - self.start

    @property
    def steps(self) -> int:
        """Number of computed times with a force."""
        return self.last - self.first + 1

    @property
    def restitution(self) -> float:
        """Speed of separation over speed of approach [-]; nan for a contact that begins at rest.

        The buildings' own forces act during the impact, too; for a point inside a storey, without
        mass of its own, it is no restitution of bodies.
        """
        return self.separation / self.approach if self.approach > 0.0 else math.nan


def impacts(response: Response) -> list[Impact]:
    """All impacts of a response in order of their start.

    An impact that is still going on when the response ends is left out of no sum: it is listed
    with the last time as its end.
    """
    found = []
    for index, pair in enumerate(response.system.pairs):
        force = response.force[:, index]
        touching = np.concatenate([[False], force != 0.0, [False]])
        edges = np.flatnonzero(np.diff(touching.astype(np.int8)))
        for first, after in edges.reshape(-1, 2):
            found.append(_impact(response, pair, index, int(first), int(after) - 1))
    return sorted(found, key=lambda impact: impact.start)


def _impact(response: Response, pair: Pair, index: int, first: int, last: int) -> Impact:
    dt = response.time_step
    n_t = response.time.size
    F = response.force[:, index]
    gap = response.gap[:, index]
    rate = response.gap_rate[:, index]
    # The step in which the gap closes and the one after the last force belong to the impact: a
    # lagged force begins a step or more after contact.
    low = max(first - 1, 0)
    while low > 0 and gap[low] < 0.0 and F[low - 1] == 0.0:
        low -= 1
    high = min(last + 1, n_t - 1)
    start = _crossing(dt, low, min(low + 1, first), gap)
    end = _crossing(dt, last, high, gap)
    window = slice(low, high + 1)
    f, g = F[window], gap[window]
    work = 0.5 * float(np.sum(np.diff(g) * (f[:-1] + f[1:])))
    taken = _taken_by_law(pair.law, -g, -rate[window], float(-rate[low]))
    peak = int(np.argmax(F[first : last + 1])) + first
    return Impact(
        pair=pair,
        index=index,
        first=first,
        last=last,
        start=start,
        end=end,
        peak_time=float(dt * peak),
        peak_force=float(F[peak]),
        impulse=float(np.sum(0.5 * dt * (f[:-1] + f[1:]))),
        penetration=float(np.max(-g)),
        approach=float(-rate[low]),
        separation=float(rate[high]),
        dissipated=-work,
        defect=-work - taken,
    )


def _taken_by_law(law: Law, p: Array, v: Array, v0: float) -> float:
    """Energy that the law itself takes along the computed motion, ∮ F(p, v) dp [J].

    Trapezoids between the computed states, and over the part of a step in which there is contact
    where it begins or ends inside one.
    """

    def force(p_: float, v_: float) -> float:
        return float(law_force(law.code, law.parameters, max(p_, 1e-300), v_, v0)[0])

    taken = 0.0
    for i in range(p.size - 1):
        p_0, p_1 = max(float(p[i]), 0.0), max(float(p[i + 1]), 0.0)
        if p_0 > 0.0 or p_1 > 0.0:
            # At the crossing the force is the law's at p = 0, with the speed outside the contact.
            F_0 = force(p_0, float(v[i]))
            F_1 = force(p_1, float(v[i + 1]))
            taken += 0.5 * (p_1 - p_0) * (F_0 + F_1)
    return taken


def _crossing(dt: float, i: int, j: int, gap: Array) -> float:
    """Time where the gap crosses zero between two times, or the later one where it does not."""
    if i == j or gap[i] * gap[j] > 0.0 or gap[i] == gap[j]:
        return float(dt * j)
    return float(dt * (i + (j - i) * gap[i] / (gap[i] - gap[j])))

"""Dynamic stiffness of soil by springs, dashpots and masses: what a time loop can take.

Of one component of the motion u of a raft, relative to the ground around it, the force is S u with

    S(ω) = K + iω C − ω² m + Σ_j −ω² m_j / (1 + iω/r_j) + Σ_j k_j iω / (r_j + iω):              (1)

a spring, a dashpot, a mass that moves with the raft, masses m_j that a dashpot m_j r_j ties to it
(the monkey-tail of Wolf and Meek), and springs k_j in series with a dashpot k_j/r_j (Maxwell's).
Each m_j, and each node between spring and dashpot, is a separate degree of freedom. With no
number below zero the model is stable and gives off no energy, whatever stands on it.

A table of S is fitted by (1): non-negative least squares over many rates r_j, in which few of the
numbers are not zero, then all of these at once. The errors of Re S are in parts of |S|, those of
Im S in parts of Im S: in parts of |S| they would hide an error of the damping as large as the
damping. The damping of rocking begins with ω³, and so does that of the masses m_j; a spring k_j
adds damping that begins with ω. A causal S with a given Im S has no other Re S than K - ω² m and
a part that follows from Im S, so that a table of two unrelated parts cannot be met in both.
Sources: Wolf, Foundation Vibration Analysis Using Simple Physical Models (1994), chapters 2 and 5;
Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.optimize

from impactfem.system.arrays import Array, Complex

Pairs = tuple[tuple[float, float], ...]

RATES = 25  # number of rates that a fit chooses among
OUTSIDE = 4.0  # how far they reach beyond the frequencies of the table, as a factor
NEGLIGIBLE = 1e-4  # elements that are below this part of S at all frequencies are left out
LOSS, SMALL = 1.3, 0.003
"""Elements go as long as the error is below this times that with all of them, or below this."""
FAR = 5.0  # how far a number may move from where it began, as a logarithm
REST = 0.8
"""Least stiffness at rest over the real part at the lowest frequency of a table, which is almost at
rest: a slow spring and dashpot in its place would not hold what rests on it. Material damping of
15 % makes it 0.8 from 0.5 Hz on."""
RESONANT = 0.07
"""Im S/|S| of formulas above which both errors count less: there nothing resonates."""
COUNTS = 0.2
"""Weight of the error of Im S, in parts of Im S, over the weight of the error of Re S, in parts of
|S|, in a fit to formulas: 5 % less damping changes a resonance about as much as 1 % less
stiffness."""
DAMPED = 0.01
"""Im S/|S| below which errors of the damping are in parts of this times |S|: half a per cent of
damping ratio hardly matters to a building."""
MAXWELL = 3
"""Elements that have the damping of the material, constant within 4 % over a factor of 20."""
PASSES = 100  # most iterations of non-negative least squares, for each column


@dataclass(frozen=True)
class Impedance:
    """Equation (1) of one component, translation or rotation."""

    stiffness: float  #: K [N/m, N m]
    dashpot: float = 0.0  #: C [N s/m, N m s]
    mass: float = 0.0  #: m [kg, kg m2]
    tails: Pairs = ()  #: masses m_j [kg, kg m2] and rates r_j [1/s]
    branches: Pairs = ()  #: stiffnesses k_j [N/m, N m] and rates r_j [1/s]

    def at(self, omega: npt.ArrayLike) -> Complex:
        """S(ω), of any shape [rad/s]."""
        s = 1j * np.asarray(omega, dtype=np.float64)
        S = self.stiffness + s * self.dashpot + s**2 * self.mass
        S = S + sum(s**2 * m / (1.0 + s / r) for m, r in self.tails)
        return np.asarray(S + sum(k * s / (r + s) for k, r in self.branches))

    def scaled(self, force: float, rate: float) -> "Impedance":
        """S times a factor at ω times another: from numbers without a unit to those of a site."""
        return Impedance(
            self.stiffness * force,
            self.dashpot * force / rate,
            self.mass * force / rate**2,
            tuple((m * force / rate**2, r * rate) for m, r in self.tails),
            tuple((k * force, r * rate) for k, r in self.branches),
        )

    def matrices(self) -> tuple[Array, Array, Array]:
        """M, C and K of the component and, after it, of the own degrees of freedom of (1)."""
        n = 1 + len(self.tails) + len(self.branches)
        M, C, K = np.zeros((3, n, n))
        M[0, 0], C[0, 0], K[0, 0] = self.mass, self.dashpot, self.stiffness
        between = np.array([[1.0, -1.0], [-1.0, 1.0]])
        for j, (m, r) in enumerate(self.tails, start=1):
            M[j, j] = m
            C[np.ix_([0, j], [0, j])] += m * r * between
        for j, (k, r) in enumerate(self.branches, start=1 + len(self.tails)):
            K[np.ix_([0, j], [0, j])] += k * between
            C[j, j] = k / r
        return M, C, K


@dataclass(frozen=True, eq=False)
class Curve:
    """Dynamic stiffness of one component against frequency."""

    omega: Array  #: ascending, above zero, shape (n,) [rad/s]
    S: Complex  #: same shape [N/m, N m]

    def scaled(self, force: float, rate: float) -> "Curve":
        """Scale the stiffness and the frequencies as :meth:`Impedance.scaled` does."""
        return Curve(self.omega * rate, self.S * force)

    def misfit(self, S: Complex) -> "Misfit":
        """Compute the errors of the values of a model at the frequencies of the curve."""
        off, size = S - self.S, np.abs(self.S)
        damping = np.abs(off.imag) / np.maximum(self.S.imag, DAMPED * size)
        return Misfit(self.omega, np.abs(off.real) / size, damping)


@dataclass(frozen=True, eq=False)
class Misfit:
    """Errors of a model of soil in one component against frequency."""

    omega: Array  #: shape (n,) [rad/s]
    stiffness: Array  #: |Re ΔS| / |S|, same shape [-]
    damping: Array  #: |Im ΔS| / Im S, with at least a hundredth of |S| below, same shape [-]

    def largest(self, low: float = 0.0, high: float = np.inf) -> Array:
        """Return the largest errors of stiffness and damping in a band [rad/s], shape (2,)."""
        ends = np.clip([low, high], self.omega[0], self.omega[-1])
        inside = self.omega[(self.omega > ends[0]) & (self.omega < ends[1])]
        band = np.concatenate([ends, inside])
        errors = (self.stiffness, self.damping)
        return np.array([np.interp(band, self.omega, one).max() for one in errors])


def fitted(
    curve: Curve,
    *,
    stiffness: float | None = None,
    dashpot: float | None = None,
    mass: bool = True,
) -> Impedance:
    """Fit the impedance (1) to a table.

    Args:
        curve: The table; its imaginary part not negative.
        stiffness: K, if it is known.
        dashpot: C, if it is known as the limit of Im S/ω at rest. All other damping then begins
            with ω³, and no Maxwell element is used, whose damping begins with ω.
        mass: Whether there may be a mass m that moves with the raft.
    """
    omega, S = curve.omega, curve.S
    rates = np.geomspace(omega[0] / OUTSIDE, omega[-1] * OUTSIDE, RATES)
    s, size = 1j * omega, np.abs(S)
    least = max(REST * float(S[0].real), 0.0) if stiffness is None else stiffness
    known = least + s * (dashpot or 0.0)
    share = S.imag / size
    # A table may hold damping of the material, which is no more causal: both parts count alike.
    counts, resonant = (1.0, np.inf) if stiffness is None else (COUNTS, RESONANT)
    damping = np.maximum(counts / (share + DAMPED), 1.0)
    weight = np.array([np.ones_like(share), damping]) / np.hypot(1.0, share / resonant)
    columns = [
        np.full_like(s, float(stiffness is None)),
        s * float(dashpot is None),
        s**2 * float(mass),
        *(s**2 / (1.0 + s / r) for r in rates),
        *(s * float(dashpot is None) / (r + s) for r in rates),
    ]
    A = np.column_stack(columns) / size[:, None]
    # Each column of length one: their numbers differ by orders of magnitude.
    length = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    right = (S - known) / size
    x, _ = scipy.optimize.nnls(
        np.vstack(weight[:, :, None] * np.array([A.real, A.imag])) / length,
        np.concatenate(weight * np.array([right.real, right.imag])),
        maxiter=PASSES * A.shape[1],
    )
    x = x / length
    x[np.abs(A * x).max(axis=0) < NEGLIGIBLE] = 0.0
    first, tails, branches = np.split(x, [3, 3 + RATES])
    start = Impedance(
        least + first[0],
        (dashpot or 0.0) + first[1],
        first[2],
        _merged(tails, rates),
        _merged(branches, rates),
    )
    fixed = (stiffness is not None, dashpot is not None)
    return _Fit(omega, S, weight, least, fixed).thinned(start)


def _merged(values: Array, rates: Array) -> Pairs:
    """Neighbours on the grid are one element at a rate between them."""
    there = np.flatnonzero(values > 0.0)
    groups = np.split(there, np.flatnonzero(np.diff(there) > 1) + 1) if there.size else []
    return tuple(
        (float(values[g].sum()), float(np.exp(values[g] @ np.log(rates[g]) / values[g].sum())))
        for g in groups
    )


@dataclass(frozen=True, eq=False)
class _Fit:
    """A table that an impedance is fitted to."""

    omega: Array
    S: Complex
    weight: Array  #: of the real and the imaginary part, shape (2, n)
    least: float  #: K, or the least K if it is not known
    fixed: tuple[bool, bool]  #: K known, C known

    def wrong(self, model: Impedance) -> Array:
        """Compute the weighted errors of a model in parts of |S|."""
        off = (model.at(self.omega) - self.S) / np.abs(self.S)
        return np.concatenate(self.weight * np.array([off.real, off.imag]))

    def error(self, model: Impedance) -> float:
        """Largest absolute real or imaginary part."""
        real, imaginary = np.split(self.wrong(model), 2)
        return float(np.hypot(real, imaginary).max())

    def thinned(self, start: Impedance) -> Impedance:
        """Elements taken out, one after the other, as long as the error hardly grows by it."""
        best = self.polished(start)
        limit = max(LOSS * self.error(best), SMALL)
        while True:
            # The element that matters least goes first.
            m, k = best.tails, best.branches
            fewer = [replace(best, tails=m[:j] + m[j + 1 :]) for j in range(len(m))]
            fewer += [replace(best, branches=k[:j] + k[j + 1 :]) for j in range(len(k))]
            loss = [float(np.abs(self.wrong(one) - self.wrong(best)).max()) for one in fewer]
            for j in np.argsort(loss):
                found = self.polished(fewer[j])
                if self.error(found) <= limit:
                    best = found
                    break
            else:
                return best

    def polished(self, start: Impedance) -> Impedance:
        """All numbers that are not zero at once, by their logarithms."""
        heads = np.array([start.stiffness, start.dashpot, start.mass])
        used = np.flatnonzero((heads > 0.0) & ~np.array([*self.fixed, False]))
        tails = len(start.tails)

        def make(x: Array) -> Impedance:
            values, head = np.exp(x), heads.copy()
            head[used] = values[: used.size]
            pairs = tuple((float(a), float(b)) for a, b in values[used.size :].reshape(-1, 2))
            K, C, m = map(float, head)
            return Impedance(K, C, m, pairs[:tails], pairs[tails:])

        numbers = np.array([*start.tails, *start.branches]).reshape(-1)
        x = np.log(np.concatenate([heads[used], numbers]))
        if not x.size:
            return start

        def slopes(x: Array) -> Array:
            """Of `wrong` by the logarithms, one column each."""
            model, s = make(x), 1j * self.omega
            of_heads = [model.stiffness + 0.0 * s, model.dashpot * s, model.mass * s**2]
            columns = [of_heads[k] for k in used]
            for m, r in model.tails:
                S = m * s**2 / (1.0 + s / r)
                columns += [S, S * s / (r + s)]
            for k, r in model.branches:
                S = k * s / (r + s)
                columns += [S, -S * r / (r + s)]
            J = np.column_stack(columns) / np.abs(self.S)[:, None]
            return np.concatenate(self.weight[:, :, None] * np.array([J.real, J.imag]))

        low, high = x - FAR, x + FAR
        # Rates stay where the fit chooses them: at a higher one a tail is but a mass of the raft.
        ends = np.log([self.omega[0] / OUTSIDE, self.omega[-1] * OUTSIDE])
        low[used.size + 1 :: 2] = ends[0] - NEGLIGIBLE
        high[used.size + 1 :: 2] = ends[1] + NEGLIGIBLE
        if not self.fixed[0] and self.least > 0.0:
            low[0] = np.log(self.least) - NEGLIGIBLE  # where x may be already
        found = scipy.optimize.least_squares(
            lambda x: self.wrong(make(x)), x, slopes, (low, high), max_nfev=50
        )
        return make(found.x)


def hysteresis(ratio: float, low: float, high: float) -> Impedance:
    """Material damping 1 + 2iζ of a spring of stiffness one, less that spring.

    Maxwell elements between two angular frequencies [rad/s] have the imaginary part. What is causal
    then grows stiffer with the frequency; a spring below zero keeps the elastic stiffness in the
    middle of the two. With the spring of stiffness one the model is stable as long as their sum is
    above zero: from 1 to 20 Hz for ζ up to 0.27.
    """
    omega, rates = np.geomspace(low, high, 60), np.geomspace(low, high, MAXWELL)
    s = 1j * omega[:, None]
    k, _ = scipy.optimize.nnls((s / (rates + s)).imag, np.full(60, 2.0 * ratio))
    branches = tuple((float(a), float(r)) for a, r in zip(k, rates, strict=True) if a > 0.0)
    middle = Impedance(0.0, branches=branches).at(np.array([np.sqrt(low * high)]))
    return Impedance(-float(middle[0].real), branches=branches)


def assembled(components: list[Impedance]) -> tuple[Array, Array, Array]:
    """M, C and K of several components and, after all of them, of their own degrees of freedom."""
    parts = [one.matrices() for one in components]
    firsts = np.cumsum([0, *(len(M) for M, _, _ in parts)])
    heads = firsts[:-1]
    order = [*heads, *(k for k in range(int(firsts[-1])) if k not in heads)]
    M, C, K = (
        np.asarray(scipy.linalg.block_diag(*(part[k] for part in parts)))[np.ix_(order, order)]
        for k in range(3)
    )
    return M, C, K

"""The misfit between a model and data, with deviations in a unit or as parts of the model's value.

A deviation in a unit, σ, gives the residual (m - d)/σ of the model's value m and the datum d.
A deviation that is a part s of the value belongs to the model's value: σ = s m. Taken of the datum,
it gives a datum that is too low by chance a small deviation and therefore a large weight: the
estimate is low by about 2 s² (1 - 1/n) for n data of one value. The minimum of Σ ((m - d)/(s m))²
is high by s² (1 - 1/n), because a large m makes the deviation large. The Gaussian likelihood adds
Σ ln(s m), which is not a sum of squares.

The quasi-likelihood (Wedderburn, Biometrika 61, 1974, 439-447; McCullagh and Nelder, Generalized
Linear Models, 1989, section 9.2 and table 9.1 with V(μ) = μ²) sets the mean of the score to zero,

    Σ (d - m)/(s m)² ∂m/∂u = 0,

for any distribution of the errors with mean 0 and standard deviation s m. Its integral is a sum of
squares, whose residuals are the deviance residuals

    r = sign(m - d) √(2 (t - ln(1 + t)))/s,    t = d/m - 1,    ∂r/∂m = (m - d)/((s m)² r).

Near m = d, r is (m - d)/(s m). The covariance of the estimate is that of weights 1/(s m)².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impactfem.system.arrays import Array

LEAST_RATIO = 0.01
"""m/d below which r goes on along its tangent, so that a search can return from zero and below."""


@dataclass(frozen=True, eq=False)
class Misfit:
    """Data and their standard deviations, shape (m,) each."""

    value: Array  #: the data in SI
    deviation: Array  #: standard deviations in SI, where they are no parts
    part: Array  #: standard deviations as parts of the model's value; 0 for those in SI

    def deviations(self, model: Array) -> Array:
        """Return the standard deviations in SI at values of the model, shape (m,) both."""
        size = np.maximum(np.abs(model), LEAST_RATIO * np.abs(self.value))
        return np.asarray(np.where(self.part > 0.0, self.part * size, self.deviation))

    def errors(self, model: Array) -> Array:
        """Return (model - datum)/deviation at values of the model, shape (m,) both.

        Their sum of squares is Pearson's χ² (McCullagh and Nelder 1989, section 4.4.5).
        """
        return (model - self.value) / self.deviations(model)

    def residuals(self, model: Array) -> Array:
        """Return the residuals that a fit minimises at values of the model, shape (m,) both."""
        return self._residuals(model)[0]

    def slopes(self, model: Array) -> Array:
        """Return ∂(residual)/∂(value of the model) of each datum, shape (m,) both."""
        return self._residuals(model)[1]

    def _residuals(self, model: Array) -> tuple[Array, Array]:
        """Return residuals and slopes."""
        parts = self.part > 0.0
        r = (model - self.value) / np.where(parts, 1.0, self.deviation)
        slope = 1.0 / np.where(parts, 1.0, self.deviation)
        d, s = self.value[parts], self.part[parts]
        ratio = model[parts] / d
        x = np.maximum(ratio, LEAST_RATIO)
        t = 1.0 / x - 1.0
        # √(2 (t - ln(1 + t)))/|t|, by its series where the difference loses digits.
        series = 1.0 - t * (2.0 / 3.0 - t * (0.5 - t * (0.4 - t / 3.0)))
        with np.errstate(divide="ignore", invalid="ignore"):
            square = np.where(np.abs(t) < 1e-3, series, 2.0 * (t - np.log1p(t)) / t**2)
        root = np.sqrt(square)
        per_ratio = 1.0 / (s * x * root)  # ∂r/∂(m/d) = -t/(s² x (-t root/s))
        r[parts] = np.sign(d) * (-t * root / s + (ratio - x) * per_ratio)
        slope[parts] = per_ratio / np.abs(d)
        return r, slope

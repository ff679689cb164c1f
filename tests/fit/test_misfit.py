"""The misfit of deviations that are parts: its arithmetic, and bias and coverage of fits."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from impactfem.fit.evaluate import evaluate
from impactfem.fit.misfit import LEAST_RATIO, Misfit
from impactfem.fit.problem import read_problem
from impactfem.verify import model_updating
from impactfem.verify.model_updating import FITS, Interpolated, files, repeat


def of_parts(value, part):
    value, part = np.atleast_1d(np.asarray(value, float)), np.atleast_1d(np.asarray(part, float))
    return Misfit(value, np.zeros_like(value), part)


@pytest.mark.parametrize("d", [0.02, -3.0, 1e9])
@pytest.mark.parametrize(
    "ratio", [-2.0, 0.0, 0.5 * LEAST_RATIO, 0.3, 1.0 - 1e-6, 1.0, 1.0 + 9.9e-4, 1.0011, 1.8, 1e4]
)
def test_the_slope_of_a_residual(d, ratio):
    """Against differences; also beyond the smallest ratio, where the residual is straight."""
    one, m, h = of_parts(d, 0.2), np.array([ratio * d]), 1e-6 * abs(d) * max(abs(ratio), 0.01)
    low, high = one.residuals(m - h), one.residuals(m + h)
    assert one.slopes(m) == pytest.approx((high - low) / (2.0 * h), rel=1e-5)
    assert one.slopes(m)[0] > 0.0
    assert np.sign(one.residuals(m)[0]) == np.sign(round(m[0] - d, 20))


def test_the_deviance():
    """r² = 2 (d/m - 1 - ln(d/m))/s², by the logarithm itself; near the datum (m - d)/(s m)."""
    m, s = np.array([0.4, 0.8, 1.3, 5.0]), 0.3
    found = of_parts(np.ones(4), np.full(4, s)).residuals(m)
    assert found**2 == pytest.approx(2.0 * (1.0 / m - 1.0 + np.log(m)) / s**2, rel=1e-12)
    near = of_parts([2.0], [s])
    assert near.residuals(np.array([2.0 + 1e-9]))[0] == pytest.approx(1e-9 / (2.0 * s), rel=1e-6)
    assert near.errors(np.array([2.5]))[0] == pytest.approx(0.5 / (2.5 * s))


def test_a_deviation_in_its_unit():
    """Stays what it is, whatever the model gives."""
    both = Misfit(np.array([3.0, 3.0]), np.array([0.5, 0.0]), np.array([0.0, 0.5]))
    m = np.array([4.0, 4.0])
    assert both.deviations(m) == pytest.approx([0.5, 2.0])
    assert both.residuals(m)[0] == pytest.approx(2.0) and both.slopes(m)[0] == pytest.approx(2.0)
    assert both.errors(m) == pytest.approx([2.0, 0.5])


@dataclass
class PowerLaw:
    """Frequencies with the root of the modulus, damping ratios with their key, shapes as they are.

    A cheap model in place of the modes of the stick.
    """

    problem: object
    first: np.ndarray
    executor: None = None

    def _powers(self):
        names = [datum.name for datum in self.problem.data]
        damping = [float(name.endswith("damping")) for name in names]
        return np.array([damping, [0.5 * name.endswith("frequency") for name in names]]).T

    def _over(self, u):
        return self.problem.values(u) / self.problem.values(self.problem.start)

    def values(self, u):
        return self.first * np.prod(self._over(u) ** self._powers(), axis=1)

    def slopes(self, u):
        slope = [key.slope(x) for key, x in zip(self.problem.fit.free.values(), u, strict=True)]
        return self.values(u)[:, None] * self._powers() * slope / self.problem.values(u)


def of_the_measured_value(datum, value):
    """The wrong rule: a deviation that is a part of what is measured."""
    return replace(datum, value=value, part=0.0, deviation=datum.part * value or datum.deviation)


def modes_of(tmp_path):
    problem, _ = read_problem(*files(tmp_path, model_updating.MODES))
    return PowerLaw(problem, np.array(evaluate(problem, problem.start, tmp_path).values))


def ordinates_of(tmp_path):
    """Ordinates that fall as the damping grows, some more and some less."""
    problem, _ = read_problem(*files(tmp_path, model_updating.SPECTRUM))
    powers = np.linspace(0.5, 1.0, len(problem.data))
    return Interpolated(problem, np.array([2.0 + powers, -powers]))


@pytest.mark.parametrize("model", [modes_of, ordinates_of])
def test_bias_and_coverage(tmp_path, model):
    """Of 200 fits: 20 % on six damping ratios, and 10 % on twelve ordinates."""
    cheap = model(tmp_path)
    found = repeat(cheap, cheap.problem.start)
    assert len(found.errors) == FITS
    assert abs(found.bias[0]) < 0.01
    assert found.within(0.683)[0] == pytest.approx(0.683, abs=0.04)
    assert found.within(0.95)[0] == pytest.approx(0.95, abs=0.04)
    assert found.together == pytest.approx(0.95, abs=0.04)
    # Parts of the measured values are seen.
    wrong = repeat(cheap, cheap.problem.start, datum=of_the_measured_value)
    assert abs(wrong.bias[0]) > 0.02
    if model is modes_of:
        assert wrong.bias[0] == pytest.approx(-0.062, abs=0.02)
        assert wrong.within(0.683)[0] < 0.683 - 0.04 and wrong.within(0.95)[0] < 0.95 - 0.04

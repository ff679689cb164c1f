"""The posterior of the keys of a fit, by an ensemble sampler."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from impactfem.fit.evaluate import evaluate
from impactfem.fit.problem import Problem
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError
from impactfem.system.least_squares import Identification
from impactfem.system.log import LOGGER


@dataclass(frozen=True, eq=False)
class Sample:
    """A sample of the posterior."""

    u: Array  #: places on the scale of the fit, shape (n_samples, n)
    acceptance: float  #: share of the steps that were accepted
    #: Autocorrelation time of each key, in steps; nan where the chain is too short for it, (n,).
    autocorrelation: Array

    def quantiles(self, problem: Problem, levels: tuple[float, ...]) -> Array:
        """Quantiles of the keys in SI, shape (n_levels, n)."""
        return np.array([problem.values(one) for one in np.quantile(self.u, levels, axis=0)])


def sample(problem: Problem, u: Array, found: Identification, folder: Path) -> Sample:
    """Sample exp(−½ χ²) inside the bounds, with priors, from around the fitted keys.

    By emcee (Foreman-Mackey et al. 2013), from the normal distribution of the linearised fit. The
    steps are not kept on disk.

    Args:
        problem: The problem.
        u: The fitted keys on the scale of the fit, shape (n,).
        found: What the data say about them.
        folder: The folder of the fit.

    Raises:
        InputError: emcee is not installed.
    """
    try:
        import emcee
    except ImportError as error:
        expected = "expected the package emcee: pip install 'impactfem[posterior]'"
        raise InputError([Fault(problem.path, "posterior", None, expected)]) from error
    setup = problem.fit.posterior
    if setup is None:
        raise ValueError("the fit has no posterior")
    value, deviation = problem.value, problem.deviation

    def logarithm(place: Array) -> float:
        if np.any(place < 0.0) or np.any(place > 1.0):
            return -math.inf
        r = (np.array(evaluate(problem, place, folder).values) - value) / deviation
        return -0.5 * float(r @ r + np.square(problem.prior_errors(place)).sum())

    rng = np.random.default_rng(problem.fit.seed)
    width = np.minimum(found.deviation, 0.3)
    start = u + width * rng.standard_normal((setup.walkers, len(u)))
    # Mirrored at the bounds.
    start = np.clip(np.abs(1.0 - np.abs(1.0 - start)), 1e-6, 1.0 - 1e-6)
    clock = perf_counter()
    logarithm(start[0])
    seconds = (perf_counter() - clock) * setup.walkers * setup.steps
    LOGGER.info("posterior: %d evaluations, about %.0f s", setup.walkers * setup.steps, seconds)
    state = np.random.RandomState(problem.fit.seed).get_state()
    sampler = emcee.EnsembleSampler(setup.walkers, len(u), logarithm)
    sampler.random_state = state
    sampler.run_mcmc(start, setup.steps, progress=False)
    kept = sampler.get_chain(discard=setup.steps // 5, flat=True)
    time = sampler.get_autocorr_time(discard=setup.steps // 5, quiet=True, tol=0)
    return Sample(np.asarray(kept), float(sampler.acceptance_fraction.mean()), np.asarray(time))

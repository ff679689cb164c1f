"""Model updating: bias and coverage of fits to data with a known truth and known errors."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import scipy.stats

from impactfem.fit.evaluate import evaluate
from impactfem.fit.fit import Evaluator, identified, search
from impactfem.fit.problem import Problem, read_problem
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark

FITS = 200
DAMPING, ORDINATE = 0.2, 0.1
"""Standard deviations of measured damping ratios and ordinates, as parts of the true values."""
CASE = """
title = "A measured stick"
[materials.concrete]
young_modulus = "30 GPa"
poisson_ratio = 0.2
density = "2500 kg/m3"
[damping]
ratio = "3 %"
frequencies = ["1 Hz", "20 Hz"]
[[buildings]]
name = "T"
material = "concrete"
floors = "floors.csv"
axis = ["7 m", "4 m"]
rigid_below = "0.4 m"
rigid_above = "0.1 m"
[[motions]]
direction = "y"
type = "synthetic"
seed = 1
pga = "1 m/s2"
duration = "4 s"
time_step = "5 ms"
strong_phase = ["1 s", "3 s"]
[motions.spectrum]
type = "ec8"
spectrum_type = 1
ground = "B"
reference_acceleration = "1 m/s2"
[pounding]
time_step = "2 ms"
[spectra]
damping = ["5 %"]
frequencies = { minimum = "0.5 Hz", maximum = "20 Hz", per_decade = 20 }
"""
FLOORS = (
    "floor,mass [t],Jx [kg m2],Jy [kg m2],Jz [kg m2],Ix [m4],Iy [m4],Iz [m4],A [m2],Avy [m2],"
    "Avx [m2],storey_height [m]",
    *(f"{k},130,6.93e5,2.12e6,2.82e6,60,90,2,4,0.0118,0.0118,3" for k in (1, 2, 3)),
)
RATIO = '[free."damping.ratio"]\nbounds = ["0.5 %", "9 %"]\n'
MODES = f"""{RATIO}
[free."materials.concrete.young_modulus"]
bounds = ["15 GPa", "45 GPa"]
[[targets]]
type = "modes"
building = "T"
modes = "modes.csv"
shapes = "shapes.csv"
frequency_deviation = 0.005
damping_deviation = {DAMPING}
"""
SPECTRUM = f"""{RATIO}
[[targets]]
type = "spectrum"
building = "T"
floor = 3
direction = "y"
damping = "5 %"
spectrum = "spectrum.csv"
deviation = {ORDINATE}
"""


@dataclass(frozen=True)
class Repeated:
    """The results of fits to the same data with other errors, shape (n_fits, n_keys) each."""

    errors: Array  #: (fitted - true)/true value of each key
    deviations: Array  #: standard deviation of each key that the fit gives, as part of the truth
    bounds: Array  #: the same of the ± within which all keys are together

    @property
    def bias(self) -> Array:
        """Mean error of each key, shape (n_keys,)."""
        return np.asarray(self.errors.mean(axis=0))

    def within(self, share: float) -> Array:
        """Return the share of the fits whose interval of this probability has the true value."""
        width = scipy.stats.norm.ppf(0.5 + 0.5 * share) * self.deviations
        return np.asarray((np.abs(self.errors) < width).mean(axis=0))

    @property
    def together(self) -> float:
        """Share of the fits whose ± have the true values of all keys."""
        return float((np.abs(self.errors) < self.bounds).all(axis=1).mean())


def repeat(
    evaluator: Any, truth: Array, count: int = FITS, datum: Callable[..., Any] = replace
) -> Repeated:
    """Fit data of a known truth with Gaussian errors, again and again.

    The errors are a Latin hypercube sample: each datum has the quantiles of its distribution once.

    Args:
        evaluator: The model, an `Evaluator`; each fit gives it a problem with other data.
        truth: The true keys on the scale of the fit, shape (n,).
        count: Number of fits.
        datum: Make the datum of a fit from one of the problem and its new value.
    """
    problem, true = evaluator.problem, evaluator.values(truth)
    of_keys, same = problem.values(truth), np.ones_like(true)
    widths = replace(problem.misfit, value=true).deviations(true)
    sample = scipy.stats.qmc.LatinHypercube(len(true), seed=1).random(count)
    found = []
    for z in scipy.stats.norm.ppf(sample):
        pairs = zip(problem.data, true + widths * z, strict=True)
        evaluator.problem = replace(problem, data=tuple(datum(one, value=x) for one, x in pairs))
        u = search(evaluator, [truth], same, 0.0 * same)[0].x
        known = identified(evaluator.problem, evaluator.values(u), evaluator.slopes(u))
        keys = zip(problem.fit.free.values(), u, strict=True)
        slopes = np.array([key.slope(float(x)) for key, x in keys]) / of_keys
        error = problem.values(u) / of_keys - 1.0
        found.append((error, known.deviation * slopes, known.bound * slopes))
    evaluator.problem = problem
    return Repeated(*(np.array(column) for column in zip(*found, strict=True)))


def files(folder: Path, fit: str) -> tuple[Path, Path]:
    """Write the case and the file of a fit with its tables; return the paths of both.

    The shapes are those of three equal masses on equal springs, along y and along x, which name
    the modes of the stick. All other values of the tables are replaced in the fits.
    """
    modes = [(d, k) for d in "yx" for k in (1, 2, 3)]
    shapes = [
        f"{number},7,4,{3 * floor},{axis},{(axis == d) * np.sin((2 * k - 1) * np.pi * floor / 7)}"
        for number, (d, k) in enumerate(modes, start=1)
        for floor in (1, 2, 3)
        for axis in "xy"
    ]
    frequencies = np.geomspace(1.0, 12.0, 12)
    texts = {
        "case.toml": [CASE],
        "floors.csv": FLOORS,
        "fit.toml": [fit],
        "modes.csv": ["mode,frequency [Hz],damping [%]", *(f"{k},3,3" for k in range(1, 7))],
        "shapes.csv": ["mode,x [m],y [m],z [m],direction,amplitude", *shapes],
        "spectrum.csv": ["frequency [Hz],psa [m/s2]", *(f"{f:.3f},3" for f in frequencies)],
    }
    for name, lines in texts.items():
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "case.toml", folder / "fit.toml"


def compare(rows: Rows, found: Repeated, key: str) -> None:
    """Write bias and coverage of the first key, and the coverage of all of them."""
    of = f"{key}, {len(found.errors)} fits"
    rows.add(f"bias of {of}", 0.0, found.bias[0], "-", 0.01)
    for share in (0.683, 0.95):
        quantity = f"truth within the {100.0 * share:g} % interval of {of}"
        rows.add(quantity, share, found.within(share)[0], "-", 0.04, absolute=True)
    rows.add(
        f"truth within the ± of all keys, {of}", 0.95, found.together, "-", 0.04, absolute=True
    )


@benchmark("fits of measured modes", "nominal probabilities of the intervals", heavy=True)
def fits_of_damping_ratios(rows: Rows) -> None:
    """Modulus and damping ratio of a stick, fitted to six measured modes with shapes.

    Errors: 20 % of each damping ratio, 0.5 % of each frequency, 5 % of the largest amplitudes.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        problem, _ = read_problem(*files(folder, MODES))
        compare(rows, repeat(Evaluator(problem, folder, None), problem.start), "damping ratio")


@benchmark("fits of a floor spectrum", "nominal probabilities of the intervals", heavy=True)
def fits_of_spectra(rows: Rows) -> None:
    """The damping ratio of a stick, fitted to twelve ordinates with errors of 10 % each.

    The model is the polynomial through runs at eight places between the bounds.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        problem, _ = read_problem(*files(folder, SPECTRUM))
        compare(rows, repeat(interpolated(problem, folder), problem.start), "damping ratio")


@dataclass
class Interpolated:
    """A model of one key u, log(values) = cᵀ (1, u, u², ...)."""

    problem: Problem
    c: Array  #: coefficients, shape (n_powers, m)
    executor: None = None

    def values(self, u: Array) -> Array:
        """Return the values of the data, shape (m,)."""
        return np.asarray(np.exp(u[0] ** np.arange(len(self.c)) @ self.c))

    def slopes(self, u: Array) -> Array:
        """Return their slopes, shape (m, 1)."""
        powers = np.arange(1, len(self.c))
        per_value = powers * u[0] ** (powers - 1) @ self.c[1:]
        return np.asarray(self.values(u) * per_value)[:, None]


def interpolated(problem: Problem, folder: Path, places: int = 8) -> Interpolated:
    """Return the polynomial model of a problem with one key, from runs in a folder."""
    u = 0.5 - 0.5 * np.cos(np.pi * (np.arange(places) + 0.5) / places)
    values = np.array([evaluate(problem, np.array([x]), folder).values for x in u])
    return Interpolated(problem, np.linalg.solve(np.vander(u, increasing=True), np.log(values)))

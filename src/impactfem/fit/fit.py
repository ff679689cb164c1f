"""The fit: searches from several starts, correction by the case itself, identifiability."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import scipy.optimize
import scipy.stats

from impactfem.case import Case
from impactfem.fit.evaluate import Evaluation, evaluate
from impactfem.fit.fit_file import ModesTarget
from impactfem.fit.plausibility import warn_of_far_targets, warn_of_implausible
from impactfem.fit.problem import Problem, read_problem
from impactfem.fit.results import FITTED, Fit, write_results
from impactfem.run.folder import open_folder
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, ImpactfemError, InputError, SolutionError, file_errors
from impactfem.system.executor import workers
from impactfem.system.files import StrPath
from impactfem.system.least_squares import (
    BLIND,
    Identification,
    Minimum,
    minima,
    solutions,
    starts_within,
)
from impactfem.system.log import LOGGER, mirrored
from impactfem.system.parallel import on_root, one_blas_thread, rank, start_solvers, world

LOG = "fit.log"  # distinguishes the folder of a fit from any other
EVALUATIONS = "evaluations.jsonl"
CLOSE, ALIKE = 0.02, 0.9
"""Relative distance of frequencies up to which modes may mix, and the MAC from which two shapes
are those of one mode (as Ewins, Modal Testing, 2000)."""
SAME = 0.05
"""Change of the keys, in their standard deviations, below which a correction is the last one."""
MOST_ROUNDS = 8
ON_BOUND = 1e-9
"""Distance from a bound, as a part of the range, up to which a place is taken as on it."""


class Evaluator:
    """Evaluations of a problem, each computed once and kept on disk; on rank 0.

    Args:
        problem: The problem.
        folder: The folder of the fit.
        executor: Computes several at a time; None for one after the other.
    """

    def __init__(self, problem: Problem, folder: Path, executor: Executor | None) -> None:
        self.problem, self.folder, self.executor = problem, folder, executor
        self.file, self.lock = folder / EVALUATIONS, Lock()
        self.known: dict[str, Evaluation] = {}
        self.used: set[str] = set()  #: those of this fit
        # Anything else, a named pipe for example, may wait for ever where it is read or written.
        if self.file.exists() and not self.file.is_file():
            expected = "not a regular file; delete it, or give another folder with --out"
            raise InputError([Fault(self.file, "", None, expected)])
        damaged, kept = 0, self.file.read_bytes() if self.file.exists() else b""
        self.half = kept[-1:] not in (b"", b"\n")  # the last line of a fit that was killed
        for line in filter(None, kept.split(b"\n")):
            try:
                key, entry, digest = json.loads(line)
                if digest != _digest(key, entry):
                    raise ValueError("another hash")
                found = Evaluation(**entry)
            except (ValueError, TypeError, RecursionError):
                damaged += 1
                continue
            # Values serve any fit, slopes one with the same bounds; None holds for all.
            if found.scale != problem.scale and any(found.slopes or ()):
                found = replace(found, slopes=None)
            if found.slopes is not None or key not in self.known:
                self.known[key] = found
        if damaged:
            LOGGER.warning("warning: %s: damaged lines: %d; computed again", self.file, damaged)

    def at(self, u: Array, slopes: bool = False) -> Evaluation:
        """Return the evaluation at places on the scale of the fit, with the known slopes."""
        u = _on_bounds(u)
        key = self.problem.key(u)
        self.used.add(key)
        found = self.known.get(key)
        if found is not None and (not slopes or found.slopes is not None):
            return found
        given = self.problem, u, self.folder, slopes
        if self.executor is None:
            found = evaluate(*given)
        else:
            found = self.executor.submit(evaluate, *given).result()
        with self.lock:
            self.known[key] = found
            with self.file.open("a", encoding="utf-8") as stream:
                entry = asdict(found)
                line = json.dumps([key, entry, _digest(key, entry)])
                stream.write("\n" * self.half + f"{line}\n")
                self.half = False
        return found

    def values(self, u: Array) -> Array:
        """Return the values of the model for the data, shape (m,)."""
        return np.array(self.at(u, slopes=True).values)  # which a search needs at the same place

    def slopes(self, u: Array) -> Array:
        """Their slopes, shape (m, n): closed forms, or differences computed at a time."""
        u = _on_bounds(u)
        here = self.at(u, slopes=True)
        known = here.slopes or []
        ends = {k: self.problem.ends(u, k) for k, one in enumerate(known) if one is None}
        if self.problem.level == "run":  # each costs a run: to one side only
            ends = {k: (u, high) if high[k] > u[k] else (low, u) for k, (low, high) in ends.items()}
        places = [place for both in ends.values() for place in both]
        if self.executor is None:
            found = [np.array(self.at(place).values) for place in places]
        else:
            with ThreadPoolExecutor(max(len(places), 1)) as threads:
                found = [np.array(one.values) for one in threads.map(self.at, places)]
        J = np.empty((len(here.values), len(u)))
        for k, one in enumerate(known):
            if one is not None:
                J[:, k] = one
        for i, (k, (low, high)) in enumerate(ends.items()):
            J[:, k] = (found[2 * i + 1] - found[2 * i]) / (high[k] - low[k])
        if not np.isfinite(J).all():
            names = [
                key
                for key, of_key in zip(self.problem.keys, J.T, strict=True)
                if not np.isfinite(of_key).all()
            ]
            raise SolutionError(f"the model has no finite slope by {', '.join(names)}")
        return J


def _digest(key: Any, entry: Any) -> str:
    """Hash of an evaluation as it is kept."""
    return hashlib.sha256(json.dumps([key, entry]).encode()).hexdigest()


def _on_bounds(u: Array) -> Array:
    """Places, with those next to a bound on it: a search starts 1e-10 inside, never there."""
    return np.where(u < ON_BOUND, 0.0, np.where(u > 1.0 - ON_BOUND, 1.0, u))


def fit(
    path: StrPath, fit_path: StrPath, *, out: StrPath | None = None, processes: int = 1
) -> Fit | None:
    """Fit keys of a case to data.

    Evaluations are kept in the folder: the same fit again goes on where it was stopped. Collective
    under `mpirun`: rank 0 hands evaluations out, the other ranks compute one each at a time.

    Args:
        path: The case file.
        fit_path: The file of the fit (TOML).
        out: The folder; ``runs/<name of the file of the fit>`` when None.
        processes: How many evaluations are computed at a time, each in a process of its own.
            Without meaning under `mpirun`.

    Returns:
        The results on rank 0; None on the others.

    Raises:
        InputError: The case, the fit or the folder is not usable; nothing is computed then.
        SolutionError: A computation failed, or no start led to a result.
        ImpactfemError: A file cannot be written.
    """
    path, fit_path = Path(path), Path(fit_path)
    folder = Path(out) if out is not None else Path("runs") / fit_path.stem
    with ExitStack() as opened:
        opened.enter_context(file_errors())
        opened.enter_context(one_blas_thread())
        start_solvers()

        def prepare() -> tuple[Problem, Problem | None]:
            both = read_problem(path, fit_path)
            opened.enter_context(open_folder(folder, resume=False, log=LOG))
            return both

        problem, rough = on_root(prepare)
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())
        if world() is None and processes == 1:
            return _fit(problem, rough, folder, None)
        with workers(processes) as executor:
            return None if executor is None else _fit(problem, rough, folder, executor)


def _fit(problem: Problem, rough: Problem | None, folder: Path, executor: Executor | None) -> Fit:
    """Fit the problem on rank 0."""
    warn_of_implausible(problem)
    LOGGER.info(
        "fit of %d keys to %d data by %s -> %s",
        len(problem.keys),
        len(problem.data),
        {
            "sticks": "the modes of the sticks",
            "floors": "the mesh",
            "modes": "the modes of the 3D model",
            "run": f"runs up to {', '.join(problem.stages)}",
        }[problem.level],
        folder,
    )
    fine = Evaluator(problem, folder, executor)
    cheap = fine if rough is None else Evaluator(rough, folder, executor)
    first = problem.start
    low, high = np.zeros_like(first), np.ones_like(first)
    drawn = starts_within(first, low, high, problem.fit.starts, problem.fit.seed)
    # Without a cheaper case the search needs the slopes there as well.
    before = np.array(fine.at(first, slopes=rough is None).values)
    warn_of_far_targets(problem, before.tolist())
    if rough is None:
        none = np.ones_like(before), np.zeros_like(before)
        minima_of = Corrected(search(cheap, drawn, *none), none[0], 0)
    else:
        minima_of = corrected(fine, cheap, drawn)
    found, ratio, u = minima_of.minima, minima_of.ratio, minima_of.x
    J = ratio[:, None] * cheap.slopes(u)
    last = fine.at(u)
    weighted = J / problem.misfit.deviations(np.array(last.values))[:, None]
    identification = Identification.of(weighted, _prior_rows(problem))
    # A slope says what data see from here. A gap where nothing touches has none, but a bound where
    # something does.
    across = {k: _across(cheap, u, k, ratio) for k in identification.unseen}
    # A key that the data do not see has a random value where the best search had a random start. It
    # gets that of the first start, unless the data then change after all.
    free, keys = problem.fit.free, problem.keys
    unseen = [k for k in identification.unseen if free[keys[k]].prior is None]
    reset = u.copy()
    reset[unseen] = first[unseen]
    again, values = fine.at(reset), np.array(last.values)
    change = (np.array(again.values) - values) / problem.misfit.deviations(values)
    if float(np.linalg.norm(change)) < BLIND:
        u, last = reset, again
    result = Fit(
        folder,
        problem,
        u,
        tuple(found),
        solutions(found, np.vstack([weighted, _prior_rows(problem)])),
        before,
        np.array(last.values),
        last.shown,
        J,
        identification,
        across,
        len(fine.used | cheap.used),
        minima_of.rounds,
    )
    result.warnings.extend(_warnings(result))
    for text in result.warnings:
        LOGGER.warning("warning: %s", text)
    return write_results(result)


@dataclass(frozen=True, eq=False)
class Corrected:
    """The minima of the first search, and the last correction of a cheaper case."""

    minima: list[Minimum]  #: of the first search, the best one first
    ratio: Array  #: values of the case over those of the cheaper one, shape (m,)
    rounds: int  #: number of corrections
    last: Array | None = None  #: places after the last correction; None without one

    @property
    def x(self) -> Array:
        """The best places on the scale of the fit, shape (n,)."""
        return self.minima[0].x if self.last is None else self.last


def corrected(fine: Evaluator, cheap: Evaluator, starts: list[Array]) -> Corrected:
    """Search with a cheaper case, corrected by the case itself until the keys settle.

    The cheaper case gives the slopes, the case itself the level: the values of both at the last
    places correct the cheaper one (Bandler et al. 1994). SolutionError where they do not settle.
    """
    problem, u = fine.problem, starts[0]
    found: list[Minimum] = []
    for rounds in range(MOST_ROUNDS + 1):
        here, there = np.array(fine.at(u).values), cheap.values(u)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = here / there
        # Of values near zero, or of either sign, the difference alone corrects.
        ratio = np.where((ratio > 0.5) & (ratio < 2.0), ratio, 1.0)
        J = ratio[:, None] * cheap.slopes(u)
        widths = np.minimum(identified(problem, here, J).deviation, 1.0)
        hardly = np.maximum(SAME * widths, 1e-5)
        # The known slopes mostly show, without a search, that it would not move the keys.
        if rounds and np.all(np.abs(_step(problem, u, here, J)) <= hardly):
            return Corrected(found, ratio, rounds, u)
        ended = search(cheap, starts if rounds == 0 else [u], ratio, here - ratio * there)
        found = found or ended
        if rounds and np.all(np.abs(ended[0].x - u) <= hardly):
            return Corrected(found, ratio, rounds, u)
        if rounds < MOST_ROUNDS:
            u = ended[0].x
            LOGGER.info("fit: correction %d by the case itself", rounds + 1)
    raise SolutionError(
        f"the fit does not settle between the case and the cheaper one in {MOST_ROUNDS} "
        "corrections; expected keys in [coarse] that change less"
    )


def _step(problem: Problem, u: Array, values: Array, J: Array) -> Array:
    """Return the Gauss-Newton step from u within the bounds, by values (m,) and slopes (m, n)."""
    misfit = problem.misfit
    rows = np.vstack([misfit.slopes(values)[:, None] * J, _prior_rows(problem)])
    r = np.append(misfit.residuals(values), problem.prior_errors(u))
    return np.asarray(scipy.optimize.lsq_linear(rows, -r, (-u, 1.0 - u)).x)


def _across(evaluator: Evaluator, u: Array, k: int, ratio: Array) -> tuple[float, float]:
    """Standard deviations by which the data change where key k alone goes to its bounds.

    nan of a bound where the case is refused or cannot be computed.
    """
    here = evaluator.values(u)
    deviation = evaluator.problem.misfit.deviations(here)

    def to(bound: float) -> float:
        place = u.copy()
        place[k] = bound
        try:
            change = ratio * (np.array(evaluator.at(place).values) - here) / deviation
        except (InputError, SolutionError):
            return math.nan
        return float(np.linalg.norm(change))

    return to(0.0), to(1.0)


def search(
    evaluator: Evaluator, starts: Sequence[Array], ratio: Array, shift: Array
) -> list[Minimum]:
    """Return the minima of half the sum of squares of data and priors, the best one first.

    Model values are ratio * (those of the evaluator) + shift, shape (m,) each.
    """
    problem, rows = evaluator.problem, _prior_rows(evaluator.problem)
    misfit = problem.misfit

    def residuals(u: Array) -> Array:
        r = misfit.residuals(ratio * evaluator.values(u) + shift)
        return np.append(r, problem.prior_errors(u))

    def jacobian(u: Array) -> Array:
        weight = ratio * misfit.slopes(ratio * evaluator.values(u) + shift)
        return np.vstack([weight[:, None] * evaluator.slopes(u), rows])

    # What costs seconds or more ends far below a standard deviation.
    end = 1e-8 if problem.level in ("sticks", "floors") else 1e-4
    low = np.zeros(len(problem.keys))
    failed: list[ImpactfemError] = []

    def led_to(start: Array) -> list[Minimum]:
        try:
            return minima(residuals, [start], low, low + 1.0, jacobian=jacobian, tolerance=end)
        except (InputError, SolutionError) as error:  # the case has no such places
            failed.append(error)
            return []

    if evaluator.executor is None:
        each = [led_to(start) for start in starts]
    else:
        with ThreadPoolExecutor(len(starts)) as threads:
            each = list(threads.map(led_to, starts))
    found = sorted(chain.from_iterable(each), key=lambda minimum: minimum.cost)
    if not found:
        raise failed[0]
    for error in failed:
        LOGGER.warning("warning: a search of %d is left out: %s", len(starts), error)
    return found


def _prior_rows(problem: Problem) -> Array:
    """∂r/∂u of the priors, a row each."""
    priors = problem.priors
    rows = np.zeros((len(priors), len(problem.keys)))
    for row, (k, _, width) in zip(rows, priors, strict=True):
        row[k] = 1.0 / width
    return rows


def identified(problem: Problem, values: Array, J: Array) -> Identification:
    """Return what data and priors say about the keys.

    Args:
        problem: The problem.
        values: The values of the model at the keys, shape (m,).
        J: Their slopes by the keys, shape (m, n).
    """
    weighted = J / problem.misfit.deviations(values)[:, None]
    return Identification.of(weighted, _prior_rows(problem))


def _warnings(result: Fit) -> list[str]:
    """Return the warnings of a fit."""
    problem, found = result.problem, result.identification
    keys, texts = problem.keys, list[str]()
    anew = _fitted_anew(problem.case(result.u)) if found.unseen else ""
    for k in found.unseen:
        has_prior = problem.fit.free[keys[k]].prior is not None
        reset = result.u[k] == problem.start[k]
        if k not in result.unseen:
            unit = problem.fit.free[keys[k]].bounds[0].unit
            here = f"{result.values[k]:.4g} {unit}".removesuffix(" -")
            changes = np.nan_to_num(result.across[k])
            at = int(changes.argmax())
            texts.append(
                f"{keys[k]} is not fitted: at {here} the data have no slope by it, but where it "
                f"alone goes to its {('lower', 'upper')[at]} bound they change by "
                f"{changes[at]:.2g} standard deviations; give it a start nearer to that bound"
            )
            continue
        rest = "its value is that of its start" if reset else "its value says nothing"
        rest = "its value is that of its prior" if has_prior else rest
        texts.append(
            f"the data do not see {keys[k]}: by the slope here they change by {found.reach[k]:.2g} "
            f"standard deviations across its bounds; {rest}{anew}"
        )
    for value, parts in found.mixed:
        named = ", ".join(keys[k] for k in parts)
        texts.append(
            f"the data see {named} only together: one combination of them changes the data by "
            f"{value:.2g} standard deviations across the bounds"
        )
    for i, j, r in found.alike:
        texts.append(f"the data hardly distinguish {keys[i]} from {keys[j]}: correlation {r:.3f}")
    for k, side in enumerate(result.at_bound):
        if k not in found.unseen and side != "no":
            texts.append(f"{keys[k]} is at its {side} bound")
    errors, of_priors = result.errors[1], problem.prior_errors(result.u)
    # A key at a bound is not fitted, nor is one that neither data nor a prior determine.
    free, held = problem.fit.free, result.at_bound
    fitted = [
        k
        for k, key in enumerate(keys)
        if held[k] == "no" and (k not in found.unseen or free[key].prior is not None)
    ]
    freedom = max(len(errors) + len(of_priors) - len(fitted), 1)
    limit = float(scipy.stats.chi2.ppf(0.95, freedom))
    both = np.append(errors, of_priors)
    if float(both @ both) > limit:
        names = [one.name for one in problem.data]
        names += [f"the prior of {keys[k]}" for k, *_ in problem.priors]
        worst = int(np.argmax(np.abs(both)))
        who = "data and priors" if len(of_priors) else "the data"
        more = f" of the data and {of_priors @ of_priors:.3g} of the priors" * bool(len(of_priors))
        texts.append(
            f"{who} are not met within their deviations: χ² = {errors @ errors:.3g}{more}, where "
            f"95 of 100 have at most {limit:.3g}; missed most is {names[worst]}, by "
            f"{both[worst]:.3g} deviations; the ± of the keys do not include the error of the model"
        )
    texts += [*_unlike_modes(result), *_several(result)]
    if not result.minima[0].met:
        texts.append("the best search ended by its number of steps, not by its tolerances")
    return texts


def _several(result: Fit) -> Iterator[str]:
    """Warn of several solutions that fit the data equally well."""
    groups, problem = result.solutions, result.problem
    if len(groups) < 2:
        return
    x = np.array([group[0].x for group in groups])
    k = int(np.ptp(x, axis=0).argmax())
    unit = problem.fit.free[problem.keys[k]].bounds[0].unit
    values = ", ".join(f"{problem.values(one)[k]:.4g}" for one in x)
    fits = ", ".join(f"{2.0 * group[0].cost:.3g}" for group in groups)
    counts = ", ".join(str(len(group)) for group in groups)
    yield (
        f"{len(groups)} solutions fit equally well: {problem.keys[k]} = {values} {unit}, χ² = "
        f"{fits}, found from {counts} of {len(result.minima)} starts; the data do not decide "
        f"between them. fit_keys.csv, {FITTED} and the ± hold for the first one alone; "
        f"fit_solutions.csv has all. Add a target or a prior, or set bounds of "
        f'[free."{problem.keys[k]}"] that hold one of them'
    ).replace(" -,", ",")


def _unlike_modes(result: Fit) -> Iterator[str]:
    """Measured modes whose shapes are other than those of the model's that they are matched with.

    Of two that the model has close together it is said why.
    """
    shown = result.shown
    after = dict(zip((one.name for one in result.problem.data), result.after, strict=True))
    for target in result.problem.fit.targets:
        if isinstance(target, ModesTarget):
            names = [f"{target.building}.mode_{one.mode}" for one in target.modes]
            of = {name: after[f"{name}.frequency"] for name in names}
            unlike = [name for name in names if shown[f"{name}.mac"] < ALIKE]
            unlike.sort(key=lambda name: of[name])
            mixed = set[str]()
            for one, other in pairwise(unlike):
                apart = of[other] / of[one] - 1.0
                if apart < CLOSE:
                    mixed |= {one, other}
                    yield (
                        f"{one} and {other} are {100.0 * apart:.2g} % apart in frequency in the "
                        "model, and any combination of their shapes is nearly a mode: their "
                        "measured shapes may be other combinations (MAC "
                        f"{shown[f'{one}.mac']:.2f}, {shown[f'{other}.mac']:.2f}), which the fit "
                        "does not look for"
                    )
            for name in unlike:
                if name not in mixed:
                    yield (
                        f"{name} is matched with mode {shown[f'{name}.mode_of_the_model']:.0f} of "
                        f"the model, whose shape is another one (MAC {shown[f'{name}.mac']:.2f}, "
                        f"of one mode at least {ALIKE:g}): it may be none of the model's modes"
                    )


def _fitted_anew(case: Case) -> str:
    """Name the calibrations that the case repeats in each evaluation, which may hide a key."""
    sticks = case.calibration is not None and case.calibration.mode == "fit"
    factors = any(one.calibration is not None for one in case.structures)
    named = ["its sticks"] * sticks + ["the factor on walls and columns"] * factors
    return f"; the case fits {' and '.join(named)} anew in each evaluation" if named else ""

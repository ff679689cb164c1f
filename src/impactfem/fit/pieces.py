"""What targets are read off, and how: scalars, floors, modes and spectra of a model."""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from impactfem.case import Case
from impactfem.case.base import nearest
from impactfem.fit.fit_file import (
    FloorTarget,
    ModesTarget,
    ScalarTarget,
    SpectrumTarget,
    measured_shape,
)
from impactfem.fit.problem import Problem
from impactfem.stages.stores import open_store
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError, SolutionError
from impactfem.system.scalar import Scalar


@dataclass(eq=False)
class Pieces:
    """What the targets are read off."""

    scalars: dict[str, Scalar] = field(default_factory=dict)
    #: Columns of the floor table by building.
    floors: dict[str, dict[str, Array]] = field(default_factory=dict)
    #: Frequencies, shape (k,) [Hz], and motions at the rows of the table of shapes, shape (k, n),
    #: by building.
    modes: dict[str, tuple[Array, Array]] = field(default_factory=dict)
    run: Path | None = None  #: folder of a run


def mac(a: Array, b: Array) -> float:
    """Modal assurance criterion (aᵀ b)²/((aᵀ a)(bᵀ b)) of two real shapes, shape (n,)."""
    squares = float(a @ a) * float(b @ b)
    return float(a @ b) ** 2 / squares if squares > 0.0 else 0.0


def paired(target: ModesTarget, frequency: Array, at: Array) -> list[tuple[int, float]]:
    """For each measured mode the number of the model's, from 0, and their MAC.

    Those are chosen that are together most alike, by 1 − MAC and, where sensors are too few to tell
    shapes apart, by the square of the logarithm of the ratio of the frequencies.

    Args:
        target: The measured modes.
        frequency: Of the model's modes, shape (k,) [Hz].
        at: Their motions at the rows of the table of shapes, shape (k, n).
    """
    rows = np.array([one.mode for one in target.shapes])
    alike = np.array(
        [
            [mac(measured_shape(target, one.mode), φ[rows == one.mode]) for φ in at]
            for one in target.modes
        ]
    )
    apart = np.log(frequency / np.array([one.frequency for one in target.modes])[:, None])
    own, chosen = linear_sum_assignment(1.0 - alike + apart**2)
    return [(int(k), float(alike[i, k])) for i, k in zip(own, chosen, strict=True)]


def read_off(problem: Problem, case: Case, pieces: Pieces) -> tuple[list[float], dict[str, float]]:
    """The value for each datum, and what is shown with them: the MAC of measured modes.

    Raises:
        InputError: A target names no result, or one of another unit.
        SolutionError: A result has no value.
    """
    values: list[float] = []
    shown: dict[str, float] = {}
    faults, absent = list[Fault](), list[str]()
    for k, target in enumerate(problem.fit.targets):
        where = f"targets[{k}]"
        if isinstance(target, ScalarTarget):
            one = pieces.scalars.get(target.result)
            if one is None:
                near = get_close_matches(target.result, pieces.scalars, n=1)
                hint = f"; did you mean '{near[0]}'?" if near else ""
                expected = f"expected the name of a result{hint}"
                faults.append(Fault(problem.path, f"{where}.result", target.result, expected))
            elif one.unit != target.value.unit:
                expected = f"expected a value in {one.unit}, the unit of the result"
                faults.append(Fault(problem.path, f"{where}.value", None, expected))
            elif one.value is None:
                absent.append(f"{where}: {target.result} has no value. {one.note}".strip())
            else:
                values.append(one.value)
        elif isinstance(target, FloorTarget):
            column = pieces.floors[target.building][target.quantity]
            numbers = [floor.floor for floor in case.building(target.building).floors]
            values += [float(column[numbers.index(floor)]) for floor in target.floors]
        elif isinstance(target, ModesTarget):
            values += _of_modes(target, case, pieces, shown)
        else:
            values += _of_spectrum(target, where, problem, case, pieces)
    if faults:
        raise InputError(faults)
    if absent:
        raise SolutionError("; ".join(absent))
    return values, shown


def _of_modes(
    target: ModesTarget, case: Case, pieces: Pieces, shown: dict[str, float]
) -> list[float]:
    frequency, at = pieces.modes[target.building]
    law = case.building(target.building).damping.law
    rows = np.array([one.mode for one in target.shapes])
    values = []
    for one, (k, alike) in zip(target.modes, paired(target, frequency, at), strict=True):
        values.append(float(frequency[k]))
        if one.damping is not None:
            values.append(float(law.ratio(np.array([frequency[k]]))[0]))
        φ, measured = at[k, rows == one.mode], measured_shape(target, one.mode)
        # The factor that brings the model's shape nearest to the measured one.
        values += [float(x) for x in φ * (φ @ measured) / max(float(φ @ φ), 1e-300)]
        name = f"{target.building}.mode_{one.mode}"
        shown |= {f"{name}.mac": alike, f"{name}.mode_of_the_model": k + 1.0}
    return values


def _of_spectrum(
    target: SpectrumTarget, where: str, problem: Problem, case: Case, pieces: Pieces
) -> list[float]:
    if pieces.run is None:
        raise ValueError("a spectrum is read off a run")

    def refused(key: str, value: object, expected: str) -> InputError:
        return InputError([Fault(problem.path, f"{where}.{key}", value, expected)])

    if target.probe is None:
        path = pieces.run / "pounding.nc"
        station = f"{target.building}.floor_{target.floor}"
        select = {"direction": ("direction", str(target.direction)), "station": ("floor", station)}
    else:
        path = case.modelled[target.building].folder(pieces.run) / "transient.nc"
        select = {
            "component": ("direction", str(target.direction)),
            "probe": ("probe", target.probe),
        }
    frequency = np.array([one.frequency for one in target.spectrum])
    with open_store(path) as store:
        for name, (key, value) in select.items():
            known = [str(one) for one in store[name].values]
            if value not in known:
                raise refused(key, value, f"no spectrum of the run; {nearest(value, known)}")
        chosen = {name: value for name, (_, value) in select.items()}
        curve = store["psa"].sel(chosen).sel(damping=target.damping, method="nearest")
        f, psa = store["frequency"].values, curve.values
    outside = frequency[(frequency < f[0]) | (frequency > f[-1])]
    if outside.size:
        expected = f"expected frequencies of [spectra], {f[0]:g} to {f[-1]:g} Hz"
        raise refused("spectrum", f"{outside[0]:g} Hz", expected)
    found = np.exp(np.interp(np.log(frequency), np.log(f), np.log(psa)))
    return [float(one) for one in found]

"""Impact forces of another program: their sign, their size, and their sampling."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from impactfem.case import Case
from impactfem.case.transient import Transient
from impactfem.coupling.force_history import ForceHistory, around_peak, check_forces, read_forces
from impactfem.records.accelerogram import STANDARD_GRAVITY
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault

PULLS = 0.1
"""Part of the impulse of a pair that is tension from which on it is warned of: contacts press."""
FACTORS = (0.05, 100.0)
"""Least and largest usual value of the largest force over the weight of the lighter floor."""
SAMPLES = 8
"""Least number of samples of the largest impact of a pair."""
STEPS = 16
"""Number of steps in an impact that is resolved, as points_per_impact of [pounding] has it."""
AGREES = 3.0
"""Largest factor between the impulses of a pair that two programs find."""
SMALL = 0.01
"""Impulse of a pair over the largest one below which it is not compared."""


def given_forces(transient: Transient, *, check: bool = False) -> ForceHistory:
    """Read the impact forces that a case names, and make them positive in compression.

    With `check` HDF5 reads them in a process of its own. InputError as `read_forces`; ValueError
    where the case names none.
    """
    if transient.forces is None:
        raise ValueError("the case has no forces of another program")
    history = (check_forces if check else read_forces)(transient.forces)
    if transient.compression == "positive":
        return history
    return replace(history, force=0.0 - history.force)  # without negative zeros


def wrong_signs(history: ForceHistory, path: Path, case: Case) -> Iterator[Fault]:
    """Pairs whose forces are mostly tension, which no contact has, with what to do."""
    push, pull = impulses(history), impulses(replace(history, force=-history.force))
    wrong, acting = pull > push, push + pull > 0.0
    if not wrong.any():
        return
    if wrong[acting].all():
        now = "positive" if case.transient is None else case.transient.compression
        other = "negative" if now == "positive" else "positive"
        expected = (
            "all pairs are mostly in tension, and contacts press: impacts would pull the buildings "
            f"together; if compression is {other} in this file, type compression = "
            f'"{other}" in [transient]'
        )
        yield Fault(path, "force", None, expected)
        return
    for j in np.flatnonzero(wrong):
        share = 100.0 * pull[j] / (push[j] + pull[j])
        expected = (
            f"{share:.0f} % of its impulse is tension, unlike other pairs; expected one sign of "
            "compression in all columns: multiply this one by -1"
        )
        yield Fault(path, f"pair {history.pairs[j]}", None, expected)


def doubts(history: ForceHistory, path: Path, case: Case) -> Iterator[Fault]:
    """Forces with much tension, off the weights of the floors, or with few samples an impact."""
    push, pull = impulses(history), impulses(replace(history, force=-history.force))
    step = float(history.time[-1]) / (len(history.time) - 1)
    ratios, few = dict[str, float](), dict[str, int]()
    for j, name in enumerate(history.pairs):
        force = history.force[:, j]
        if not force.any():
            continue
        if PULLS * (push[j] + pull[j]) < pull[j] <= push[j]:
            share = 100.0 * pull[j] / (push[j] + pull[j])
            text = (
                f"{share:.0f} % of its impulse is tension, and contacts press; floor spectra at "
                "impacts change with it. Check the sign, and how the force was resampled"
            )
            yield Fault(path, f"pair {name}", None, text)
        first, behind = around_peak(force)
        if behind - first < SAMPLES:
            few[name] = behind - first
        weight = _lighter_floor(history, j, case)
        if weight is not None:
            ratios[name] = float(np.abs(force).max()) / weight
    if few:
        name = min(few, key=lambda one: few[one])
        text = (
            f"the largest impact has fewer than {SAMPLES} samples ({few[name]}) at the step of the "
            f"file, {1e3 * step:g} ms; peak, impulse and spectra above {0.1 / step:.3g} Hz are "
            f"uncertain, for {len(few)} of {len(history.pairs)} pairs. Export the forces with a "
            f"step of at most {1e3 * step * max(few[name] - 1, 1) / STEPS:.2g} ms"
        )
        yield Fault(path, f"pair {name}", None, text)
    if not ratios:
        return
    name = max(ratios, key=lambda one: ratios[one])
    if not FACTORS[0] <= ratios[name] <= FACTORS[1]:
        text = (
            f"the largest force is {ratios[name]:.3g} times the weight of the lighter floor; usual "
            f"is {FACTORS[0]:g} to {FACTORS[1]:g}. Floor spectra at impacts are proportional to "
            "the forces. Check the unit in the header, and the masses of the floors"
        )
        yield Fault(path, f"pair {name}", None, text)


def impulses(history: ForceHistory, end: float = np.inf) -> Array:
    """Compute the impulse in compression of each pair up to a time [s], shape (m,) [N s]."""
    step = float(history.time[-1]) / (len(history.time) - 1)
    press: Array = np.maximum(history.force[history.time <= end], 0.0).sum(axis=0) * step
    return press


def largest_disagreement(given: ForceHistory, own: ForceHistory) -> tuple[str, float, float] | None:
    """Find the pair whose impulses differ most, of forces that are given and of the sticks.

    Its name and both impulses, over the time that both have [N s]; None without common pairs that
    touch. Pairs with small impulses in both are left out.
    """
    end = min(float(given.time[-1]), float(own.time[-1])) * (1.0 + 1e-9)
    theirs: dict[str, float] = dict(zip(given.pairs, impulses(given, end).tolist(), strict=True))
    ours: dict[str, float] = dict(zip(own.pairs, impulses(own, end).tolist(), strict=True))
    common = [name for name in theirs if name in ours]
    largest = max((max(theirs[name], ours[name]) for name in common), default=0.0)
    least = SMALL * largest  # a pair that touches in one of them only differs by a finite factor
    pairs = [name for name in common if max(theirs[name], ours[name]) > least]
    if not pairs:
        return None

    def factor(name: str) -> float:
        both = max(theirs[name], least), max(ours[name], least)
        return max(both) / min(both)

    worst = max(pairs, key=factor)
    return worst, theirs[worst], ours[worst]


def _lighter_floor(history: ForceHistory, column: int, case: Case) -> float | None:
    """Weight of the lighter floor of a pair [N]; None where case and file do not say which."""
    name, ends = history.pairs[column], history.ends
    contact = next((one for one in case.contacts if one.name == name), None)
    floors: list[tuple[str, int]] = []
    if contact is not None:
        points = [point for point, _ in contact.ends]
        floors = [(one.building, one.floor or one.storey or 0) for one in points]
    elif ends.building_a is not None and ends.floor_a is not None:
        floors = [(ends.building_a[column], ends.floor_a[column])]
        if ends.building_b is not None and ends.floor_b is not None:
            floors.append((ends.building_b[column], ends.floor_b[column]))
    masses = [
        floor.mass
        for building in case.buildings
        for floor in building.floors
        if (building.name, floor.floor) in floors
    ]
    return STANDARD_GRAVITY * min(masses) if masses else None

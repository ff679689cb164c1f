"""Variations of a case: one parameter of each is changed.

Values that the impact on a wall gives are those of the case: they are not calibrated again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from impactfem.case import Building, Case
from impactfem.case.damping import ConstantDamping, TableDamping
from impactfem.coupling.pounding import System
from impactfem.dynamics.damping import DampingLaw
from impactfem.system.quantity import results, si

FACTORS = {"half": 0.5, "double": 2.0}
"""Factors on the contact stiffness."""
RESTITUTION = 0.1
"""Change of the restitution, within the limits of `LEAST` and 1."""
LEAST = 0.05
GAPS = {"-50 %": 0.5, "+50 %": 1.5}
"""Factors on the gap."""
CORNER = 20.0
"""Frequency above which the damping changes [Hz]."""
POINTS = 60
"""Points of the changed damping below `CORNER`: the largest error of Rayleigh damping between two
of them is 0.1 %."""
LOWEST, HIGHEST = 0.1, 1e4
"""Ends of the changed damping [Hz]."""
PERCENTILE = 84.0
"""Percentile of the motions."""
WORDS = {
    "contact_stiffness": "contact stiffness",
    "restitution": "restitution",
    "damping": f"damping above {CORNER:g} Hz",
    "gap": "gap",
    "motion": "motion",
    "time_step": "time step",
    "model": "model in contact",
}
"""The parameters in words, in the order of the results."""


@results
class Variation:
    """A case with one changed parameter."""

    parameter: str = si("", "changed parameter")
    setting: str = si("", "its value or change")
    keys: str = si("", "changed keys of the case")
    case: Case

    @property
    def label(self) -> str:
        """Parameter and setting."""
        return f"{WORDS[self.parameter]}: {self.setting}"


@dataclass(frozen=True)
class Unknown:
    """A parameter whose variation is not known, with the reason."""

    parameter: str
    reason: str


@dataclass(frozen=True, eq=False)
class Source:
    """What variations are made from."""

    case: Case  #: with targets of the sticks and contact laws of the run
    system: System  #: its sticks and pairs
    #: Value of the largest impact force by the name of the motion; empty without an ensemble.
    impact_forces: Mapping[str, float]
    members: Mapping[str, Case]  #: the case with each of these motions


def variations(source: Source) -> tuple[list[Variation], list[Unknown]]:
    """Return the variations of a case by its [sensitivity], and those that are not known."""
    known, unknown = list[Variation](), list[Unknown]()
    for parameter in WORDS:
        if parameter not in source.case.sensitivity.parameters:
            continue
        for one in MAKERS[parameter](source):
            if isinstance(one, Unknown):
                unknown.append(one)
            else:
                known.append(one)
    return known, unknown


Made = Iterator[Variation | Unknown]


def _stiffness(source: Source) -> Made:
    laws = _laws(source, "stiffness")
    if not laws:
        yield Unknown("contact_stiffness", "no contact law has a stiffness")
    for setting, factor in FACTORS.items() if laws else ():
        changed = {name: {"stiffness": factor * law.stiffness} for name, law in laws.items()}
        yield _of_laws(source.case, "contact_stiffness", setting, changed)


def _restitution(source: Source) -> Made:
    laws = _laws(source, "restitution")
    if not laws:
        yield Unknown("restitution", "no contact law has a restitution")
        return
    given = {
        contact.law: pair.law.target_restitution
        for contact, pair in zip(source.case.contacts, source.system.pairs, strict=True)
    }
    for sign, symbol in ((-1.0, "-"), (1.0, "+")):
        changed: dict[str, dict[str, float | None]] = {}
        for name, law in laws.items():
            ε = min(max(given[name] + sign * RESTITUTION, LEAST), 1.0)
            changed[name] = {"restitution": ε}
            if hasattr(law, "damping_ratio"):
                changed[name]["damping_ratio"] = None
        yield _of_laws(source.case, "restitution", f"{symbol}{RESTITUTION:g}", changed)


def _laws(source: Source, key: str) -> dict[str, Any]:
    """Return the contact laws of the pairs that have a key, by their names."""
    used = dict.fromkeys(contact.law for contact in source.case.contacts)
    laws = {name: source.case.contact_laws[name] for name in used}
    return {name: law for name, law in laws.items() if hasattr(law, key)}


def _of_laws(
    case: Case, parameter: str, setting: str, changed: Mapping[str, Mapping[str, float | None]]
) -> Variation:
    laws = case.contact_laws | {
        name: case.contact_laws[name].model_copy(update=dict(update))
        for name, update in changed.items()
    }
    keys = [
        f"contact_laws.{name}.{key} = {value:.6g}"
        for name, update in changed.items()
        for key, value in update.items()
        if value is not None
    ]
    varied = case.model_copy(update={"contact_laws": laws})
    return Variation(parameter, setting, ", ".join(keys), varied)


def _damping(source: Source) -> Made:
    """Damping that is equal up to `CORNER`: above it constant, or proportional to the frequency."""
    case = source.case
    constant = all(isinstance(one.damping, ConstantDamping) for one in case.buildings)
    setting = "proportional to f" if constant else "constant"
    buildings = tuple(_damped(one, rising=constant) for one in case.buildings)
    keys = 'damping.type = "table"'
    yield Variation("damping", setting, keys, case.model_copy(update={"buildings": buildings}))


def _damped(building: Building, *, rising: bool) -> Building:
    points = damping_points(building.damping.law, rising=rising)
    table = TableDamping.model_construct(type="table", points=points)
    return building.model_copy(update={"damping": table})


def damping_points(law: DampingLaw, *, rising: bool) -> tuple[tuple[float, float], ...]:
    """Return the points of a damping that follows a law up to `CORNER`.

    Above it the ratio is constant, or proportional to the frequency where it is to rise.
    """
    low = np.geomspace(LOWEST, CORNER, POINTS)
    points = list(zip(low.tolist(), law.ratio(low).tolist(), strict=True))
    high = np.geomspace(CORNER, HIGHEST, POINTS)[1:] if rising else np.array([HIGHEST])
    ratio = float(law.ratio(CORNER)) * (high / CORNER if rising else np.ones(1))
    points += zip(high.tolist(), ratio.tolist(), strict=True)
    return tuple(points)


def _gap(source: Source) -> Made:
    case = source.case
    if not any(contact.gap > 0.0 for contact in case.contacts):
        yield Unknown("gap", "the case has no contact pair with a gap")
        return
    for setting, factor in GAPS.items():
        contacts = tuple(one.model_copy(update={"gap": factor * one.gap}) for one in case.contacts)
        least = 1e3 * min(one.gap for one in contacts)
        keys = f"contacts.gap x {factor:g}, the smallest {least:.3g} mm"
        yield Variation("gap", setting, keys, case.model_copy(update={"contacts": contacts}))


def _motion(source: Source) -> Made:
    """The motion of the ensemble at a percentile of the impact force."""
    forces = {name: value for name, value in source.impact_forces.items() if math.isfinite(value)}
    if not forces:
        yield Unknown("motion", "the case has no [ensemble]")
        return
    wanted = float(np.percentile(list(forces.values()), PERCENTILE))
    name = min(forces, key=lambda one: abs(forces[one] - wanted))
    setting = f"{PERCENTILE:g}th percentile of {len(forces)}"
    keys = f"motions: {name.replace('_', ' ')}"
    yield Variation("motion", setting, keys, source.members[name])


def _time_step(source: Source) -> Made:
    case = source.case
    update: dict[str, Any] = {}
    for section in ("pounding", "transient", "device_analysis"):
        given = getattr(case, section)
        if given is not None:
            update[section] = given.model_copy(update={"time_step": 0.5 * given.time_step})
    keys = ", ".join(f"{name}.time_step = {one.time_step:.6g} s" for name, one in update.items())
    yield Variation("time_step", "half", keys, case.model_copy(update=update))


def _model(source: Source) -> Made:
    case = source.case
    if not case.pounding_in_3d:
        if len(case.modelled) > 1:
            reason = 'the reduced models have no contact points: set pounding.models to "structure"'
            yield Unknown("model", reason)
        return
    if any(pair.law.unilateral for pair in source.system.pairs):
        yield Unknown("model", "sticks need a contact law; unilateral contact has none")
        return
    sticks = case.pounding.model_copy(update={"models": {}})
    varied = case.model_copy(update={"pounding": sticks})
    yield Variation("model", "sticks", 'pounding.models = "stick"', varied)


MAKERS: dict[str, Callable[[Source], Made]] = {
    "contact_stiffness": _stiffness,
    "restitution": _restitution,
    "damping": _damping,
    "gap": _gap,
    "motion": _motion,
    "time_step": _time_step,
    "model": _model,
}
